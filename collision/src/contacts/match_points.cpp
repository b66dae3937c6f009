#include <collision/contacts/match_points.h>
#include <jobs/assert.h>

namespace atl::collision {

OldPoints OldPoints::of(const Contact& contact, const ContactManifold& manifold) {
  OldPoints old;
  ATL_ASSERT(contact.count <= max_points, contact.pair.first, contact.pair.second, contact.count);
  old.count = contact.count;
  old.ids = contact.ids;
  old.reference_is_second = contact.reference_is_second;
  const Vector3 centre(contact.centre_reference[0], contact.centre_reference[1], contact.centre_reference[2]);
  for (std::size_t i = 0; i < contact.count; ++i) {
    const std::array<float, 4>& point = contact.points[i];
    old.impulses[i] = manifold.normal_impulse[i];
    old.positions[i] = centre + Vector3(point[0], point[1], point[2]);
  }
  return old;
}

PointMatches match_points(const OldPoints& old, const Manifold& recomputed, double reach, ContactManifold& manifold) {
  PointMatches matches;
  ATL_ASSERT(old.count >= 0 && old.count <= max_points, old.count);
  ATL_ASSERT(recomputed.count >= 0 && recomputed.count <= max_points, recomputed.count);
  ATL_ASSERT(!(reach < 0), reach);
  std::array<bool, max_points> taken = {};
  std::array<bool, max_points> matched = {};
  const auto count = static_cast<std::size_t>(recomputed.count);
  const auto old_count = static_cast<std::size_t>(old.count);
  for (std::size_t i = 0; i < max_points; ++i) manifold.normal_impulse[i] = 0;
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = 0; j < old_count; ++j) {
      if (taken[j] || old.ids[j] != recomputed.points[i].id) continue;
      manifold.normal_impulse[i] = old.impulses[j];
      taken[j] = matched[i] = true;
      ++matches.by_id;
      break;
    }
  }
  if (old_count == 0) return matches;
  for (std::size_t i = 0; i < count; ++i) {
    if (matched[i]) continue;
    ++matches.missed;
    if (old.reference_is_second != recomputed.reference_is_second) continue;
    double nearest = reach * reach;
    std::size_t best = max_points;
    for (std::size_t j = 0; j < old_count; ++j) {
      const double distance = (old.positions[j] - recomputed.points[i].position).squaredNorm();
      if (taken[j] || !(distance < nearest)) continue;
      nearest = distance;
      best = j;
    }
    if (best == max_points) continue;
    manifold.normal_impulse[i] = old.impulses[best];
    taken[best] = true;
  }
  return matches;
}

}  // namespace atl::collision
