#pragma once

#include <collision/contacts/update_contacts.h>
#include <collision/narrowphase/surface_contacts.h>

#include <array>
#include <cstdint>
#include <span>

namespace atl::collision {

// Contacts of one loop chunk; they are refreshed in blocks of lanes.
inline constexpr std::size_t contact_grain = 128;
// A chunk and the rest of its last pair's parts.
inline constexpr std::size_t longest_stretch = contact_grain + max_surface_manifolds;

// Pose of a shape that isn't its body's, for a lane of a block.
struct alignas(16) PlacedLane {
  std::array<float, 4> offset = {};
  std::array<double, 4> orientation;
  std::array<double, 3> position;
};

// The update of a stretch of the cache's order, on one thread.
class ContactStretch {
 public:
  ContactStretch(ContactCache& cache, const Broadphase& broadphase, const ContactUpdateInput& input)
      : cache_(cache), broadphase_(broadphase), input_(input) {}

  // Writes those that touch to `touching`, over those of the last update.
  struct Result {
    ContactUpdateCounts counts;
    std::size_t touching = 0;
    bool changed = false;  // what touches, up to their number
  };
  Result run(std::size_t begin, std::size_t end, ContactStatus* status, std::span<TouchingPair> touching);
  void place(std::span<const std::uint32_t> slots);

 private:
  // Entries of the order, collected for refresh() until they fill a block.
  struct Batch {
    std::array<std::uint32_t, block_lanes> entries;
    std::size_t count = 0;
  };

  // contact_stretch.cpp: what is kept, and what is not.
  bool is_lost(Pair pair) const;
  bool still_apart(const Contact& contact) const;
  void keep(std::size_t first, std::size_t end);
  void add_to(Batch& batch, std::size_t entry, bool fresh);
  void refresh(Batch& batch, bool fresh);
  template <typename SlotOf>
  void fill_block(std::size_t count, const SlotOf& slot_of);
  void fill_lane(const Contact& contact, ContactManifold& manifold, std::size_t lane);
  void place(std::uint32_t collider, PlacedLane& lane) const;
  void fetch_ahead(std::size_t entry) const;
  void fetch_rest(std::uint32_t slot) const;
  void list_touching(std::size_t begin, std::size_t end, std::span<TouchingPair> touching, Result& result);
  Vector3 shift_between(const Contact& contact) const;
  Vector3 origins_apart(const Contact& contact) const;
  double margin_of(const Contact& contact) const;
  std::size_t parts_from(std::size_t entry) const;
  std::size_t pair_end(std::size_t entry) const;

  // fresh_manifolds.cpp: what is found anew.
  void find_stale();
  void note_source(Narrowphase by);
  void find_anew(std::size_t entry);
  void find_boxes();
  void find_surface_parts(std::size_t entry);
  void set_apart(std::size_t entry, double margin, double gap, double lever);
  double lever_of(Pair pair) const;
  bool set_surface_apart(std::size_t entry, double margin, double gap, double lever);
  void replace(std::size_t entry, const Manifold& fresh, const Pose& incident, double margin);
  float tolerance_of(Pair pair, const Manifold& fresh) const;
  bool are_boxes(Pair pair) const;
  bool has_surface(Pair pair) const;

  void note_points(std::size_t entry) { points_[entry - begin_] = contact_at(entry).count; }
  Contact& contact_at(std::size_t entry) { return cache_.contacts[cache_.order[entry]]; }

  ContactCache& cache_;
  const Broadphase& broadphase_;
  const ContactUpdateInput& input_;
  ContactStatus* status_ = nullptr;
  ContactUpdateCounts counts_;
  RefreshBlock block_;
  std::array<PlacedLane, block_lanes> placed_reference_;
  std::array<PlacedLane, block_lanes> placed_incident_;
  Batch kept_batch_;
  Batch fresh_batch_;
  Batch box_batch_;  // pairs of boxes to be found anew
  BoxBlock boxes_;
  BoxAxes box_axes_;
  std::array<std::uint32_t, longest_stretch> stale_;
  // Of the entries from begin_ on: noted as they pass, since to come back to all contacts costs more.
  std::size_t begin_ = 0;
  std::array<TouchingPair, longest_stretch> pairs_;
  std::array<std::uint8_t, longest_stretch> points_;
  std::size_t stale_count_ = 0;
};

}  // namespace atl::collision
