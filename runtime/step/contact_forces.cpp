#include <jobs/assert.h>
#include <jobs/prefetch.h>
#include <solver/integrate/motion_locks.h>

#include <algorithm>

#include "step/results.h"
#include "world/bodies.h"

namespace atl {

namespace {

// Contacts, by which their memory is asked for before they are looked at, as they lie anywhere.
constexpr std::size_t ahead = 16;

Vector3 vector3(const auto& v) { return {v[0], v[1], v[2]}; }

Vector3 normal_of(const Stores& world, std::uint32_t first, std::uint32_t second,
                  const collision::ContactManifold& manifold) {
  Vector3 normal = vector3(manifold.normal);
  // Two bodies that move in one plane push each other within it only.
  if (const int plane = solver::shared_plane(world.bodies, first, second); plane >= 0) {
    normal[plane] = 0;
    normal.normalize();
  }
  return normal;
}

// All contacts with points, in order. The span ends with the vector or the phase's next update.
std::span<const solver::TouchingPair> all_touching(Stores& world, const ContactPhase& phase,
                                                   const collision::NarrowphaseKernels& kernels, jobs::Arena& arena,
                                                   std::vector<solver::TouchingPair>& found) {
  if (world.clock.last_substep == 0) return {};
  if (phase.touching_is_all(world)) return phase.touching();
  place_idle_contacts(world, kernels, arena);
  const std::span<const std::uint32_t> slots = world.cache.all_in_order();
  for (std::size_t i = 0; i < slots.size(); ++i) {
    if (i + ahead < slots.size()) jobs::prefetch(world.cache.contacts[slots[i + ahead]].pair);
    const collision::Contact& contact = world.cache.contacts[slots[i]];
    if (contact.count > 0) found.push_back({contact.body_first, contact.body_second, slots[i]});
  }
  return found;
}

// Forces of a manifold's points, of which impulses are those of the last substep.
class PointForces {
 public:
  PointForces(const Stores& world, const collision::ContactManifold& manifold)
      : manifold_(manifold), per_impulse_(1 / world.clock.last_substep) {
    ATL_ASSERT(world.clock.last_substep > 0, world.clock.last_substep);
    for (const float impulse : manifold.normal_impulse) total_ += std::abs(static_cast<double>(impulse));
  }

  bool are_any() const { return total_ > 0; }
  bool has_impulse(std::size_t point) const { return manifold_.normal_impulse[point] != 0; }
  double normal(std::size_t point) const { return std::abs(manifold_.normal_impulse[point]) * per_impulse_; }
  Vector3 friction(std::size_t point) const { return vector3(manifold_.friction_impulse) * (normal(point) / total_); }

 private:
  const collision::ContactManifold& manifold_;
  double per_impulse_;  // 1/s
  double total_ = 0;    // N s
};

// Contacts are in order of their shapes' numbers, which is that of bodies' ids but for those that got other shapes.
void merge_pairs(std::vector<PairForce>& pairs) {
  const auto precedes = [](const PairForce& x, const PairForce& y) { return x.a != y.a ? x.a < y.a : x.b < y.b; };
  const auto is_out_of_order = [&](const PairForce& x, const PairForce& y) { return !precedes(x, y); };
  if (std::adjacent_find(pairs.begin(), pairs.end(), is_out_of_order) == pairs.end()) return;
  std::stable_sort(pairs.begin(), pairs.end(), precedes);
  std::size_t last = 0;
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    if (precedes(pairs[last], pairs[i])) {
      pairs[++last] = pairs[i];
      continue;
    }
    pairs[last].force += pairs[i].force;
    pairs[last].normal_force += pairs[i].normal_force;
    pairs[last].separation = std::min(pairs[last].separation, pairs[i].separation);
  }
  pairs.resize(last + 1);
}

}  // namespace

Vector3 ManifoldPlace::point(const collision::ContactManifold& manifold, std::size_t i) const {
  return centre + manifold.x[i] * tangents[0] + manifold.y[i] * tangents[1];
}

