#include <solver/direct/direct_joints.h>
#include <solver/integrate/free_flight.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

#include "direct/joint_laws.h"
#include "direct/joint_targets.h"
#include "integrate/matrix3.h"

namespace atl::solver {
namespace {

// The impulses of rows that are given by their laws.
void apply_given_impulses(JointAssembly& assembly) {
  for (const JointNode& node : assembly.nodes) {
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      AssemblyRow& row = assembly.rows[r];
      if (row.mode.is_solved()) continue;
      assembly.apply(node, row.at, row.mode.given() - row.impulse);
      row.impulse = row.mode.given();
    }
  }
}

// Gives members impulses along all rows that are solved for, as JointMatrix orders them.
void apply_impulses(JointAssembly& assembly, const JointMatrix& matrix, const std::vector<double>& impulses) {
  for (JointMember& member : assembly.members) {
    member.impulse.setZero();
    member.angular_impulse.setZero();
  }
  for (std::uint32_t i = 0; i < assembly.nodes.size(); ++i) {
    const JointNode& node = assembly.nodes[i];
    JointMember& a = assembly.members[node.first];
    JointMember& b = assembly.members[node.second];
    const double* impulse = &impulses[matrix.row(i)];
    if (node.point) {
      const Vector3 of_point(impulse[0], impulse[1], impulse[2]);
      a.impulse -= of_point;
      a.angular_impulse -= node.arm_first.cross(of_point);
      b.impulse += of_point;
      b.angular_impulse += node.arm_second.cross(of_point);
      impulse += 3;
    }
    for (std::uint32_t r = node.begin; r < node.end; ++r, ++impulse) {
      const AssemblyRow& row = assembly.rows[r];
      if (!row.mode.is_solved()) continue;
      a.impulse -= *impulse * row.at.linear;
      a.angular_impulse -= *impulse * row.at.angular_first;
      b.impulse += *impulse * row.at.linear;
      b.angular_impulse += *impulse * row.at.angular_second;
    }
  }
  for (JointMember& member : assembly.members) {
    if (!member.dynamic) continue;
    member.velocity += member.inverse_mass * member.impulse;
    member.spin += product(member.inverse_inertia, member.angular_impulse);
  }
}

// Counts them among those of the substep.
void note_impulses(JointAssembly& assembly, const JointMatrix& matrix, const std::vector<double>& impulses) {
  for (std::uint32_t i = 0; i < assembly.nodes.size(); ++i) {
    JointNode& node = assembly.nodes[i];
    const double* impulse = &impulses[matrix.row(i)];
    if (node.point) {
      node.impulse += Vector3(impulse[0], impulse[1], impulse[2]);
      impulse += 3;
    }
    for (std::uint32_t r = node.begin; r < node.end; ++r, ++impulse) {
      if (assembly.rows[r].mode.is_solved()) assembly.rows[r].impulse += *impulse;
    }
  }
}

// Tension follows the force of the substep's impulses.
void follow_tension(JointAssembly& assembly, double over_h) {
  for (JointNode& node : assembly.nodes) {
    Vector3 force = over_h * node.impulse;
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      force += over_h * assembly.rows[r].impulse * assembly.rows[r].at.linear;
    }
    node.tension += tuning::tension_smoothing * (force - node.tension);
  }
}

}  // namespace

bool DirectJoints::analyse(std::span<const JointLink> links, std::span<const Joint> joints, const BodyTable& table) {
  assembly_ = JointAssembly::of(links, joints, table);
  if (!matrix_.analyse(assembly_)) return false;
  b_.assign(matrix_.rows(), 0.0);
  return true;
}

void DirectJoints::begin_step(const DirectInput& input) {
  for (JointMember& member : assembly_.members) {
    member.start = input.table.position(member.body);
    member.start_turn = input.table.orientation(member.body);
  }
  acts_ = looks_back_ = rotors_ = bounces_ = false;
  late_ = true;
  for (JointNode& node : assembly_.nodes) {
    const Joint& joint = input.joints[node.joint];
    node.tension = joint.tension;
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      const std::uint32_t k = r - node.begin;
      AssemblyRow& row = assembly_.rows[r];
      acts_ |= joint.law[k].looks_back() || joint.law[k].drives();
      looks_back_ |= joint.law[k].looks_back();
      rotors_ |= joint.law[k].armature > 0;
      bounces_ |= joint.law[k].restitution > 0;
      row.bounces = false;
      row.position = joint.position[k];
      row.mode.resume(joint.law[k], joint.limit[k], joint.motor_bound[k]);
    }
  }
  place(input);
}

