// Weights that hang on damped springs and are let go from above where they would rest.

#include <array>
#include <numbers>

#include "../analytic.h"
#include "comparison.h"
#include "rod.h"

namespace atl::scene {
namespace spring_damper {

constexpr double duration = 3;       // s
constexpr double lift = 0.3;         // m, above equilibrium
constexpr double half_weight = 0.2;  // m
constexpr double hang = 2;           // m, of the spring at its rest

struct Weight {
  const char* part;
  double damping_ratio;
  bool by_distance;  ///< on a distance joint instead of a slider
};
constexpr std::array<Weight, 5> weights = {Weight{"undamped_error", 0, false}, Weight{"underdamped_error", 0.2, false},
                                           Weight{"critical_error", 1, false}, Weight{"overdamped_error", 3, false},
                                           Weight{"distance_error", 0.2, true}};

// How far a damped oscillator is from rest, relative to where it was let go: x'' + 2 z w x' + w^2 x = 0.
double oscillation(double ratio, double phase) {
  const double square = 1 - ratio * ratio;
  if (square > 0) {
    const double root = std::sqrt(square);
    return std::exp(-ratio * phase) * (std::cos(root * phase) + ratio / root * std::sin(root * phase));
  }
  if (square == 0) return std::exp(-phase) * (1 + phase);
  const double root = std::sqrt(-square);
  const double slow = -ratio + root, fast = -ratio - root;
  return (slow * std::exp(fast * phase) - fast * std::exp(slow * phase)) / (slow - fast);
}

}  // namespace spring_damper

Scene build_spring_damper(const ParameterValues& values, std::uint64_t) {
  using namespace spring_damper;
  const double hertz = values["hertz"];
  const double rate = 2 * std::numbers::pi * hertz;
  const double sag = standard_gravity / (rate * rate);
  Scene scene;
  scene.steps = steps_for(duration);
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const Vector3 hook(static_cast<double>(i), 0, 0);
    scene.bodies.push_back(untouched(fixed_ball(numbered("hook", static_cast<int>(i)), hook, 0.05)));
    const Vector3 centre = hook - Vector3(0, 0, hang + sag - lift);
    scene.bodies.push_back(
        untouched(solid(numbered("weight", static_cast<int>(i)), Box{Vector3::Constant(half_weight)}, centre, {})));
    JointSpring spring = {.hertz = hertz, .damping_ratio = weights[i].damping_ratio, .rest = hang};
    const std::size_t last = scene.bodies.size() - 1;
    // Frames at the centres, so the effective mass is the weight's. The slider's x axis points down.
    const Quaternion down = frame_along(-Vector3::UnitZ());
    const JointKind kind = weights[i].by_distance
                               ? JointKind(DistanceJoint{.distance = {.range = {}, .spring = spring}})
                               : JointKind(SliderJoint{.offset = {.spring = spring}});
    SceneJoint joint = joined(scene, numbered("spring", static_cast<int>(i)), kind, last - 1, last, {hook, down});
    joint.def.frame_second = seen_from(scene.bodies[last].def, {centre, down});
    scene.joints.push_back(joint);
  }
  std::vector<ErrorMeasure> parts;
  parts.reserve(weights.size());
  for (const Weight& weight : weights) parts.push_back({weight.part});
  scene.closed_form = known_motion(
      "largest distance of a weight from its place, relative to how far from rest it is let go",
      "damped oscillator, x'' + 2 z w x' + w^2 x = 0", parts,
      [=](double time, std::span<const BodyState> states, LargestErrors& errors) {
        for (std::size_t i = 0; i < weights.size(); ++i) {
          const double height = lift * oscillation(weights[i].damping_ratio, rate * time) - hang - sag;
          const Vector3 place(static_cast<double>(i), 0, height);
          errors.raise_with_total(weights[i].part, (states[2 * i + 1].pose.position - place).norm() / lift);
        }
      });
  return scene;
}

}  // namespace atl::scene
