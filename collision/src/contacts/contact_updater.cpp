#include "contacts/contact_updater.h"

#include <jobs/assert.h>

#include <algorithm>
#include <utility>

#include "contacts/pair_motion.h"

namespace atl::collision {
namespace {

// True if two solids that were found apart still are, whatever their features. The gap shrinks at most by how far their
// origins have moved against each other since, and by a radius times how far the bodies have turned.
bool still_apart(const Contact& contact, const ContactUpdateInput& input) {
  const Eigen::Map<const Vector3> from(contact.apart_from.data());
  const double moved = (origins_apart(contact, input) - from).norm();
  const double turned = turned_by_both(contact, input) - contact.turned;
  ATL_ASSERT(!(turned < 0), contact.pair.first, contact.pair.second, turned);
  const double left = static_cast<double>(contact.gap) - moved - static_cast<double>(contact.radius) * turned;
  return left > range_of(contact, input);
}

// A pair's parts stay together: they belong to the chunk in which they begin.
std::size_t first_whole_pair(const ContactRange& range, std::size_t begin, std::size_t end) {
  while (begin < end && range.contact(begin).part > 0) ++begin;
  return begin;
}
std::size_t end_of_last_pair(const ContactRange& range, std::size_t end) {
  while (end < range.cache.order().size() && range.contact(end).part > 0) ++end;
  return end;
}

void list_touching(const ContactRange& range, std::size_t end, std::span<TouchingPair> touching,
                   ContactUpdater::Result& result) {
  const std::span<const std::uint8_t> dynamic = range.input.dynamic;
  std::size_t listed = 0;
  std::uint32_t difference = 0;
  std::int64_t points = 0;
  for (std::size_t i = 0; i < end - range.begin; ++i) {
    ATL_ASSERT(range.status[range.begin + i] != ContactStatus::Stale, range.begin + i);
    if (range.status[range.begin + i] != ContactStatus::Touching) continue;
    const TouchingPair pair = range.pairs[i];
    ATL_ASSERT(pair.slot == range.cache.order()[range.begin + i], range.begin + i, pair.slot);
    ATL_ASSERT(range.points[i] > 0 && range.points[i] <= max_points, range.begin + i, range.points[i]);
    if (!dynamic[pair.first] && !dynamic[pair.second]) continue;
    ATL_ASSERT(listed < touching.size(), listed, touching.size());
    TouchingPair& place = touching[listed++];
    difference |= (pair.first ^ place.first) | (pair.second ^ place.second) | (pair.slot ^ place.slot);
    place = pair;
    points += range.points[i];
  }
  result.touching = listed;
  result.changed = difference != 0;
  result.counts.points += points;
}

}  // namespace

bool ContactUpdater::is_lost(Pair pair) const {
  return (broadphase_.has_moved(pair.first) || broadphase_.has_moved(pair.second)) &&
         !broadphase_.overlap(pair.first, pair.second);
}

ContactUpdater::Result ContactUpdater::run(std::size_t begin, std::size_t end, std::span<TouchingPair> touching) {
  const ContactOrder& order = range_.cache.order();
  begin = first_whole_pair(range_, begin, end);
  if (begin < end) end = end_of_last_pair(range_, end);

  range_.begin = begin;
  ATL_ASSERT(end - begin <= longest_range, begin, end);
  for (std::size_t i = begin; i < end;) {
    const std::size_t next = order.pair_end(i);
    if (is_lost(order.pair_at(i))) {
      std::fill(range_.status + i, range_.status + next, ContactStatus::Lost);
      range_.counts.lost += static_cast<std::int64_t>(next - i);
    } else {
      recycle(i, next);
    }
    i = next;
  }
  refresh_recycled();
  ManifoldRecomputer(range_, refresher_).run();

  Result result;
  result.counts = range_.counts;
  list_touching(range_, end, touching, result);
  return result;
}

// A pair that isn't lost, of which the parts are apart together, and are recomputed together.
void ContactUpdater::recycle(std::size_t first, std::size_t end) {
  fetch_ahead(first);
  const Contact& contact = range_.contact(first);
  ATL_ASSERT(contact.part == 0 && end > first, first, end, contact.part);
  ATL_ASSERT(!(contact.gap > 0 && contact.count > 0), first, contact.gap, contact.count);
  const bool was_apart = contact.gap > 0;
  if (was_apart && still_apart(contact, range_.input)) {
    std::fill(range_.status + first, range_.status + end, ContactStatus::Apart);
    ++range_.counts.recycled;
    return;
  }
  bool recycles = !was_apart;
  for (std::size_t i = first; i < end; ++i) recycles &= range_.contact(i).recycles;
  for (std::size_t i = first; i < end; ++i) {
    const std::uint32_t slot = range_.cache.order()[i];
    range_.pairs[i - range_.begin] = {contact.body_first, contact.body_second, slot};
    if (!was_apart) refresher_.fetch(slot);
    if (!recycles) {
      range_.status[i] = ContactStatus::Stale;
    } else if (recycled_.add(i)) {
      refresh_recycled();
    }
  }
  if (!recycles) range_.add_stale(first);
}

// Slots are in no order: what is needed soon is asked of memory now.
void ContactUpdater::fetch_ahead(std::size_t entry) const {
  constexpr std::size_t ahead = 16;
  if (entry + ahead < range_.cache.order().size()) __builtin_prefetch(&range_.contact(entry + ahead));
}

void ContactUpdater::refresh_recycled() {
  const std::size_t count = std::exchange(recycled_.count, 0);
  if (count == 0) return;
  const ContactOrder& order = range_.cache.order();
  const unsigned recycled = refresher_.refresh(
      count, [&](std::size_t lane) { return order[recycled_.entries[lane]]; }, false);
  ATL_ASSERT(recycled >> count == 0, recycled, count);
  for (std::size_t lane = 0; lane < count; ++lane) {
    const std::uint32_t entry = recycled_.entries[lane];
    if ((recycled >> lane & 1) != 0) {
      // A pair found apart is recycled as well: it stays apart, but for the tolerance, while it doesn't move.
      range_.record_points(entry);
      range_.status[entry] = range_.contact(entry).count > 0 ? ContactStatus::Touching : ContactStatus::Apart;
      range_.counts.recycled += range_.contact(entry).part == 0;
    } else {
      range_.status[entry] = ContactStatus::Stale;
      range_.add_stale(entry);
    }
  }
}

}  // namespace atl::collision