// At the poses that bodies have now.
void DirectJoints::place(const DirectInput& input) {
  assembly_.place_members(input.bodies);
  assembly_.place_joints(input.joints, input.table, input.h);
  weigh_rows(assembly_);
}

void DirectJoints::factor_laws(const DirectInput& input) {
  begin_laws(assembly_, input.joints, input.h);
  matrix_.factor(assembly_);
}

void DirectJoints::start(const DirectInput& input) {
  factor_laws(input);
  start_laws(input);
}

void DirectJoints::start_laws(const DirectInput& input) {
  if (!looks_back_ && !bounces_) return;
  assembly_.load_velocities(input.bodies);
  solver::start_laws(assembly_, input.joints);
}

void DirectJoints::note_rates(const DirectInput& input) {
  if (!acts_) return;
  assembly_.load_velocities(input.bodies);
  solver::note_rates(assembly_);
}

// Springs and servos have their half of the substep's forces with all others, and joints answer to them together: a
// spring that bears a load is in balance with it at every instant.
void DirectJoints::kick(const DirectInput& input, int sign) {
  late_ = sign < 0;
  if (!acts_) {
    // The first substep's solve holds the joints as the step begins, and the last one's system as it ends.
    if (!late_) project(input);
    return;
  }
  begin_kick(assembly_, input.joints, input.h, sign);
  matrix_.factor(assembly_);
  begin_substep();
  assembly_.load_velocities(input.bodies);
  const int rounds = late_ ? 1 : tuning::mode_rounds;
  solve_laws(rounds, nullptr);
  if (looks_back_) {
    correct_kick(assembly_, input.joints, input.h, sign);
    solve_laws(rounds, nullptr);
  }
  assembly_.store_velocities(input.bodies);
}

// An armature has momentum of its own. It pays for every change of its coordinate's rate with an impulse: also for
// those that tumbling makes of velocities while positions move, and the turning of the row with the bodies. These come
// after a substep's impulses, and are paid for with the projection. What is not yet paid for is the sum of the momenta
// that it had, less that which it has; of impulses that are solved for with its row, it has its part.
void DirectJoints::note_armature(const DirectInput& input, double times) {
  if (rotors_) add_armature(assembly_, input.joints, times);
}

// Impulses that change the rates of all rows by b.
void DirectJoints::solve_and_apply() {
  if (!matrix_.solve(b_)) return;
  apply_impulses(assembly_, matrix_, b_);
  note_impulses(assembly_, matrix_, b_);
}

// Gives members what changes the rates of all rows by b; or nothing, and returns false, if there is no solution or
// bodies move far with it in h seconds. It is of the joints' impulses only where bodies keep the velocities they gain
// by it.
bool DirectJoints::solve_within(double far, double h) {
  if (!matrix_.solve(b_)) return false;
  apply_impulses(assembly_, matrix_, b_);
  if (!assembly_.moves_far(h, far)) return true;
  assembly_.take_back();
  return false;
}

// Finds the impulses of rows, and which pieces of their laws these belong on. Where coordinates may bounce, `impacts`
// is told how fast they would come to the ends of their ranges by the first of these.
void DirectJoints::solve_laws(int rounds, const DirectInput* impacts) {
  for (int round = 0; round < rounds; ++round) {
    apply_given_impulses(assembly_);
    set_velocity_targets(assembly_, matrix_, b_);
    solve_and_apply();
    if (impacts != nullptr && round == 0) note_impacts(assembly_, impacts->joints, impacts->h);
    // The system must be that of the pieces the rows are on.
    if (assembly_.rows.empty() || round + 1 == rounds || !update_laws(assembly_)) break;
    matrix_.factor(assembly_);
  }
}

void DirectJoints::begin_substep() {
  for (JointNode& node : assembly_.nodes) node.impulse.setZero();
  for (AssemblyRow& row : assembly_.rows) row.impulse = 0;
}

// Impulses along rows that ask for no rate of their own only take energy from bodies of the inertia that they have.
template <typename Solve>
void DirectJoints::solve_passively(const Solve& solve) {
  assembly_.take_back();
  assembly_.leave_out_tension();
  matrix_.factor(assembly_);
  solve();
}

void DirectJoints::solve_velocities(const DirectInput& input) {
  assembly_.load_velocities(input.bodies);
  note_bends(assembly_, input.joints, input.table, input.h);
  solve_laws(tuning::mode_rounds, bounces_ ? &input : nullptr);
  if (assembly_.makes_energy(input.joints, false, false)) {
    solve_passively([&] {
      forget_bends(assembly_);
      solve_laws(tuning::mode_rounds, nullptr);
    });
  }
  for (AssemblyRow& row : assembly_.rows) row.unpaid = 0;  // sweeps may follow one another
  note_armature(input, 1);
  assembly_.store_velocities(input.bodies);
}

