#include <solver/constraints/contact_inertia.h>
#include <solver/integrate/motion.h>
#include <solver/integrate/motion_locks.h>
#include <solver/sweep/spin_energy.h>
#include <solver/tuning.h>

#include <algorithm>
#include <functional>
#include <span>

namespace atl::solver {
namespace {

// Contacts see a body with other moments than it has, or turn it out of what they see.
bool turns_blindly(const BodyTable& bodies, std::uint32_t body, double dt) {
  if (!bodies.gyroscopic[body]) return false;
  if (dt * bodies.angular_velocity(body).norm() > tuning::blind_turn) return true;
  if (!is_seen_heavier(bodies, body)) return false;
  const double swing = swing_in_contact(bodies, body, bodies.velocity(body).norm(), dt);
  return swing * swing * bodies.moments[body].maxCoeff() > bodies.moments[body].minCoeff();
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

}  // namespace

void SpinEnergy::begin(const SolveInput& input, const IslandGroup& group) {
  islands_.clear();
  blind_.clear();
  for (std::size_t island = group.begin; island < group.end; ++island) {
    const std::size_t first = blind_.size();
    for (const std::uint32_t body : input.islands.bodies(island, island + 1)) {
      if (turns_blindly(input.bodies, body, input.dt)) blind_.push_back(body);
    }
    if (blind_.size() == first) continue;
    if (is_passive(input, island)) {
      islands_.push_back({island, energy_of(input, island), first, blind_.size()});
    } else {
      blind_.resize(first);
    }
  }
}

void SpinEnergy::bound(const SolveInput& input) const {
  BodyTable& bodies = input.bodies;
  for (const Watched& watched : islands_) {
    const double gained = energy_of(input, watched.island) - watched.energy;
    if (gained <= 0) continue;
    const auto blind = std::span(blind_).subspan(watched.first, watched.end - watched.first);
    double theirs = 0;
    for (const std::uint32_t body : blind) theirs += kinetic_energy(bodies, body);
    const double share = theirs > 0 ? std::min(gained / theirs, 1.0) : 0;
    for (const std::uint32_t body : blind) slow_down(bodies, body, share * kinetic_energy(bodies, body));
  }
}

}  // namespace atl::solver
