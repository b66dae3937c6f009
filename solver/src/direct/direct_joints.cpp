#include <solver/constraints/spring_step.h>
#include <solver/direct/direct_joints.h>
#include <solver/integrate/free_flight.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

#include "integrate/matrix3.h"
#include "integrate/rows3.h"

namespace atl::solver {
namespace {

// What takes a vector to zero. Returns where the next number goes.
double* put_negative(const Vector3& v, double* to) {
  for (int k = 0; k < 3; ++k) *to++ = -v[k];
  return to;
}

}  // namespace

void DirectJoints::begin_step(const DirectInput& input) {
  for (Member& member : members_) {
    member.start = input.table.position(member.body);
    member.start_turn = input.table.orientation(member.body);
  }
  looks_back_ = bounces_ = false;
  late_ = true;
  for (Node& node : nodes_) {
    const Joint& joint = input.joints[node.joint];
    node.tension = joint.tension;
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      const std::uint32_t k = r - node.begin;
      looks_back_ |= joint.law[k].looks_back();
      bounces_ |= joint.law[k].restitution > 0;
      rows_[r].bounces = false;
      rows_[r].position = joint.position[k];
      rows_[r].mode.resume(joint.law[k], joint.limit[k], joint.motor_bound[k]);
    }
  }
  prepare(input);
}

// For the poses that bodies have now.
void DirectJoints::prepare(const DirectInput& input) {
  place_members(input);
  place_frames(input.joints);
  place_inertia(input.table, input.h);
  begin_laws(input.joints, input.h);
  factor();
}

// The pieces of their laws that rows were on still hold as a guess.
void DirectJoints::begin_laws(const Joint* joints, double h) {
  if (rows_.empty()) return;
  for (const Node& node : nodes_) {
    const Joint& joint = joints[node.joint];
    const Member& a = members_[node.first];
    const Member& b = members_[node.second];
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      Row& row = rows_[r];
      const double response = row.at.response(a.inverse_mass + b.inverse_mass, a.inverse_inertia, b.inverse_inertia);
      row.mass = response > 0 ? 1 / response : 0;
      row.mode.begin(joint.law[r - node.begin], row.position, row.mass, h);
    }
  }
}

void DirectJoints::note_rates(const DirectInput& input) {
  if (!looks_back_ && !bounces_) return;
  load_velocities(input.bodies);
  for (const Node& node : nodes_) {
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      const Law& law = input.joints[node.joint].law[r - node.begin];
      rows_[r].rate_before = row_speed(node, rows_[r]);
      if (law.looks_back()) rows_[r].mode.start_at(rows_[r].rate_before);
    }
  }
}

// Where substeps can't follow a spring there is no half of one. Called between the half kicks of other forces.
void DirectJoints::kick_springs(const DirectInput& input, int sign) {
  late_ = sign < 0;
  if (!looks_back_) return;
  load_velocities(input.bodies);
  bool kicks = false;
  for (const Node& node : nodes_) {
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      const Row& row = rows_[r];
      const Law& law = input.joints[node.joint].law[r - node.begin];
      if (!law.looks_back() || law.locked() || !(row.mass > 0)) continue;
      const double moved = row.mass + law.armature;
      LinearForce force = LinearForce::of_spring(law, moved);
      if (law.is_servo()) {
        const LinearForce servo = LinearForce::of_servo(law, moved);
        const double most = law.motor_force / moved;
        const double pull = servo.at(row.position, row_speed(node, row));
        if (std::abs(pull) < most) {
          force.add(servo);
        } else {
          force.beside += std::copysign(most, pull);
        }
      }
      const double omega = std::sqrt(force.square_of_omega);
      if (omega * input.h > SpringStep::most_phase || force.decay * input.h > SpringStep::most_phase) continue;
      const LateRate late = LateRate::of(omega, force.decay, input.h);
      const auto accelerates = [&](std::uint32_t member, bool turns) -> Vector3 {
        const AccelerationRows& by = input.bodies.acceleration[members_[member].local];
        return get3(turns ? by.angular : by.linear);
      };
      const double acceleration = row.at.rate(accelerates(node.first, false), accelerates(node.first, true),
                                              accelerates(node.second, false), accelerates(node.second, true));
      const double of_force = 0.5 * input.h * acceleration;  // half a kick of everything else, which it has
      const double beside = late.of_position * (row.position - force.rest) +
                            late.of_acceleration * (row.mass / moved * acceleration + force.beside);
      const double rate = row_speed(node, row);
      const double kicked =
          sign < 0 ? beside + late.of_rate * (rate + of_force) : (rate - beside) / late.of_rate - of_force;
      apply(node, row.at, row.mass * (kicked - rate));
      kicks = true;
    }
  }
  if (kicks) store_velocities(input.bodies);
}

