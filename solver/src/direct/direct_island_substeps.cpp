// An island with joints in it: substeps of RATTLE (Andersen, "Rattle: a velocity version of the Shake algorithm",
// J. Comput. Phys. 1983), with the contacts in the system of the joints.

#include <solver/constraints/arm_stiffness.h>
#include <solver/direct/direct_island.h>
#include <solver/integrate/motion.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

#include "integrate/rows3.h"

namespace atl::solver {
namespace {

JointRow point_row(int axis, const Vector3& arm_first, const Vector3& arm_second) {
  JointRow row;
  row.linear = Vector3::Unit(axis);
  row.angular_first = arm_first.cross(row.linear);
  row.angular_second = arm_second.cross(row.linear);
  return row;
}

// How the normal speed of a contact's point changes as a body turns: what its arm gains.
Vector3 gained_by_turning(const Quaternion& start, const Quaternion& now, const Vector3& arm) {
  return now * (start.conjugate() * arm) - arm;
}

}  // namespace

bool DirectIsland::solve_substeps(const DirectIslandInput& input) {
  const SolverSettings& settings = input.settings;
  const double h = input.dt / settings.substeps;
  load_joints(input);
  place_inertia(input, 0, h);
  place_joints(input, 0);
  note_tears(input);
  if (may_bounce(input)) return false;
  for (int substep = 0; substep < settings.substeps; ++substep) {
    lasting_ = problem_.velocity;
    free_substep_velocities(input, h);
    begin_laws(input, h);
    if (!all_locked_) forget_factor(problem_);
    if (!find_motions(settings, h, drive(h, input))) return false;
    if (pushes_) push_gently(settings.contact_push_speed);
    if (input.capture != nullptr && substep + 1 == settings.substeps) capture(input, h);
    const double time = h * (substep + 1);
    move(h, problem_.velocity);
    close_joints(input, h, time);
    place_inertia(input, time, h);
    place_joints(input, time);
    place_contacts(input, time);
    if (!project(h)) return false;
  }
  settle_joints(input);
  write_back_substeps(input);
  write_impulses(input, 1);
  return true;
}

void DirectIsland::load_joints(const DirectIslandInput& input) {
  all_locked_ = true;
  for (std::size_t j = 0; j < links_.size(); ++j) {
    const Joint& from = input.joints[links_[j].joint];
    DirectJoint& joint = problem_.joints[j];
    joint.joint = links_[j].joint;
    joint.first_body = links_[j].first;
    joint.second_body = links_[j].second;
    joint.first = local(input, joint.first_body);
    joint.second = local(input, joint.second_body);
    joint.rows = from.row_count();
    joint.tension = from.tension;
    joint.position = {};
    joint.impulse = {};
    const std::size_t points = from.point ? 3 : 0;
    for (std::size_t r = points; r < joint.rows; ++r) {
      joint.position[r] = from.position[r - points];
      all_locked_ &= from.law[r - points].locked();
    }
  }
  placed_.resize(pairs_.size());
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    placed_[c] = {pairs_[c].first, pairs_[c].second, problem_.contacts[c].separation};
  }
}

// World frame, with what tension adds.
void DirectIsland::place_inertia(const DirectIslandInput& input, double time, double h) {
  for (State& state : states_) state.stiffness.setZero();
  for (DirectJoint& joint : problem_.joints) {
    const Joint& of = input.joints[joint.joint];
    joint.arm_first = pose_of(input, joint.first, joint.first_body, time).orientation * of.anchor_first;
    joint.arm_second = pose_of(input, joint.second, joint.second_body, time).orientation * of.anchor_second;
    const auto add = [&](std::uint32_t body, const Vector3& arm, const Vector3& force) {
      if (body != no_body) states_[body].stiffness += arm_stiffness(arm, force);
    };
    add(joint.first, joint.arm_first, -joint.tension);
    add(joint.second, joint.arm_second, joint.tension);
  }
  for (std::size_t i = 0; i < states_.size(); ++i) {
    State& state = states_[i];
    const Matrix3 rotation = state.turn.toRotationMatrix();
    state.inertia = rotation * state.body_inertia * rotation.transpose();
    DirectBody& of = problem_.bodies[i];
    of.inertia = state.inertia + h * h * state.stiffness;
    of.inverse_inertia = of.inertia.inverse();
  }
}

