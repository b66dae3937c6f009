// Maps velocities to motions of contacts and joints, and impulses to momenta.

#include <jobs/assert.h>
#include <solver/direct/direct_rows.h>
#include <solver/integrate/motion_locks.h>

namespace atl::solver {
namespace {

// The places in a Six of the parts along and about an axis.
constexpr int along(int axis) { return axis == 0 ? 0 : 2 + axis; }
constexpr int about(int axis) { return axis == 0 ? 5 : axis; }

constexpr double at_rest[6] = {};

Vector3 linear(const double* velocity) { return {velocity[0], velocity[1], velocity[2]}; }
Vector3 angular(const double* velocity) { return {velocity[3], velocity[4], velocity[5]}; }

}  // namespace

void DirectBody::weigh(double mass_now, double inverse) {
  mass = mass_now;
  inverse_mass = without(linear_locks(locks), Vector3::Constant(inverse));
}

void DirectContact::add_motion(double sign, const Vector3& arm, const Vector3& v, const Vector3& w, Six& to) const {
  const Vector3 at_centre = v + w.cross(arm);
  for (int axis = 0; axis < 3; ++axis) {
    to[along(axis)] += sign * axes[axis].dot(at_centre);
    to[about(axis)] += sign * axes[axis].dot(w);
  }
}

void DirectContact::bound_friction(double load) {
  ATL_ASSERT(!(load < 0), slot, load);
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

void DirectContact::give(const Vector3& velocity) {
  for (int axis = 0; axis < 3; ++axis) given[along(axis)] += axes[axis].dot(velocity);
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

JointRow DirectJoint::row(std::size_t r) const {
  if (r >= point_rows()) return at[r];
  const Vector3 along = Vector3::Unit(static_cast<Eigen::Index>(r));
  return {.linear = along, .angular_first = arm_first.cross(along), .angular_second = arm_second.cross(along)};
}

double DirectTerm::rate_by(const double* velocities) const {
  const double* a = first == no_body ? at_rest : velocities + 6 * first;
  const double* b = second == no_body ? at_rest : velocities + 6 * second;
  return row.at.rate(linear(a), angular(a), linear(b), angular(b));
}

PulledBodies DirectJoint::pulled() const {
  PulledBodies bodies;
  for (std::size_t i = 0; i < terms; ++i) bodies.add(term[i].first, term[i].second, term[i].row);
  return bodies;
}

void DirectJoint::move_terms(const std::vector<double>& velocities, double time) {
  for (std::size_t i = 0; i < terms; ++i) term[i].row.position += time * term[i].rate_by(velocities.data());
}

double DirectJoint::rate_by(const std::vector<double>& velocities, std::size_t row, double start) const {
  double sum = start;
  if (is_tendon()) {
    rates_by(velocities.data(), &sum);
    return start + sum;
  }
  const JointRow& of = at[row];
  const auto add = [&](std::uint32_t body, const Vector3& angular, double sign) {
    if (body == no_body) return;
    sum += sign * (of.linear.dot(linear_part(velocities, body)) + angular.dot(angular_part(velocities, body)));
  };
  add(first, of.angular_first, -1);
  add(second, of.angular_second, 1);
  return sum;
}

void DirectJoint::rates_by(const double* velocities, double* rates) const {
  if (is_tendon()) {
    rates[0] = 0;
    for (std::size_t i = 0; i < terms; ++i) rates[0] += term[i].row.slope * term[i].rate_by(velocities);
    return;
  }
  const double* a = first == no_body ? at_rest : velocities + 6 * first;
  const double* b = second == no_body ? at_rest : velocities + 6 * second;
  const Vector3 apart = linear(b) - linear(a);
  const Vector3 spin_a = angular(a), spin_b = angular(b);
  std::size_t r = 0;
  if (point) {
    const Vector3 rate = apart + (spin_b.cross(arm_second) - spin_a.cross(arm_first));
    for (; r < 3; ++r) rates[r] = rate[static_cast<Eigen::Index>(r)];
  }
  for (; r < rows; ++r) {
    const JointRow& row = at[r];
    rates[r] = row.linear.dot(apart) + (row.angular_second.dot(spin_b) - row.angular_first.dot(spin_a));
  }
}

Vector3 DirectJoint::linear_impulse(const Rows<double>& impulses) const {
  Vector3 sum = point ? linear(impulses.data()) : Vector3(0, 0, 0);
  for (std::size_t r = point_rows(); r < rows; ++r) sum += impulses[r] * at[r].linear;
  return sum;
}

void DirectJoint::add_impulses(const double* impulses, double* momenta) const {
  if (is_tendon()) {
    for (const PulledBody& body : pulled()) {
      if (body.body == no_body) continue;
      double* to = momenta + 6 * body.body;
      for (int k = 0; k < 3; ++k) {
        to[k] += impulses[0] * body.linear[k];
        to[3 + k] += impulses[0] * body.angular[k];
      }
    }
    return;
  }
  Vector3 force = Vector3::Zero(), couple_first = Vector3::Zero(), couple_second = Vector3::Zero();
  std::size_t r = 0;
  if (point) {
    force = linear(impulses);
    couple_first = arm_first.cross(force);
    couple_second = arm_second.cross(force);
    r = 3;
  }
  for (; r < rows; ++r) {
    force += impulses[r] * at[r].linear;
    couple_first += impulses[r] * at[r].angular_first;
    couple_second += impulses[r] * at[r].angular_second;
  }
  const auto add = [&](std::uint32_t body, double side, const Vector3& couple) {
    if (body == no_body) return;
    double* to = momenta + 6 * body;
    for (int k = 0; k < 3; ++k) {
      to[k] += side * force[k];
      to[3 + k] += side * couple[k];
    }
  };
  add(first, -1, couple_first);
  add(second, 1, couple_second);
}

void DirectJoint::set_momenta(std::size_t row, std::vector<double>& momenta) const {
  std::fill(momenta.begin(), momenta.end(), 0.0);
  Rows<double> impulse = {};
  impulse[row] = 1;
  add_impulses(impulse.data(), momenta.data());
}

}  // namespace atl::solver
