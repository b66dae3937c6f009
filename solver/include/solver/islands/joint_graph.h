#pragma once

#include <jobs/arrays.h>
#include <jobs/compact_array.h>
#include <solver/constraints/joint.h>
#include <solver/integrate/body_table.h>
#include <solver/islands/islands.h>

#include <cstdint>
#include <span>

namespace atl::solver {

/// The graph of bodies and joints: components of dynamic bodies connected by enabled joints, whatever touches or
/// sleeps. It is rebuilt when joints come, go or change, and kept from step to step in between.
class JointGraph {
 public:
  static constexpr std::uint32_t none = ~std::uint32_t{0};

  /// `acts[joint]` is 1 for joints that are there and enabled; of these, those with a dynamic body count.
  void build(std::span<const Joint> joints, std::span<const std::uint8_t> acts, const BodyTable& bodies);

  /// All joints that act, in order.
  std::span<const JointLink> links() const { return links_; }
  /// Dynamic bodies that tendons hang together, two by two, beyond the two of their link.
  std::span<const JointLink> ties() const { return ties_; }
  std::size_t component_count() const { return start_.empty() ? 0 : start_.size() - 1; }
  std::size_t joint_count() const { return component_of_.size(); }
  /// The component of a joint; none if it doesn't act. Components are in order of their first joint.
  std::uint32_t component_of(std::uint32_t joint) const { return component_of_[joint]; }
  std::span<const JointLink> links_of(std::uint32_t component) const;
  /// Tells a joint that is the only one of its component.
  bool is_single(std::uint32_t joint) const { return links_of(component_of(joint)).size() == 1; }
  /// The number of joints that act between the same two bodies, this one included. All bodies that don't respond count
  /// as one.
  int parallel_joints(std::uint32_t joint) const { return parallel_[joint]; }
  /// The number of joints, with tendons, at that dynamic body of a joint's link that has the most.
  int joints_around(std::uint32_t joint) const { return around_[joint]; }

  /// See jobs/arrays.h.
  auto arrays() const {
    return std::tie(links_, ties_, component_of_, parallel_, around_, sorted_, start_, parent_, component_of_root_);
  }

 private:
  void add_tendon(std::span<const Joint> joints, std::uint32_t tendon, const BodyTable& bodies);
  void count_parallel(std::span<const Joint> joints, const BodyTable& bodies);
  void count_around(const BodyTable& bodies);

  jobs::CompactArray<JointLink> links_;
  jobs::CompactArray<JointLink> ties_;
  jobs::CompactArray<std::uint32_t> component_of_;       // by joint
  jobs::CompactArray<int> parallel_, around_;            // likewise
  jobs::CompactArray<JointLink> sorted_;                 // by component, in order of joints
  jobs::CompactArray<std::uint32_t> start_;              // by component, in sorted_, and the end
  jobs::CompactArray<std::uint32_t> parent_;             // by body, while building
  jobs::CompactArray<std::uint32_t> component_of_root_;  // by body, while building
};

}  // namespace atl::solver
