#include <solver/tuning.h>

#include <algorithm>

#include "direct/island_solves.h"

namespace atl::solver {
namespace {

// The velocities that forces alone would make in the step, as sweeps would in their substeps.
void free_velocities_of_step(const SolveInput& input, const std::vector<MovingBody>& bodies, IslandProblem& problem) {
  const BodyTable& table = input.bodies;
  const double h = input.substep();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const DirectBody& of = problem.bodies[i];
    const Vector3 spin = table.angular_velocity(of.body);
    const Vector3 turning = of.inverse_inertia * (table.torque(of.body) - spin.cross(of.inertia * spin));
    auto velocity = linear_part(problem.free, i);
    auto angular = angular_part(problem.free, i);
    velocity = table.velocity(of.body);
    angular = spin;
    for (int k = 0; k < input.settings.substeps; ++k) {
      velocity = (velocity + h * bodies[i].acceleration) / (1 + h * table.linear_damping[of.body]);
      angular = (angular + h * turning) / (1 + h * table.angular_damping[of.body]);
    }
  }
}

// Marks (1, by body) the bodies that a contact stops on their way. By half of such a gain, as the trapezoidal rule has
// it, a body would get into what it lands on.
std::vector<std::uint8_t> find_landed(const IslandMotions& motions, const std::vector<double>& before) {
  std::vector<std::uint8_t> landed(motions.problem.bodies.size(), 0);
  for (const DirectContact& contact : motions.problem.contacts) {
    const auto& pushes = contact.lasting.normal;
    if (std::all_of(pushes.begin(), pushes.begin() + contact.law.points, [](double n) { return n <= 0; })) continue;
    if (contact.motion_at(before)[0] >= -tuning::resting_speed) continue;
    if (contact.first != no_body) landed[contact.first] = 1;
    if (contact.second != no_body) landed[contact.second] = 1;
  }
  return landed;
}

// Moves bodies by the trapezoidal rule where the change is steady. `before`: velocities as the step began.
void write_back_bodies(const SolveInput& input, const std::vector<MovingBody>& bodies, const IslandMotions& motions,
                       const std::vector<double>& before) {
  BodyTable& table = input.bodies;
  const std::vector<std::uint8_t> landed = find_landed(motions, before);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const std::uint32_t body = motions.problem.bodies[i].body;
    const BodyPose& start = bodies[i].start;
    const Vector3 velocity = linear_part(motions.lasting, i);
    const Vector3 spin = angular_part(motions.lasting, i);
    const Vector3 gained = velocity - table.velocity(body);
    const Vector3 gained_spin = spin - table.angular_velocity(body);
    Vector3 moves = linear_part(motions.problem.velocity, i);
    Vector3 turns = angular_part(motions.problem.velocity, i);
    if (!landed[i] && changes_steadily(gained, gained_spin, bodies[i].acceleration, input.dt, table.radius[body])) {
      moves -= 0.5 * gained;
      turns -= 0.5 * gained_spin;
    }
    table.velocity(body) = velocity;
    table.angular_velocity(body) = spin;
    table.position(body) += input.dt * moves;
    table.set_orientation(body, turned(input.dt * turns, start.orientation));
    record_motion(table, input.bounds, body, start, input.dt, input.fast.local());
  }
}

}  // namespace

bool solve_step(const SolveInput& input, const std::vector<MovingBody>& bodies, IslandMotions& motions) {
  free_velocities_of_step(input, bodies, motions.problem);
  const std::vector<double> before = motions.lasting = motions.problem.velocity;
  if (!find_motions(motions, input.settings, input.dt, 0)) return false;
  if (input.capture != nullptr) capture_contacts(*input.capture, input.manifolds, input.dt, motions.problem);
  write_back_bodies(input, bodies, motions, before);
  if (input.pushed != nullptr) record_pushes(motions.problem, true, input.pushed);
  write_back_contacts(input, 1.0 / input.settings.substeps, motions.problem.contacts);
  return true;
}

}  // namespace atl::solver