// Rows at the poses that bodies have `time` seconds into the step.
void DirectIsland::place_joints(const DirectIslandInput& input, double time) {
  const BodyTable& table = input.bodies;
  for (DirectJoint& joint : problem_.joints) {
    const Joint& of = input.joints[joint.joint];
    const BodyPose first = pose_of(input, joint.first, joint.first_body, time);
    const BodyPose second = pose_of(input, joint.second, joint.second_body, time);
    std::size_t r = 0;
    if (of.point) {
      const Vector3 offset = (second.position - first.position) + (joint.arm_second - joint.arm_first);
      for (; r < 3; ++r) {
        joint.at[r] = point_row(static_cast<int>(r), joint.arm_first, joint.arm_second);
        joint.position[r] = offset[static_cast<Eigen::Index>(r)];
      }
    }
    if (r < joint.rows) {
      const JointFrames frames =
          joint_frames(of, first.position, first.orientation, second.position, second.orientation);
      for (std::size_t k = 0; r < joint.rows; ++r, ++k) {
        joint.at[r] = joint_row(of, k, frames);
        joint.position[r] = continued(of.coordinate[k], joint.at[r].value, joint.position[r]);
      }
    }
    const auto response = [&](std::uint32_t body, const Vector3& linear, const Vector3& angular) {
      if (body == no_body) return 0.0;
      const DirectBody& b = problem_.bodies[body];
      return linear.squaredNorm() / b.mass + angular.dot(b.inverse_inertia * angular);
    };
    for (r = 0; r < joint.rows; ++r) {
      const JointRow& at = joint.at[r];
      const double responds =
          response(joint.first, at.linear, at.angular_first) + response(joint.second, at.linear, at.angular_second);
      joint.mass[r] = responds > 0 ? 1 / responds : 0;
      joint.given[r] = 0;
      if (joint.first == no_body) {
        joint.given[r] -= at.linear.dot(table.velocity(joint.first_body)) +
                          at.angular_first.dot(table.angular_velocity(joint.first_body));
      }
      if (joint.second == no_body) {
        joint.given[r] += at.linear.dot(table.velocity(joint.second_body)) +
                          at.angular_second.dot(table.angular_velocity(joint.second_body));
      }
    }
  }
  forget_factor(problem_);
}

BodyPose DirectIsland::pose_of(const DirectIslandInput& input, std::uint32_t local, std::uint32_t body, double time) const {
  if (local != no_body) return {states_[local].position, states_[local].turn};
  const BodyTable& table = input.bodies;
  if (table.mobility[body] == Mobility::Fixed) return {table.position(body), table.orientation(body)};
  return {table.position(body) + time * table.velocity(body),
          turned(time * table.angular_velocity(body), table.orientation(body))};
}

// As sweeps see them: a contact stays where it was on its bodies as the step began, and its normal stays too.
void DirectIsland::place_contacts(const DirectIslandInput& input, double time) {
  const BodyTable& table = input.bodies;
  for (std::size_t c = 0; c < problem_.contacts.size(); ++c) {
    DirectContact& contact = problem_.contacts[c];
    const Placed& placed = placed_[c];
    const auto& [normal, tangent, other] = contact.axes;
    const BodyPose pose_first = pose_of(input, contact.first, placed.first_body, time);
    const BodyPose pose_second = pose_of(input, contact.second, placed.second_body, time);
    const auto moved = [&](std::uint32_t body, const BodyPose& now, const Vector3& at) -> Vector3 {
      if (table.mobility[body] == Mobility::Fixed) return Vector3::Zero();
      Vector3 by = now.position - table.position(body);
      // A rolling ball's lowest point does not rise with its surface.
      if (!table.ball[body]) by += gained_by_turning(table.orientation(body), now.orientation, at);
      return by;
    };
    for (int i = 0; i < contact.law.points; ++i) {
      const Vector3 out = contact.law.x[i] * tangent + contact.law.y[i] * other;
      const Vector3 first = moved(placed.first_body, pose_first, contact.arm_first + out);
      const Vector3 second = moved(placed.second_body, pose_second, contact.arm_second + out);
      contact.separation[i] = placed.start_separation[i] + normal.dot(second - first);
    }
  }
}

