#include <solver/direct/direct_joints.h>
#include <solver/tuning.h>

#include <algorithm>
#include <utility>

#include "direct/island_joints.h"
#include "direct/island_solves.h"
#include "direct/joined_masses.h"
#include "direct/joint_leapfrog.h"
#include "direct/substeps.h"
#include "integrate/rows3.h"

namespace atl::solver {

bool DirectJoints::analyse(std::span<const JointLink> links, std::span<const Joint> joints, const BodyTable& table) {
  const auto is_dynamic = [&](std::uint32_t body) { return table.mobility[body] == Mobility::Dynamic; };
  std::vector<std::uint32_t>& bodies = members_.bodies;
  const auto take_in = [&](const auto& ends) {
    for (const std::uint32_t body : {ends.first, ends.second}) {
      if (is_dynamic(body)) bodies.push_back(body);
    }
  };
  for (const JointLink& link : links) {
    take_in(link);
    // A joint that has no rows of its own is in no list, and may be a term all the same.
    for_each_term(joints.data(), link.joint, take_in);
  }
  std::sort(bodies.begin(), bodies.end());
  bodies.erase(std::unique(bodies.begin(), bodies.end()), bodies.end());
  const auto number = [&](std::uint32_t body) {
    if (!is_dynamic(body)) return no_body;
    return static_cast<std::uint32_t>(std::lower_bound(bodies.begin(), bodies.end(), body) - bodies.begin());
  };
  members_.joints.assign(links.begin(), links.end());
  for (const JointLink& link : links) {
    members_.ends.emplace_back(number(link.first), number(link.second));
    for_each_term(joints.data(), link.joint,
                  [&](const Joint& of) { members_.term_ends.emplace_back(number(of.first), number(of.second)); });
  }
  const std::size_t count = bodies.size();
  places_.resize(count);
  motions_.resize(count);
  answer_.resize(6 * count);
  motions_.problem.joints.resize(links.size());
  load_joints(joints.data(), members_, motions_.problem.joints);
  return motions_.search.matrix.analyse_joints(motions_.problem, max_factor_blocks(count, false));
}

bool DirectJoints::solve(const SolveInput& input) {
  static_cast<void>(load_bodies(input, members_, motions_.problem, bodies_));
  const bool solved = solve_substeps(input, members_, bodies_, motions_);
  kicked_ = solved && input.settings.substeps == 1 && count_rows_at_ends(motions_.problem.joints) == 0;
  return solved;
}

void DirectJoints::begin_step(const SolveInput& input) {
  kicked_ = false;
  static_cast<void>(load_bodies(input, members_, motions_.problem, bodies_));
  rows_ = load_joints(input.joints, members_, motions_.problem.joints);
  Substeps joints(input, bodies_, motions_, rows_);
  joints.begin();
  joints.weigh_crowded();
  if (!rows_.all_locked) record_rates(motions_.problem.velocity, motions_.problem.joints);
}

void DirectJoints::begin_substep(const SolveInput& input) {
  Substeps(input, bodies_, motions_, rows_).begin_substep();
  std::fill(answer_.begin(), answer_.end(), 0.0);
  for (DirectJoint& joint : motions_.problem.joints) joint.lasting = {};
  solved_ = false;
}

void DirectJoints::solve_velocities(const SolveInput& input, int substep, SolverBodies& bodies) {
  IslandProblem& problem = motions_.problem;
  Substeps joints(input, bodies_, motions_, rows_);
  load_velocities(bodies);
  problem.free = motions_.lasting;
  forget_bends(input.joints, problem);
  joints.foresee_bends(input.substep() * (substep + 1));
  for (std::size_t i = 0; i < answer_.size(); ++i) problem.free[i] -= answer_[i];
  if (!joints.find_joint_velocities(!solved_)) {
    load_velocities(bodies);
    problem.velocity = motions_.lasting;
    return;
  }
  solved_ = true;
  for (std::size_t i = 0; i < answer_.size(); ++i) answer_[i] = problem.velocity[i] - problem.free[i];
  record_armature_rates(input.joints, problem.velocity, problem.joints);
  store_velocities(problem.velocity, bodies);
}

void DirectJoints::solve_positions(const SolveInput& input, int substep, SolverBodies& bodies) {
  const double h = input.substep();
  Substeps(input, bodies_, motions_, rows_).advance_coordinates();
  load_poses(bodies);
  for (MovingBody& body : bodies_) body.next = body.now;
  load_velocities(bodies);
  close_joints(input, h * (substep + 1), h, bodies_, motions_);
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    DisplacementRows& rows = bodies.displacement[places_[i]];
    const BodyPose& now = bodies_[i].now;
    add3(rows.linear, now.position - bodies_[i].next.position);
    const Quaternion turn = now.orientation * bodies_[i].next.orientation.conjugate();
    turn_on(bodies, places_[i], turn);
  }
  store_velocities(motions_.lasting, bodies);
}

