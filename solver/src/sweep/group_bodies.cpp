#include <jobs/assert.h>
#include <solver/constraints/contact_arm.h>
#include <solver/constraints/contact_inertia.h>
#include <solver/constraints/tendon.h>
#include <solver/integrate/free_flight.h>
#include <solver/integrate/motion_locks.h>
#include <solver/sweep/group_bodies.h>

#include <algorithm>
#include <cmath>

#include "integrate/matrix3.h"
#include "integrate/rows3.h"

namespace atl::solver {
namespace {

void load_shape(const SolveInput& input, std::uint32_t body, std::size_t local, SolverBodies& rows) {
  const Vector3 half = half_turn(input.bodies, body, input.dt);
  if (half.isZero(0)) return;
  rows.shape[local].kind = input.bodies.rolls[body] ? 2 : 1;
  set3(rows.shape[local].half_turn, half);
}

// A turn without the spin about the axis of a body that is alike all round it, which goes with that axis.
Vector3 tilt_of(const BodyTable& table, std::uint32_t body, const Vector3& turn) {
  const Vector3 moments = table.moments[body];
  const auto alike = [](double a, double b) { return std::abs(a - b) <= 1e-9 * a; };
  const int axis = alike(moments[0], moments[1])   ? 2
                   : alike(moments[1], moments[2]) ? 0
                   : alike(moments[2], moments[0]) ? 1
                                                   : -1;
  if (axis < 0) return turn;
  const Vector3 of = table.orientation(body) * (table.principal_axes[body] * Vector3::Unit(axis));
  return turn - turn.dot(of) * of;
}

void load_velocity(const BodyTable& table, std::uint32_t body, std::size_t local, SolverBodies& rows) {
  set3(rows.start_velocity[local].linear, table.velocity(body));
  set3(rows.start_velocity[local].angular, table.angular_velocity(body));
}

}  // namespace

void GroupBodies::collect(const SolveInput& input, const IslandGroup& group) {
  const std::span<const Mobility> mobility = input.bodies.mobility;
  kinematic_.clear();
  const auto collect = [&](const auto& pair) {
    if (mobility[pair.first] == Mobility::Kinematic) kinematic_.push_back(pair.first);
    if (mobility[pair.second] == Mobility::Kinematic) kinematic_.push_back(pair.second);
  };
  for (const collision::TouchingPair& pair : input.islands.contacts(group.begin, group.end)) collect(pair);
  for (const JointLink& link : input.islands.joints(group.begin, group.end)) {
    collect(link);
    // A joint that has no rows of its own is in no list, and may be a term all the same.
    for_each_term(input.joints, link.joint, collect);
  }
  std::sort(kinematic_.begin(), kinematic_.end());
  kinematic_.erase(std::unique(kinematic_.begin(), kinematic_.end()), kinematic_.end());
  first_dynamic_ = 1 + static_cast<std::uint32_t>(kinematic_.size());
  count_ = first_dynamic_ + static_cast<std::uint32_t>(input.islands.bodies(group.begin, group.end).size());
}

namespace {

double least_moment(const BodyTable& bodies, std::uint32_t body) {
  return bodies.gyroscopic[body] ? bodies.moments[body].minCoeff() : bodies.inertia[body].diagonal().minCoeff();
}

Matrix3 inverse_in_sweeps(const BodyTable& bodies, std::uint32_t body) {
  const Matrix3& own = bodies.inertia[body];
  if (!(least_moment(bodies, body) < swept_share * own.trace())) return world_inverse_inertia(bodies, body);
  const Matrix3 inertia = resolved_inertia(bodies, body, bodies.orientation(body), Matrix3::Zero());
  return inverse_inertia_with(bodies.locks[body], inertia);
}

}  // namespace

Matrix3 resolved_inertia(const BodyTable& bodies, std::uint32_t body, const Quaternion& orientation,
                         const Matrix3& added) {
  const Matrix3 rotation = orientation.toRotationMatrix();
  const Matrix3 inertia = symmetric_product(product(rotation, bodies.inertia[body]), rotation) + added;
  const double min = swept_share * inertia.trace();
  return least_moment(bodies, body) < min ? Matrix3(inertia + min * Matrix3::Identity()) : inertia;
}

void set_inverse_inertia(SolverBodies& rows, std::size_t local, const Matrix3& inverse) {
  ATL_ASSERT(!((inverse - inverse.transpose()).norm() > 1e-6 * inverse.norm()), local, inverse.norm());
  for (VelocityRows* velocity : {&rows.velocity[local], &rows.start_velocity[local]}) {
    velocity->inertia_xx = static_cast<float>(inverse(0, 0));
    velocity->inertia_yy = static_cast<float>(inverse(1, 1));
  }
  rows.inertia[local] = {static_cast<float>(inverse(2, 2)), static_cast<float>(inverse(0, 1)),
                         static_cast<float>(inverse(0, 2)), static_cast<float>(inverse(1, 2))};
}

std::vector<double> approach_speeds(const SolveInput& input, const IslandGroup& group, const GroupBodies& numbers) {
  if (input.bodies.min_moment.empty()) return {};
  std::vector<double> speeds(numbers.count(), 0.0);
  for (const collision::TouchingPair& pair : input.islands.contacts(group.begin, group.end)) {
    const double speed = (input.bodies.velocity(pair.first) - input.bodies.velocity(pair.second)).norm();
    for (const std::uint32_t body : {pair.first, pair.second}) {
      double& max = speeds[static_cast<std::size_t>(numbers.local(input, group, body))];
      max = std::max(max, speed);
    }
  }
  return speeds;
}

void load_bodies(const SolveInput& input, std::span<const std::uint32_t> bodies, std::size_t begin, std::size_t end,
                 std::uint32_t first_dynamic, std::span<const double> approaches, SolverBodies& rows) {
  const double substep = input.dt / input.settings.substeps;
  const BodyTable& table = input.bodies;
  for (std::size_t i = begin; i < end; ++i) {
    const std::uint32_t body = bodies[i];
    const std::size_t local = first_dynamic + i;
    const bool heavier = is_seen_heavier(table, body) && input.islands.joint_count(input.islands.island_of(body)) == 0;
    ATL_ASSERT(table.mobility[body] == Mobility::Dynamic && local < rows.velocity.size(), body, local,
               rows.velocity.size());
    ATL_ASSERT(!heavier || local < approaches.size(), body, local, approaches.size());
    if (!rows.shape.empty()) load_shape(input, body, local, rows);
    const double swing = heavier ? swing_in_contact(table, body, approaches[local], input.dt) : 0;
    Matrix3 inverse_inertia = heavier ? inverse_inertia_in_contact(table, body, swing) : inverse_in_sweeps(table, body);
    if (!rows.shape.empty() && rows.shape[local].kind > 0 && table.gyroscopic[body]) {
      // The inertia in the orientation half way through the step.
      const Vector3 turn = get3(rows.shape[local].half_turn);
      const Matrix3 half = rotation_by(table.rolls[body] ? tilt_of(table, body, turn) : turn).toRotationMatrix();
      inverse_inertia = symmetric_product(product(half, inverse_inertia), half);
    }

    load_velocity(table, body, local, rows);
    set_inverse_inertia(rows, local, inverse_inertia);
    rows.free_velocity[local].inverse_mass = static_cast<float>(table.inverse_mass[body]);

    rows.displacement[local].carries = table.ball[body] ? 0.0f : 1.0f;

    AccelerationRows& acceleration = rows.acceleration[local];
    set3(acceleration.linear,
         linear_acceleration(table, body, input.gravity) - table.linear_damping[body] * table.velocity(body));
    const Vector3 turn = inverse_inertia * table.torque(body);
    const unsigned locked_turns = angular_locks(table.locks[body]);
    set3(acceleration.angular, (locked_turns == 0 ? turn : without(locked_turns, turn)) -
                                   table.angular_damping[body] * table.angular_velocity(body));
    acceleration.linear_damping = static_cast<float>(1 / (1 + substep * table.linear_damping[body]));
    acceleration.angular_damping = static_cast<float>(1 / (1 + substep * table.angular_damping[body]));

    if (!rows.locks.empty()) rows.locks[local] = LockRow::of(table.locks[body]);

    if (table.gyroscopic[body]) {
      rows.gyroscopic[local] = GyroscopicRows::of(table.orientation(body) * table.principal_axes[body],
                                                  heavier ? moments_in_contact(table, body) : table.moments[body]);
    }
  }
}

void load_kinematic_bodies(const SolveInput& input, std::span<const std::uint32_t> kinematic, SolverBodies& rows) {
  for (std::size_t i = 0; i < kinematic.size(); ++i) {
    load_velocity(input.bodies, kinematic[i], 1 + i, rows);
    if (!rows.shape.empty()) load_shape(input, kinematic[i], 1 + i, rows);
  }
}

}  // namespace atl::solver
