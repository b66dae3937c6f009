#include <jobs/assert.h>
#include <solver/direct/island_matrix.h>
#include <solver/direct/moving_bodies.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "direct/conservation.h"
#include "direct/island_joints.h"
#include "direct/island_solves.h"
#include "direct/joined_masses.h"
#include "direct/joint_leapfrog.h"
#include "direct/substeps.h"
#include "integrate/matrix3.h"

namespace atl::solver {
namespace {

// True if a body turns other than by its spin alone.
bool tumbles(const MovingBody& body, const Vector3& spin) {
  return body.tumbles && spin.squaredNorm() > tuning::min_spin * tuning::min_spin;
}

// The velocities that forces alone would make in a substep. A body with contacts turns by its spin, along which these
// are held, and its tumbling is a change of the spin.
void free_velocities_of_substep(const BodyTable& table, const std::vector<MovingBody>& bodies, double h, bool alone,
                                IslandProblem& problem) {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const std::uint32_t body = problem.bodies[i].body;
    const auto velocity = linear_part(std::as_const(problem.velocity), i);
    Vector3 spin = angular_part(std::as_const(problem.velocity), i);
    if (!alone && tumbles(bodies[i], spin)) {
      Quaternion orientation = bodies[i].now.orientation;
      bodies[i].top.turn(table.inverse_inertia[body], product(bodies[i].inertia, spin), h, orientation, spin);
    }
    linear_part(problem.free, i) = (velocity + h * bodies[i].acceleration) / (1 + h * table.linear_damping[body]);
    angular_part(problem.free, i) =
        (spin + h * turning(problem.bodies[i], bodies[i], table.torque(body))) / (1 + h * table.angular_damping[body]);
  }
}

// N s: what drives the island in a substep beside its own momentum.
double drive(const BodyTable& table, double h, const IslandMotions& motions) {
  const std::vector<DirectBody>& bodies = motions.problem.bodies;
  double sum = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const DirectBody& body = bodies[i];
    sum += body.mass * linear_part(motions.lasting, i).norm() +
           h * (table.force(body.body).norm() + table.torque(body.body).norm() / body.radius);
  }
  for (const DirectJoint& joint : motions.problem.joints) {
    double radius = 0;  // m, that makes forces of torques
    for (const std::uint32_t body : {joint.first, joint.second}) {
      if (body != no_body) radius = radius > 0 ? std::min(radius, bodies[body].radius) : bodies[body].radius;
    }
    for (std::size_t r = 0; r < joint.rows; ++r) {
      const RowLaw& law = joint.law[r];
      const double turns = joint.at[r].linear.isZero() ? 1 / radius : 1;
      sum += turns * (law.motor_impulse + law.friction_impulse + law.spring_slope * std::abs(law.spring_rate));
    }
  }
  return sum;
}

// Points that rest push on, and no other.
void hold_resting_points(IslandProblem& problem, double h) {
  stop_contacts(problem.contacts, h);
  for (DirectContact& contact : problem.contacts) {
    const ContactPieces pieces = contact.lasting.pieces;
    contact.answer = {};
    contact.answer.pieces = pieces;
    const Six motion = contact.motion_at(problem.velocity);
    for (int i = 0; i < contact.law.points; ++i) {
      contact.law.bias[i] = 0;
      const bool rests = std::abs(contact.law.speed(i, motion)) <= tuning::resting_speed;
      if (!rests) contact.answer.pieces.points &= static_cast<std::uint8_t>(~(1 << i));
    }
  }
}

// Tells joints that make loops: more of them than a tree has. A tendon holds one coordinate of bodies that others
// carry.
bool has_loops(const IslandProblem& problem) {
  const auto tendons = static_cast<std::size_t>(std::count_if(
      problem.joints.begin(), problem.joints.end(), [](const DirectJoint& joint) { return joint.is_tendon(); }));
  const bool anchored = std::any_of(problem.joints.begin(), problem.joints.end(), [](const DirectJoint& joint) {
    return joint.first == no_body || joint.second == no_body;
  });
  return problem.joints.size() - tendons > problem.bodies.size() - (anchored ? 0 : 1);
}

