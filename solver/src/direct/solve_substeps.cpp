#include <solver/direct/island_matrix.h>
#include <solver/direct/moving_bodies.h>
#include <solver/tuning.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "direct/island_contacts.h"
#include "direct/island_gaps.h"
#include "direct/island_joints.h"
#include "direct/island_results.h"
#include "direct/island_solves.h"

namespace atl::solver {
namespace {

// Euler's equations by the midpoint rule.
Vector3 free_spin(const MovingBody& body, const Vector3& spin, const Vector3& torque, double h) {
  const auto accelerates = [&](const Matrix3& inertia, const Vector3& w) -> Vector3 {
    return inertia.inverse() * (torque - w.cross(inertia * w));
  };
  if (!body.tumbles) return spin + h * (body.inertia.inverse() * torque);
  const Vector3 middle = spin + 0.5 * h * accelerates(body.inertia, spin);
  const Matrix3 rotation = turned(0.5 * h * spin, body.now.orientation).toRotationMatrix();
  return spin + h * accelerates(rotation * body.body_inertia * rotation.transpose(), middle);
}

// The velocities that forces alone would make in a substep.
void free_velocities_of_substep(const BodyTable& table, const std::vector<MovingBody>& bodies, double h,
                                IslandProblem& problem) {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const std::uint32_t body = problem.bodies[i].body;
    const auto velocity = linear_part(std::as_const(problem.velocity), i);
    const auto spin = angular_part(std::as_const(problem.velocity), i);
    linear_part(problem.free, i) = (velocity + h * bodies[i].acceleration) / (1 + h * table.linear_damping[body]);
    angular_part(problem.free, i) =
        free_spin(bodies[i], spin, table.torque(body), h) / (1 + h * table.angular_damping[body]);
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
      sum += turns * (law.motor_impulse + law.spring_slope * std::abs(law.spring_rate));
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

// Finds velocities that keep the joints at the new poses, and change nothing at contacts that rest: both have had their
// impulses, and answer to what is left alone. Returns false if there are none.
bool project(const Joint* joints, IslandMotions& motions, double h) {
  IslandProblem& problem = motions.problem;
  problem.free = motions.lasting;
  problem.velocity = motions.lasting;
  hold_rows(joints, problem);
  hold_resting_points(problem, h);
  if (!solve_on_last_pieces(problem, motions.search)) return false;
  for (DirectContact& contact : problem.contacts) contact.answer = contact.lasting;
  return true;
}

void write_back_bodies(const DirectIslandInput& input, const std::vector<MovingBody>& bodies,
                       const IslandProblem& problem) {
  BodyTable& table = input.bodies;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const std::uint32_t body = problem.bodies[i].body;
    table.position(body) = bodies[i].now.position;
    table.set_orientation(body, bodies[i].now.orientation);
    table.velocity(body) = linear_part(problem.velocity, i);
    table.angular_velocity(body) = angular_part(problem.velocity, i);
    note_motion(table, input.bounds, body, bodies[i].start, input.dt, input.fast.local());
  }
}

}  // namespace

bool solve_substeps(const DirectIslandInput& input, const IslandMembers& members, std::vector<MovingBody>& bodies,
                    IslandMotions& motions) {
  const SolverSettings& settings = input.settings;
  const double h = input.substep();
  IslandProblem& problem = motions.problem;
  const bool all_locked = load_joints(input, members, problem.joints);
  place_joints(input, 0, h, bodies, problem);
  const bool torn = note_tears(input.joints, problem.joints);
  if (may_bounce(input, problem)) return false;
  for (int substep = 0; substep < settings.substeps; ++substep) {
    const double time = h * (substep + 1);
    motions.lasting = problem.velocity;
    free_velocities_of_substep(input.bodies, bodies, h, problem);
    begin_laws(input.joints, h, motions.lasting, problem);
    if (!all_locked) forget_factor(problem);
    if (!find_motions(motions, settings, h, drive(input.bodies, h, motions))) return false;
    const bool last = substep + 1 == settings.substeps;
    if (last && input.capture != nullptr) capture_contacts(*input.capture, input.manifolds, h, problem);
    note_armature(input.joints, motions.lasting, problem.joints);
    move(bodies, h, problem.velocity);
    close_joints(input, time, h, torn, bodies, motions);
    place_joints(input, time, h, bodies, problem);
    place_contacts({input.bodies, bodies, time}, problem.contacts);
    if (!project(input.joints, motions, h)) return false;
  }
  settle_joints(input, bodies, motions);
  write_back_bodies(input, bodies, problem);
  write_back_joints(input, problem.joints);
  write_back_contacts(input, 1, problem.contacts);
  return true;
}

}  // namespace atl::solver
