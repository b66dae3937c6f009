#pragma once

#include <atoll/joint.h>
#include <jobs/arrays.h>
#include <jobs/compact_array.h>
#include <jobs/pair_lists.h>
#include <solver/constraints/joint.h>

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

namespace atl {

/// s: how long the damped spring and servo of a row would take to their balance at the speed of now, where nothing
/// but their damping slows them. 0 where they have no stiffness or damping.
double creep_time(const solver::Law& law);

/// All joints of a world, one entry a joint's index: what the solver works on, and what users add to it.
struct JointTable {
  using Limits = std::array<std::int8_t, solver::max_joint_rows>;

  jobs::CompactArray<solver::Joint> joints;
  jobs::CompactArray<std::shared_ptr<const JointDef>> def;  ///< never null; worlds that are alike may share them
  jobs::CompactArray<std::uint32_t> generation;
  jobs::CompactArray<std::uint8_t> alive;
  jobs::CompactArray<std::uint8_t> enabled;
  jobs::CompactArray<std::uint8_t> broken;
  jobs::CompactArray<std::uint8_t> suspended;  ///< how many of its bodies are in quarantine
  jobs::CompactArray<std::uint8_t> acts;       ///< 1 for those that are there, enabled, not suspended, and have rows
  jobs::CompactArray<std::uint8_t> watched;    ///< 1 for those that may break, or reach the ends of a range
  jobs::CompactArray<std::uint8_t> driven;     ///< 1 for those that may move bodies however slowly: see creep_time()
  jobs::CompactArray<Limits> limit_before;     ///< that events have told of
  jobs::CompactArray<std::uint32_t> free;      ///< indices of removed joints; the last is used first
  std::size_t count = 0;                       ///< alive

  std::size_t size() const { return joints.size(); }
  /// Adds an enabled joint, and returns its index.
  std::uint32_t add(const JointDef& definition, const solver::Joint& joint);
  void remove(std::uint32_t joint);
  /// Leaves nothing of what a joint was where none is.
  void clear(std::uint32_t joint);
  /// Makes `acts` and the like follow a change of the others, also those of tendons over the joint.
  void update_flags(std::uint32_t joint);

  /// Makes room for so many joints, all of them absent.
  void reset(std::size_t joints);
  /// Makes all that is derived follow the joints that are there: flags, lists, and who is kept apart.
  void rebuild();

  /// Calls visit(joint) for the joints of a body, in no order to rely on.
  template <typename Visit>
  void for_each_of(std::uint32_t body, const Visit& visit) const {
    by_.body.for_each_of(body, visit);
  }

  /// Tendons over a joint that is none, in order.
  std::vector<std::uint32_t> tendons_over(std::uint32_t joint) const;

  /// Counts the joints that keep two bodies from touching. Whether the first came, or the last went.
  bool keep_apart(std::uint32_t a, std::uint32_t b);
  bool let_touch(std::uint32_t a, std::uint32_t b);
  /// Calls visit(a, b), a < b, for those pairs, in order.
  template <typename Visit>
  void for_each_kept_apart(const Visit& visit) const {
    for (const auto& [bodies, joints_of] : apart_) visit(bodies.first, bodies.second);
  }
  bool are_kept_apart(std::uint32_t a, std::uint32_t b) const { return apart_.contains(std::minmax(a, b)); }
  auto arrays() const {
    return std::tie(joints, def, generation, alive, enabled, broken, suspended, acts, watched, driven, limit_before,
                    free, by_.body, by_.tendons);
  }

 private:
  void resize(std::size_t joints);

  // A tendon is found by the joints of its terms.
  void link(std::uint32_t joint);
  void unlink(std::uint32_t joint);
  bool takes_part(std::uint32_t joint) const;

  // See WorldState::check_members().
  static void check_members(JointTable& table) {
    auto& [joints, def, generation, alive, enabled, broken, limit_before, free, /**/ suspended, acts, watched, driven,
           count, by, apart] = table;
    static_cast<void>(joints);
  }

  // Lists by which joints are found.
  struct Lists {
    jobs::PairLists body;
    jobs::CompactArray<std::uint32_t> tendons;  // alive, in order
  };

  Lists by_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> apart_;
};

}  // namespace atl