ManifoldPlace place_of(const Stores& world, const collision::Contact& contact,
                       const collision::ContactManifold& manifold) {
  const collision::Tangents frame = collision::tangents(manifold.normal);
  // Anchors are where the contact was as the step started: the bodies have moved since, by far less than their size.
  return {.centre = world.bodies.position(contact.body_first) + vector3(manifold.anchor_first),
          .tangents = {vector3(frame.first), vector3(frame.second)},
          .normal = normal_of(world, contact.body_first, contact.body_second, manifold)};
}

std::span<const ContactForce> contact_forces(Stores& world, const ContactPhase& phase,
                                             const collision::NarrowphaseKernels& kernels, jobs::Arena& arena) {
  std::vector<ContactForce>& forces = world.results.contact_forces;
  if (world.results.contact_forces_valid) return forces;
  forces.clear();
  world.results.contact_forces_valid = true;
  std::vector<solver::TouchingPair> found;
  const std::span<const solver::TouchingPair> touching = all_touching(world, phase, kernels, arena, found);
  for (std::size_t pair = 0; pair < touching.size(); ++pair) {
    if (pair + ahead < touching.size()) {
      jobs::prefetch(world.cache.contacts[touching[pair + ahead].slot]);
      jobs::prefetch(world.cache.manifolds[touching[pair + ahead].slot]);
    }
    const collision::Contact& contact = world.cache.contacts[touching[pair].slot];
    const collision::ContactManifold& manifold = world.cache.manifolds[touching[pair].slot];
    const BodyId a = id_of(world, contact.body_first), b = id_of(world, contact.body_second);
    const ManifoldPlace place = place_of(world, contact, manifold);
    const PointForces of(world, manifold);
    for (std::size_t i = 0; i < contact.count; ++i) {
      if (!of.has_impulse(i)) continue;
      forces.push_back({a, b, place.point(manifold, i), place.normal, of.normal(i), of.friction(i),
                        manifold.separation[i], contact.ids[i], world.colliders.child[contact.pair.first],
                        world.colliders.child[contact.pair.second]});
    }
  }
  return forces;
}

std::span<const PairForce> pair_forces(Stores& world, const ContactPhase& phase,
                                       const collision::NarrowphaseKernels& kernels, jobs::Arena& arena) {
  std::vector<PairForce>& pairs = world.results.pair_forces;
  pairs.clear();
  // Takes the force of the first body on the second, and stores that of the lower id on the higher.
  const auto add = [&](BodyId first, BodyId second, const Vector3& force, double normal_force, double separation) {
    const bool swapped = second < first;
    const BodyId a = swapped ? second : first, b = swapped ? first : second;
    if (pairs.empty() || pairs.back().a != a || pairs.back().b != b) {
      pairs.push_back({.a = a, .b = b, .separation = separation});
    }
    PairForce& pair = pairs.back();
    pair.force += swapped ? Vector3(-force) : force;
    pair.normal_force += normal_force;
    pair.separation = std::min(pair.separation, separation);
  };
  // They may be without those of bodies that were changed since the step.
  if (world.results.contact_forces_valid) {
    for (const ContactForce& point : world.results.contact_forces) {
      add(point.a, point.b, point.normal_force * point.normal + point.friction, point.normal_force, point.separation);
    }
    merge_pairs(pairs);
    return pairs;
  }
  std::vector<solver::TouchingPair> found;
  const std::span<const solver::TouchingPair> touching = all_touching(world, phase, kernels, arena, found);
  for (std::size_t pair = 0; pair < touching.size(); ++pair) {
    if (pair + ahead < touching.size()) jobs::prefetch(world.cache.manifolds[touching[pair + ahead].slot]);
    const collision::ContactManifold& manifold = world.cache.manifolds[touching[pair].slot];
    const PointForces of(world, manifold);
    if (!of.are_any()) continue;
    const BodyId first = id_of(world, touching[pair].first), second = id_of(world, touching[pair].second);
    const Vector3 normal = normal_of(world, touching[pair].first, touching[pair].second, manifold);
    for (std::size_t i = 0; i < collision::max_points; ++i) {
      if (!of.has_impulse(i)) continue;
      add(first, second, of.normal(i) * normal + of.friction(i), of.normal(i), manifold.separation[i]);
    }
  }
  merge_pairs(pairs);
  return pairs;
}

