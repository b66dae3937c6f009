#include "world/materials.h"

#include <features/with_restitution.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "world/bodies.h"
#include "world/colliders.h"
#include "world/left_out.h"
#include "world/refuse.h"

namespace atl {
namespace {

// The least part of a contact's friction: less is none in the single precision of sweeps.
constexpr double min_part = 1e-6;

double combined(double a, double b, CombineRule rule) {
  switch (rule) {
    case CombineRule::Average:
      return 0.5 * (a + b);
    case CombineRule::Min:
      return std::min(a, b);
    case CombineRule::Multiply:
      return a * b;
    case CombineRule::Max:
      return std::max(a, b);
    case CombineRule::Default:
    case CombineRule::GeometricMean:
      break;
  }
  return std::sqrt(a * b);
}

bool precedes(const MaterialPair& x, const MaterialPair& y) {
  return std::pair(x.first, x.second) < std::pair(y.first, y.second);
}

MaterialPair in_order(MaterialPair pair) {
  if (pair.second < pair.first) std::swap(pair.first, pair.second);
  return pair;
}

// Contacts take over what has changed between their materials. `changed` is told of their slots.
template <typename Changed>
void update_contacts(Stores& world, const Changed& changed) {
  for (const std::uint32_t slot : world.cache.all_in_order()) {
    const collision::ContactManifold& manifold = world.cache.manifolds[slot];
    const float friction = manifold.friction, restitution = manifold.restitution;
    mix_materials(world, slot);
    if (manifold.friction != friction || manifold.restitution != restitution) changed(slot);
  }
}

}  // namespace

void check(const MaterialPair& pair) {
  for (const std::uint64_t id : {pair.first, pair.second}) {
    if (id == 0) throw Error("MaterialPair: found a material of id 0; expected two with a Material::id above 0");
  }
  if (pair.friction) check_not_negative("MaterialPair.friction", *pair.friction);
  if (pair.friction_across) check_not_negative("MaterialPair.friction_across", *pair.friction_across);
  if (pair.friction_across && !pair.friction) {
    throw Error("MaterialPair.friction_across is given without friction; expected both");
  }
  const double restitution = pair.restitution.value_or(0);
  if (!(restitution >= 0 && restitution <= 1)) {
    refuse("MaterialPair.restitution", restitution, "a number in [0, 1]");
  }
  if (!with_restitution && restitution > 0) {
    throw_left_out("MaterialPair.restitution is above 0", "bounces", "RESTITUTION");
  }
}

void set_material_pair(Stores& world, const MaterialPair& pair) {
  std::vector<MaterialPair>& pairs = world.material_pairs;
  const MaterialPair ordered = in_order(pair);
  const auto place = std::lower_bound(pairs.begin(), pairs.end(), ordered, precedes);
  const bool known = place != pairs.end() && !precedes(ordered, *place);
  if (!ordered.friction && !ordered.restitution) {
    if (known) pairs.erase(place);
  } else if (known) {
    *place = ordered;
  } else {
    pairs.insert(place, ordered);
  }
  update_contacts(world, [&](std::uint32_t slot) {
    const collision::Contact& contact = world.cache.contacts[slot];
    if (contact.count == 0) return;
    world.sleeping.wake(contact.body_first);
    world.sleeping.wake(contact.body_second);
    world.changes.islands = true;
  });
}

void restore_material_pairs(Stores& world, std::vector<MaterialPair> pairs) {
  if (pairs == world.material_pairs) return;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    check(pairs[i]);
    const bool ordered = pairs[i].first <= pairs[i].second && (i == 0 || precedes(pairs[i - 1], pairs[i]));
    if (!ordered) throw Error("World: found pairs of materials out of order; expected them in that of their ids");
  }
  world.material_pairs = std::move(pairs);
  update_contacts(world, [&](std::uint32_t) { world.changes.islands = true; });
}

const MaterialPair* find_pair(const Stores& world, const Material& a, const Material& b) {
  if (world.material_pairs.empty() || a.id == 0 || b.id == 0) return nullptr;
  const MaterialPair asked = in_order({.first = a.id, .second = b.id});
  const auto place = std::lower_bound(world.material_pairs.begin(), world.material_pairs.end(), asked, precedes);
  return place == world.material_pairs.end() || precedes(asked, *place) ? nullptr : &*place;
}

