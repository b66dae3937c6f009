#include "contacts/contact_stretch.h"

#include <jobs/prefetch.h>

#include <algorithm>
#include <limits>
#include <utility>

namespace atl::collision {
namespace {

// Faster than any body: for the largest margin.
constexpr double any_approach = std::numeric_limits<double>::infinity();

alignas(16) constexpr std::array<float, 4> no_offset = {};

}  // namespace

// m, of the second body against the first in this step.
Vector3 ContactStretch::shift_between(const Contact& contact) const {
  const float(&first)[3] = input_.reaches[contact.body_first].shift;
  const float(&second)[3] = input_.reaches[contact.body_second].shift;
  return {second[0] - first[0], second[1] - first[1], second[2] - first[2]};
}

// m, world: origin of the second shape from the first's.
Vector3 ContactStretch::origins_apart(const Contact& contact) const {
  if (!contact.placed) return input_.poses.position(contact.body_second) - input_.poses.position(contact.body_first);
  return input_.colliders.position(contact.pair.second, input_.poses) -
         input_.colliders.position(contact.pair.first, input_.poses);
}

double ContactStretch::margin_of(const Contact& contact) const {
  const float turn = input_.reaches[contact.body_first].turn + input_.reaches[contact.body_second].turn;
  return speculative_margin(static_cast<double>(contact.size),
                            shift_between(contact).norm() + static_cast<double>(turn));
}

bool ContactStretch::is_lost(Pair pair) const {
  return (broadphase_.has_moved(pair.first) || broadphase_.has_moved(pair.second)) &&
         !broadphase_.overlap(pair.first, pair.second);
}

std::size_t ContactStretch::parts_from(std::size_t entry) const {
  std::size_t end = entry + 1;
  while (end < cache_.order.size() && cache_.contacts[cache_.order[end]].part > 0) ++end;
  return end - entry;
}

// The entry after the parts of a pair: to find it reads no contact.
std::size_t ContactStretch::pair_end(std::size_t entry) const {
  std::size_t end = entry + 1;
  while (end < cache_.order.size() && cache_.pair_at(end) == cache_.pair_at(entry)) ++end;
  return end;
}

ContactStretch::Result ContactStretch::run(std::size_t begin, std::size_t end, ContactStatus* status,
                                           std::span<TouchingPair> touching) {
  status_ = status;
  stale_count_ = 0;
  // A pair's parts stay together: they belong to the chunk in which they begin.
  while (begin < end && contact_at(begin).part > 0) ++begin;
  if (begin < end) end += parts_from(end - 1) - 1;

  begin_ = begin;
  for (std::size_t i = begin; i < end;) {
    const std::size_t next = pair_end(i);
    if (is_lost(cache_.pair_at(i))) {
      std::fill(status_ + i, status_ + next, ContactStatus::Lost);
      counts_.lost += static_cast<std::int64_t>(next - i);
    } else {
      keep(i, next);
    }
    i = next;
  }
  refresh(kept_batch_, false);

  find_stale();
  refresh(fresh_batch_, true);

  Result result;
  list_touching(begin, end, touching, result);
  result.counts = std::exchange(counts_, {});
  return result;
}

void ContactStretch::list_touching(std::size_t begin, std::size_t end, std::span<TouchingPair> touching,
                                   Result& result) {
  std::size_t listed = 0;
  std::uint32_t difference = 0;
  std::int64_t points = 0;
  for (std::size_t i = 0; i < end - begin; ++i) {
    if (status_[begin + i] != ContactStatus::Touching) continue;
    const TouchingPair pair = pairs_[i];
    if (!input_.dynamic[pair.first] && !input_.dynamic[pair.second]) continue;
    TouchingPair& place = touching[listed++];
    difference |= (pair.first ^ place.first) | (pair.second ^ place.second) | (pair.slot ^ place.slot);
    place = pair;
    points += points_[i];
  }
  result.touching = listed;
  result.changed = difference != 0;
  counts_.points += points;
}

// A pair that isn't lost, of which the parts are apart together.
void ContactStretch::keep(std::size_t first, std::size_t end) {
  fetch_ahead(first);
  const Contact& contact = contact_at(first);
  const bool was_apart = contact.gap > 0;
  if (was_apart && still_apart(contact)) {
    std::fill(status_ + first, status_ + end, ContactStatus::Apart);
    ++counts_.kept;
    return;
  }
  for (std::size_t i = first; i < end; ++i) {
    pairs_[i - begin_] = {contact.body_first, contact.body_second, cache_.order[i]};
    if (was_apart) {
      status_[i] = ContactStatus::Stale;
    } else {
      add_to(kept_batch_, i, false);
    }
  }
  if (was_apart) stale_[stale_count_++] = static_cast<std::uint32_t>(first);
}

void ContactStretch::add_to(Batch& batch, std::size_t entry, bool fresh) {
  fetch_rest(cache_.order[entry]);
  batch.entries[batch.count++] = static_cast<std::uint32_t>(entry);
  if (batch.count == block_lanes) refresh(batch, fresh);
}

// What a refresh reads beside the first line of a contact, while its batch fills.
void ContactStretch::fetch_rest(std::uint32_t slot) const {
  jobs::prefetch(cache_.contacts[slot], jobs::cache_line);
  jobs::prefetch(cache_.manifolds[slot]);
}

// Slots are in no order: what is needed soon is asked of memory now.
void ContactStretch::fetch_ahead(std::size_t entry) const {
  constexpr std::size_t ahead = 16;
  if (entry + ahead < cache_.order.size()) __builtin_prefetch(&cache_.contacts[cache_.order[entry + ahead]]);
}

// Whether two solids that were found apart are so still, whatever their features: by how far their origins have moved
// against each other since, and how much the bodies have turned.
bool ContactStretch::still_apart(const Contact& contact) const {
  const Eigen::Map<const Vector3> from(contact.apart_from.data());
  const double moved = (origins_apart(contact) - from).norm();
  const double turned = input_.turned[contact.body_first] + input_.turned[contact.body_second] - contact.turned;
  const double left = static_cast<double>(contact.gap) - moved - static_cast<double>(contact.lever) * turned;
  return left > speculative_margin(static_cast<double>(contact.size), any_approach) || left > margin_of(contact);
}

void ContactStretch::refresh(Batch& batch, bool fresh) {
  const std::size_t count = std::exchange(batch.count, 0);
  if (count == 0) return;
  fill_block(count, [&](std::size_t lane) { return cache_.order[batch.entries[lane]]; });
  const unsigned kept = input_.kernels.refresh(block_, count, fresh);
  if (fresh) return;
  for (std::size_t lane = 0; lane < count; ++lane) {
    const std::uint32_t entry = batch.entries[lane];
    if ((kept >> lane & 1) != 0) {
      // A pair found apart is kept as well: it stays apart, but for the tolerance, while it doesn't move.
      note_points(entry);
      status_[entry] = contact_at(entry).count > 0 ? ContactStatus::Touching : ContactStatus::Apart;
      counts_.kept += contact_at(entry).part == 0;
    } else {
      status_[entry] = ContactStatus::Stale;
      stale_[stale_count_++] = entry;
    }
  }
}

// By lane: slot_of(lane) of the first `count`.
template <typename SlotOf>
void ContactStretch::fill_block(std::size_t count, const SlotOf& slot_of) {
  for (std::size_t lane = 0; lane < block_lanes; ++lane) {
    const std::uint32_t slot = slot_of(std::min(lane, count - 1));
    fill_lane(cache_.contacts[slot], cache_.manifolds[slot], lane);
  }
}

void ContactStretch::place(std::span<const std::uint32_t> slots) {
  for (std::size_t begin = 0; begin < slots.size(); begin += block_lanes) {
    const std::span<const std::uint32_t> after = slots.subspan(std::min(begin + block_lanes, slots.size()));
    for (const std::uint32_t slot : after.first(std::min(block_lanes, after.size()))) {
      jobs::prefetch(cache_.contacts[slot]);
      jobs::prefetch(cache_.manifolds[slot]);
    }
    const std::size_t count = std::min(block_lanes, slots.size() - begin);
    fill_block(count, [&](std::size_t lane) { return slots[begin + lane]; });
    input_.kernels.refresh(block_, count, true);
  }
}

void ContactStretch::place(std::uint32_t collider, PlacedLane& lane) const {
  const Pose pose = input_.colliders.pose(collider, input_.poses);
  const Vector3 offset = pose.position - input_.poses[input_.colliders.body[collider]].position;
  Eigen::Map<Vector3>(lane.position.data()) = pose.position;
  Eigen::Map<Eigen::Vector4d>(lane.orientation.data()) = pose.orientation.coeffs();
  Eigen::Map<Eigen::Vector3f>(lane.offset.data()) = offset.cast<float>();
}

void ContactStretch::fill_lane(const Contact& contact, ContactManifold& manifold, std::size_t lane) {
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
  if (!contact.placed) return;

  PlacedLane& at_reference = placed_reference_[lane];
  PlacedLane& at_incident = placed_incident_[lane];
  place(swapped ? contact.pair.second : contact.pair.first, at_reference);
  place(swapped ? contact.pair.first : contact.pair.second, at_incident);
  block_.position_reference[lane] = at_reference.position.data();
  block_.orientation_reference[lane] = at_reference.orientation.data();
  block_.offset_reference[lane] = at_reference.offset.data();
  block_.position_incident[lane] = at_incident.position.data();
  block_.orientation_incident[lane] = at_incident.orientation.data();
  block_.offset_incident[lane] = at_incident.offset.data();
}

}  // namespace atl::collision
