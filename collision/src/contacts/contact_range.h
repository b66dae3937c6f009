#pragma once

#include <collision/contacts/update_contacts.h>
#include <collision/narrowphase/surface_contacts.h>
#include <jobs/assert.h>

#include <array>
#include <cstddef>
#include <cstdint>

namespace atl::collision {

// Contacts of one loop chunk; they are refreshed in blocks of lanes.
inline constexpr std::size_t contact_grain = 128;
// A chunk and the rest of its last pair's parts.
inline constexpr std::size_t longest_range = contact_grain + max_surface_manifolds;

// A range of entries of the cache's order, which one thread updates, and what has been found out about them. An entry
// is a place in the whole order.
struct ContactRange {
  ContactRange(ContactCache& of, const ContactUpdateInput& with, ContactStatus* by_entry)
      : cache(of), input(with), status(by_entry) {}

  ContactCache& cache;
  const ContactUpdateInput& input;
  ContactStatus* status;  // by entry
  ContactUpdateCounts counts;
  std::array<std::uint32_t, longest_range> stale;  // entries to be recomputed: of a pair's parts at least one
  std::size_t stale_count = 0;
  std::size_t begin = 0;
  // Results for the entries from `begin` on. They are recorded while each entry is at hand: a second pass over all
  // contacts costs more.
  std::array<TouchingPair, longest_range> pairs;
  std::array<std::uint8_t, longest_range> points;

  Contact& contact(std::size_t entry) const { return cache.contacts[cache.order()[entry]]; }
  ContactManifold& manifold(std::size_t entry) const { return cache.manifolds[cache.order()[entry]]; }
  void add_stale(std::size_t entry) {
    ATL_ASSERT(stale_count < stale.size(), entry, stale_count);
    stale[stale_count++] = static_cast<std::uint32_t>(entry);
  }
  void record_points(std::size_t entry) {
    ATL_ASSERT(entry >= begin && entry - begin < points.size(), entry, begin);
    points[entry - begin] = contact(entry).count;
  }
};

}  // namespace atl::collision