double friction_of(const Stores& world, const Material& a, const Material& b) {
  const MaterialPair* pair = find_pair(world, a, b);
  if (pair == nullptr || !pair->friction) {
    return combined(max_friction(a), max_friction(b), std::max(a.friction_rule, b.friction_rule));
  }
  const bool is_directed = a.is_directed() || b.is_directed();
  return std::max(*pair->friction, is_directed ? pair->friction_across.value_or(0) : 0);
}

namespace {

// A material's friction in the world frame, half way through the step. In all directions it is the ellipsoid that has
// `along` as the half axis in its direction, and `across` as the two others.
struct DirectedFriction {
  Vector3 direction = Vector3::Zero();  // unit, or zero
  double along = 0, across = 0;

  // The half width, along the unit vector t, of its shadow on a plane that holds t.
  double in(const Vector3& t) const {
    const double cosine = direction.dot(t), part = std::min(cosine * cosine, 1.0);
    return std::sqrt(along * along * part + across * across * (1 - part));
  }
  double unevenness() const { return std::abs(along - across) / std::max({along, across, 1e-300}); }
};

DirectedFriction directed(const Stores& world, std::uint32_t body, const Material& material) {
  if (!material.is_directed()) return {.along = material.friction, .across = material.friction};
  const solver::BodyTable& bodies = world.bodies;
  const Vector3 now = bodies.orientation(body) * Vector3(material.friction_direction.data()).stableNormalized();
  const Vector3 then = now + 0.5 * world.clock.dt * bodies.angular_velocity(body).cross(now);
  return {then.normalized(), material.friction, material.friction_across};
}

}  // namespace

void record_grip(const Stores& world, const collision::Contact& contact, const Material& first, const Material& second,
                 const collision::ContactManifold& manifold, solver::SurfaceContact& surface) {
  std::fill_n(surface.grip, 3, 0.0f);
  surface.twist = surface.ratio = 1;
  if (!first.is_directed() && !second.is_directed()) return;
  DirectedFriction a = directed(world, contact.body_first, first), b = directed(world, contact.body_second, second);
  const double max = friction_of(world, first, second);
  if (!(max > 0)) return;
  const bool by_second = a.direction.isZero(0) || (!b.direction.isZero(0) && b.unevenness() > a.unevenness());
  const Vector3 direction = by_second ? b.direction : a.direction;
  const collision::Tangents frame = collision::tangents(manifold.normal);
  const auto vector = [](const auto& v) { return Vector3(v[0], v[1], v[2]); };
  const Vector3 normal = vector(manifold.normal), in_plane = direction - normal.dot(direction) * normal;
  const Vector3 along = in_plane.norm() > 1e-9 ? in_plane.normalized() : vector(frame.first);
  const Vector3 across = normal.cross(along);
  const MaterialPair* pair = find_pair(world, first, second);
  if (pair != nullptr && pair->friction) {
    a = b = {direction, *pair->friction, pair->friction_across.value_or(*pair->friction)};
  }
  const CombineRule rule = std::max(first.friction_rule, second.friction_rule);
  const auto part = [&](const Vector3& t) {
    return (pair != nullptr && pair->friction ? a.in(t) : combined(a.in(t), b.in(t), rule)) / max;
  };
  const double parts[2] = {part(along), part(across)};
  const bool crosswise = parts[1] > parts[0];
  const double greater = std::max(parts[crosswise], min_part);
  const Vector3 grip = greater * (crosswise ? across : along);
  for (int i = 0; i < 3; ++i) surface.grip[i] = static_cast<float>(grip[i]);
  surface.ratio = static_cast<float>(std::max(parts[!crosswise] / greater, min_part));
  // A point that turns about the centre slips across its arm.
  double turning = 0, arms = 0;
  for (int i = 0; i < contact.count; ++i) {
    if (manifold.separation[i] >= collision::no_point) continue;
    const Vector3 arm = manifold.x[i] * vector(frame.first) + manifold.y[i] * vector(frame.second);
    turning += Eigen::Vector2d(parts[0] * arm.dot(across), parts[1] * arm.dot(along)).norm();
    arms += arm.norm();
  }
  surface.twist = arms > 0 ? static_cast<float>(turning / arms) : 1;
}

double restitution_of(const Stores& world, const Material& a, const Material& b) {
  const MaterialPair* pair = find_pair(world, a, b);
  if (pair != nullptr && pair->restitution) return *pair->restitution;
  const CombineRule rule = std::max(a.restitution_rule, b.restitution_rule);
  return combined(a.restitution, b.restitution, rule == CombineRule::Default ? CombineRule::Max : rule);
}

}  // namespace atl