// Of a row, those of the point first, which are locked.
const Law& DirectIsland::law_of(const Joint& joint, std::size_t row) {
  static constexpr Law locked{.lower = 0, .upper = 0};
  const std::size_t points = joint.point ? 3 : 0;
  return row < points ? locked : joint.law[row - points];
}

void DirectIsland::note_tears(const DirectIslandInput& input) {
  tears_ = false;
  for (DirectJoint& joint : problem_.joints) {
    for (std::size_t r = 0; r < joint.rows; ++r) {
      const Law& law = law_of(input.joints[joint.joint], r);
      joint.torn[r] = law.locked() && std::abs(joint.position[r] - law.lower) > tuning::torn;
      tears_ |= joint.torn[r];
    }
  }
}

// Whether a coordinate that bounces at the ends of its range may get there within the step, and not rest there.
bool DirectIsland::may_bounce(const DirectIslandInput& input) const {
  for (const DirectJoint& joint : problem_.joints) {
    const Joint& of = input.joints[joint.joint];
    if (!of.bounces) continue;
    for (std::size_t r = of.point ? 3 : 0; r < joint.rows; ++r) {
      const Law& law = law_of(of, r);
      const double there = joint.position[r] + input.dt * rate_of(problem_.velocity, joint, r);
      const bool leaves = there < law.lower - tuning::open_gap || there > law.upper + tuning::open_gap;
      if (law.restitution > 0 && leaves) return true;
    }
  }
  return false;
}

// Of a joint's row, before the substep's forces.
double DirectIsland::rate_of(std::span<const double> velocities, const DirectJoint& joint, std::size_t row) {
  double rate = joint.given[row];
  const auto add = [&](std::uint32_t body, double sign, const Vector3& angular) {
    if (body == no_body) return;
    const double* velocity = &velocities[6 * body];
    rate += sign * joint.at[row].linear.dot(Eigen::Map<const Vector3>(velocity)) +
            sign * angular.dot(Eigen::Map<const Vector3>(velocity + 3));
  };
  add(joint.first, -1, joint.at[row].angular_first);
  add(joint.second, 1, joint.at[row].angular_second);
  return rate;
}

void DirectIsland::begin_laws(const DirectIslandInput& input, double h) {
  for (DirectJoint& joint : problem_.joints) {
    for (std::size_t r = 0; r < joint.rows; ++r) {
      const Law& law = law_of(input.joints[joint.joint], r);
      joint.law[r] = RowLaw::of(law, joint.position[r], joint.mass[r], h, tuning::compliance);
      if (law.looks_back()) joint.law[r].start_at(rate_of(lasting_, joint, r));
    }
  }
}

// N s: what drives the island beside its momentum, in a substep.
double DirectIsland::drive(double h, const DirectIslandInput& input) const {
  double sum = 0;
  for (std::size_t i = 0; i < states_.size(); ++i) {
    const Eigen::Map<const Vector3> velocity(&lasting_[6 * i]);
    sum += problem_.bodies[i].mass * velocity.norm() +
           h * (input.bodies.force(members_[i]).norm() +
                input.bodies.torque(members_[i]).norm() / problem_.bodies[i].radius);
  }
  for (const DirectJoint& joint : problem_.joints) {
    double lever = 0;  // m, that makes forces of torques
    for (const std::uint32_t body : {joint.first, joint.second}) {
      if (body != no_body)
        lever = lever > 0 ? std::min(lever, problem_.bodies[body].radius) : problem_.bodies[body].radius;
    }
    for (std::size_t r = 0; r < joint.rows; ++r) {
      const RowLaw& law = joint.law[r];
      const double turns = joint.at[r].linear.isZero() ? 1 / lever : 1;
      sum += turns * (law.motor_impulse + law.spring_slope * std::abs(law.spring_rate));
    }
  }
  return sum;
}