// What the rows' bending makes of their rates by the end of the substep, on the mean: points that go round are pulled
// inwards, and what tumbles turns otherwise than it spins. Rates that are asked for with it bring positions onto the
// constraint to third order, before bodies have moved: impulses that come later act on spins that have gone another
// way. Not where arms swing farther in a substep than that is true for.
void DirectJoints::note_bends(const DirectInput& input) {
  for (Member& member : members_) {
    member.next_turn = member.turn;
    if (member.spin.isZero(0)) continue;
    Vector3 spin = member.turn.conjugate() * member.spin;
    if (member.dynamic && input.table.gyroscopic[member.body]) {
      const Vector3 torque = (input.table.inertia[member.body] * spin).cross(spin);
      spin += (0.5 * input.h) * (input.table.inverse_inertia[member.body] * torque);
    }
    member.next_turn = turned(input.h * (member.turn * spin), member.turn);
  }
  constexpr double least_square = tuning::least_bend_spin * tuning::least_bend_spin;
  const auto spins = [=](const Member& member) { return member.spin.squaredNorm() > least_square; };
  bool goes_far = false;
  for (Node& node : nodes_) {
    const Member& a = members_[node.first];
    const Member& b = members_[node.second];
    node.bend.setZero();
    for (std::uint32_t r = node.begin; r < node.end; ++r) rows_[r].bend = 0;
    if (!spins(a) && !spins(b)) continue;
    const Joint& joint = input.joints[node.joint];
    const Vector3 turned_first = a.next_turn * joint.anchor_first - node.arm_first;
    const Vector3 turned_second = b.next_turn * joint.anchor_second - node.arm_second;
    goes_far |= turned_first.norm() > tuning::most_bend * node.arm_first.norm() ||
                turned_second.norm() > tuning::most_bend * node.arm_second.norm();
    node.bend =
        (turned_second - turned_first) / input.h - (b.spin.cross(node.arm_second) - a.spin.cross(node.arm_first));
    if (node.begin == node.end) continue;
    const JointFrames frames = joint_frames(joint, a.position + input.h * a.velocity, a.next_turn,
                                            b.position + input.h * b.velocity, b.next_turn);
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      Row& row = rows_[r];
      const double straight = row.position + input.h * row_speed(node, row);
      const double there =
          continued(joint.coordinate[r - node.begin], joint_row(joint, r - node.begin, frames).value, straight);
      row.bend = (there - straight) / input.h;
    }
  }
  if (!goes_far) return;
  for (Node& node : nodes_) node.bend.setZero();
  for (Row& row : rows_) row.bend = 0;
}

bool DirectJoints::update_laws() {
  bool changed = false;
  for (const Node& node : nodes_) {
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      changed |= rows_[r].mode.update(row_speed(node, rows_[r]), rows_[r].impulse);
    }
  }
  return changed;
}

void DirectJoints::load_velocities(const SolverBodies& bodies) {
  for (Member& member : members_) {
    member.velocity = member.velocity_before = get3(bodies.velocity[member.local].linear);
    member.spin = member.spin_before = get3(bodies.velocity[member.local].angular);
  }
}

