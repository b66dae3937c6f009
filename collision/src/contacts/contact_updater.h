#pragma once

#include <cstddef>
#include <span>

#include "contacts/contact_range.h"
#include "contacts/manifold_recomputer.h"
#include "contacts/manifold_refresher.h"

namespace atl::collision {

// The update of a range of the cache's order, on one thread: recycles the manifolds of pairs that have hardly moved
// against each other, and has the others recomputed.
class ContactUpdater {
 public:
  ContactUpdater(ContactCache& cache, const Broadphase& broadphase, const ContactUpdateInput& input,
                 ContactStatus* status)
      : broadphase_(broadphase), range_(cache, input, status), refresher_(cache, input) {}

  // Writes those that touch to `touching`, over those of the last update.
  struct Result {
    ContactUpdateCounts counts;
    std::size_t touching = 0;
    bool changed = false;  // the set of touching pairs, up to their number
  };
  Result run(std::size_t begin, std::size_t end, std::span<TouchingPair> touching);

 private:
  bool is_lost(Pair pair) const;
  void recycle(std::size_t first, std::size_t end);
  void refresh_recycled();
  void fetch_ahead(std::size_t entry) const;

  const Broadphase& broadphase_;
  ContactRange range_;
  ManifoldRefresher refresher_;
  LaneBatch recycled_;  // entries that may keep their features
};

}  // namespace atl::collision
