// Blocks launched outwards in all directions on one plane, which friction brings to a stop.

#include <numbers>

#include "../analytic.h"
#include "comparison.h"
#include "setting.h"

namespace atl::scene {
namespace sliding_blocks {

// Flat: the pressure moves forward by friction times the half height, a twentieth of the half length.
const Vector3 half_extents(0.25, 0.25, 0.025);  // m

}  // namespace sliding_blocks

Scene build_sliding_blocks(const ParameterValues& values, std::uint64_t) {
  using namespace sliding_blocks;
  const double friction = values["friction"], speed = values["speed"];
  const int count = values.integer("headings");
  const double deceleration = friction * standard_gravity;
  const double stop = speed / deceleration;  // s
  const double path = 0.5 * speed * stop;

  Scene scene;
  scene.steps = steps_for(1.25 * stop);
  scene.bodies.push_back(plane({.friction = friction}));
  const double spacing = 3 * half_extents.x();
  const double ring = std::max(1.0, spacing * count / (2 * std::numbers::pi));
  std::vector<Vector3> starts, directions;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count;
    directions.push_back(heading(angle));
    starts.push_back(ring * directions.back() + Vector3(0, 0, half_extents.z()));
    SceneBody block = solid(numbered("block", i), Box{half_extents}, starts.back(), {.friction = friction});
    // Turned with its heading, so that all blocks do the same but for their direction.
    block.def.orientation = turned(angle, Vector3::UnitZ());
    block.def.velocity = speed * directions.back();
    scene.bodies.push_back(block);
  }

  scene.closed_form =
      known_motion("largest horizontal distance of a block from the closed form's place, relative to its whole path",
                   "Coulomb friction: deceleration mu g, stop after v^2 / (2 mu g), straight on",
                   {{"lateral_drift"}, {"distance_error"}},
                   [=](double time, std::span<const BodyState> states, LargestErrors& errors) {
                     const double braked = std::min(time, stop);
                     const double travelled = speed * braked - 0.5 * deceleration * braked * braked;
                     for (std::size_t i = 0; i < starts.size(); ++i) {
                       const Vector3 moved = states[i + 1].pose.position - starts[i];
                       const double along = moved.dot(directions[i]);
                       const double across = moved.dot(Vector3(-directions[i].y(), directions[i].x(), 0));
                       errors.raise("analytic_error", std::hypot(along - travelled, across) / path);
                       errors.raise("lateral_drift", std::abs(across) / path);
                       errors.raise("distance_error", std::abs(along - travelled) / path);
                     }
                   });
  return scene;
}

}  // namespace atl::scene
