#include <collision/contacts/refresh.h>
#include <solver/constraints/stored_energy.h>
#include <solver/integrate/motion.h>
#include <solver/integrate/motion_locks.h>
#include <solver/sweep/passive_energy.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>
#include <span>

namespace atl::solver {
namespace {

// True if contacts may not know a body's inertia for all of a step: as it turns, or as it does once what it has, and
// falls by in the step, is struck. A spin that they make about the light axis, where that was, is one about the heavy
// axes once it has swung by an angle, by so much: its energy grows by their moment over the least times the square of
// the angle.
bool turns_blindly(const SolveInput& input, std::uint32_t body) {
  const BodyTable& bodies = input.bodies;
  const double dt = input.dt;
  if (!bodies.gyroscopic[body]) return false;
  const double most = bodies.moments[body].maxCoeff(), least = bodies.moments[body].minCoeff();
  const double spin = bodies.angular_velocity(body).norm();
  const double fall = dt * linear_acceleration(bodies, body, input.gravity).norm();
  const double struck = (bodies.velocity(body).norm() + fall) / std::sqrt(most * bodies.inverse_mass[body]);
  return dt * (spin + struck) * std::sqrt(most / least) > tuning::blind_turn;
}

// m: the inner radius of the smallest body. To go through contacts, which are all over memory, costs 8% of a step.
double least_size(const SolveInput& input, const IslandGroup& group) {
  double least = std::numeric_limits<double>::infinity();
  for (const std::uint32_t body : input.islands.bodies(group.begin, group.end)) {
    least = std::min(least, input.bounds.margin_limit[body]);
  }
  return least / collision::approach_share;
}

// What Baumgarte's pushes give is what was asked for.
bool is_deep(const SolveInput& input, std::size_t island) {
  const auto contacts = input.islands.contacts(island, island + 1);
  return input.settings.stabilisation != Stabilisation::Baumgarte &&
         std::any_of(contacts.begin(), contacts.end(), [&](const TouchingPair& pair) {
           const float* const separation = input.manifolds[pair.slot].separation;
           const collision::Contact& contact = input.contacts[pair.slot];
           const float deepest = *std::min_element(separation, separation + contact.count);
           return deepest < -tuning::deep_overlap * contact.size;
         });
}

StoredEnergy stored_in(const SolveInput& input, std::size_t island) {
  StoredEnergy sum;
  for (const JointLink& link : input.islands.joints(island, island + 1)) {
    const StoredEnergy stored = StoredEnergy::of(link.joint, input.joints, input.bodies);
    sum.potential += stored.potential;
    sum.rotors += stored.rotors;
  }
  return sum;
}

// J: in the forces on a body, which are the same for all of a step.
double height_of(const SolveInput& input, std::uint32_t body) {
  const Vector3 force = linear_acceleration(input.bodies, body, input.gravity) / input.bodies.inverse_mass[body];
  return -force.dot(input.bodies.position(body));
}

double height_of(const SolveInput& input, std::span<const std::uint32_t> bodies) {
  double sum = 0;
  for (const std::uint32_t body : bodies) sum += height_of(input, body);
  return sum;
}

// J: of motion, in springs, rotors and heights.
double energy_of(const SolveInput& input, std::size_t island, const StoredEnergy& stored) {
  double sum = stored.potential + stored.rotors;
  for (const std::uint32_t body : input.islands.bodies(island, island + 1)) {
    sum += kinetic_energy(input.bodies, body) + height_of(input, body);
  }
  return sum;
}

// J: what motion and springs have given each other, by what each has gained.
double exchanged(double moving, double springs) {
  return moving * springs < 0 ? std::min(std::abs(moving), std::abs(springs)) : 0;
}

// An island is passive if nothing in it gives energy that it hasn't: no torque, belt or motor, and no body that is led.
bool is_passive(const SolveInput& input, std::size_t island) {
  const BodyTable& bodies = input.bodies;
  const auto ids = input.islands.bodies(island, island + 1);
  const auto contacts = input.islands.contacts(island, island + 1);
  const auto links = input.islands.joints(island, island + 1);
  const auto is_led = [&](std::uint32_t body) {
    return bodies.mobility[body] == Mobility::Kinematic ||
           (!bodies.surfaces.empty() && !bodies.surfaces[body].velocity.isZero(0));
  };
  const auto is_led_pair = [&](const auto& pair) { return is_led(pair.first) || is_led(pair.second); };
  return input.added_slips == nullptr &&
         std::all_of(ids.begin(), ids.end(), [&](std::uint32_t body) { return bodies.torque(body).isZero(0); }) &&
         std::none_of(contacts.begin(), contacts.end(), is_led_pair) &&
         std::none_of(links.begin(), links.end(), [&](const JointLink& link) {
           return is_led_pair(link) || !only_stores(input.joints[link.joint]);
         });
}

// An island is alone if nothing takes its momentum: neither what doesn't respond, nor locks.
bool is_alone(const SolveInput& input, std::size_t island) {
  const auto is_fixed = [&](const auto& pair) {
    const auto& mobility = input.bodies.mobility;
    return mobility[pair.first] != Mobility::Dynamic || mobility[pair.second] != Mobility::Dynamic;
  };
  const auto contacts = input.islands.contacts(island, island + 1);
  const auto links = input.islands.joints(island, island + 1);
  const auto ids = input.islands.bodies(island, island + 1);
  return std::none_of(contacts.begin(), contacts.end(), is_fixed) &&
         std::none_of(links.begin(), links.end(), is_fixed) &&
         std::all_of(ids.begin(), ids.end(), [&](std::uint32_t body) { return input.bodies.locks[body] == 0; });
}

}  // namespace

void PassiveEnergy::begin(const SolveInput& input, const IslandGroup& group, float deepest) {
  islands_.clear();
  watched_.clear();
  const bool any_deep = deepest < -tuning::deep_overlap * least_size(input, group);
  for (std::size_t island = group.begin; island < group.end; ++island) {
    const std::size_t first = watched_.size();
    const bool joined = input.islands.joint_count(island) > 0;
    if (joined && input.islands.contacts(island, island + 1).empty()) continue;
    const auto bodies = input.islands.bodies(island, island + 1);
    for (const std::uint32_t body : bodies) {
      if (joined || turns_blindly(input, body)) watched_.push_back(body);
    }
    const bool overlaps = any_deep && watched_.size() == first && is_deep(input, island);
    if (overlaps) watched_.insert(watched_.end(), bodies.begin(), bodies.end());
    if (watched_.size() == first) continue;
    if (is_passive(input, island)) {
      const StoredEnergy stored = stored_in(input, island);
      const double moving = kinetic_energy(input.bodies, std::span(watched_).subspan(first)) + stored.rotors;
      const double more = joined ? tuning::energy_tolerance * moving : 0;
      const double most = energy_of(input, island, stored) + more;
      islands_.push_back({.island = island,
                          .overlaps = overlaps,
                          .most = most,
                          .height = overlaps ? height_of(input, bodies) : 0,
                          .moving = moving,
                          .springs = stored.potential,
                          .first = first,
                          .end = watched_.size()});
    } else {
      watched_.resize(first);
    }
  }
}

void PassiveEnergy::bound(const SolveInput& input) const {
  for (const Island& of : islands_) {
    const StoredEnergy stored = stored_in(input, of.island);
    const auto watched = std::span(watched_).subspan(of.first, of.end - of.first);
    const double moving = kinetic_energy(input.bodies, watched) + stored.rotors;
    const double passed_on = exchanged(moving - of.moving, stored.potential - of.springs);
    // Who is pushed out of an overlap is lifted for nothing.
    const double lifted =
        of.overlaps ? std::max(0.0, height_of(input, input.islands.bodies(of.island, of.island + 1)) - of.height) : 0;
    const double gained =
        energy_of(input, of.island, stored) - of.most - tuning::exchange_tolerance * passed_on - lifted;
    if (!(gained > 0)) continue;
    const Momentum momentum = is_alone(input, of.island) ? Momentum::Keep : Momentum::Take;
    slow_down(input.bodies, watched, momentum, gained, stored.rotors);
  }
}

}  // namespace atl::solver