// Records the impulses of held rows after a linear solution.
void record_held_impulses(IslandProblem& problem) {
  for (DirectJoint& joint : problem.joints) {
    for (std::size_t r = 0; r < joint.rows; ++r) {
      joint.impulse[r] = joint.law[r].impulse(joint.rate[r] + joint.change[r]);
    }
  }
}

void add_last_impulses(IslandProblem& problem) {
  for (DirectJoint& joint : problem.joints) {
    for (std::size_t r = 0; r < joint.rows; ++r) joint.lasting[r] += joint.impulse[r];
  }
}

bool any_bounces(const IslandProblem& problem) {
  for (const DirectJoint& joint : problem.joints) {
    for (std::size_t r = 0; r < joint.rows; ++r) {
      if (joint.bounces[r]) return true;
    }
  }
  return false;
}

void stop_bounces(IslandProblem& problem) {
  for (DirectJoint& joint : problem.joints) {
    for (std::size_t r = 0; r < joint.rows; ++r) {
      if (joint.bounces[r]) joint.law[r].lock_rate = 0;
    }
  }
}

}  // namespace

bool Substeps::solve() {
  const int substeps = input_.settings.substeps;
  begin();
  if (alone_) {
    conserved_ = Conservation(input_, rows_, problem_, bodies_);
    kick(-1);
  } else {
    weigh_crowded();
  }
  for (int substep = 0; substep < substeps; ++substep) {
    const double time = h_ * (substep + 1);
    if (!find_velocities(time)) return false;
    if (input_.pushed != nullptr) record_pushes(problem_, substep == 0, input_.pushed);
    const bool last = substep + 1 == substeps;
    if (last && input_.capture != nullptr) capture_contacts(*input_.capture, input_.manifolds, h_, problem_);
    advance();
    close_joints(input_, time, h_, bodies_, motions_);
    place(time);
    place_contacts({input_.bodies, bodies_, time}, problem_.contacts);
    if (!project()) return false;
  }
  const bool closed = settle_joints(input_, bodies_, motions_);
  if (alone_) {
    kick(1);
    // Joints didn't answer to the forces that were taken back ahead of the first substep: what they held then is known
    // from those that are taken on, if no substep has come in between.
    if (substeps == 1 && !rows_.acts) add_last_impulses(problem_);
    conserved_.restore(input_, bodies_, closed && swing_ <= tuning::max_resolved_swing, problem_);
  }
  return true;
}

void Substeps::begin() {
  ATL_ASSERT(bodies_.size() == problem_.bodies.size(), bodies_.size(), problem_.bodies.size());
  const bool gives = alone_ && (has_loops(problem_) || has_locks(problem_));
  problem_.lock_compliance = gives        ? tuning::compliance_of_loops
                             : by_bodies_ ? tuning::compliance
                                          : tuning::compliance_of_trees;
  motions_.search.max_iterations = tuning::max_iterations_if_patient;
  place(0);
}

void Substeps::weigh_crowded() {
  if (!rows_.looks_back) return;
  std::vector<DirectContact> contacts;
  contacts.swap(problem_.contacts);
  solver::weigh_crowded(input_.joints, h_, problem_, motions_.search);
  contacts.swap(problem_.contacts);
}

void Substeps::place(double time) {
  place_joints(input_, time, h_, bodies_, problem_);
  if (by_bodies_) weigh_locks(input_.joints, problem_);
}

// Velocities that were given may be none that the joints allow. Forces are taken back from what is left of them: rows
// that go at the rates they have would be driven at rates that they don't keep.
void Substeps::give_up_what_locks_forbid() {
  const auto forbids = [&](const DirectJoint& joint) { return is_against_locks(problem_, joint); };
  if (std::none_of(problem_.joints.begin(), problem_.joints.end(), forbids)) return;
  hold_locks_alone(input_.joints, problem_);
  problem_.free = problem_.velocity;
  if (!solve_rows()) problem_.velocity = problem_.free;
  record_rates(problem_.velocity, problem_.joints);
}

