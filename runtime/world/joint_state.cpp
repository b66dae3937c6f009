// Positions, speeds and forces of a joint at the end of the last step.

#include <solver/constraints/tendon.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "world/joints.h"
#include "world/make_joint.h"

namespace atl {
namespace {

// kg or kg m^2: of two bodies along a row, if nothing else held them. 0 of bodies that aren't dynamic.
double mass_along(const solver::JointRow& row, const solver::Joint& joint, const solver::BodyTable& bodies) {
  const auto inverse_inertia = [&](std::uint32_t body) -> Matrix3 {
    const Matrix3 turn = bodies.orientation(body).toRotationMatrix();
    return turn * bodies.inverse_inertia[body] * turn.transpose();
  };
  const double response = row.response(bodies.inverse_mass[joint.first] + bodies.inverse_mass[joint.second],
                                       inverse_inertia(joint.first), inverse_inertia(joint.second));
  return response > 0 ? 1 / response : 0;
}

// N or N m: a spring's, of a frequency with the mass along its row.
double spring_force(const solver::Law& law, double position, double speed, double mass) {
  if (law.spring_hertz == 0) return -law.stiffness * (position - law.rest) - law.damping * speed;
  const double omega = 2 * std::numbers::pi * law.spring_hertz;
  return -mass * omega * (omega * (position - law.rest) + 2 * law.damping_ratio * speed);
}

// N or N m, in the last substep of so many seconds, with a spring beside it; see JointState::motor.
double motor_force(const solver::Joint& joint, std::size_t row, double position, double speed, double spring,
                   double substep) {
  const solver::Law& law = joint.law[row];
  if (!law.drives() || substep == 0) return 0;
  const double max = law.motor_force;
  if (law.is_servo()) {
    const double wanted =
        law.servo_stiffness * (law.servo_target - position) + law.servo_damping * (law.motor_speed - speed);
    return std::clamp(wanted, -max, max);
  }
  const double way = law.motor_speed < 0 ? -1 : 1;
  if (law.motor_speed != 0 && joint.limit[row] * way > 0 && std::isfinite(max)) return way * max;
  const double all = joint.impulse[row] / substep - spring;
  // Friction holds back the motor; where both hold the coordinate still, it takes what it can.
  const double rubs = law.motor_speed != 0 ? -way * law.friction : std::clamp(all, -law.friction, law.friction);
  return std::clamp(all - rubs, -max, max);
}

}  // namespace

JointState joint_state(const Stores& world, std::uint32_t index) {
  const solver::Joint& joint = world.joints.joints[index];
  JointState state{.enabled = world.joints.enabled[index] != 0,
                   .broken = world.joints.broken[index] != 0,
                   .force = joint.force,
                   .torque = joint.torque};
  if (joint.is_tendon()) {
    const solver::TendonNow now = tendon_now(joint, world.joints.joints.data(), world.bodies);
    if (std::isfinite(now.length) && std::isfinite(now.rate)) {
      state.position[0] = now.length;
      state.speed[0] = now.rate;
      const double spring = spring_force(joint.law[0], now.length, now.rate, 0);
      state.motor[0] = motor_force(joint, 0, now.length, now.rate, spring, world.clock.last_substep);
    }
    return state;
  }
  const std::span<const solver::Coordinate> names = named_coordinates(world.joints.def[index]->kind);
  // Without the joint's laws: to copy those costs more than all the rest.
  solver::Joint named;
  named.first = joint.first;
  named.second = joint.second;
  named.anchor_first = joint.anchor_first;
  named.anchor_second = joint.anchor_second;
  named.axes_first = joint.axes_first;
  named.axes_second = joint.axes_second;
  named.rows = static_cast<std::uint8_t>(names.size());
  std::copy(names.begin(), names.end(), named.coordinate.begin());
  const solver::JointFrames frames = frames_of(world, named);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const solver::JointRow row = coordinate_row(names[i], frames, joint.ratio);
    const std::size_t kept = joint.row_along(names[i]);
    const double position = kept == joint.rows ? row.value : continued(names[i], row.value, joint.position[kept]);
    const double speed = row.rate(world.bodies.velocity(joint.first), world.bodies.angular_velocity(joint.first),
                                  world.bodies.velocity(joint.second), world.bodies.angular_velocity(joint.second));
    // Skips joints of quarantined bodies, which may be anywhere.
    if (!std::isfinite(position) || !std::isfinite(speed)) continue;
    state.position[i] = position;
    state.speed[i] = speed;
    if (kept == joint.rows || !joint.law[kept].drives()) continue;
    const double mass = joint.law[kept].spring_hertz > 0 ? mass_along(row, joint, world.bodies) : 0;
    const double spring = spring_force(joint.law[kept], position, speed, mass);
    state.motor[i] = motor_force(joint, kept, position, speed, spring, world.clock.last_substep);
  }
  return state;
}

}  // namespace atl