void DirectJoints::relax(const SolveInput& input, int substep, SolverBodies& bodies) {
  Substeps joints(input, bodies_, motions_, rows_);
  joints.place(input.substep() * (substep + 1));
  load_velocities(bodies);
  keep_projected(input, joints.project(), bodies);
}

// Keeps the projected velocities, or the lasting ones if none were found, and sets the armatures to their rates. Bodies
// that tumble by themselves in the next substep thus don't work against armatures.
void DirectJoints::keep_projected(const SolveInput& input, bool found, SolverBodies& bodies) {
  IslandProblem& problem = motions_.problem;
  if (!found) load_velocities(bodies);
  const std::vector<double>& velocities = found ? problem.velocity : motions_.lasting;
  if (!rows_.all_locked) record_rates(velocities, problem.joints);
  record_armature_rates(input.joints, velocities, problem.joints);
  if (found) store_velocities(velocities, bodies);
}

void DirectJoints::finish(const SolveInput& input) {
  BodyTable& table = input.bodies;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const std::uint32_t body = members_.bodies[i];
    bodies_[i].now = {table.position(body), table.orientation(body)};
  }
  static_cast<void>(settle_joints(input, bodies_, motions_));
  MovedBodies& notes = input.fast.local();
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const std::uint32_t body = members_.bodies[i];
    table.position(body) = bodies_[i].now.position;
    table.set_orientation(body, bodies_[i].now.orientation);
    record_motion(table, input.bounds, body, bodies_[i].start, input.dt, notes);
  }
  write_back_joints(input, motions_.problem.joints);
}

void DirectJoints::load(const SolveInput& input, const SolverBodies& bodies) {
  static_cast<void>(load_bodies(input, members_, motions_.problem, bodies_));
  rows_ = load_joints(input.joints, members_, motions_.problem.joints);
  Substeps(input, bodies_, motions_, rows_).begin();
  load_poses(bodies);
}

bool DirectJoints::begin_impacts(const SolveInput& input, double time, std::span<const BodyPose> by,
                                 std::vector<double>& velocities) {
  for (MovingBody& body : bodies_) body.before = body.now;
  take_to(input, time, by);
  motions_.problem.free = velocities;
  if (!rows_.all_locked) record_rates(velocities, motions_.problem.joints);
  if (!Substeps(input, bodies_, motions_, rows_).hold()) return false;
  velocities = motions_.problem.velocity;
  return true;
}

int DirectJoints::end_at(const SolveInput& input, std::size_t joint, std::size_t row) const {
  const DirectJoint& of = motions_.problem.joints[joint];
  const Law& law = law_of(input.joints[of.joint], row);
  if (law.locked()) return 0;
  if (of.limit[row] != 0) return of.limit[row];
  return of.at[row].value <= law.lower ? -1 : of.at[row].value >= law.upper ? 1 : 0;
}

void DirectJoints::end_impacts(const SolveInput& input, double time, std::span<const BodyPose> by,
                               const std::vector<double>& velocities) {
  take_to(input, time, by);
  if (!rows_.all_locked) record_rates(velocities, motions_.problem.joints);
  record_armature_rates(input.joints, velocities, motions_.problem.joints);
}