// Takes half a substep's forces back (-1), or on (1). Springs and servos have their half of it with all others, and
// joints answer to them together: a spring that bears a load is in balance with it at every instant.
void Substeps::kick(int sign) {
  // The kick that gives and the next that takes, at the same poses, see stiff springs alike.
  const bool weighs = rows_.looks_back && (sign < 0 || any_stiff_spring(input_.joints, h_, problem_));
  if (rows_.acts) record_rates(problem_.velocity, problem_.joints);
  if (sign < 0) bound_servos(input_.joints, problem_.joints);
  if (weighs) weigh_joined(input_.joints, h_, problem_, motions_.search);
  if (rows_.acts && sign < 0) give_up_what_locks_forbid();
  free_velocities_of_kick(input_.bodies, 0.5 * sign * h_, bodies_, problem_);
  conserved_.add_forces(problem_, bodies_);
  if (!rows_.acts && sign < 0) {
    problem_.velocity = problem_.free;
    return;
  }
  if (!rows_.acts) {
    motions_.lasting = problem_.free;
    for (DirectJoint& joint : problem_.joints) {
      for (std::size_t r = 0; r < joint.rows; ++r) {
        if (joint.bounces[r]) joint.law[r].lock_rate = joint.impact[r].leaving;
      }
    }
    static_cast<void>(solve_held_rows());
    return;
  }
  begin_kick(input_.joints, h_, sign, problem_);
  const auto find = [&] {
    const bool found = solve_rows();
    if (!found) problem_.velocity = problem_.free;
    return found;
  };
  if (!find() || !rows_.looks_back) return;
  for (DirectJoint& joint : problem_.joints) find_rates(problem_.velocity, joint, joint.rate);
  correct_kick(input_.joints, h_, sign, problem_);
  find();
}

// Finds the velocities that bodies keep and those that they move by, along the rows of the substep's start.
bool Substeps::find_velocities(double time) {
  motions_.lasting = problem_.velocity;
  free_velocities_of_substep(input_.bodies, bodies_, h_, alone_, problem_);
  if (alone_) conserved_.add_forces(problem_, bodies_);
  if (!rows_.all_locked) record_rates(motions_.lasting, problem_.joints);
  begin_substep();
  stop_at_ends(problem_.joints);
  if (alone_) {
    foresee_bends(time);
    return find_joint_velocities(true) && go_back();
  }
  if (rows_.bounces && !find_impacts()) return false;
  return find_motions(motions_, input_.settings, h_, drive(input_.bodies, h_, motions_));
}

void Substeps::begin_substep() {
  begin_laws(input_.joints, h_, problem_);
  if (!rows_.all_locked) forget_factor(problem_);
}

void Substeps::foresee_bends(double time) {
  const double swing = find_bends(input_, time, h_, bodies_, problem_);
  swing_ = std::max(swing_, swing);
  if (rows_.damps && swing > 0) even_out_dampers();
  answer_bends(input_.joints, problem_);
}

void Substeps::even_out_dampers() {
  if (!is_factored(problem_) && !motions_.search.matrix.factor(problem_)) return;
  find_closing_motion(problem_, motions_.search, [&](const DirectJoint& joint, std::size_t r) {
    const double slope = joint.law[r].slope(joint.rate[r]);
    const double turns = slope > 0 ? law_of(input_.joints[joint.joint], r).armature / slope : 0;
    return -(joint.law[r].locked ? 1 : turns) * joint.bend[r];
  });
  damp_by_like_rates(input_.joints, motions_.search.direction, problem_);
}

bool Substeps::find_joint_velocities(bool finds_impacts) {
  if (finds_impacts && rows_.bounces && !find_impacts()) return false;
  return find_row_velocities() && find_passive_velocities();
}

bool Substeps::solve_rows() {
  if (!by_bodies_ && solve_joints(problem_, motions_.search)) return true;
  problem_.velocity = problem_.free;
  if (!by_bodies_) weigh_locks(input_.joints, problem_);
  return solve_by_newton(problem_, motions_.search);
}

bool Substeps::find_row_velocities() {
  if (!solve_rows()) return false;
  motions_.lasting = problem_.velocity;
  motions_.pushes = false;
  for (DirectJoint& joint : problem_.joints) joint.lasting = joint.impulse;
  return true;
}

