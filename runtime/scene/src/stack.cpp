#include "building_blocks.h"
#include "builtin.h"

namespace atl::scene {

Scene build_stack(const ParameterValues& values, std::uint64_t) {
  Scene scene = scene_on_ground(600, true);
  add_unit_boxes(scene, {.count = {1, 1, values.integer("height")}});
  scene.bodies.back().def.density *= values["ratio"];
  return scene;
}

}  // namespace atl::scene
