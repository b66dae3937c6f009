#pragma once

#include <collision/narrowphase/collide.h>

#include <array>
#include <cstddef>

#include "contacts/contact_range.h"
#include "contacts/manifold_refresher.h"

namespace atl::collision {

// Asks the narrowphase for the manifolds of contacts that are stale, and hands impulses on to their points.
class ManifoldRecomputer {
 public:
  ManifoldRecomputer(ContactRange& range, ManifoldRefresher& refresher)
      : range_(range), input_(range.input), refresher_(refresher) {}

  // Recomputes all stale entries of the range, and refreshes their manifolds, since only kernels compute world axes.
  void run();

 private:
  void recompute(std::size_t entry);
  void recompute_boxes();
  void recompute_surface_parts(std::size_t entry);
  void replace(std::size_t entry, const Manifold& manifold, const Pose& incident, double margin);
  void refresh_replaced();
  void set_apart(std::size_t entry, double margin, double gap, double radius);
  bool meet_ahead(std::size_t entry, double margin, double gap);
  bool set_surface_apart(std::size_t entry, double margin, double gap, double radius);
  void fill_box_lane(const Contact& contact, std::size_t lane);
  void count_source(Narrowphase source);

  ContactRange& range_;
  const ContactUpdateInput& input_;
  ManifoldRefresher& refresher_;
  LaneBatch replaced_;  // entries whose new manifolds are to be refreshed
  LaneBatch box_pairs_;
  BoxBlock boxes_;
  BoxAxes box_axes_;
  std::array<OffsetShapeLane, block_lanes> first_;
  std::array<OffsetShapeLane, block_lanes> second_;
};

}  // namespace atl::collision
