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
  if (pair != nullptr && pair->friction) return *pair->friction;
  return combined(a.friction, b.friction, std::max(a.friction_rule, b.friction_rule));
}

double restitution_of(const Stores& world, const Material& a, const Material& b) {
  const MaterialPair* pair = find_pair(world, a, b);
  if (pair != nullptr && pair->restitution) return *pair->restitution;
  const CombineRule rule = std::max(a.restitution_rule, b.restitution_rule);
  return combined(a.restitution, b.restitution, rule == CombineRule::Default ? CombineRule::Max : rule);
}

}  // namespace atl