// Finds the velocities by which bodies move, where coordinates are beyond their ranges.
bool Substeps::go_back() {
  motions_.pushes = any_goes_back(problem_.joints);
  if (!motions_.pushes) return true;
  begin_going_back(problem_.joints);
  return solve_rows();
}

// Finds how fast coordinates would come to the ends of their ranges if these didn't hold.
bool Substeps::find_impacts() {
  motions_.energy_before = kinetic_energy(bodies_, problem_, problem_.free);
  const auto limit_ranges = [&](bool limited) {
    for (DirectJoint& joint : problem_.joints) {
      for (std::size_t r = 0; r < joint.rows; ++r) {
        RowLaw& law = joint.law[r];
        if (law_of(input_.joints[joint.joint], r).restitution == 0 || joint.limit[r] != 0) continue;
        if (limited) {
          law.lower_rate = joint.impact[r].leaving;
          law.upper_rate = joint.impact[r].leaving_late;
        } else {
          joint.impact[r].leaving = law.lower_rate;
          joint.impact[r].leaving_late = law.upper_rate;
          law.lower_rate = -Law::unlimited;
          law.upper_rate = Law::unlimited;
        }
      }
    }
  };
  limit_ranges(false);
  if (!alone_) stop_contacts(problem_.contacts, h_);
  const bool found = alone_ ? solve_rows() : solve_by_newton(problem_, motions_.search);
  if (found) find_falls(input_.joints, h_, problem_, motions_.search);
  limit_ranges(true);
  if (!found) return false;
  record_impacts(input_.joints, h_, problem_.joints);
  problem_.velocity = motions_.lasting;
  forget_factor(problem_);
  return true;
}

// True if a solution makes energy from the free velocities. Where what joints hang on moves, so do arms with it all the
// time. Locks that foresee a bend then go along a chord, longer than the way along the row by a part that the
// projection takes back, and that is no gain. Where it stands, arms that turn as fast whip, and mechanisms gain 6%
// without.
bool Substeps::makes_energy(const std::vector<double>& velocity, Rotors rotors) const {
  double given = work_of_bases(problem_, &DirectJoint::impulse);
  if (given != 0) {
    for (const DirectJoint& joint : problem_.joints) {
      for (std::size_t r = 0; r < joint.rows; ++r) {
        if (joint.law[r].locked) given -= 0.5 * joint.impulse[r] * joint.bend[r];
      }
    }
  }
  return gains_energy(input_.joints, problem_, bodies_, given, problem_.free, velocity, rotors);
}

// Impulses along rows that ask for no rate of their own only take energy from bodies of the inertia that they have.
bool Substeps::find_passive_velocities() {
  if (!makes_energy(motions_.lasting, Rotors::Turn)) return true;
  leave_out_tension(bodies_, problem_);
  forget_bends(input_.joints, problem_);
  return find_row_velocities();
}

// Moves bodies by their velocities. Bodies of unequal moments tumble with constant angular momentum.
void Substeps::advance() {
  record_armature_rates(input_.joints, motions_.lasting, problem_.joints);
  advance_coordinates();
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    BodyPose& pose = bodies_[i].now;
    Vector3 spin = angular_part(motions_.lasting, i);
    Vector3 turns = angular_part(problem_.velocity, i);
    pose.position += h_ * linear_part(problem_.velocity, i);
    if (alone_ && tumbles(bodies_[i], spin)) {
      turns -= spin;
      const Matrix3& inverse_inertia = input_.bodies.inverse_inertia[problem_.bodies[i].body];
      bodies_[i].top.turn(inverse_inertia, product(bodies_[i].inertia, spin), h_, pose.orientation, spin);
      angular_part(motions_.lasting, i) = spin;
    }
    if (!turns.isZero(0)) pose.orientation = turned(h_ * turns, pose.orientation);
  }
}

bool Substeps::hold() {
  leave_out_tension(bodies_, problem_);
  hold_locks_alone(input_.joints, problem_);
  if (by_bodies_) weigh_locks(input_.joints, problem_);
  return solve_rows() && (is_factored(problem_) || motions_.search.matrix.factor(problem_));
}

