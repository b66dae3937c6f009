#include "direct/island_results.h"
#include "direct/island_solves.h"

namespace atl::solver {
namespace {

// The velocities that forces alone would make in the step, as sweeps would in their substeps.
void free_velocities_of_step(const DirectIslandInput& input, const std::vector<MovingBody>& bodies,
                             IslandProblem& problem) {
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

// Moves bodies by the trapezoidal rule where the change is steady.
void write_back_bodies(const DirectIslandInput& input, const std::vector<MovingBody>& bodies,
                       const IslandMotions& motions) {
  BodyTable& table = input.bodies;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const std::uint32_t body = motions.problem.bodies[i].body;
    const BodyPose& start = bodies[i].start;
    const Vector3 velocity = linear_part(motions.lasting, i);
    const Vector3 spin = angular_part(motions.lasting, i);
    const Vector3 gained = velocity - table.velocity(body);
    const Vector3 gained_spin = spin - table.angular_velocity(body);
    Vector3 moves = linear_part(motions.problem.velocity, i);
    Vector3 turns = angular_part(motions.problem.velocity, i);
    if (changes_steadily(gained, gained_spin, bodies[i].acceleration, input.dt, table.radius[body])) {
      moves -= 0.5 * gained;
      turns -= 0.5 * gained_spin;
    }
    table.velocity(body) = velocity;
    table.angular_velocity(body) = spin;
    table.position(body) += input.dt * moves;
    table.set_orientation(body, turned(input.dt * turns, start.orientation));
    note_motion(table, input.bounds, body, start, input.dt, input.fast.local());
  }
}

}  // namespace

bool solve_step(const DirectIslandInput& input, const std::vector<MovingBody>& bodies, IslandMotions& motions) {
  free_velocities_of_step(input, bodies, motions.problem);
  motions.lasting = motions.problem.velocity;
  if (!find_motions(motions, input.settings, input.dt, 0)) return false;
  if (input.capture != nullptr) capture_contacts(*input.capture, input.manifolds, input.dt, motions.problem);
  write_back_bodies(input, bodies, motions);
  write_back_contacts(input, 1.0 / input.settings.substeps, motions.problem.contacts);
  return true;
}

}  // namespace atl::solver