void DirectIsland::free_substep_velocities(const DirectIslandInput& input, double h) {
  const BodyTable& table = input.bodies;
  for (std::size_t i = 0; i < states_.size(); ++i) {
    const std::uint32_t body = members_[i];
    const State& state = states_[i];
    const Eigen::Map<const Vector3> velocity(&problem_.velocity[6 * i]);
    const Eigen::Map<const Vector3> spin(&problem_.velocity[6 * i + 3]);
    Eigen::Map<Vector3>(&problem_.free[6 * i]) =
        (velocity + h * state.acceleration) / (1 + h * table.linear_damping[body]);
    Eigen::Map<Vector3>(&problem_.free[6 * i + 3]) =
        free_spin(state, spin, table.torque(body), h) / (1 + h * table.angular_damping[body]);
  }
}

// Euler's equations by the midpoint rule.
Vector3 DirectIsland::free_spin(const State& state, const Vector3& spin, const Vector3& torque, double h) const {
  const auto accelerates = [&](const Matrix3& inertia, const Vector3& w) -> Vector3 {
    return inertia.inverse() * (torque - w.cross(inertia * w));
  };
  if (!state.tumbles) return spin + h * (state.inertia.inverse() * torque);
  const Vector3 middle = spin + 0.5 * h * accelerates(state.inertia, spin);
  const Matrix3 rotation = turned(0.5 * h * spin, state.turn).toRotationMatrix();
  return spin + h * accelerates(rotation * state.body_inertia * rotation.transpose(), middle);
}

void DirectIsland::move(double h, std::span<const double> by) {
  for (std::size_t i = 0; i < states_.size(); ++i) {
    states_[i].position += h * Eigen::Map<const Vector3>(&by[6 * i]);
    states_[i].turn = turned(h * Eigen::Map<const Vector3>(&by[6 * i + 3]), states_[i].turn);
  }
}

// m or rad: how far a row is from where it is held, at the poses of now; 0 of what is free.
double DirectIsland::gap_of(const Joint& of, const DirectJoint& joint, std::size_t row, double position) {
  const Law& law = law_of(of, row);
  if (law.locked()) return position - law.lower;
  const int limit = joint.law[row].limit(joint.rate[row]);
  return limit < 0 ? position - law.lower : limit > 0 ? position - law.upper : 0;
}

// What moves bodies apart stays near what they keep.
void DirectIsland::push_gently(double push_speed) {
  double most = 0;
  for (std::size_t i = 0; i < states_.size(); ++i) {
    const auto gained = [&](std::size_t at) -> Vector3 {
      return Eigen::Map<const Vector3>(&problem_.velocity[at]) - Eigen::Map<const Vector3>(&lasting_[at]);
    };
    most = std::max(most, gained(6 * i).norm() + problem_.bodies[i].radius * gained(6 * i + 3).norm());
  }
  const double share = std::min(1.0, tuning::most_push * push_speed / most);
  for (std::size_t i = 0; i < lasting_.size() && share < 1; ++i) {
    problem_.velocity[i] = lasting_[i] + share * (problem_.velocity[i] - lasting_[i]);
  }
}

// What bodies' turns have left open is closed by Newton's method, in poses and velocities: by one step along the rows
// of the substep's start, or where that is not near, along rows that follow. There a taut chain of light links would
// rather turn them far than move what it pulls on; what holds it straight is the stiffness of its tension.
void DirectIsland::close_joints(const DirectIslandInput& input, double h, double time) {
  const auto sound = [](const DirectJoint& joint, std::size_t r) { return joint.torn[r] ? 0 : joint.gap[r]; };
  note_gaps(input, time);
  double most = widest_noted();
  bool tightens = follow_tension(h);
  for (int round = 0; round == 0 || (most > tuning::open_gap && round < tuning::most_closing_steps); ++round) {
    if (most > tuning::open_gap || tightens) {
      tightens = false;
      place_inertia(input, time, h);
      place_joints(input, time);
      if (!search_.matrix.factor(problem_)) return;
    }
    find_closing_motion(problem_, search_, sound);
    const double share = move_closer(input, time, most);
    if (share == 0) break;
    if (!pushes_) {
      for (std::size_t i = 0; i < lasting_.size(); ++i) lasting_[i] += share * search_.direction[i] / h;
    }
    add_closing_impulses(problem_, search_, sound, share / h);
    follow_tension(h);
    note_gaps(input, time);
    most = widest_noted();
  }
  close_tears(h);
}

