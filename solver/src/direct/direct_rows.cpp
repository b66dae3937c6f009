// What velocities make of contacts and joints, and impulses of momenta.

#include <solver/direct/direct_rows.h>

namespace atl::solver {
namespace {

// Where in a Six what is along and about an axis is.
constexpr int along(int axis) { return axis == 0 ? 0 : 2 + axis; }
constexpr int about(int axis) { return axis == 0 ? 5 : axis; }

}  // namespace

void DirectContact::add_motion(double sign, const Vector3& arm, const Vector3& v, const Vector3& w, Six& to) const {
  const Vector3 at_centre = v + w.cross(arm);
  for (int axis = 0; axis < 3; ++axis) {
    to[along(axis)] += sign * axes[axis].dot(at_centre);
    to[about(axis)] += sign * axes[axis].dot(w);
  }
}

void DirectContact::bound_friction(double load) {
  law.friction_bound = friction * load;
  law.torsional_bound = radius * law.friction_bound + torsional * load;
  law.rolling_bound = rolling * load;
}

Six DirectContact::motion_after(double t) const {
  Six after = motion;
  for (int k = 0; k < 6; ++k) after[k] += t * change[k];
  return after;
}

Six DirectContact::motion_by(const std::vector<double>& velocities) const {
  Six made = {};
  const auto add = [&](std::uint32_t body, const Vector3& arm, double sign) {
    if (body == no_body) return;
    add_motion(sign, arm, linear_part(velocities, body), angular_part(velocities, body), made);
  };
  add(first, arm_first, -1);
  add(second, arm_second, 1);
  return made;
}

Six DirectContact::motion_at(const std::vector<double>& velocities) const {
  Six there = motion_by(velocities);
  for (int k = 0; k < 6; ++k) there[k] += given[k];
  return there;
}

void DirectContact::add_impulse(const Six& impulse, double sign, std::vector<double>& to) const {
  const Vector3 force = impulse[0] * axes[0] + impulse[3] * axes[1] + impulse[4] * axes[2];
  const Vector3 couple = impulse[1] * axes[1] + impulse[2] * axes[2] + impulse[5] * axes[0];
  const auto add = [&](std::uint32_t body, const Vector3& arm, double side) {
    if (body == no_body) return;
    const Vector3 torque = couple + arm.cross(force);
    for (int k = 0; k < 3; ++k) {
      to[6 * body + k] += side * force[k];
      to[6 * body + 3 + k] += side * torque[k];
    }
  };
  add(first, arm_first, -sign);
  add(second, arm_second, sign);
}

double DirectJoint::rate_by(const std::vector<double>& velocities, std::size_t row, double start) const {
  double sum = start;
  const auto add = [&](std::uint32_t body, const Vector3& angular, double sign) {
    if (body == no_body) return;
    sum += sign * (at[row].linear.dot(linear_part(velocities, body)) + angular.dot(angular_part(velocities, body)));
  };
  add(first, at[row].angular_first, -1);
  add(second, at[row].angular_second, 1);
  return sum;
}

void DirectJoint::add_impulse(std::size_t row, double row_impulse, std::vector<double>& to) const {
  const auto add = [&](std::uint32_t body, const Vector3& angular, double side) {
    if (body == no_body) return;
    for (int k = 0; k < 3; ++k) {
      to[6 * body + k] += side * at[row].linear[k];
      to[6 * body + 3 + k] += side * angular[k];
    }
  };
  add(first, at[row].angular_first, -row_impulse);
  add(second, at[row].angular_second, row_impulse);
}

}  // namespace atl::solver
