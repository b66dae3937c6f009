#pragma once

#include <collision/continuous/fast_body.h>
#include <jobs/scratch.h>

#include <compare>
#include <cstdint>
#include <span>
#include <vector>

namespace atl::collision {

/// A collider of a fast body and one near it. In order, so that of several contacts of the two one that touches is
/// first.
struct CcdPair {
  std::uint32_t own;
  std::uint32_t other;
  bool apart;  ///< they have no contact with points

  auto operator<=>(const CcdPair&) const = default;
};

/// Finds the pairs for continuous collision: the shapes near each fast body. Shapes that touch a body's fat AABB
/// already form a pair with it, so the broadphase is asked only for the few bodies that left their fat AABB.
class CcdCandidates {
 public:
  explicit CcdCandidates(int threads) : scratch_(threads) {}
  /// Makes it do for so many workers, if it is for fewer.
  void reach(int threads) { scratch_.reach(threads); }

  /// Finds the candidates of all fast bodies. The fat AABBs of bodies that left theirs are replaced by ones that cover
  /// the motion. New pairs are put to step.decide, if set, which says which of them pass through each other.
  void find(CcdStep& step, Broadphase& broadphase, jobs::Arena& arena);

  /// Lists the shapes that a fast body may meet in the step, in order.
  void list(std::size_t fast, std::vector<CcdPair>& pairs) const;

 private:
  // A contact of fast bodies, by its entry in the order of contacts. Numbers + 1, or 0.
  struct FastContact {
    std::uint32_t entry;
    std::uint32_t fast_first;
    std::uint32_t fast_second;
  };
  // Something near a fast body, which goes by its number.
  struct Candidate {
    std::uint32_t fast;
    CcdPair pair;
  };
  // Memory of a worker.
  struct Scratch {
    std::vector<FastContact> contacts;
    std::vector<Candidate> candidates;
    std::vector<CcdPair> pairs;  // of one body
  };

  static void find_by_contacts(const CcdStep& step, std::size_t begin, std::size_t end, Scratch& scratch);
  static void find_by_tree(const CcdStep& step, std::uint32_t fast, const Broadphase& broadphase, Scratch& scratch);
  void decide(CcdStep& step);
  void sort_by_body(std::size_t fast_bodies);

  std::vector<CcdPair> pairs_;        // by fast body
  std::vector<std::uint32_t> begin_;  // by fast body, and the end
  jobs::Scratch<Scratch> scratch_;
};

/// Adds those of the pairs, as pairs of colliders, that have no contact: whether they may touch is to be decided.
void list_undecided(const CcdStep& step, std::span<const CcdPair> pairs, std::vector<Pair>& undecided);

/// Asks the broadphase for the shapes that a fast body may meet in the step if its end pose is shifted by `aside` (m).
/// The pairs are in order.
void query_candidates(const CcdStep& step, const FastBody& fast, const Vector3& aside, const Broadphase& broadphase,
                      std::vector<CcdPair>& pairs);

}  // namespace atl::collision
