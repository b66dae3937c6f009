#include "building_blocks.h"
#include "builtin.h"

namespace atl::scene {

Scene build_pyramid3d(const ParameterValues& values, std::uint64_t) {
  const int layers = values.integer("layers");
  Scene scene = scene_on_ground(300, true);
  // Neighbours in a layer don't touch: each box stands on the four below it and nothing else.
  add_unit_boxes(scene, {.count = {layers, layers, layers}, .spacing = {1.02, 1.02, 1}, .taper = {1, 1}});
  return scene;
}

}  // namespace atl::scene