void Substeps::advance_coordinates() {
  for (DirectJoint& joint : problem_.joints) {
    joint.move_terms(problem_.velocity, h_);
    for (std::size_t r = joint.point_rows(); r < joint.rows; ++r) {
      joint.position[r] += h_ * joint.rate_by(problem_.velocity, r, joint.given[r]);
    }
  }
}

// Finds velocities that keep the joints at the new poses, and change nothing at contacts that rest: both have had their
// impulses, and answer to what is left alone. Returns false if there are none.
bool Substeps::project() {
  if (motions_.pushes) end_going_back(problem_.joints);
  hold_rows(input_.joints, problem_);
  if (!alone_) {
    problem_.velocity = motions_.lasting;
    hold_resting_points(problem_, h_);
  }
  if (!solve_held_rows()) return false;
  add_last_impulses(problem_);
  for (DirectContact& contact : problem_.contacts) contact.answer = contact.lasting;
  return true;
}

bool Substeps::solve_held_rows() {
  problem_.free = motions_.lasting;
  if (!solve_linear()) return false;
  if (any_bounces(problem_)) return limit_bounces();
  if (!alone_) return true;
  if (!makes_energy(problem_.velocity, Rotors::Pay)) return true;
  leave_out_tension(bodies_, problem_);
  return solve_linear();
}

// Solves for velocities with all rows kept on the pieces of their laws.
bool Substeps::solve_linear() {
  if (!by_bodies_) return solve_joints(problem_, motions_.search);
  problem_.velocity = motions_.lasting;
  if (!solve_on_last_pieces(problem_, motions_.search)) return false;
  record_held_impulses(problem_);
  return true;
}

// By Newton's law of restitution, a bounce while other coordinates are at their ends may make energy. All then leave
// slower by a common share, which is found from the velocities without any bounce, on the same rows.
bool Substeps::limit_bounces() {
  if (count_rows_at_ends(problem_.joints) < 2) return true;
  if (kinetic_energy(bodies_, problem_, problem_.velocity) <= motions_.energy_before) return true;
  const std::vector<double> bounced = problem_.velocity;
  stop_bounces(problem_);
  if (!solve_linear()) return false;
  std::vector<double> change = bounced;
  for (std::size_t i = 0; i < change.size(); ++i) change[i] -= problem_.velocity[i];
  const double stopped = kinetic_energy(bodies_, problem_, problem_.velocity);
  const double square = kinetic_energy(bodies_, problem_, change);
  if (square == 0) return true;  // nothing leaves faster than it is stopped
  const double linear = kinetic_energy(bodies_, problem_, bounced) - stopped - square;
  const double room = std::max(motions_.energy_before - stopped, 0.0);
  const double share = std::clamp((std::sqrt(linear * linear + 4 * square * room) - linear) / (2 * square), 0.0, 1.0);
  for (DirectJoint& joint : problem_.joints) {
    for (LimitImpact& impact : joint.impact) {
      impact.leaving *= share;
      impact.leaving_late *= share;
    }
  }
  for (std::size_t i = 0; i < change.size(); ++i) problem_.velocity[i] += share * change[i];
  return true;
}

namespace {

void write_back_bodies(const SolveInput& input, const std::vector<MovingBody>& bodies, const IslandProblem& problem) {
  BodyTable& table = input.bodies;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const std::uint32_t body = problem.bodies[i].body;
    table.position(body) = bodies[i].now.position;
    table.set_orientation(body, bodies[i].now.orientation);
    table.velocity(body) = linear_part(problem.velocity, i);
    table.angular_velocity(body) = angular_part(problem.velocity, i);
    record_motion(table, input.bounds, body, bodies[i].start, input.dt, input.fast.local());
  }
}

}  // namespace

bool solve_substeps(const SolveInput& input, const IslandMembers& members, std::vector<MovingBody>& bodies,
                    IslandMotions& motions) {
  IslandProblem& problem = motions.problem;
  const RowKinds rows = load_joints(input.joints, members, problem.joints);
  if (!Substeps(input, bodies, motions, rows).solve()) return false;
  write_back_bodies(input, bodies, problem);
  write_back_joints(input, problem.joints);
  write_back_contacts(input, 1, problem.contacts);
  return true;
}

}  // namespace atl::solver