// Of positions that are closed for themselves.
void DirectJoints::load_no_velocities() {
  for (Member& member : members_) {
    member.velocity = member.velocity_before = Vector3::Zero();
    member.spin = member.spin_before = Vector3::Zero();
  }
}

// Not to be carried over into the next substep: there the impulses act along other rows.
void DirectJoints::store_velocities(SolverBodies& bodies) const {
  for (const Member& member : members_) {
    if (!member.dynamic) continue;
    set3(bodies.velocity[member.local].linear, member.velocity);
    set3(bodies.velocity[member.local].angular, member.spin);
    add3(bodies.free_velocity[member.local].linear, member.velocity - member.velocity_before);
    add3(bodies.free_velocity[member.local].angular, member.spin - member.spin_before);
  }
}

Vector3 DirectJoints::point_speed(const Node& node) const {
  const Member& a = members_[node.first];
  const Member& b = members_[node.second];
  return (b.velocity + b.spin.cross(node.arm_second)) - (a.velocity + a.spin.cross(node.arm_first));
}

double DirectJoints::row_speed(const Node& node, const Row& row) const {
  const Member& a = members_[node.first];
  const Member& b = members_[node.second];
  return row.at.rate(a.velocity, a.spin, b.velocity, b.spin);
}

void DirectJoints::apply(const Node& node, const JointRow& row, double impulse) {
  Member& a = members_[node.first];
  Member& b = members_[node.second];
  if (a.dynamic) {
    a.velocity -= (a.inverse_mass * impulse) * row.linear;
    a.spin -= a.inverse_inertia * (impulse * row.angular_first);
  }
  if (b.dynamic) {
    b.velocity += (b.inverse_mass * impulse) * row.linear;
    b.spin += b.inverse_inertia * (impulse * row.angular_second);
  }
}

// Impulses that change the rates of all rows by b.
void DirectJoints::solve_and_apply() {
  if (!solvable_) return;
  system_.solve(b_);
  for (Member& member : members_) {
    member.impulse.setZero();
    member.angular_impulse.setZero();
  }
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    Node& node = nodes_[i];
    Member& a = members_[node.first];
    Member& b = members_[node.second];
    const double* impulse = &b_[system_.row(i)];
    if (node.point) {
      const Vector3 of_point(impulse[0], impulse[1], impulse[2]);
      node.impulse += of_point;
      a.impulse -= of_point;
      a.angular_impulse -= node.arm_first.cross(of_point);
      b.impulse += of_point;
      b.angular_impulse += node.arm_second.cross(of_point);
      impulse += 3;
    }
    for (std::uint32_t r = node.begin; r < node.end; ++r, ++impulse) {
      Row& row = rows_[r];
      if (!row.mode.is_solved()) continue;
      row.impulse += *impulse;
      a.impulse -= *impulse * row.at.linear;
      a.angular_impulse -= *impulse * row.at.angular_first;
      b.impulse += *impulse * row.at.linear;
      b.angular_impulse += *impulse * row.at.angular_second;
    }
  }
  for (Member& member : members_) {
    if (!member.dynamic) continue;
    member.velocity += member.inverse_mass * member.impulse;
    member.spin += product(member.inverse_inertia, member.angular_impulse);
  }
}

void DirectJoints::begin_substep() {
  for (Node& node : nodes_) node.impulse.setZero();
  for (Row& row : rows_) row.impulse = 0;
}

