#pragma once

#include <jobs/arrays.h>
#include <solver/solver_settings.h>
#include <solver/sweep/impact_contact.h>
#include <solver/sweep/kernels.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace atl::solver {

/// Bounces of a group's contacts, solved in double as a substep begins. All points that close and will meet in it are
/// reflected together: their impulses are those with which each parts at e times the speed that it met with, or faster
/// where others push it on (Newton's law of restitution, as a complementarity problem: Moreau, "Unilateral contact and
/// dry friction in finite freedom dynamics", 1988). Then so are those that now close, round after round (Smith,
/// Kaufman, Vouga, Tamstorf and Grinspun, "Reflections on simultaneous impact", ToG 2012, section 4). So a blow passes
/// along what touches, no round makes energy, and the answer is as symmetric as the scene. Memory is reused.
///
/// Bodies then move as if they had met within the substep: those that no swept joint holds are put back by what they
/// travel too far until then. Forces and sweeps come after it, and find nothing that closes fast.
class Impacts {
 public:
  /// Starts a step, once blocks are prepared. `body_count` is 0 if nothing may bounce.
  void begin_step(std::size_t body_count, std::size_t block_count);
  /// Solves the impacts of a substep, after Kernels::find_approaches.
  void solve(const ContactKernelData& data, Friction friction);

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(bodies_, contacts_, number_, first_, lanes_, changed_, sets_); }

 private:
  static constexpr std::uint32_t none = ~0u;

  void find_first(const ContactKernelData& data);
  void find_next(const ContactKernelData& data);
  void list_lanes(const ContactKernelData& data);
  void add_if_hit(const ContactKernelData& data, std::uint32_t number);
  std::uint32_t body_of(const ContactKernelData& data, std::uint32_t local);
  void gather_sets();
  void store(const ContactKernelData& data);

  std::size_t block_count_ = 0;
  std::vector<ImpactBody> bodies_;       // the bodies that impacts hit in this substep
  std::vector<ImpactContact> contacts_;  // of this round
  std::vector<std::uint32_t> number_;    // by local body: its place in bodies_, or none
  std::vector<std::uint32_t> first_;     // by local body: where its lanes begin in lanes_; empty until they are listed
  std::vector<std::uint32_t> lanes_;     // of contacts that bounce: block_lanes * block + lane
  std::vector<std::uint32_t> changed_;   // lanes of what the last round has changed
  std::vector<std::uint32_t> sets_;      // by place in bodies_: another of what it hits together with, or itself
};

}  // namespace atl::solver
