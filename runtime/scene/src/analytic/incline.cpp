// Blocks on a slope whose friction is just enough, or just not.

#include <array>

#include "../analytic.h"
#include "slope.h"

namespace atl::scene {
namespace incline {

constexpr double duration = 3;                                   // s
constexpr std::array ratios = {0.5, 0.8, 0.95, 1.05, 1.5, 2.0};  // of the slope to the friction
const Vector3 half_extents(0.25, 0.25, 0.1);                     // m

}  // namespace incline

Scene build_incline(const ParameterValues& values, std::uint64_t) {
  using namespace incline;
  const Slope slope = {values["angle"]};
  Scene scene;
  scene.steps = steps_for(duration);
  scene.bodies.push_back(plane({.friction = 1}, slope.normal()));
  std::vector<Descent> descents;
  for (std::size_t i = 0; i < ratios.size(); ++i) {
    const double friction = slope.sine() / slope.cosine() / ratios[i];
    const Vector3 start = half_extents.z() * slope.normal() + Vector3(0, static_cast<double>(i), 0);
    // The geometric mean with the ground's 1.
    SceneBody block =
        solid(numbered("block", static_cast<int>(i)), Box{half_extents}, start, {.friction = friction * friction});
    block.def.orientation = slope.orientation();
    scene.bodies.push_back(block);
    const double pull = slope.sine() - friction * slope.cosine();
    descents.push_back({start, ratios[i] < 1 ? 0 : standard_gravity * pull});
  }
  scene.closed_form = known_motion(
      "largest distance of a block along the plane from the closed form's place, relative to its way without friction",
      "Coulomb friction: holds where tan(a) <= mu, else slides at g (sin(a) - mu cos(a))",
      {{"hold_error"}, {"slide_error"}}, compare_descents(slope, descents, duration, "hold_error", "slide_error"));
  return scene;
}

}  // namespace atl::scene