void DirectJoints::solve_velocities(const DirectInput& input) {
  load_velocities(input.bodies);
  note_bends(input);
  for (int round = 0; round < tuning::mode_rounds; ++round) {
    for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
      const Node& node = nodes_[i];
      for (std::uint32_t r = node.begin; r < node.end; ++r) {
        Row& row = rows_[r];
        if (row.mode.is_solved()) continue;
        apply(node, row.at, row.mode.given() - row.impulse);
        row.impulse = row.mode.given();
      }
    }
    for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
      const Node& node = nodes_[i];
      double* b = &b_[system_.row(i)];
      if (node.point) b = put_negative(point_speed(node) + node.bend, b);
      for (std::uint32_t r = node.begin; r < node.end; ++r) {
        const Row& row = rows_[r];
        const LawMode& mode = row.mode;
        const double speed = row_speed(node, row) + (mode.is_locked() ? row.bend : 0);
        *b++ = mode.is_solved() ? mode.target() - speed - mode.compliance() * (row.impulse - mode.given()) : 0;
      }
    }
    solve_and_apply();
    if (bounces_ && round == 0) note_impacts(input.joints, input.h);
    // The system must be that of the pieces the rows are on.
    if (rows_.empty() || round + 1 == tuning::mode_rounds || !update_laws()) break;
    factor();
  }
  store_velocities(input.bodies);
}

void DirectJoints::solve_positions(const DirectInput& input) {
  place_members(input);
  load_velocities(input.bodies);
  if (catch_limits(input.joints, input.h)) factor();
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    measure(input.joints[nodes_[i].joint], nodes_[i], &b_[system_.row(i)], input.h);
  }
  const bool torn = torn_ = set_tears_aside(input.joints, input.h);
  solve_and_apply();
  if (moves_far(input.h, tuning::far_in_motion)) take_back();
  move_members(input);
  store_velocities(input.bodies);
  if (!torn) return;
  load_velocities(input.bodies);
  b_.swap(tears_);
  solve_and_apply();
  if (!moves_far(input.h, tuning::far_at_rest)) move_members(input);
}

// Holds what an impact has pushed beyond its range. Whether there is such a row.
bool DirectJoints::catch_limits(const Joint* joints, double h) {
  if (rows_.empty()) return false;
  bool caught = false;
  for (const Node& node : nodes_) {
    const Joint& joint = joints[node.joint];
    if (std::none_of(joint.law.begin(), joint.law.begin() + joint.rows,
                     [](const Law& law) { return law.limited() && !law.locked(); })) {
      continue;
    }
    const JointFrames frames = frames_of(joint, node);
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      const Law& law = joint.law[r - node.begin];
      if (!law.limited() || law.locked()) continue;
      caught |= rows_[r].mode.catch_at_end(law, position_of(joint, frames, node, r, h));
    }
  }
  return caught;
}

// The same of what closing other gaps has turned beyond its range, where bodies are now.
bool DirectJoints::catch_limits_here(const Joint* joints) {
  bool caught = false;
  for (const Node& node : nodes_) {
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      const Law& law = joints[node.joint].law[r - node.begin];
      if (law.limited()) caught |= rows_[r].mode.catch_at_end(law, rows_[r].position);
    }
  }
  return caught;
}

// The position of a row's coordinate at the frames, after h seconds at the velocities that are loaded.
double DirectJoints::position_of(const Joint& joint, const JointFrames& frames, const Node& node, std::uint32_t r,
                                 double h) const {
  const double moved = rows_[r].position + h * row_speed(node, rows_[r]);  // what is a rate only is there
  return continued(joint.coordinate[r - node.begin], joint_row(joint, r - node.begin, frames).value, moved);
}

JointFrames DirectJoints::frames_of(const Joint& joint, const Node& node) const {
  const Member& first = members_[node.first];
  const Member& second = members_[node.second];
  return joint_frames(joint, first.position, first.turn, second.position, second.turn);
}