namespace {

// The wrench that a contact exerts on one of its bodies.
Wrench wrench_of(const Stores& world, std::uint32_t slot, bool second) {
  const collision::Contact& contact = world.cache.contacts[slot];
  const collision::ContactManifold& manifold = world.cache.manifolds[slot];
  const PointForces of(world, manifold);
  if (!of.are_any()) return {};
  const ManifoldPlace place = place_of(world, contact, manifold);
  const double per_impulse = 1 / world.clock.last_substep;
  // From the body's own centre of mass as the step began: between the bodies it has changed since.
  const Vector3 arm = vector3(second ? manifold.anchor_second : manifold.anchor_first);
  Wrench wrench{.force = per_impulse * vector3(manifold.friction_impulse),
                .torque = per_impulse * manifold.torsional_impulse * place.normal};
  wrench.torque += arm.cross(wrench.force);
  for (std::size_t i = 0; i < contact.count; ++i) {
    if (!of.has_impulse(i)) continue;
    const Vector3 force = of.normal(i) * place.normal;
    wrench.force += force;
    wrench.torque += (arm + place.point(manifold, i) - place.centre).cross(force);
  }
  if (slot < world.surface_contacts.size() && world.surface_contacts[slot].rolling_friction > 0) {
    wrench.torque += per_impulse * vector3(world.surface_contacts[slot].rolling_impulse);
  }
  if (!second) wrench = {-wrench.force, -wrench.torque};
  return wrench;
}

}  // namespace

Wrench contact_wrench(Stores& world, std::uint32_t body, const ContactPhase& phase,
                      const collision::NarrowphaseKernels& kernels, jobs::Arena& arena) {
  if (world.clock.last_substep == 0) return {};
  if (!phase.touching_is_all(world)) place_idle_contacts(world, kernels, arena);
  // In an order that doesn't follow from when contacts came.
  std::vector<std::uint32_t> slots;
  world.cache.for_each_contact_of(body, [&](std::uint32_t slot) { slots.push_back(slot); });
  std::sort(slots.begin(), slots.end(), [&](std::uint32_t x, std::uint32_t y) {
    const collision::Contact &a = world.cache.contacts[x], &b = world.cache.contacts[y];
    return std::pair(a.pair, a.part) < std::pair(b.pair, b.part);
  });
  Wrench sum;
  for (const std::uint32_t slot : slots) {
    const Wrench one = wrench_of(world, slot, world.cache.contacts[slot].body_second == body);
    sum.force += one.force;
    sum.torque += one.torque;
  }
  return sum;
}

Eigen::Matrix<double, 6, Eigen::Dynamic> contact_wrenches(Stores& world, const ContactPhase& phase,
                                                          const collision::NarrowphaseKernels& kernels,
                                                          jobs::Arena& arena) {
  Eigen::Matrix<double, 6, Eigen::Dynamic> sums(6, static_cast<Eigen::Index>(world.bodies.size()));
  sums.setZero();
  std::vector<solver::TouchingPair> found;
  for (const solver::TouchingPair& pair : all_touching(world, phase, kernels, arena, found)) {
    for (const bool second : {false, true}) {
      const Wrench one = wrench_of(world, pair.slot, second);
      sums.col(second ? pair.second : pair.first) +=
          (Eigen::Matrix<double, 6, 1>() << one.force, one.torque).finished();
    }
  }
  return sums;
}

}  // namespace atl
