#include <array>

#include "building_blocks.h"
#include "builtin.h"
#include "random.h"

namespace atl::scene {
namespace hopper {

constexpr double outlet_half = 2;      // m, of the square opening
constexpr double outlet_height = 6;    // m, above the floor
constexpr double slope = 16;           // m, length of a side along its slope of 45 degrees
constexpr double thickness = 1;        // m, of a side
constexpr double container_half = 12;  // m, of what it all falls into
constexpr double half_root = 0.70710678118654752440;

// Written out, so that no libm has a say.
const Quaternion tilted(0.92387953251128675613, 0, -0.38268343236508977173, 0);  // by -45 degrees about y
const std::array<Quaternion, 4> headings = {Quaternion(1, 0, 0, 0), Quaternion(half_root, 0, 0, half_root),
                                            Quaternion(0, 0, 0, 1), Quaternion(half_root, 0, 0, -half_root)};

// A side of the funnel that rises outwards along x, turned to its heading.
SceneBody side(std::size_t number, const Material& material) {
  const Vector3 middle(outlet_half + 0.5 * slope * half_root, 0, outlet_height + 0.5 * slope * half_root);
  const Vector3 inwards(-half_root, 0, half_root);
  const Quaternion& heading = headings[number];
  return {.name = "side_" + std::to_string(number),
          .def = {.type = BodyType::Static,
                  .shape = Box{.half_extents = {0.5 * slope, slope, 0.5 * thickness}},
                  .position = heading * Vector3(middle - 0.5 * thickness * inwards),
                  .orientation = heading * tilted,
                  .material = material}};
}

}  // namespace hopper

Scene build_hopper(const ParameterValues& values, std::uint64_t seed) {
  using namespace hopper;
  const Material material = {.friction = values["friction"]};
  Scene scene = scene_on_ground(600, false);
  add_walls(scene, container_half);
  for (SceneBody& body : scene.bodies) body.def.material = material;
  for (std::size_t number = 0; number < headings.size(); ++number) scene.bodies.push_back(side(number, material));

  constexpr int a_row = 12;
  constexpr double spacing = 1.4;  // m: boxes have room, however they are turned
  const double lowest = outlet_height + slope * half_root;
  Random random(seed);
  const int count = values.integer("bodies");
  for (int i = 0; i < count; ++i) {
    const Vector3 place(i % a_row - 0.5 * (a_row - 1), i / a_row % a_row - 0.5 * (a_row - 1), i / (a_row * a_row));
    SceneBody& body =
        scene.bodies.emplace_back(unit_box(static_cast<std::size_t>(i), spacing * place + Vector3(0, 0, lowest)));
    body.def.shape = Box{random.in_box(Vector3::Constant(0.1)) + Vector3::Constant(0.3)};
    body.def.orientation = random.rotation();
    body.def.material = material;
  }
  return scene;
}

}  // namespace atl::scene