// What was apart when the substep began, as no substep leaves it, was put apart from outside. It is closed, too, but by
// no velocity: bodies would fly. Takes it out of b_, and leaves in tears_ the rates that close it. Whether there is
// any.
bool DirectJoints::set_tears_aside(const Joint* joints, double h) {
  bool torn = false;
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    const Node& node = nodes_[i];
    std::size_t at = system_.row(i);
    const auto set_aside = [&](double apart) {
      if (!torn) tears_.assign(b_.size(), 0.0);
      torn = true;
      b_[at] -= apart / h;
      tears_[at] = std::clamp(apart / h, -tuning::closing_speed, tuning::closing_speed);
    };
    if (node.point) {
      const bool apart = node.offset.squaredNorm() > tuning::torn * tuning::torn;
      for (int k = 0; k < 3; ++k, ++at) {
        if (apart) set_aside(-node.offset[k]);
      }
    }
    for (std::uint32_t r = node.begin; r < node.end; ++r, ++at) {
      const Row& row = rows_[r];
      if (!row.mode.holds()) continue;
      const double apart = bound(row, joints[node.joint].law[r - node.begin]) - row.position;
      // To an end that it is still on its way to it goes as fast as it goes.
      const bool beyond = row.mode.is_locked() || (row.mode.limit() < 0 ? apart > 0 : apart < 0);
      if (beyond && std::abs(apart) > tuning::torn) set_aside(apart);
    }
  }
  return torn;
}

// Whether what was gained since velocities were loaded would take a body so far that no row is true there: near where
// rows are singular the solution of the linear system says nothing of where joints close.
bool DirectJoints::moves_far(double h, double far) const {
  return std::any_of(members_.begin(), members_.end(), [=](const Member& member) {
    return !(h * (member.velocity - member.velocity_before).norm() <= far &&
             h * (member.spin - member.spin_before).norm() <= far);
  });
}

// What was gained since velocities were loaded.
void DirectJoints::take_back() {
  for (Member& member : members_) {
    member.velocity = member.velocity_before;
    member.spin = member.spin_before;
  }
}

// By the velocities that were gained since they were loaded.
void DirectJoints::move_members(const DirectInput& input) {
  for (Member& member : members_) {
    if (!member.dynamic) continue;
    DisplacementRows& moved = input.bodies.displacement[member.local];
    add3(moved.linear, input.h * (member.velocity - member.velocity_before));
    const Vector3 turn = input.h * (member.spin - member.spin_before);
    const auto turn_rows = [&](float(&rotation)[4]) {
      const Quaternion now = turned(turn, {rotation[3], rotation[0], rotation[1], rotation[2]});
      for (int k = 0; k < 4; ++k) rotation[k] = static_cast<float>(now.coeffs()[k]);
    };
    turn_rows(moved.rotation);
    if (input.bodies.round_shapes) turn_rows(input.bodies.shape[member.local].rotation);
  }
}

// How far the joint's rows are from where they should be, as rates that take them there in h seconds.
void DirectJoints::measure(const Joint& joint, const Node& node, double* b, double h) const {
  const Member& first = members_[node.first];
  const Member& second = members_[node.second];
  if (node.point) {
    const Vector3 offset =
        (second.position - first.position) + (second.turn * joint.anchor_second - first.turn * joint.anchor_first);
    b = put_negative(offset / h, b);
  }
  if (node.begin == node.end) return;
  const JointFrames frames = frames_of(joint, node);
  for (std::uint32_t r = node.begin; r < node.end; ++r) {
    const Row& row = rows_[r];
    *b++ = row.mode.holds() ? (bound(row, joint.law[r - node.begin]) - position_of(joint, frames, node, r, h)) / h : 0;
  }
}

// How fast rows that bounce would come to the ends of their ranges, if nothing held them there: with what accelerates
// them along the way.
void DirectJoints::note_impacts(const Joint* joints, double h) {
  for (const Node& node : nodes_) {
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      const Law& law = joints[node.joint].law[r - node.begin];
      Row& row = rows_[r];
      row.bounces = false;
      row.impact = row.mode.holds() || law.restitution == 0
                       ? LimitImpact{}
                       : LimitImpact::of(law, row.position, row.rate_before, row_speed(node, row), h);
    }
  }
}

void DirectJoints::relax(const DirectInput& input) {
  const double over_h = 1 / input.h;
  for (Node& node : nodes_) {
    Vector3 force = over_h * node.impulse;
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      Row& row = rows_[r];
      force += over_h * row.impulse * row.at.linear;
      row.position += input.h * row_speed(node, row);
    }
    node.tension += tuning::tension_smoothing * (force - node.tension);
  }
  if (bounces_) {
    for (Row& row : rows_) row.bounces = row.mode.limit() * row.impact.end > 0;
  }
  prepare(input);
  close_gaps(input);
  project(input);
  note_rates(input);
}