// Velocities change by as much as the solution of the last kick does, so joints answer as they do to all that acts:
// locks and ends of ranges hold entirely, motors and friction with what the rest of the forces leaves of theirs.
bool DirectJoints::follow_forces(const SolveInput& input, const ForceChange& change) {
  IslandProblem& problem = motions_.problem;
  const double h = input.substep();
  Substeps joints(input, bodies_, motions_, rows_);
  const bool kicked = std::exchange(kicked_, false);
  if (!kicked) begin_last_kick(input);
  if (!joints.solve_rows()) return false;
  motions_.lasting = problem.velocity;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const DirectBody& body = problem.bodies[i];
    const Eigen::Map<const Vector3> force(change.force + 3 * body.body), torque(change.torque + 3 * body.body);
    linear_part(problem.free, i) += 0.5 * h * body.inverse_mass.cwiseProduct(force);
    angular_part(problem.free, i) += 0.5 * h * turning(body, bodies_[i], torque);
  }
  const auto find_answer = [&] {
    const bool found = joints.solve_rows();
    for (std::size_t i = 0; i < answer_.size(); ++i) answer_[i] = problem.velocity[i] - motions_.lasting[i];
    return found;
  };
  if (!find_answer()) return false;
  const auto looks_back = [&](const DirectJoint& joint) { return input.joints[joint.joint].looking_back() > 0; };
  // Corrections of springs and servos go by accelerations, which have changed too. Swept joints are of first order.
  if (kicked && std::any_of(problem.joints.begin(), problem.joints.end(), looks_back)) {
    for (DirectJoint& joint : problem.joints) {
      joint.rate_before = {};
      joint.rates_by(answer_.data(), joint.rate.data());
    }
    correct_kick(input.joints, h, 1, problem);
    for (DirectJoint& joint : problem.joints) find_rates(problem.velocity, joint, joint.rate);
    if (!find_answer()) return false;
  }
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    input.bodies.velocity(members_.bodies[i]) += linear_part(answer_, i);
    input.bodies.angular_velocity(members_.bodies[i]) += angular_part(answer_, i);
  }
  return true;
}

// Loads what was solved otherwise, as if velocities were to be kicked by the forces of half a substep.
void DirectJoints::begin_last_kick(const SolveInput& input) {
  IslandProblem& problem = motions_.problem;
  const double h = input.substep();
  static_cast<void>(load_bodies(input, members_, problem, bodies_));
  rows_ = load_joints(input.joints, members_, problem.joints);
  Substeps(input, bodies_, motions_, rows_).begin();
  record_rates(problem.velocity, problem.joints);
  bound_servos(input.joints, problem.joints);
  if (rows_.looks_back) weigh_joined(input.joints, h, problem, motions_.search);
  free_velocities_of_kick(input.bodies, 0.5 * h, bodies_, problem);
  begin_kick(input.joints, h, 1, problem);
}

void DirectJoints::load_poses(const SolverBodies& bodies) {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const DisplacementRows& rows = bodies.displacement[places_[i]];
    BodyPose& now = bodies_[i].now;
    now.position = bodies_[i].start.position + get3(rows.linear);
    now.orientation = (rotation_of(rows) * bodies_[i].start.orientation).normalized();
  }
}

void DirectJoints::take_to(const SolveInput& input, double time, std::span<const BodyPose> by) {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    MovingBody& body = bodies_[i];
    body.now.position = body.before.position + by[i].position;
    body.now.orientation = (by[i].orientation * body.before.orientation).normalized();
  }
  Substeps(input, bodies_, motions_, rows_).place(time);
}

void DirectJoints::load_velocities(const SolverBodies& bodies) {
  std::vector<double>& velocities = motions_.lasting;
  velocities.resize(answer_.size());
  for (std::size_t i = 0; i < places_.size(); ++i) {
    linear_part(velocities, i) = velocity_of(bodies, places_[i]);
    angular_part(velocities, i) = spin_of(bodies, places_[i]);
  }
}

// Sets velocities outside of what is carried over to the next substep, which is the impulses of contacts alone.
void DirectJoints::store_velocities(const std::vector<double>& velocities, SolverBodies& bodies) {
  for (std::size_t i = 0; i < places_.size(); ++i) {
    set_uncarried(bodies, places_[i], linear_part(velocities, i), angular_part(velocities, i));
  }
}

}  // namespace atl::solver