// By as much of the closing motion as closes anything. Returns how much that was, or 0 if nothing does.
double DirectIsland::move_closer(const DirectIslandInput& input, double time, double gap_before) {
  before_ = states_;
  double share = std::min(1.0, tuning::far_at_rest / farthest());
  for (int round = 0; round < tuning::most_shortenings; ++round, share *= 0.25) {
    move(share, search_.direction);
    if (widest_gap(input, time) <= std::max(gap_before, tuning::open_gap)) return share;
    states_ = before_;
  }
  return 0;
}

double DirectIsland::widest_noted() const {
  double most = 0;
  for (const DirectJoint& joint : problem_.joints) {
    for (std::size_t r = 0; r < joint.rows; ++r) {
      if (!joint.torn[r]) most = std::max(most, std::abs(joint.gap[r]));
    }
  }
  return most;
}

double DirectIsland::widest_gap(const DirectIslandInput& input, double time) const {
  double most = 0;
  for (const DirectJoint& joint : problem_.joints) {
    const DirectJoint::Rows<double> gap = gaps_of(input, joint, time);
    for (std::size_t r = 0; r < joint.rows; ++r) {
      if (!joint.torn[r]) most = std::max(most, std::abs(gap[r]));
    }
  }
  return most;
}

// What was apart as the step began was put apart from outside. It is closed too, but by no velocity: bodies would fly.
void DirectIsland::close_tears(double h) {
  if (!tears_) return;
  find_closing_motion(problem_, search_, [&](const DirectJoint& joint, std::size_t r) {
    return joint.torn[r] ? std::clamp(joint.gap[r], -h * tuning::closing_speed, h * tuning::closing_speed) : 0;
  });
  if (farthest() <= tuning::far_at_rest) move(1, search_.direction);
}

// Of all rows, at the poses of now.
void DirectIsland::note_gaps(const DirectIslandInput& input, double time) {
  for (DirectJoint& joint : problem_.joints) joint.gap = gaps_of(input, joint, time);
}

DirectJoint::Rows<double> DirectIsland::gaps_of(const DirectIslandInput& input, const DirectJoint& joint, double time) const {
  DirectJoint::Rows<double> gap = {};
  const Joint& of = input.joints[joint.joint];
  const BodyPose first = pose_of(input, joint.first, joint.first_body, time);
  const BodyPose second = pose_of(input, joint.second, joint.second_body, time);
  std::size_t r = 0;
  if (of.point) {
    const Vector3 offset = (second.position - first.position) +
                           (second.orientation * of.anchor_second - first.orientation * of.anchor_first);
    for (; r < 3; ++r) gap[r] = offset[static_cast<Eigen::Index>(r)];
  }
  if (r == joint.rows) return gap;
  const JointFrames frames = joint_frames(of, first.position, first.orientation, second.position, second.orientation);
  for (std::size_t k = 0; r < joint.rows; ++r, ++k) {
    gap[r] = gap_of(of, joint, r, continued(of.coordinate[k], joint_row(of, k, frames).value, joint.position[r]));
  }
  return gap;
}

// m or rad, of what would close joints.
double DirectIsland::farthest() const {
  const std::span<const double> by = search_.direction;
  double most = 0;
  for (std::size_t i = 0; i < by.size(); i += 3) most = std::max(most, Eigen::Map<const Vector3>(&by[i]).norm());
  return most;
}

