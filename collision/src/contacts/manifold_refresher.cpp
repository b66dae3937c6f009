#include "contacts/manifold_refresher.h"

#include <jobs/prefetch.h>

namespace atl::collision {
namespace {

alignas(16) constexpr std::array<float, 4> no_offset = {};

}  // namespace

void OffsetShapeLane::set(std::uint32_t collider, const ContactUpdateInput& input) {
  const Pose pose = input.colliders.pose(collider, input.poses);
  const Vector3 from_body = pose.position - input.poses[input.colliders.body[collider]].position;
  Eigen::Map<Vector3>(position.data()) = pose.position;
  Eigen::Map<Eigen::Vector4d>(orientation.data()) = pose.orientation.coeffs();
  Eigen::Map<Eigen::Vector3f>(offset.data()) = from_body.cast<float>();
}

void ManifoldRefresher::fetch(std::uint32_t slot) const {
  jobs::prefetch(cache_.contacts[slot], jobs::cache_line);
  jobs::prefetch(cache_.manifolds[slot]);
}

void ManifoldRefresher::refresh_all(std::span<const std::uint32_t> slots) {
  for (std::size_t begin = 0; begin < slots.size(); begin += block_lanes) {
    const std::span<const std::uint32_t> after = slots.subspan(std::min(begin + block_lanes, slots.size()));
    for (const std::uint32_t slot : after.first(std::min(block_lanes, after.size()))) {
      jobs::prefetch(cache_.contacts[slot]);
      jobs::prefetch(cache_.manifolds[slot]);
    }
    const std::size_t count = std::min(block_lanes, slots.size() - begin);
    refresh(
        count, [&](std::size_t lane) { return slots[begin + lane]; }, true);
  }
}

void ManifoldRefresher::fill_lane(const Contact& contact, ContactManifold& manifold, std::size_t lane) {
  block_.contact[lane] = &contact;
  block_.manifold[lane] = &manifold;
  block_.reach_first[lane] = &input_.reaches[contact.body_first];
  block_.reach_second[lane] = &input_.reaches[contact.body_second];

  const bool swapped = contact.reference_is_second;
  const std::size_t reference = swapped ? contact.body_second : contact.body_first;
  const std::size_t incident = swapped ? contact.body_first : contact.body_second;
  block_.position_reference[lane] = input_.poses.positions + 3 * reference;
  block_.orientation_reference[lane] = input_.poses.orientations + 4 * reference;
  block_.position_incident[lane] = input_.poses.positions + 3 * incident;
  block_.orientation_incident[lane] = input_.poses.orientations + 4 * incident;
  block_.offset_reference[lane] = block_.offset_incident[lane] = no_offset.data();
  if (!contact.has_local_offset) return;

  OffsetShapeLane& at_reference = reference_[lane];
  OffsetShapeLane& at_incident = incident_[lane];
  at_reference.set(swapped ? contact.pair.second : contact.pair.first, input_);
  at_incident.set(swapped ? contact.pair.first : contact.pair.second, input_);
  block_.position_reference[lane] = at_reference.position.data();
  block_.orientation_reference[lane] = at_reference.orientation.data();
  block_.offset_reference[lane] = at_reference.offset.data();
  block_.position_incident[lane] = at_incident.position.data();
  block_.orientation_incident[lane] = at_incident.orientation.data();
  block_.offset_incident[lane] = at_incident.offset.data();
}

}  // namespace atl::collision
