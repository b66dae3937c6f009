// What a group is made of: bodies, contacts and joints under the group's own numbers.

#include <jobs/with_joints.h>
#include <jobs/with_surfaces.h>
#include <solver/constraints/contact_inertia.h>
#include <solver/constraints/motion_locks.h>
#include <solver/integrate/free_flight.h>
#include <solver/sweep/group_solver.h>
#include <solver/tuning.h>

#include <Eigen/LU>
#include <algorithm>

#include "integrate/matrix3.h"
#include "integrate/rows3.h"

namespace atl::solver {

// Those that contacts touch or joints join.
void GroupSolver::collect_kinematic_bodies(const SolveInput& input, const IslandGroup& group) {
  const std::vector<Mobility>& mobility = input.bodies.mobility;
  kinematic_.clear();
  const auto collect = [&](const auto& pairs) {
    for (const auto& pair : pairs) {
      if (mobility[pair.first] == Mobility::Kinematic) kinematic_.push_back(pair.first);
      if (mobility[pair.second] == Mobility::Kinematic) kinematic_.push_back(pair.second);
    }
  };
  collect(input.islands.contacts(group.begin, group.end));
  collect(input.islands.joints(group.begin, group.end));
  std::sort(kinematic_.begin(), kinematic_.end());
  kinematic_.erase(std::unique(kinematic_.begin(), kinematic_.end()), kinematic_.end());
  first_dynamic_ = 1 + static_cast<std::uint32_t>(kinematic_.size());
}

// The group's own index of a body.
std::uint32_t GroupSolver::local_body(const SolveInput& input, const IslandGroup& group, std::uint32_t body) const {
  switch (input.bodies.mobility[body]) {
    case Mobility::Fixed:
      return 0;
    case Mobility::Kinematic:
      return 1 + static_cast<std::uint32_t>(std::lower_bound(kinematic_.begin(), kinematic_.end(), body) -
                                            kinematic_.begin());
    case Mobility::Dynamic:
      break;
  }
  return first_dynamic_ + input.islands.rank(body) - input.islands.first_rank(group.begin);
}

void GroupSolver::collect_contacts(const SolveInput& input, const IslandGroup& group) {
  contacts_.clear();
  friction_ = restitution_ = false;
  const std::span<const TouchingPair> touching = input.islands.contacts(group.begin, group.end);
  for (std::size_t i = 0; i < touching.size(); ++i) {
    // Slots are in no order: what is needed soon is asked of memory now.
    constexpr std::size_t ahead = 16;
    if (i + ahead < touching.size()) __builtin_prefetch(&input.manifolds[touching[i + ahead].slot]);
    const TouchingPair& pair = touching[i];
    const collision::ContactManifold& manifold = input.manifolds[pair.slot];
    const std::uint32_t first = local_body(input, group, pair.first);
    const std::uint32_t second = local_body(input, group, pair.second);
    const bool rubs = manifold.friction > 0;
    const bool bounces = manifold.restitution > 0;
    const bool rolls = input.bodies.ball[pair.first] || input.bodies.ball[pair.second];  // it has one point
    const int movers = first == 0 ? 1 : second == 0 ? 2 : 0;
    const int kind = 8 * movers + 4 * rolls + 2 * rubs + bounces;
    contacts_.push_back({first, second, pair.slot, static_cast<std::uint8_t>(kind)});
    friction_ |= rubs;
    restitution_ |= bounces;
  }
}

// Joints of components that are solved at once are left to who does that; what else happens to bodies that are joined
// happens to all.
void GroupSolver::collect_joints(const SolveInput& input, const IslandGroup& group) {
  if constexpr (!with_joints) return;
  joints_.clear();
  joined_.clear();
  const std::span<const JointLink> links = input.islands.joints(group.begin, group.end);
  if (links.empty()) return;
  joined_motion_.build(input, group);
  joined_.resize(first_dynamic_ + input.islands.bodies(group.begin, group.end).size());
  for (std::size_t i = first_dynamic_; i < joined_.size(); ++i) {
    joined_[i] = joined_motion_.is_joined(i - first_dynamic_);
  }
  for (const JointLink& link : links) {
    if (input.solves_directly(input.joint_graph->component_of(link.joint))) continue;
    const Joint& joint = input.joints[link.joint];
    joints_.add({local_body(input, group, link.first), local_body(input, group, link.second), link.joint, joint.point,
                 joint.rows},
                joint.bounces);
  }
}

// Notes what the surfaces of touching pairs do in this step. Whether that is more than plain friction anywhere.
bool GroupSolver::note_surfaces(const SolveInput& input, const IslandGroup& group) {
  if (!with_surfaces || input.surface_contacts == nullptr) return false;
  bool any = input.settings.everything;
  for (const TouchingPair& pair : input.islands.contacts(group.begin, group.end)) {
    any |= note_surfaces_of(pair, input.bodies, input.manifolds[pair.slot], input.added_slip(pair.slot),
                            input.surface_contacts[pair.slot]);
    any |= input.rises != nullptr && input.rises[pair.slot] != 0;
  }
  return any;
}

void GroupSolver::load_bodies(const SolveInput& input, std::span<const std::uint32_t> bodies, std::size_t begin,
                              std::size_t end, double substep) {
  const BodyTable& table = input.bodies;
  for (std::size_t i = begin; i < end; ++i) {
    const std::uint32_t body = bodies[i];
    const std::size_t local = first_dynamic_ + i;
    const bool heavier = is_seen_heavier(input, body);
    if (!bodies_.shape.empty()) load_shape(input, body, local);
    Matrix3 inverse_inertia = heavier ? inverse_inertia_in_contact(table, body) : world_inverse_inertia(table, body);
    if (!bodies_.shape.empty() && bodies_.shape[local].kind > 0 && table.gyroscopic[body]) {
      // As it is half way through the step.
      const Matrix3 half = rotation_by(get3(bodies_.shape[local].half_turn)).toRotationMatrix();
      inverse_inertia = symmetric_product(product(half, inverse_inertia), half);
    }

    VelocityRows& velocity = bodies_.velocity[local];
    set3(velocity.linear, table.velocity(body));
    set3(velocity.angular, table.angular_velocity(body));
    set_inverse_inertia(local, inverse_inertia);

    FreeVelocityRows& free_velocity = bodies_.free_velocity[local];
    set3(free_velocity.linear, table.velocity(body));
    set3(free_velocity.angular, table.angular_velocity(body));
    free_velocity.inverse_mass = static_cast<float>(table.inverse_mass[body]);

    bodies_.displacement[local].carries = table.ball[body] ? 0.0f : 1.0f;

    AccelerationRows& acceleration = bodies_.acceleration[local];
    set3(acceleration.linear, linear_acceleration(table, body, input.gravity));
    const Vector3 turn = inverse_inertia * table.torque(body);
    const unsigned locked_turns = angular_locks(table.locks[body]);
    set3(acceleration.angular, locked_turns == 0 ? turn : without(locked_turns, turn));
    acceleration.linear_damping = static_cast<float>(1 / (1 + substep * table.linear_damping[body]));
    acceleration.angular_damping = static_cast<float>(1 / (1 + substep * table.angular_damping[body]));

    if (!bodies_.locks.empty()) bodies_.locks[local] = LockRow::of(table.locks[body]);

    if (table.gyroscopic[body]) {
      bodies_.gyroscopic[local] = GyroscopicRows::of(table.orientation(body) * table.principal_axes[body],
                                                     heavier ? moments_in_contact(table, body) : table.moments[body]);
    }
  }
}

// Whether contacts move with a body that turns in the step, by what counts.
bool GroupSolver::turns(const SolveInput& input, std::uint32_t body) const {
  return input.dt * input.bodies.angular_velocity(body).norm() > tuning::least_turn && !input.bodies.ball[body];
}

void GroupSolver::load_shape(const SolveInput& input, std::uint32_t body, std::size_t local) {
  ShapeRows& shape = bodies_.shape[local];
  shape.kind = turns(input, body) ? 1 : 0;
  if (shape.kind == 0) return;
  const Vector3 turn = input.dt * input.bodies.angular_velocity(body);
  Vector3 moves = turn;
  if (input.bodies.round[body]) {
    const Vector3 axis = input.bodies.orientation(body) * Vector3::UnitZ();
    shape.kind = 2;
    set3(shape.axis, axis);
    moves -= turn.dot(axis) * axis;
  }
  // What turns far in a step may come to turn any way in it.
  const double square = turn.squaredNorm() / (tuning::known_turn * tuning::known_turn);
  set3(shape.half_turn, 0.5 / (1 + square * square) * moves);
}

// Where tension turns bodies back faster than substeps can follow, it counts as inertia.
void GroupSolver::stiffen_bodies(const SolveInput& input, std::span<const std::uint32_t> bodies, std::size_t begin,
                                 std::size_t end) {
  constexpr double negligible = 1e-3;  // of the inertia
  const double h = input.dt / input.settings.substeps;
  for (std::size_t i = begin; i < end; ++i) {
    Matrix3& added = stiffness_[first_dynamic_ + i];
    added *= h * h;
    const Matrix3& own = input.bodies.inertia[bodies[i]];
    if (!(added.trace() > negligible * own.trace())) {
      added.setZero();
      continue;
    }
    const Matrix3 rotation = input.bodies.orientation(bodies[i]).toRotationMatrix();
    set_inverse_inertia(first_dynamic_ + i, (rotation * own * rotation.transpose() + added).inverse());
  }
}

// Bodies of unequal moments of inertia in swept joints, whose inertia is to turn with them in the step. Contacts have
// made their matrices of it: what they touch is left as it is.
void GroupSolver::find_followers(const SolveInput& input, std::span<const std::uint32_t> bodies) {
  followers_.clear();
  for (std::uint32_t i = 0; i < bodies.size(); ++i) {
    if (!input.bodies.gyroscopic[bodies[i]] || !joined_motion_.follows(i)) continue;
    const Matrix3& added = stiffness_[first_dynamic_ + i];
    const Matrix3 rotation = input.bodies.orientation(bodies[i]).toRotationMatrix();
    const Matrix3 own = symmetric_product(product(rotation, input.bodies.inertia[bodies[i]]), rotation);
    followers_.push_back({i, !added.isZero(0), own + added});
  }
}

void GroupSolver::follow_inertia(const SolveInput& input, std::span<const std::uint32_t> bodies) {
  for (Follower& follower : followers_) {
    const std::size_t local = first_dynamic_ + follower.place;
    const std::uint32_t body = bodies[follower.place];
    const Vector3 spin = get3(bodies_.velocity[local].angular);
    if (!(spin.squaredNorm() > tuning::least_spin * tuning::least_spin)) continue;
    const Quaternion turn = rotation_of(bodies_.displacement[local]) * input.bodies.orientation(body);
    const Matrix3 rotation = turn.normalized().toRotationMatrix();
    Matrix3 inertia = symmetric_product(product(rotation, input.bodies.inertia[body]), rotation);
    if (follower.stiff) inertia += stiffness_[local];
    const Matrix3 inverse = symmetric_inverse(inertia);
    // What joints did is carried over as a change of spin: as the same angular impulse it is another one now.
    FreeVelocityRows& free = bodies_.free_velocity[local];
    const Vector3 done = spin - get3(free.angular);
    set3(free.angular, spin - product(inverse, product(follower.inertia, done)));
    set_inverse_inertia(local, inverse);
    follower.inertia = inertia;
  }
}

void GroupSolver::set_inverse_inertia(std::size_t local, const Matrix3& inverse) {
  bodies_.velocity[local].inertia_xx = static_cast<float>(inverse(0, 0));
  bodies_.velocity[local].inertia_yy = static_cast<float>(inverse(1, 1));
  bodies_.inertia[local] = {static_cast<float>(inverse(2, 2)), static_cast<float>(inverse(0, 1)),
                            static_cast<float>(inverse(0, 2)), static_cast<float>(inverse(1, 2))};
}

void GroupSolver::load_kinematic_bodies(const SolveInput& input) {
  for (std::size_t i = 0; i < kinematic_.size(); ++i) {
    VelocityRows& velocity = bodies_.velocity[1 + i];
    set3(velocity.linear, input.bodies.velocity(kinematic_[i]));
    set3(velocity.angular, input.bodies.angular_velocity(kinematic_[i]));
    FreeVelocityRows& free_velocity = bodies_.free_velocity[1 + i];
    std::copy_n(velocity.linear, 3, free_velocity.linear);
    std::copy_n(velocity.angular, 3, free_velocity.angular);
    if (!bodies_.shape.empty()) load_shape(input, kinematic_[i], 1 + i);
  }
}

}  // namespace atl::solver