// Velocities that keep the joints at the new poses, and change nothing at contacts that rest: both have had their
// impulses, and answer to what is left alone.
bool DirectIsland::project(double h) {
  for (DirectJoint& joint : problem_.joints) {
    for (std::size_t r = 0; r < joint.rows; ++r) {
      const RowLaw before = joint.law[r];
      joint.law[r] = {};
      joint.limit[r] = static_cast<std::int8_t>(before.limit(joint.rate[r]));
      joint.motor_bound[r] = static_cast<std::int8_t>(before.motor_bound(joint.rate[r]));
      if (!before.holds(joint.rate[r])) continue;
      joint.law[r].locked = true;
      joint.law[r].stiffness = joint.mass[r] / tuning::compliance;
    }
  }
  problem_.free = lasting_;
  problem_.velocity = lasting_;
  stop_contacts(h);
  for (DirectContact& contact : problem_.contacts) {
    const ContactPieces pieces = contact.lasting.pieces;
    contact.answer = {};
    contact.answer.pieces = pieces;
    const Six motion = contact.motion_at(problem_.velocity);
    for (int i = 0; i < contact.law.points; ++i) {
      contact.law.bias[i] = 0;
      const bool rests = std::abs(contact.law.speed(i, motion)) <= tuning::resting_speed;
      if (!rests) contact.answer.pieces.points &= static_cast<std::uint8_t>(~(1 << i));
    }
  }
  if (!solve_on_last_pieces(problem_, search_)) return false;
  for (DirectContact& contact : problem_.contacts) contact.answer = contact.lasting;
  return true;
}

// At once where it grows, and smoothly where it falls. Returns whether it is far from what bodies' inertia has of it.
bool DirectIsland::follow_tension(double h) {
  bool tightens = false;
  for (DirectJoint& joint : problem_.joints) {
    Vector3 force = Vector3::Zero();
    for (std::size_t r = 0; r < joint.rows; ++r) force += (joint.lasting[r] / h) * joint.at[r].linear;
    const bool grows = force.squaredNorm() > joint.tension.squaredNorm();
    const Vector3 change = (grows ? 1 : tuning::tension_smoothing) * (force - joint.tension);
    joint.tension += change;
    const auto turns = [&](std::uint32_t body, const Vector3& arm) {
      if (body == no_body) return false;
      return h * h * change.norm() * arm.norm() > tuning::notable_stiffness * problem_.bodies[body].inertia.trace();
    };
    tightens |= grows && (turns(joint.first, joint.arm_first) || turns(joint.second, joint.arm_second));
  }
  return tightens;
}

// What a step of Newton's method has left.
void DirectIsland::settle_joints(const DirectIslandInput& input) {
  for (int round = 0; round < tuning::most_closings; ++round) {
    note_gaps(input, input.dt);
    if (widest_noted() <= tuning::closed) return;
    find_closing_motion(problem_, search_, [](const DirectJoint& joint, std::size_t r) {
      return joint.law[r].locked && !joint.torn[r] ? joint.gap[r] : 0;
    });
    if (farthest() > tuning::far_at_rest) return;
    move(1, search_.direction);
  }
}

void DirectIsland::write_back_substeps(const DirectIslandInput& input) {
  BodyTable& table = input.bodies;
  for (std::size_t i = 0; i < states_.size(); ++i) {
    const std::uint32_t body = members_[i];
    table.position(body) = states_[i].position;
    table.set_orientation(body, states_[i].turn);
    table.velocity(body) = Eigen::Map<const Vector3>(&problem_.velocity[6 * i]);
    table.angular_velocity(body) = Eigen::Map<const Vector3>(&problem_.velocity[6 * i + 3]);
    note_motion(table, input.bounds, body, {states_[i].start, states_[i].start_turn}, input.dt, input.fast.local());
  }
  const double over_h = input.settings.substeps / input.dt;
  for (const DirectJoint& from : problem_.joints) {
    Joint& joint = input.joints[from.joint];
    joint.tension = from.tension;
    joint.force.setZero();
    joint.torque.setZero();
    std::size_t r = 0;
    if (joint.point) {
      for (; r < 3; ++r) joint.point_impulse[static_cast<Eigen::Index>(r)] = from.lasting[r];
      joint.force = over_h * joint.point_impulse;
    }
    for (std::size_t k = 0; r < from.rows; ++r, ++k) {
      const JointRow& at = from.at[r];
      joint.impulse[k] = from.lasting[r];
      joint.position[k] = from.position[r];
      joint.limit[k] = from.limit[r];
      joint.motor_bound[k] = from.motor_bound[r];
      joint.force += over_h * from.lasting[r] * at.linear;
      joint.torque += over_h * from.lasting[r] * (at.angular_second - from.arm_second.cross(at.linear));
    }
  }
}

}  // namespace atl::solver
