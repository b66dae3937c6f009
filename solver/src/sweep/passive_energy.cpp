#include <collision/contacts/refresh.h>
#include <jobs/assert.h>
#include <solver/constraints/stored_energy.h>
#include <solver/direct/joint_systems.h>
#include <solver/integrate/motion.h>
#include <solver/integrate/motion_locks.h>
#include <solver/sweep/passive_energy.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "integrate/rows3.h"

namespace atl::solver {
namespace {

using BodyStart = PassiveEnergy::BodyStart;

// True if contacts may not know a body's inertia for all of a step: as it turns, or as it does once what it has, and
// falls by in the step, is struck. A spin that they make about the light axis, where that was, is one about the heavy
// axes once it has swung by an angle, by so much: its energy grows by their moment over the least times the square of
// the angle.
bool turns_blindly(const SolveInput& input, std::uint32_t body) {
  const BodyTable& bodies = input.bodies;
  const double dt = input.dt;
  if (!bodies.gyroscopic[body]) return false;
  const double max = bodies.moments[body].maxCoeff(), min = bodies.moments[body].minCoeff();
  ATL_ASSERT(min > 0 && min <= max, body, min, max);
  const double spin = bodies.angular_velocity(body).norm();
  const double fall = dt * linear_acceleration(bodies, body, input.gravity).norm();
  const double struck = (bodies.velocity(body).norm() + fall) / std::sqrt(max * bodies.inverse_mass[body]);
  return dt * (spin + struck) * std::sqrt(max / min) > tuning::blind_turn;
}

// m: the inner radius of the smallest body. To go through contacts, which are all over memory, costs 8% of a step.
double min_size(const SolveInput& input, const IslandGroup& group) {
  double min = std::numeric_limits<double>::infinity();
  for (const std::uint32_t body : input.islands.bodies(group.begin, group.end)) {
    min = std::min(min, input.bounds.margin_limit[body]);
  }
  return min / collision::approach_share;
}

// What Baumgarte's pushes give is what was asked for.
bool is_deep(const SolveInput& input, std::size_t island) {
  const auto contacts = input.islands.contacts(island, island + 1);
  return input.settings.stabilisation != Stabilisation::Baumgarte &&
         std::any_of(contacts.begin(), contacts.end(), [&](const TouchingPair& pair) {
           const float* const separation = input.manifolds[pair.slot].separation;
           const collision::Contact& contact = input.contacts[pair.slot];
           ATL_ASSERT(contact.count >= 1 && contact.count <= collision::max_points, pair.slot, contact.count);
           const float deepest = *std::min_element(separation, separation + contact.count);
           return deepest < -tuning::deep_overlap * contact.size;
         });
}

StoredEnergy stored_in(const SolveInput& input, std::size_t island) {
  StoredEnergy sum;
  for (const JointLink& link : input.islands.joints(island, island + 1)) {
    const StoredEnergy stored = StoredEnergy::of(link.joint, input.joints, input.bodies, input.substep());
    sum.potential += stored.potential;
    sum.rotors += stored.rotors;
    sum.springs |= stored.springs;
  }
  return sum;
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

// J: in the forces on bodies, which are the same for all of a step, `lag` seconds ago.
double height_of(const SolveInput& input, std::span<const std::uint32_t> bodies, double lag) {
  double sum = 0;
  for (const std::uint32_t body : bodies) {
    const Vector3 force = linear_acceleration(input.bodies, body, input.gravity) / input.bodies.inverse_mass[body];
    sum -= force.dot(input.bodies.position(body) - lag * input.bodies.velocity(body));
  }
  return sum;
}

// J: of motion, in springs, rotors and heights. Semi-implicit Euler, which moves joints that hang on something fixed,
// keeps the energy that there is with the heights of half a substep ago; so it does where springs carry weights, as
// these count likewise. An island that falls as a whole is moved at second order, and keeps that with its own heights.
double energy_of(const SolveInput& input, std::size_t island, const StoredEnergy& stored) {
  const auto bodies = input.islands.bodies(island, island + 1);
  const bool swings = input.islands.contacts(island, island + 1).empty() && !is_alone(input, island);
  const double lag = swings || stored.springs ? input.substep() / 2 : 0;
  double sum = stored.potential + stored.rotors + height_of(input, bodies, lag);
  for (const std::uint32_t body : bodies) sum += kinetic_energy(input.bodies, body);
  return sum;
}

// A body's motion in the step: m and rad.
struct Moved {
  Vector3 by, turn;

  Moved(const BodyTable& bodies, std::uint32_t body, const BodyPose& start)
      : by(bodies.position(body) - start.position) {
    const Quaternion turned = bodies.orientation(body) * start.orientation.conjugate();
    turn = (turned.w() < 0 ? -2.0 : 2.0) * turned.vec();
  }
  Vector3 at(const Vector3& arm) const { return by + turn.cross(arm); }
};

// m: how far a contact's overlap at a point has parted in the step, or 0.
double parted(const collision::ContactManifold& manifold, int point, const collision::Tangents& tangents,
              const std::optional<Moved>& first, const std::optional<Moved>& second) {
  const Vector3 arm = manifold.x[point] * get3(tangents.first) + manifold.y[point] * get3(tangents.second);
  Vector3 by = Vector3::Zero();
  if (first) by -= first->at(get3(manifold.anchor_first) + arm);
  if (second) by += second->at(get3(manifold.anchor_second) + arm);
  return std::clamp(get3(manifold.normal).dot(by), 0.0, std::max(0.0, -double{manifold.separation[point]}));
}

// J: the work of contacts that part what overlaps, by the forces with which they end the step. `starts`: of the
// island's bodies.
double work_of_parting(const SolveInput& input, std::size_t island, std::span<const BodyStart> starts) {
  const auto moved = [&](std::uint32_t body) -> std::optional<Moved> {
    if (input.bodies.mobility[body] != Mobility::Dynamic) return {};
    return Moved(input.bodies, body, starts[input.islands.rank(body) - input.islands.first_rank(island)].pose);
  };
  double sum = 0;  // J s
  for (const TouchingPair& pair : input.islands.contacts(island, island + 1)) {
    const collision::ContactManifold& manifold = input.manifolds[pair.slot];
    const collision::Tangents tangents = collision::tangents(manifold.normal);
    const std::optional<Moved> first = moved(pair.first), second = moved(pair.second);
    for (int i = 0; i < input.contacts[pair.slot].count; ++i) {
      sum += collision::kept_impulse(manifold.normal_impulse[i]) * parted(manifold, i, tangents, first, second);
    }
  }
  return sum / (input.settings.refinement * input.substep());  // for which manifolds keep impulses
}

// J: by which those bodies have risen that did, in the forces on them, but for what has been struck.
double lift(const SolveInput& input, std::span<const std::uint32_t> bodies, std::span<const BodyStart> starts) {
  const BodyTable& table = input.bodies;
  double sum = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const std::uint32_t body = bodies[i];
    const Vector3 acceleration = linear_acceleration(table, body, input.gravity);
    const Vector3 gained = table.velocity(body) - starts[i].velocity;
    const Vector3 gained_spin = table.angular_velocity(body) - starts[i].spin;
    if (!changes_steadily(gained, gained_spin, acceleration.norm(), input.dt, table.radius[body])) continue;
    const Vector3 risen = table.position(body) - starts[i].pose.position;
    sum += std::max(0.0, -acceleration.dot(risen) / table.inverse_mass[body]);
  }
  return sum;
}

// J: what motion and springs have given each other, by what each has gained.
double exchanged(double moving, double springs) {
  return moving * springs < 0 ? std::min(std::abs(moving), std::abs(springs)) : 0;
}

// Tells an island in which nothing but joints gives energy that it hasn't: no torque, belt or body that is led.
bool is_passive(const SolveInput& input, std::size_t island) {
  const BodyTable& bodies = input.bodies;
  const auto ids = input.islands.bodies(island, island + 1);
  const auto contacts = input.islands.contacts(island, island + 1);
  const auto links = input.islands.joints(island, island + 1);
  const auto is_led = [&](std::uint32_t body) {
    return bodies.mobility[body] == Mobility::Kinematic ||
           (!bodies.surfaces.empty() && !bodies.surfaces[body].motion.is_zero());
  };
  const auto is_led_pair = [&](const auto& pair) { return is_led(pair.first) || is_led(pair.second); };
  return input.added_slips == nullptr &&
         std::all_of(ids.begin(), ids.end(), [&](std::uint32_t body) { return bodies.torque(body).isZero(0); }) &&
         std::none_of(contacts.begin(), contacts.end(), is_led_pair) &&
         std::none_of(links.begin(), links.end(), is_led_pair);
}

// An island's joints, each looked at once: they are far apart in memory.
struct IslandJoints {
  double given = 0;       // J, the most that they give in the step beyond what they have stored; infinite if not known
  bool stores = false;    // some has energy of its own
  bool only_hold = true;  // none gives motion back
  bool swept = false;     // some are
};

IslandJoints look_at(const SolveInput& input, std::size_t island) {
  IslandJoints joints;
  for (const JointLink& link : input.islands.joints(island, island + 1)) {
    const Joint& joint = input.joints[link.joint];
    joints.given += max_energy_given(joint, input.dt);
    joints.stores |= stores_energy(joint);
    joints.only_hold &= !gives_back(joint);
    joints.swept |= !input.solves_directly(input.joint_graph->component_of(link.joint));
  }
  return joints;
}

}  // namespace

void PassiveEnergy::begin(const SolveInput& input, const IslandGroup& group, float deepest) {
  islands_.clear();
  watched_.clear();
  starts_.clear();
  const bool any_deep = deepest < 0 && deepest < -tuning::deep_overlap * min_size(input, group);
  for (std::size_t island = group.begin; island < group.end; ++island) {
    const std::size_t first = watched_.size();
    const bool joined = input.islands.joint_count(island) > 0;
    const IslandJoints joints = look_at(input, island);
    // For what gives motion back, energy would have to be known to the order to which springs are integrated.
    const bool watches = joints.swept && joints.only_hold;
    if (joined && input.islands.contacts(island, island + 1).empty() && !watches) continue;
    const auto bodies = input.islands.bodies(island, island + 1);
    for (const std::uint32_t body : bodies) {
      if (joined || turns_blindly(input, body)) watched_.push_back(body);
    }
    const bool overlaps = any_deep && watched_.size() == first && is_deep(input, island);
    if (overlaps) watched_.insert(watched_.end(), bodies.begin(), bodies.end());
    if (watched_.size() == first) continue;
    if (!(joints.given < std::numeric_limits<double>::infinity()) || !is_passive(input, island)) {
      watched_.resize(first);
      continue;
    }
    const StoredEnergy stored = joints.stores ? stored_in(input, island) : StoredEnergy();
    const double moving = kinetic_energy(input.bodies, std::span(watched_).subspan(first)) + stored.rotors;
    const double more = joined ? tuning::held_tolerance * moving : 0;
    islands_.push_back({.island = island,
                        .stores = joints.stores,
                        .max = energy_of(input, island, stored) + more + joints.given,
                        .moving = moving,
                        .springs = stored.potential,
                        .first = first,
                        .end = watched_.size(),
                        .starts = starts_.size()});
    if (input.islands.contact_count(island) == 0) continue;
    for (const std::uint32_t body : bodies) {
      starts_.push_back({{input.bodies.position(body), input.bodies.orientation(body)},
                         input.bodies.velocity(body),
                         input.bodies.angular_velocity(body)});
    }
  }
}

void PassiveEnergy::bound(const SolveInput& input) const {
  for (const Island& of : islands_) {
    const StoredEnergy stored = of.stores ? stored_in(input, of.island) : StoredEnergy();
    const auto watched = std::span(watched_).subspan(of.first, of.end - of.first);
    const double moving = kinetic_energy(input.bodies, watched) + stored.rotors;
    const double passed_on = exchanged(moving - of.moving, stored.potential - of.springs);
    double gained = energy_of(input, of.island, stored) - of.max - tuning::exchange_tolerance * passed_on;
    if (!(gained > 0)) continue;
    if (input.islands.contact_count(of.island) > 0) {
      const auto bodies = input.islands.bodies(of.island, of.island + 1);
      const auto starts = std::span(starts_).subspan(of.starts, bodies.size());
      gained -= std::min(work_of_parting(input, of.island, starts), lift(input, bodies, starts));
      if (!(gained > 0)) continue;
    }
    const Momentum momentum = is_alone(input, of.island) ? Momentum::Keep : Momentum::Take;
    slow_down(input.bodies, watched, momentum, gained, stored.rotors);
  }
}

}  // namespace atl::solver
