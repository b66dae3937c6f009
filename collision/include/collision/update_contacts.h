#pragma once

#include <collision/broadphase.h>
#include <collision/contact_cache.h>
#include <jobs/arena.h>

#include <cstdint>
#include <span>
#include <vector>

namespace atl::collision {

/// What the update reads of the shapes, each by shape number.
struct ContactUpdateInput {
  std::span<const Shape> shapes;
  PoseView poses;
  std::span<const std::uint8_t> active;  ///< 1 if the shape may move this step; a pair with none is left alone
  const double* velocities;              ///< 3 a shape, m/s
  const double* angular_velocities;      ///< 3 a shape, rad/s
  double dt;                             ///< s
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

/// Separation below which a pair gets contact points before it touches: part of the smaller shape's size, and
/// what the pair's speeds can close in one step (up to half that size), so that a contact is there in the
/// substep in which it is needed.
double speculative_margin(const Shape& a, const Shape& b, double approach);

/// Brings all contacts up to date with the poses: closed-form refresh where the pair has hardly moved against
/// each other since its manifold was found, else the narrowphase, handing impulses on by feature id. Contacts
/// are independent, so this runs in parallel; status[i] is that of cache.order[i].
ContactUpdateCounts update_contacts(ContactCache& cache, const Broadphase& broadphase, const ContactUpdateInput& input,
                                    jobs::Arena& arena, std::vector<ContactStatus>& status);

}  // namespace atl::collision
