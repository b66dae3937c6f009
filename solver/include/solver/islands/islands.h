#pragma once

#include <collision/contacts/touching_pair.h>
#include <jobs/arrays.h>
#include <jobs/compact_array.h>

#include <cstdint>
#include <span>
#include <vector>

namespace atl::solver {

using collision::TouchingPair;

/// A joint that acts, and its bodies.
struct JointLink {
  std::uint32_t first;
  std::uint32_t second;
  std::uint32_t joint;
};

/// The connected components of awake dynamic bodies under touching contacts and joints. Fixed and kinematic bodies join
/// nothing. Islands are in order of their lowest body; bodies and contacts within one in order of index and
/// of pair, so all order is a function of the contact graph alone.
class Islands {
 public:
  static constexpr std::uint32_t none = ~std::uint32_t{0};

  /// `awake[body]` is 1 for the bodies that take part, all of which are among `candidates`. Both these and `pairs` are
  /// in order, and each pair has an awake body. `links` are in order of joints; those without an awake body are left
  /// out. `ties` are more bodies that such joints hang together. The cost follows candidates, pairs, links and ties,
  /// however many bodies there are.
  void build(std::span<const std::uint32_t> candidates, std::span<const std::uint8_t> awake,
             std::span<const TouchingPair> pairs, std::span<const JointLink> links = {},
             std::span<const JointLink> ties = {});

  std::size_t count() const { return body_start_.empty() ? 0 : body_start_.size() - 1; }
  std::span<const std::uint32_t> bodies(std::size_t begin, std::size_t end) const;  ///< of islands [begin, end)
  std::span<const TouchingPair> contacts(std::size_t begin, std::size_t end) const;
  std::span<const JointLink> joints(std::size_t begin, std::size_t end) const;
  std::size_t body_count(std::size_t island) const { return body_start_[island + 1] - body_start_[island]; }
  std::size_t contact_count(std::size_t island) const { return contact_start_[island + 1] - contact_start_[island]; }
  std::size_t joint_count(std::size_t island) const { return joint_start_[island + 1] - joint_start_[island]; }

  /// The island of any body of the world; none if it is in no island.
  std::uint32_t island_of(std::uint32_t body) const { return body < island_of_.size() ? island_of_[body] : none; }
  /// Position of a body in the list of all islands' bodies. Valid for bodies of islands only.
  std::uint32_t rank(std::uint32_t body) const { return rank_[body]; }
  std::uint32_t first_rank(std::size_t island) const { return body_start_[island]; }

  /// Awake dynamic bodies that nothing touches or joins, in order.
  std::span<const std::uint32_t> free_bodies() const { return free_bodies_; }

  /// See jobs/arrays.h.
  auto arrays() const {
    return std::tie(rank_, island_of_, bodies_, body_start_, contacts_, contact_start_, joints_, joint_start_,
                    free_bodies_);
  }

 private:
  // Memory of a thread, while it builds.
  struct Memory {
    std::vector<std::uint32_t> parent;  // by body: union-find; a root is the lowest of its set; none if untouched
    std::vector<std::uint32_t> island_of_pair;
    std::vector<std::uint32_t> cursor;  // by island

    std::uint32_t find(std::uint32_t body);
    void join(std::span<const std::uint32_t> candidates, std::span<const std::uint8_t> awake,
              std::span<const TouchingPair> pairs, std::span<const JointLink> links, std::span<const JointLink> ties);
  };

  template <typename Pair>
  void sort_by_island(std::span<const Pair> pairs, Memory& memory, jobs::CompactArray<Pair>& sorted,
                      jobs::CompactArray<std::uint32_t>& start) const;
  void number(std::span<const std::uint32_t> candidates, std::span<const std::uint8_t> awake, Memory& memory);

  jobs::CompactArray<std::uint32_t> rank_;       // by body
  jobs::CompactArray<std::uint32_t> island_of_;  // by body; none if in no island
  jobs::CompactArray<std::uint32_t> bodies_, body_start_;
  jobs::CompactArray<TouchingPair> contacts_;
  jobs::CompactArray<std::uint32_t> contact_start_;
  jobs::CompactArray<JointLink> joints_;
  jobs::CompactArray<std::uint32_t> joint_start_;
  jobs::CompactArray<std::uint32_t> free_bodies_;
};

/// The structure of an island, so far as it decides how far its contacts may overlap under a load.
enum class Build : std::uint8_t {
  Any,
  /// Small and of so few contacts that it is little but columns (or arches): to solve it at once costs not much more
  /// than to sweep it.
  Columns,
  Joined,  ///< there are joints in it
};
Build build_of(const Islands& islands, std::size_t island);

/// Consecutive islands that are solved together: one task, sharing lanes.
struct IslandGroup {
  std::size_t begin;
  std::size_t end;
  bool large;  ///< a single island, worth all workers at once
};

/// Packs islands into groups whose working set stays in a core's cache, or gives each a group of its own. `group_keys`
/// by island, or empty: those with the same number may share a group, those with Islands::none share none.
void pack_groups(const Islands& islands, bool one_each, std::span<const std::uint32_t> group_keys,
                 std::vector<IslandGroup>& groups);

}  // namespace atl::solver
