#include <solver/constraints/contact_arm.h>
#include <solver/constraints/contact_inertia.h>
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
    const Vector3 turning = of.inverse_inertia * (table.torque(of.body) - of.spin.cross(of.inertia * of.spin));
    auto velocity = linear_part(problem.free, i);
    auto angular = angular_part(problem.free, i);
    velocity = table.velocity(of.body);
    angular = spin;
    if (table.linear_damping[of.body] == 0 && table.angular_damping[of.body] == 0) {
      velocity += input.dt * bodies[i].acceleration;
      angular += input.dt * turning;
      continue;
    }
    for (int k = 0; k < input.settings.substeps; ++k) {
      velocity = (velocity + h * bodies[i].acceleration) / (1 + h * table.linear_damping[of.body]);
      angular = (angular + h * turning) / (1 + h * table.angular_damping[of.body]);
    }
  }
}

// The ways in which a body's velocity changes in the step.
enum class Change : std::uint8_t {
  Steadily,  // it moves by the mean of the first and the last, as the trapezoidal rule has it
  Lands,     // slowly; it moves by the last, or it would get into what it lands on
  Jumps,     // likewise, and nothing is foreseen
};

bool pushes(const DirectContact& contact) {
  const auto& of = contact.lasting.normal;
  return std::any_of(of.begin(), of.begin() + contact.law.points, [](double normal) { return normal > 0; });
}

// Bodies that push each other move alike: one that moved by the mean would get into one that has stopped.
void spread_landings(const std::vector<DirectContact>& contacts, std::vector<Change>& changes) {
  for (bool any = true; any;) {
    any = false;
    for (const DirectContact& contact : contacts) {
      if (contact.fixed() || !pushes(contact)) continue;
      Change& first = changes[contact.first];
      Change& second = changes[contact.second];
      if ((first == Change::Steadily) == (second == Change::Steadily)) continue;
      (first == Change::Steadily ? first : second) = Change::Lands;
      any = true;
    }
  }
}

std::vector<Change> find_changes(const SolveInput& input, const std::vector<MovingBody>& bodies,
                                 const IslandMotions& motions, const std::vector<double>& before) {
  const std::vector<DirectContact>& contacts = motions.problem.contacts;
  std::vector<Change> changes(bodies.size(), Change::Steadily);
  for (const DirectContact& contact : contacts) {
    if (!contact.lands || !pushes(contact)) continue;
    if (contact.first != no_body) changes[contact.first] = Change::Lands;
    if (contact.second != no_body) changes[contact.second] = Change::Lands;
  }
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Vector3 gained = linear_part(motions.lasting, i) - linear_part(before, i);
    const Vector3 gained_spin = angular_part(motions.lasting, i) - angular_part(before, i);
    const double radius = input.bodies.radius[motions.problem.bodies[i].body];
    // A turning body's velocity also changes by its own motion.
    const double turning = radius * angular_part(before, i).squaredNorm();
    const double acceleration = bodies[i].acceleration.norm() + turning;
    if (!changes_steadily(gained, gained_spin, acceleration, input.dt, radius)) changes[i] = Change::Jumps;
  }
  spread_landings(contacts, changes);
  return changes;
}

// Marks (1, by body) those that something pushes on.
std::vector<std::uint8_t> find_pushed(const IslandProblem& problem) {
  std::vector<std::uint8_t> pushed(problem.bodies.size(), 0);
  for (const DirectContact& contact : problem.contacts) {
    if (!pushes(contact)) continue;
    if (contact.first != no_body) pushed[contact.first] = 1;
    if (contact.second != no_body) pushed[contact.second] = 1;
  }
  return pushed;
}

void write_back_bodies(const SolveInput& input, const std::vector<MovingBody>& bodies, const IslandMotions& motions,
                       const std::vector<Change>& changes) {
  BodyTable& table = input.bodies;
  const std::vector<std::uint8_t> pushed = find_pushed(motions.problem);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const std::uint32_t body = motions.problem.bodies[i].body;
    // A body that has parted tumbles by the integrator of free flight, which keeps its energy.
    if (bodies[i].tumbles && pushed[i] == 0) {
      move_free_body(table, body, input.gravity, input.dt, input.settings.substeps, input.bounds, input.fast);
      continue;
    }
    const BodyPose& start = bodies[i].start;
    const Vector3 velocity = linear_part(motions.lasting, i);
    const Vector3 spin = angular_part(motions.lasting, i);
    Vector3 moves = linear_part(motions.problem.velocity, i);
    Vector3 turns = angular_part(motions.problem.velocity, i);
    if (changes[i] == Change::Steadily) {
      moves -= 0.5 * (velocity - table.velocity(body));
      turns -= 0.5 * (spin - table.angular_velocity(body));
    }
    table.velocity(body) = velocity;
    table.angular_velocity(body) = spin;
    table.position(body) += input.dt * moves;
    table.set_orientation(body, turned(input.dt * turns, start.orientation));
    record_motion(table, input.bounds, body, start, input.dt, input.fast.local());
  }
}

// Takes the turns of bodies from the solution, but for those that jump. Returns whether one differs from that which it
// was found with.
bool foresee_turns(const SolveInput& input, const std::vector<Change>& changes, const std::vector<double>& before,
                   IslandMotions& motions) {
  const BodyTable& table = input.bodies;
  bool differs = false;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    DirectBody& body = motions.problem.bodies[i];
    if (!turns_in_step(table, body.body, input.dt) || is_seen_heavier(table, body.body)) continue;
    if (changes[i] == Change::Jumps) continue;
    const Vector3 last = angular_part(motions.lasting, i);
    const Vector3 spin = changes[i] == Change::Lands ? last : Vector3(0.5 * (angular_part(before, i) + last));
    const Vector3 half_turn = 0.5 * input.dt * spin;
    const double rim_speed = table.radius[body.body] * spin.norm();
    const double missed = rim_speed * (half_turn - body.half_turn).norm() / input.dt;
    differs |= missed > tuning::foreseen_part * input.gravity.norm();
    body.spin = spin;
    body.half_turn = half_turn;
    set_inertia_half_way(table, body);
  }
  return differs;
}

}  // namespace

bool solve_step(const SolveInput& input, const IslandMembers& members, const std::vector<MovingBody>& bodies,
                IslandMotions& motions) {
  IslandProblem& problem = motions.problem;
  const std::vector<double> before = problem.velocity;
  std::vector<Change> changes;
  for (int round = 0;; ++round) {
    free_velocities_of_step(input, bodies, problem);
    motions.lasting = before;
    if (!find_motions(motions, input.settings, input.dt, 0)) return false;
    changes = find_changes(input, bodies, motions, before);
    if (round == tuning::turn_rounds || !foresee_turns(input, changes, before, motions)) break;
    problem.velocity = before;
    turn_contacts(input, members, problem);
  }
  if (input.capture != nullptr) capture_contacts(*input.capture, input.manifolds, input.dt, motions.problem);
  write_back_bodies(input, bodies, motions, changes);
  if (input.pushed != nullptr) record_pushes(motions.problem, true, input.pushed);
  const double share = input.settings.refinement / input.settings.substeps;
  write_back_contacts(input, share, motions.problem.contacts);
  return true;
}

}  // namespace atl::solver
