#pragma once

#include <collision/contacts/update_contacts.h>
#include <jobs/assert.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace atl::collision {

// The pose of a shape with a local offset, for one lane of a block. Without an offset the body's pose is used instead.
struct alignas(16) OffsetShapeLane {
  std::array<float, 4> offset = {};  // m, world: from the body's centre of mass
  std::array<double, 4> orientation;
  std::array<double, 3> position;

  void set(std::uint32_t collider, const ContactUpdateInput& input);
};

// Entries of the cache's order, or slots, collected until they fill a block of lanes.
struct LaneBatch {
  std::array<std::uint32_t, block_lanes> entries;
  std::size_t count = 0;

  // Adds an entry. Returns true if the batch is now full.
  bool add(std::size_t entry) {
    entries[count++] = static_cast<std::uint32_t>(entry);
    return count == block_lanes;
  }
};

// Brings manifolds up to date with the poses, for the features that they have, in blocks of lanes.
class ManifoldRefresher {
 public:
  ManifoldRefresher(ContactCache& cache, const ContactUpdateInput& input) : cache_(cache), input_(input) {}

  // Prefetches what refresh() reads of a slot, except the first line of its contact, while its batch fills.
  void fetch(std::uint32_t slot) const;
  // Refreshes up to a block of contacts; slot_of(lane) gives the slot of each. With `all` every lane is written;
  // otherwise see NarrowphaseKernels::refresh.
  template <typename SlotOf>
  unsigned refresh(std::size_t count, const SlotOf& slot_of, bool all) {
    ATL_ASSERT(count >= 1 && count <= block_lanes, count);
    for (std::size_t lane = 0; lane < block_lanes; ++lane) {
      const std::uint32_t slot = slot_of(std::min(lane, count - 1));
      fill_lane(cache_.contacts[slot], cache_.manifolds[slot], lane);
    }
    return input_.kernels.refresh(block_, count, all);
  }
  void refresh_all(std::span<const std::uint32_t> slots);

 private:
  void fill_lane(const Contact& contact, ContactManifold& manifold, std::size_t lane);

  ContactCache& cache_;
  const ContactUpdateInput& input_;
  RefreshBlock block_;
  std::array<OffsetShapeLane, block_lanes> reference_;
  std::array<OffsetShapeLane, block_lanes> incident_;
};

}  // namespace atl::collision
