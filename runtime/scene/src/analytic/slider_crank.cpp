// A crank, turned by a motor, moves a slider to and fro by a rod.

#include <numbers>

#include "../analytic.h"
#include "comparison.h"
#include "rod.h"

namespace atl::scene {
namespace slider_crank {

constexpr double duration = 3;  // s
constexpr double crank = 0.25;  // m, from the axle to the pin
constexpr double half_width = 0.04;
constexpr double half_slider = 0.1;

SceneBody beam(std::string name, double length, double start) {
  return untouched(solid(std::move(name), Box{{length / 2, half_width, half_width}}, {start + length / 2, 0, 0}, {}));
}

// Distance of the slider's pin from the axle, m, with the crank at an angle from the line between the two.
double slider_at(double angle, double rod) {
  const double across = crank * std::sin(angle);
  return crank * std::cos(angle) + std::sqrt(rod * rod - across * across);
}

}  // namespace slider_crank

// Hinge, ball, universal joint and slider leave one freedom and hold nothing twice: three hinges would.
Scene build_slider_crank(const ParameterValues& values, std::uint64_t) {
  using namespace slider_crank;
  const double speed = values["speed"], rod = values["rod"] * crank;
  Scene scene;
  scene.steps = steps_for(duration);
  SceneBody frame = untouched(solid("frame", Box{{half_slider, half_slider, half_slider}}, {-0.3, 0, 0}, {}));
  frame.def.type = BodyType::Static;
  scene.bodies = {frame, beam("crank", crank, 0), beam("rod", rod, crank),
                  untouched(solid("slider", Box{Vector3::Constant(half_slider)}, {crank + rod, 0, 0}, {}))};
  // At the start all lies in line, so the slider stands and the rod turns against the crank.
  scene.bodies[1].def.angular_velocity = {0, -speed, 0};
  scene.bodies[1].def.velocity = {0, 0, speed * crank / 2};
  scene.bodies[2].def.angular_velocity = {0, speed * crank / rod, 0};
  scene.bodies[2].def.velocity = {0, 0, speed * crank / 2};

  const HingeJoint motor = {.angle = {.motor = JointMotor{.speed = speed, .max_force = unlimited}}};
  const Vector3 pin(crank, 0, 0), far_pin(crank + rod, 0, 0);
  scene.joints = {
      joined(scene, "axle", motor, 0, 1, {Vector3::Zero(), swinging()}),
      joined(scene, "crank_pin", BallJoint{}, 1, 2, {pin, Quaternion::Identity()}),
      joined(scene, "slider_pin", UniversalJoint{}, 3, 2, {far_pin, frame_along(Vector3::UnitY(), Vector3::UnitZ())}),
      joined(scene, "guide", SliderJoint{}, 0, 3, {far_pin, Quaternion::Identity()})};

  scene.closed_form = known_motion(
      "largest distance of the slider from its place at that time, relative to the crank's length; closure_error is "
      "that from its place at the crank's own angle",
      "x = r cos(a) + sqrt(l^2 - r^2 sin^2(a)), a = w t",
      {{"closure_error"}, {"crank_error", 0, "rad"}, {"guide_error"}},
      [=](double time, std::span<const BodyState> states, LargestErrors& errors) {
        const Vector3 along = states[1].pose.orientation * Vector3::UnitX();
        const double angle = std::atan2(along.z(), along.x());
        const Vector3 slider = states[3].pose.position;
        errors.raise("analytic_error", std::abs(slider.x() - slider_at(speed * time, rod)) / crank);
        errors.raise("closure_error", std::abs(slider.x() - slider_at(angle, rod)) / crank);
        errors.raise("crank_error", std::abs(std::remainder(angle - speed * time, 2 * std::numbers::pi)));
        errors.raise("guide_error", slider.tail<2>().norm() / crank);
      });
  return scene;
}

}  // namespace atl::scene
