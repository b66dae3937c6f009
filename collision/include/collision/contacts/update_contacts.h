#pragma once

#include <collision/broadphase/broadphase.h>
#include <collision/contacts/contact_cache.h>
#include <collision/contacts/narrowphase_kernels.h>
#include <collision/contacts/touching_pair.h>
#include <collision/shapes/collider_table.h>
#include <collision/shapes/function_ref.h>
#include <jobs/arena.h>
#include <jobs/arrays.h>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace atl::collision {

struct ContactUpdateInput;
struct Meeting;

/// How bodies move on at the speeds that they have.
struct MotionAhead {
  const double* angular_velocities;            ///< 3 a body, rad/s
  double dt;                                   ///< s, of this step
  FunctionRef<bool(std::uint32_t)> is_joined;  ///< joints act on a body, so that its speed doesn't say where it goes
  /// The function of that name, which sweeps solids: what does so is above contacts.
  std::optional<Meeting> (*find_meeting)(const Contact& contact, bool bounces, const ContactUpdateInput& input,
                                         double margin);
};

struct ContactUpdateInput {
  const ColliderTable& colliders;
  PoseView poses;                         ///< of bodies
  std::span<const std::uint8_t> dynamic;  ///< by body: 1 if contacts move it
  /// 0 for a body that stands still. If such a body is turned by hand all the same, `turned` jumps by `put_elsewhere`.
  std::span<const std::uint8_t> mobility;
  /// By body: an odometer of turns, the sum of the chords 2 sin(angle / 2). The difference of two readings bounds how
  /// far a point 1 m from the origin got by turning.
  std::span<const double> turned;
  std::span<const StepReach> reaches;  ///< by body: in this step, at its present velocity
  const NarrowphaseKernels& kernels;
  const MotionAhead* ahead = nullptr;  ///< without it contacts beyond the speculative margin are not looked for
};

/// More than any gap allows for.
inline constexpr double put_elsewhere = 1e6;

/// One entry of ContactCache::order() each.
enum class ContactStatus : std::uint8_t {
  Apart,     ///< no points
  Touching,  ///< points, at least within the speculative margin
  Stale,     ///< while it is being updated: it is to be recomputed
  Lost,      ///< the fat boxes parted; to be removed
};

struct ContactUpdateCounts {
  std::int64_t recycled = 0;     ///< pairs that kept their features, or their having none
  std::int64_t recomputed = 0;   ///< pairs that the narrowphase computed
  std::int64_t fcl_calls = 0;    ///< pairs of these for which FCL ran
  std::int64_t fcl_repairs = 0;  ///< and its answer was not taken: see Narrowphase
  std::int64_t id_matches = 0;
  std::int64_t id_misses = 0;
  std::int64_t points = 0;  ///< of touching pairs
  std::int64_t lost = 0;    ///< contacts

  ContactUpdateCounts& operator+=(const ContactUpdateCounts& other);
};

/// The result of an update of contacts. It keeps its memory for the next one.
class ContactUpdate {
 public:
  std::vector<ContactStatus> status;  ///< status[i] is that of cache.order()[i]
  ContactUpdateCounts counts;
  std::vector<TouchingPair> touching;  ///< in order
  bool touching_changed = false;       ///< it is not what it was after the update before

  /// Drops the knowledge of earlier contacts, so that the next update reports all as changed.
  void forget();

  /// Adds those of the contacts, which are in order and were not updated, that touch as they last did.
  void add_touching(const ContactCache& cache, std::span<const std::uint32_t> slots);

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(status, touching, chunks_, by_chunk_); }

 private:
  friend void update_contacts(ContactCache&, const Broadphase&, const ContactUpdateInput&, jobs::Arena&,
                              ContactUpdate&);

  // Chunks of the loop over contacts list what touches each in a place of its own, where the last update's list still
  // stands: so they see whether it changed.
  struct Chunk {
    ContactUpdateCounts counts;
    std::size_t touching = 0;
    std::size_t offset = 0;  // in `touching`
    bool changed = false;
  };
  void collect_touching(jobs::Arena& arena);

  std::vector<Chunk> chunks_;
  std::vector<TouchingPair> by_chunk_;
  bool added_to_ = false;  // `touching` has more than the chunks do
};

/// Brings all active contacts up to date with the poses: closed-form refresh where the pair has hardly moved against
/// each other since its manifold was found, else the narrowphase, handing impulses on by feature id. Contacts
/// are independent, so this runs in parallel.
void update_contacts(ContactCache& cache, const Broadphase& broadphase, const ContactUpdateInput& input,
                     jobs::Arena& arena, ContactUpdate& update);

/// Brings what the manifolds of these slots say of where points are up to date with the poses, for the features that
/// they have. For contacts of bodies that are at rest, as others are updated by each step.
void refresh_contacts(ContactCache& cache, const ContactUpdateInput& input, std::span<const std::uint32_t> slots,
                      jobs::Arena& arena);

}  // namespace atl::collision
