#pragma once

#include <collision/broadphase.h>
#include <collision/collider_table.h>
#include <collision/contact_cache.h>
#include <collision/refresh.h>
#include <jobs/arena.h>

#include <cstdint>
#include <span>
#include <vector>

namespace atl::collision {

struct ContactUpdateInput {
  const ColliderTable& colliders;
  PoseView poses;                        ///< of bodies
  std::span<const std::uint8_t> active;  ///< by body: 1 if it may move this step; a pair with none is left alone
  std::span<const StepReach> reaches;    ///< by body: in this step, at its present velocity
  const RefreshKernels& kernels;
};

/// One entry of ContactCache::order each.
enum class ContactStatus : std::uint8_t {
  Apart,     ///< no points
  Touching,  ///< points, at least within the speculative margin
  Idle,      ///< not updated: nothing of it may move
  Lost,      ///< the fat boxes parted; to be removed
};

struct ContactUpdateCounts {
  std::int64_t fcl_calls = 0;
  std::int64_t kept = 0;
  std::int64_t id_matches = 0;
  std::int64_t id_misses = 0;

  ContactUpdateCounts& operator+=(const ContactUpdateCounts& other);
};

struct ContactUpdate {
  std::vector<ContactStatus> status;  ///< that of cache.order[i] at i
  ContactUpdateCounts counts;
  std::vector<ContactUpdateCounts> by_chunk;  ///< memory that is used again
};

/// Brings all contacts up to date with the poses: closed-form refresh where the pair has hardly moved against
/// each other since its manifold was found, else the narrowphase, handing impulses on by feature id. Contacts
/// are independent, so this runs in parallel.
void update_contacts(ContactCache& cache, const Broadphase& broadphase, const ContactUpdateInput& input,
                     jobs::Arena& arena, ContactUpdate& update);

}  // namespace atl::collision
