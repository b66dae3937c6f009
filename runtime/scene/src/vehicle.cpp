// A car in a steady turn over bumpy ground: springs carry it, the rear wheels drive, the front wheels steer.

#include <numbers>

#include "analytic/setting.h"
#include "builtin.h"
#include "joined_scene.h"

namespace atl::scene {
namespace vehicle {

constexpr double chassis_mass = 1200;          // kg
constexpr double wheel_mass = 25;              // kg
constexpr double wheel_radius = 0.35;          // m; a ball rolls over an edge as a tyre does
const Vector3 half_chassis = {1.8, 0.5, 0.2};  // m
constexpr double axle = 1.3;                   // m, before and behind the middle
constexpr double track = 0.9;                  // m, to either side
constexpr double sag = 0.1;                    // m, of the springs under the chassis
constexpr double travel = 0.2;                 // m, of the suspension to either side
constexpr double damping = 0.4;                // of the chassis on its springs
constexpr double drive_torque = 400;           // N m, of a wheel
constexpr double steering_hertz = 10;

constexpr int samples = 201;
constexpr double spacing = 0.5;    // m
constexpr double bump = 0.08;      // m, of each of two waves
constexpr double wave_length = 6;  // m
constexpr Material tyre = {.friction = 1};

double bumps(double x, double y) {
  const double k = 2 * std::numbers::pi / wave_length;
  return bump * (sine_cosine(k * x).sine + sine_cosine(k * y).sine);
}

SceneBody terrain(const Vector3& centre) {
  const Vector3 corner = centre - spacing * (samples - 1) / 2 * Vector3(1, 1, 0);
  std::vector<double> heights;
  for (int row = 0; row < samples; ++row) {
    for (int column = 0; column < samples; ++column) {
      heights.push_back(bumps(corner.x() + column * spacing, corner.y() + row * spacing));
    }
  }
  SceneBody body;
  body.name = "ground";
  body.def = {.type = BodyType::Static,
              .shape = HeightField(samples, samples, spacing, spacing, std::move(heights)),
              .position = corner,
              .material = tyre};
  return body;
}

JointSpring suspension_spring() {
  const double load = chassis_mass / 4;
  const double stiffness = load * standard_gravity / sag;
  return {.rest = -sag, .stiffness = stiffness, .damping = 2 * damping * std::sqrt(stiffness * load)};
}

}  // namespace vehicle

Scene build_vehicle(const ParameterValues& values, std::uint64_t) {
  using namespace vehicle;
  const double steer = values["steer"];
  Scene scene;
  scene.steps = 600;
  // The middle of the turn is that of the ground.
  const double turn = steer == 0 ? 0 : 2 * axle * sine_cosine(steer).cosine / sine_cosine(steer).sine;
  scene.bodies.push_back(terrain({0, std::min(std::max(turn, -24.0), 24.0), 0}));

  SceneBody chassis;
  chassis.name = "chassis";
  const double hub = 2 * bump + wheel_radius;
  chassis.def = {.shape = Box{half_chassis},
                 .position = {0, 0, hub + half_chassis.z()},
                 .mass = chassis_mass,
                 .material = builtin_material};
  scene.bodies.push_back(chassis);

  const JointAxis springs = {.range = {-travel, travel}, .spring = suspension_spring()};
  for (int i = 0; i < 4; ++i) {
    const bool front = i < 2;
    SceneBody wheel;
    wheel.name = std::string("wheel_") + (front ? "front_" : "rear_") + (i % 2 == 0 ? "left" : "right");
    wheel.def = {.shape = Sphere{wheel_radius},
                 .position = {front ? axle : -axle, i % 2 == 0 ? track : -track, hub},
                 .mass = wheel_mass,
                 .material = tyre};
    scene.bodies.push_back(wheel);
    WheelJoint joint = {.suspension = springs};
    if (front) {
      joint.steering = {.range = {-0.6, 0.6}, .spring = JointSpring{steering_hertz, 1, steer}};
    } else {
      joint.spin.motor = JointMotor{values["speed"] / wheel_radius, drive_torque};
    }
    scene.joints.push_back(
        joined(scene, wheel.name, joint, 1, scene.bodies.size() - 1, {wheel.def.position, Quaternion::Identity()}));
  }
  return scene;
}

}  // namespace atl::scene
