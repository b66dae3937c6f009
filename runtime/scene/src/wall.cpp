#include "building_blocks.h"
#include "builtin.h"

namespace atl::scene {

Scene build_wall(const ParameterValues& values, std::uint64_t) {
  Scene scene = scene_on_ground(200, true);
  add_unit_boxes(scene, wall_lattice(values.integer("base")));
  if (values.integer("planar") == 1) {
    for (SceneBody& body : scene.bodies) body.def.locks = MotionLocks::plane(Axis::Y);
  }
  return scene;
}

}  // namespace atl::scene
