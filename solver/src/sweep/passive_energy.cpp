#include <solver/integrate/motion.h>
#include <solver/integrate/motion_locks.h>
#include <solver/sweep/passive_energy.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>

namespace atl::solver {
namespace {

// Whether a body may turn so far in a step, or when it is struck, that contacts don't know its inertia. A spin that
// they make about the light axis, where that was, is one about the heavy axes once it has swung by an angle, by so
// much: its energy grows by their moment over the least times the square of the angle.
bool turns_blindly(const BodyTable& bodies, std::uint32_t body, double dt) {
  if (!bodies.gyroscopic[body]) return false;
  const double most = bodies.moments[body].maxCoeff(), least = bodies.moments[body].minCoeff();
  const double spin = bodies.angular_velocity(body).norm();
  const double struck = bodies.velocity(body).norm() / std::sqrt(most * bodies.inverse_mass[body]);
  return dt * (spin + struck) * std::sqrt(most / least) > tuning::blind_turn;
}

// J: of motion, and in the forces on bodies, which are the same for all of a step.
double energy_of(const SolveInput& input, std::size_t island) {
  const BodyTable& bodies = input.bodies;
  double sum = 0;
  for (const std::uint32_t body : input.islands.bodies(island, island + 1)) {
    const Vector3 force = linear_acceleration(bodies, body, input.gravity) / bodies.inverse_mass[body];
    sum += kinetic_energy(bodies, body) - force.dot(bodies.position(body));
  }
  return sum;
}

// Whether nothing in an island gives energy: no torque, belt, spring or motor, and no body that is led.
bool is_passive(const SolveInput& input, std::size_t island) {
  const BodyTable& bodies = input.bodies;
  const auto ids = input.islands.bodies(island, island + 1);
  const auto contacts = input.islands.contacts(island, island + 1);
  const auto links = input.islands.joints(island, island + 1);
  const auto is_led = [&](std::uint32_t body) {
    return bodies.mobility[body] == Mobility::Kinematic ||
           (!bodies.surfaces.empty() && !bodies.surfaces[body].velocity.isZero(0));
  };
  const auto acts = [&](const JointLink& link) {
    const Joint& joint = input.joints[link.joint];
    return std::any_of(joint.law.begin(), joint.law.begin() + joint.rows, std::mem_fn(&Law::acts_as_force));
  };
  return input.added_slips == nullptr &&
         std::all_of(ids.begin(), ids.end(), [&](std::uint32_t body) { return bodies.torque(body).isZero(0); }) &&
         std::none_of(contacts.begin(), contacts.end(),
                      [&](const TouchingPair& pair) { return is_led(pair.first) || is_led(pair.second); }) &&
         std::none_of(links.begin(), links.end(),
                      [&](const JointLink& link) { return acts(link) || is_led(link.first) || is_led(link.second); });
}

// Whether something that doesn't move takes an island's momentum, or locks do.
bool touches_fixed(const SolveInput& input, std::size_t island) {
  const auto is_fixed = [&](const auto& pair) {
    const auto& mobility = input.bodies.mobility;
    return mobility[pair.first] != Mobility::Dynamic || mobility[pair.second] != Mobility::Dynamic;
  };
  const auto contacts = input.islands.contacts(island, island + 1);
  const auto links = input.islands.joints(island, island + 1);
  const auto ids = input.islands.bodies(island, island + 1);
  return std::any_of(contacts.begin(), contacts.end(), is_fixed) || std::any_of(links.begin(), links.end(), is_fixed) ||
         std::any_of(ids.begin(), ids.end(), [&](std::uint32_t body) { return input.bodies.locks[body] != 0; });
}

// Slows bodies down by so many J, or as many as they have; by their spins and their speeds against each other alone if
// they are to keep their momentum.
void take(BodyTable& bodies, std::span<const std::uint32_t> from, bool with_momentum, double energy) {
  Vector3 kept = Vector3::Zero();
  double mass = 0, theirs = 0;
  for (const std::uint32_t body : from) {
    theirs += kinetic_energy(bodies, body);
    mass += 1 / bodies.inverse_mass[body];
    kept += bodies.velocity(body) / bodies.inverse_mass[body];
  }
  kept *= with_momentum ? 0 : 1 / mass;
  theirs -= 0.5 * mass * kept.squaredNorm();
  const double scale = energy < theirs ? std::sqrt(1 - energy / theirs) : 0;
  for (const std::uint32_t body : from) {
    bodies.velocity(body) = kept + scale * (bodies.velocity(body) - kept);
    bodies.angular_velocity(body) *= scale;
  }
}

}  // namespace

void PassiveEnergy::begin(const SolveInput& input, const IslandGroup& group) {
  islands_.clear();
  watched_.clear();
  for (std::size_t island = group.begin; island < group.end; ++island) {
    const std::size_t first = watched_.size();
    const bool joined = input.islands.joint_count(island) > 0;
    if (joined && input.islands.contacts(island, island + 1).empty()) continue;
    double kinetic = 0;
    for (const std::uint32_t body : input.islands.bodies(island, island + 1)) {
      if (!joined && !turns_blindly(input.bodies, body, input.dt)) continue;
      watched_.push_back(body);
      kinetic += kinetic_energy(input.bodies, body);
    }
    if (watched_.size() == first) continue;
    if (is_passive(input, island)) {
      const double more = joined ? tuning::energy_tolerance * kinetic : 0;
      islands_.push_back({island, energy_of(input, island) + more, first, watched_.size()});
    } else {
      watched_.resize(first);
    }
  }
}

void PassiveEnergy::bound(const SolveInput& input) const {
  for (const Island& of : islands_) {
    const double gained = energy_of(input, of.island) - of.most;
    const auto watched = std::span(watched_).subspan(of.first, of.end - of.first);
    if (gained > 0) take(input.bodies, watched, touches_fixed(input, of.island), gained);
  }
}

}  // namespace atl::solver
