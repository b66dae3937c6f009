#pragma once

#include <jobs/arrays.h>
#include <solver/direct/solve_input.h>
#include <solver/solver_settings.h>
#include <solver/sweep/group_bodies.h>
#include <solver/sweep/impact_contact.h>
#include <solver/sweep/joined_motion.h>
#include <solver/sweep/kernels.h>

#include <compare>
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
/// Bodies then move as if they had met within the substep: they are put back by what they travel too far until then.
/// Forces and sweeps come after it, and find nothing that closes fast.
///
/// Joints are solved with the impacts: one on a body moves all that hangs together with it (ImpactSystem), and so is
/// what is put back. Only of joints whose loops would fill the factor too much is each body hit by itself, where it is
/// next to the surface, up to half a substep early or late.
class Impacts {
 public:
  /// The joints of a group.
  struct Joints {
    const SolveInput& input;
    const IslandGroup& group;
    const GroupBodies& numbers;
    const JoinedMotion* components;  ///< null without joints
    double start;                    ///< s into the step, of the substep
  };
  /// Starts a step, once blocks are prepared. `body_count` is 0 if nothing may bounce.
  void begin_step(std::size_t body_count, std::size_t block_count);
  /// Solves the impacts of a substep, after Kernels::find_approaches.
  void solve(const ContactKernelData& data, Friction friction, const Joints& joints);

  /// See jobs/arrays.h.
  auto arrays() const {
    return std::tie(bodies_, contacts_, number_, first_, lanes_, changed_, sets_, systems_, hit_systems_, hits_,
                    joined_);
  }

 private:
  static constexpr std::uint32_t none = ImpactBody::none;

  // A body that joints hold and something hits.
  struct JoinedHit {
    std::uint32_t system;
    double time;
    std::uint32_t local;

    auto operator<=>(const JoinedHit&) const = default;
  };

  void find_first(const ContactKernelData& data, const Joints& joints);
  void find_next(const ContactKernelData& data, const Joints& joints);
  void list_lanes(const ContactKernelData& data);
  void add_if_hit(const ContactKernelData& data, const Joints& joints, std::uint32_t number);
  void complete(const ContactKernelData& data, ImpactContact& contact);
  bool is_joined(const ImpactContact& contact) const {
    return bodies_[contact.first].is_joined() || bodies_[contact.second].is_joined();
  }
  void begin_systems(const ContactKernelData& data, const Joints& joints);
  bool begin_system(const ContactKernelData& data, const Joints& joints, std::uint32_t number, double time);
  void reflect_sets(Friction friction);
  std::uint32_t body_of(const ContactKernelData& data, const Joints& joints, std::uint32_t local);
  void gather_sets();
  void store(const ContactKernelData& data, const Joints& joints);

  std::size_t block_count_ = 0;
  std::vector<ImpactBody> bodies_;       // the bodies that impacts hit in this substep
  std::vector<ImpactContact> contacts_;  // of this round
  std::vector<std::uint32_t> number_;    // by local body: its place in bodies_, or none
  std::vector<std::uint32_t> first_;     // by local body: where its lanes begin in lanes_; empty until they are listed
  std::vector<std::uint32_t> lanes_;     // of contacts that bounce: block_lanes * block + lane
  std::vector<std::uint32_t> changed_;   // lanes of what the last round has changed
  std::vector<std::uint32_t> sets_;      // by place in bodies_: another of what it hits together with, or itself
  std::vector<ImpactSystem> systems_;    // by component
  std::vector<std::uint32_t> hit_systems_;  // in this substep
  std::vector<JoinedHit> hits_;             // of this round
  std::vector<std::uint32_t> joined_;       // systems of a set, or members of a system
};

}  // namespace atl::solver
