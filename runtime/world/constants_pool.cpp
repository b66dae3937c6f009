#include "world/constants_pool.h"

#include <collision/shapes/collider_table.h>

#include <algorithm>
#include <optional>

#include "state/world_definition.h"

namespace atl {
namespace {

using jobs::same_bits;

bool are_alike(const std::optional<Material>& a, const std::optional<Material>& b) {
  return a.has_value() == b.has_value() && (!a || same_bits(*a, *b));
}

bool are_alike(const CheckedCollider& a, const CheckedCollider& b) {
  return same_bits(a.shape, b.shape) && same_bits(a.local, b.local) && a.geometry == b.geometry &&
         a.content == b.content && same_bits(a.density_factor, b.density_factor) && are_alike(a.material, b.material) &&
         a.filter == b.filter;
}

// Field by field, as in visit_constants(): far faster than two fingerprints. Cheap and likely differences come first.
bool are_alike(const BodyConstants& a, const BodyConstants& b) {
  const auto alike = [](const CheckedCollider& x, const CheckedCollider& y) { return are_alike(x, y); };
  return a.type == b.type &&
         std::equal(a.colliders.begin(), a.colliders.end(), b.colliders.begin(), b.colliders.end(), alike) &&
         a.continuous == b.continuous && a.sensor == b.sensor && a.notices_static == b.notices_static &&
         a.notices_sensors == b.notices_sensors && a.contact_event_force == b.contact_event_force &&
         same_bits(a.material, b.material) && a.materials == b.materials && a.locks == b.locks &&
         a.may_sleep == b.may_sleep && a.max_speed == b.max_speed && a.max_angular_speed == b.max_angular_speed &&
         same_bits(a.gravity_scale, b.gravity_scale) && same_bits(a.linear_damping, b.linear_damping) &&
         same_bits(a.angular_damping, b.angular_damping) && same_bits(a.centre, b.centre) &&
         same_bits(a.inverse_mass, b.inverse_mass) && same_bits(a.inertia, b.inertia) &&
         same_bits(a.inverse_inertia, b.inverse_inertia) && a.gyroscopic == b.gyroscopic &&
         same_bits(a.principal_axes, b.principal_axes) && same_bits(a.moments, b.moments);
}

}  // namespace

std::shared_ptr<const BodyConstants> ConstantsPool::share(const BodyConstants& constants) {
  std::shared_ptr<const BodyConstants> last = last_.lock();
  if (last && are_alike(*last, constants)) return last;
  if (known_.size() >= max_) {
    std::erase_if(known_, [](const auto& entry) { return entry.second.expired(); });
    max_ = std::max<std::size_t>(64, 2 * known_.size());
  }
  std::weak_ptr<const BodyConstants>& place = known_[fingerprint(constants)];
  std::shared_ptr<const BodyConstants> shared = place.lock();
  if (!shared) {
    shared = std::make_shared<const BodyConstants>(constants);
    place = shared;
  }
  last_ = shared;
  return shared;
}

}  // namespace atl
