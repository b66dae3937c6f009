// A bridge of planks, hinged to each other and to two banks, that boxes fall on.

#include <algorithm>
#include <cmath>

#include "analytic/setting.h"
#include "builtin.h"
#include "joined_scene.h"

namespace atl::scene {
namespace bridge {

constexpr double pitch = 0.5;                // m, from hinge to hinge
const Vector3 half_plank = {0.24, 1, 0.05};  // m
constexpr double plank_density = 600;        // kg/m^3
constexpr double slope = 0.4;                // rad, of the ends at the start
constexpr double half_box = 0.3;             // m
constexpr double drop = 0.5;                 // m, from a box to the planks
constexpr int planks_a_box = 8;
const Vector3 half_bank = {2, 1.5, 2};  // m

SceneBody bank(std::string name, double x, double side, double top) {
  SceneBody body;
  body.name = std::move(name);
  body.def = {.type = BodyType::Static,
              .shape = Box{half_bank},
              .position = {x + side * (half_bank.x() + pitch / 2 - half_plank.x()), 0, top - half_bank.z()},
              .material = builtin_material};
  return body;
}

}  // namespace bridge

// The planks start on an arc, which leaves them the room to sag that a taut row would not have.
Scene build_bridge(const ParameterValues& values, std::uint64_t) {
  using namespace bridge;
  const int planks = values.integer("planks");
  Scene scene;
  scene.steps = 600;
  scene.bodies.push_back(ground());

  const auto tilt = [planks](int plank) { return slope * (2 * plank + 1 - planks) / planks; };
  std::vector<Vector3> hinges = {Vector3::Zero()};
  for (int i = 0; i < planks; ++i) {
    const auto [sine, cosine] = sine_cosine(tilt(i));
    hinges.push_back(hinges.back() + pitch * Vector3(cosine, 0, sine));
  }
  double lowest = 0;
  for (const Vector3& hinge : hinges) lowest = std::min(lowest, hinge.z());
  const Vector3 shift(-hinges.back().x() / 2, 0, 3 - 2 * lowest);
  for (Vector3& hinge : hinges) hinge += shift;

  const Quaternion across = frame_along(Vector3::UnitY());
  const double top = hinges.front().z() + half_plank.z();
  scene.bodies.push_back(bank("bank_west", hinges.front().x(), -1, top));
  for (int i = 0; i < planks; ++i) {
    SceneBody plank;
    plank.name = numbered("plank", i);
    plank.def = {.shape = Box{half_plank},
                 .position = (hinges[static_cast<std::size_t>(i)] + hinges[static_cast<std::size_t>(i) + 1]) / 2,
                 .orientation = turned(-tilt(i), Vector3::UnitY()),
                 .density = plank_density,
                 .material = builtin_material};
    scene.bodies.push_back(plank);
    join_last_two(scene, HingeJoint{}, hinges[static_cast<std::size_t>(i)], across);
  }
  scene.bodies.push_back(bank("bank_east", hinges.back().x(), 1, top));
  join_last_two(scene, HingeJoint{}, hinges.back(), across);

  const double plank_mass = 8 * half_plank.prod() * plank_density;
  const int boxes = std::max(1, planks / planks_a_box);
  for (int i = 0; i < boxes; ++i) {
    const int under = planks * (2 * i + 1) / (2 * boxes);
    SceneBody box =
        unit_box(static_cast<std::size_t>(i), scene.bodies[static_cast<std::size_t>(under) + 2].def.position);
    box.def.shape = Box{Vector3::Constant(half_box)};
    box.def.position.z() += half_plank.z() + half_box + drop;
    box.def.mass = values["ratio"] * plank_mass;
    scene.bodies.push_back(box);
  }
  return scene;
}

}  // namespace atl::scene