// One round of Newton's method is all that positions get where bodies turn by little in a substep. After an impact it
// takes more, at rows that are true there.
void DirectJoints::close_gaps(const DirectInput& input) {
  for (int round = 1; round < tuning::mode_rounds && !torn_; ++round) {
    load_no_velocities();
    bool closed = !catch_limits_here(input.joints);
    if (!closed) factor();
    for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
      const Node& node = nodes_[i];
      double* b = &b_[system_.row(i)];
      if (node.point) {
        closed &= node.offset.squaredNorm() <= tuning::open_gap * tuning::open_gap;
        b = put_negative(node.offset / input.h, b);
      }
      for (std::uint32_t r = node.begin; r < node.end; ++r, ++b) {
        const Row& row = rows_[r];
        const double apart =
            row.mode.holds() ? bound(row, input.joints[node.joint].law[r - node.begin]) - row.position : 0;
        closed &= std::abs(apart) <= tuning::open_gap;
        *b = apart / input.h;
      }
    }
    if (closed) return;
    solve_and_apply();
    if (moves_far(input.h, tuning::far_at_rest)) return;
    move_members(input);
    prepare(input);
  }
}

void DirectJoints::project(const DirectInput& input) {
  load_velocities(input.bodies);
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    const Node& node = nodes_[i];
    double* b = &b_[system_.row(i)];
    if (node.point) b = put_negative(point_speed(node), b);
    // Springs and motors have had their impulse, and answer to changes only.
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      const Row& row = rows_[r];
      const double leaving = !row.bounces ? 0 : late_ ? row.impact.leaving_late : row.impact.leaving;
      *b++ = row.mode.holds() ? leaving - row_speed(node, row) : 0;
    }
  }
  solve_and_apply();
  store_velocities(input.bodies);
}

void DirectJoints::end_step(const DirectInput& input) {
  const double over_h = 1 / input.h;
  for (const Node& node : nodes_) {
    Joint& joint = input.joints[node.joint];
    joint.point_impulse = node.impulse;
    joint.tension = node.tension;
    joint.force = over_h * node.impulse;
    joint.torque.setZero();
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      const Row& row = rows_[r];
      const std::uint32_t k = r - node.begin;
      joint.impulse[k] = row.impulse;
      joint.position[k] = row.position;
      joint.limit[k] = static_cast<std::int8_t>(row.mode.limit());
      joint.motor_bound[k] = static_cast<std::int8_t>(row.mode.motor_bound());
      joint.force += over_h * row.impulse * row.at.linear;
      joint.torque += over_h * row.impulse * (row.at.angular_second - node.arm_second.cross(row.at.linear));
    }
  }
}

void DirectJoints::settle(const DirectInput& input, BodyTable& table, collision::MotionBounds& bounds, double dt,
                          FastBodies& fast) {
  for (Member& member : members_) {
    member.position = table.position(member.body);
    member.turn = table.orientation(member.body);
  }
  load_no_velocities();
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    measure(input.joints[nodes_[i].joint], nodes_[i], &b_[system_.row(i)], 1);
  }
  bool holds = std::all_of(b_.begin(), b_.end(), [](double b) { return std::abs(b) <= tuning::settled_gap; });
  if (!holds) {
    solve_and_apply();
    holds = moves_far(1, tuning::far_at_rest);
  }
  MovedBodies& notes = fast.local();
  for (const Member& member : members_) {
    if (!member.dynamic) continue;
    if (!holds) {
      table.position(member.body) += member.velocity;
      table.set_orientation(member.body, turned(member.spin, member.turn));
    }
    note_motion(table, bounds, member.body, {member.start, member.start_turn}, dt, notes);
  }
}

}  // namespace atl::solver
