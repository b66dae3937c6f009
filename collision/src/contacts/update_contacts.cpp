#include <collision/contacts/update_contacts.h>
#include <jobs/assert.h>

#include <algorithm>

#include "contacts/contact_updater.h"

namespace atl::collision {

ContactUpdateCounts& ContactUpdateCounts::operator+=(const ContactUpdateCounts& other) {
  recycled += other.recycled;
  recomputed += other.recomputed;
  fcl_calls += other.fcl_calls;
  fcl_repairs += other.fcl_repairs;
  id_matches += other.id_matches;
  id_misses += other.id_misses;
  points += other.points;
  lost += other.lost;
  return *this;
}

// Joins the lists of the chunks, one after another. With only one chunk its list is already in place.
void ContactUpdate::collect_touching(jobs::Arena& arena) {
  if (chunks_.size() == 1) {
    ATL_ASSERT(chunks_[0].touching <= touching.size(), chunks_[0].touching, touching.size());
    return touching.resize(chunks_[0].touching);
  }
  std::size_t total = 0;
  for (Chunk& chunk : chunks_) {
    ATL_ASSERT(chunk.touching <= longest_range, chunk.touching);
    chunk.offset = total;
    total += chunk.touching;
  }
  touching.resize(total);
  constexpr std::size_t chunks_at_once = 16;
  arena.parallel_for(chunks_.size(), chunks_at_once, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      std::copy_n(by_chunk_.data() + i * longest_range, chunks_[i].touching, touching.data() + chunks_[i].offset);
    }
  });
}

void ContactUpdate::forget() {
  touching.clear();
  chunks_.clear();
  added_to_ = true;
}

void ContactUpdate::add_touching(const ContactCache& cache, std::span<const std::uint32_t> slots) {
  const auto updated = static_cast<std::ptrdiff_t>(touching.size());
  for (const std::uint32_t slot : slots) {
    const Contact& contact = cache.contacts[slot];
    if (contact.count == 0) continue;
    touching.push_back({contact.body_first, contact.body_second, slot});
    counts.points += contact.count;
    added_to_ = touching_changed = true;
  }
  // Each pair is in only one of the parts, with its contacts in order.
  std::inplace_merge(touching.begin(), touching.begin() + updated, touching.end(),
                     [&cache](const TouchingPair& a, const TouchingPair& b) {
                       return cache.contacts[a.slot].pair < cache.contacts[b.slot].pair;
                     });
}

void update_contacts(ContactCache& cache, const Broadphase& broadphase, const ContactUpdateInput& input,
                     jobs::Arena& arena, ContactUpdate& update) {
  const std::size_t count = cache.order().size();
  const std::size_t chunk_count = jobs::Arena::chunk_count(count, contact_grain);
  [[maybe_unused]] const std::size_t bodies = input.dynamic.size();
  ATL_ASSERT(input.mobility.size() == bodies && input.turned.size() == bodies, bodies, input.mobility.size(),
             input.turned.size());
  ATL_ASSERT(count == 0 || input.reaches.size() == bodies, count, bodies, input.reaches.size());
  update.touching_changed = update.added_to_ || update.chunks_.size() != chunk_count;
  update.added_to_ = false;
  update.status.resize(count);
  update.chunks_.resize(chunk_count);
  if (chunk_count == 1) update.touching.resize(std::max(update.touching.size(), count));
  if (chunk_count > 1) update.by_chunk_.resize(std::max(update.by_chunk_.size(), chunk_count * longest_range));
  arena.parallel_for(count, contact_grain, [&](std::size_t begin, std::size_t end) {
    ContactUpdate::Chunk& chunk = update.chunks_[begin / contact_grain];
    const std::span<TouchingPair> place =
        chunk_count == 1 ? std::span(update.touching)
                         : std::span(update.by_chunk_).subspan(begin / contact_grain * longest_range, longest_range);
    ContactUpdater updater(cache, broadphase, input, update.status.data());
    const ContactUpdater::Result result = updater.run(begin, end, place);
    chunk.changed = result.changed || result.touching != chunk.touching;
    chunk.touching = result.touching;
    chunk.counts = result.counts;
  });
  update.counts = {};
  for (const ContactUpdate::Chunk& chunk : update.chunks_) {
    update.counts += chunk.counts;
    update.touching_changed |= chunk.changed;
  }
  if (update.touching_changed || chunk_count == 1) update.collect_touching(arena);
}

void refresh_contacts(ContactCache& cache, const ContactUpdateInput& input, std::span<const std::uint32_t> slots,
                      jobs::Arena& arena) {
  arena.parallel_for(slots.size(), contact_grain, [&](std::size_t begin, std::size_t end) {
    ManifoldRefresher(cache, input).refresh_all(slots.subspan(begin, end - begin));
  });
}

}  // namespace atl::collision