void DirectJoints::solve_positions(const DirectInput& input) {
  assembly_.place_members(input.bodies);
  assembly_.load_velocities(input.bodies);
  note_armature(input, -1);
  if (catch_limits(assembly_, input.joints, input.h)) matrix_.factor(assembly_);
  set_position_targets(assembly_, matrix_, input.joints, input.h, b_);
  torn_ = set_tears_aside(assembly_, matrix_, input.joints, input.h, b_, tears_);
  if (solve_within(tuning::far_in_motion, input.h)) note_impulses(assembly_, matrix_, b_);
  assembly_.move_bodies(input.bodies, input.h);
  if (assembly_.makes_energy(input.joints, true, true)) assembly_.take_back();
  note_armature(input, 1);
  assembly_.store_velocities(input.bodies);
  if (!torn_) return;
  assembly_.load_velocities(input.bodies);
  b_.swap(tears_);
  if (solve_within(tuning::far_at_rest, input.h)) assembly_.move_bodies(input.bodies, input.h);
}

void DirectJoints::relax(const DirectInput& input) {
  follow_tension(assembly_, 1 / input.h);
  for (const JointNode& node : assembly_.nodes) {
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      AssemblyRow& row = assembly_.rows[r];
      row.position += input.h * assembly_.row_speed(node, row);
    }
  }
  if (bounces_) {
    for (AssemblyRow& row : assembly_.rows) row.bounces = row.mode.limit() * row.impact.end > 0;
  }
  place(input);
  factor_laws(input);
  close_gaps(input);
  assembly_.load_velocities(input.bodies);
  note_armature(input, -1);
  project(input);
  for (AssemblyRow& row : assembly_.rows) row.unpaid = 0;  // bounces are projected, too
  start_laws(input);
}

// One round of Newton's method is all that positions get where bodies turn by little in a substep. After an impact it
// takes more, at rows that are true there.
void DirectJoints::close_gaps(const DirectInput& input) {
  for (int round = 1; round < tuning::mode_rounds && !torn_; ++round) {
    assembly_.load_no_velocities();
    const bool caught = catch_limits_here(assembly_, input.joints);
    if (caught) matrix_.factor(assembly_);
    const bool closed = set_position_targets_here(assembly_, matrix_, input.joints, input.h, b_);
    if (closed && !caught) return;
    if (!solve_within(tuning::far_at_rest, input.h)) return;
    assembly_.move_bodies(input.bodies, input.h);
    place(input);
    factor_laws(input);
  }
}

void DirectJoints::project(const DirectInput& input) {
  assembly_.load_velocities(input.bodies);
  set_projection_targets(assembly_, matrix_, late_, b_);
  solve_and_apply();
  const bool leaves = bounces_ && std::any_of(assembly_.rows.begin(), assembly_.rows.end(),
                                              [](const auto& row) { return row.bounces; });
  if (!leaves && assembly_.makes_energy(input.joints, true, false)) {
    solve_passively([&] {
      set_projection_targets(assembly_, matrix_, late_, b_);
      solve_and_apply();
    });
  }
  assembly_.store_velocities(input.bodies);
}

void DirectJoints::end_step(const DirectInput& input) {
  const double over_h = 1 / input.h;
  for (const JointNode& node : assembly_.nodes) {
    Joint& joint = input.joints[node.joint];
    joint.point_impulse = node.impulse;
    joint.tension = node.tension;
    joint.force = over_h * node.impulse;
    joint.torque.setZero();
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      const AssemblyRow& row = assembly_.rows[r];
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
  for (JointMember& member : assembly_.members) {
    // Kinematic bodies move after all groups.
    member.position = table.position(member.body);
    member.turn = table.orientation(member.body);
    if (member.dynamic) continue;
    const BodyPose end = pose_after(table, member.body, dt);
    member.position = end.position;
    member.turn = end.orientation;
  }
  assembly_.load_no_velocities();
  set_position_targets(assembly_, matrix_, input.joints, 1, b_);
  bool holds = std::all_of(b_.begin(), b_.end(), [](double b) { return std::abs(b) <= tuning::settled_gap; });
  if (!holds) {
    solve_and_apply();
    holds = assembly_.moves_far(1, tuning::far_at_rest);
  }
  MovedBodies& notes = fast.local();
  for (const JointMember& member : assembly_.members) {
    if (!member.dynamic) continue;
    if (!holds) {
      table.position(member.body) += member.velocity;
      table.set_orientation(member.body, turned(member.spin, member.turn));
    }
    note_motion(table, bounds, member.body, {member.start, member.start_turn}, dt, notes);
  }
}

}  // namespace atl::solver
