#pragma once

#include <collision/continuous/ccd_candidates.h>
#include <collision/continuous/ccd_culling.h>
#include <collision/shapes/function_ref.h>

#include <cstdint>
#include <span>
#include <vector>

namespace atl::collision {

/// The stop of a fast body, or of an assembly: how far it may go in the step.
struct CcdStop {
  std::span<const FastBody> bodies;  ///< the body, or the fast ones of its assembly
  double t = 1;                      ///< part of their motion
  Vector3 aside = Vector3::Zero();   ///< m, added to their ends
  bool undecided = false;            ///< on its way aside it may meet what nobody has decided about: see CcdStep

  bool stops() const { return t < 1 || !aside.isZero(0); }
};

/// A surface that a fast body's core touches as the step starts.
struct CcdSupport {
  Vector3 normal;    ///< unit, from the core to the surface
  double excess;     ///< m, how far the core ends beyond it
  double tolerance;  ///< m, it is to end before the surface by a part of this
};

/// Continuous collision: finds how far bodies that moved far in a step get until they first meet something in their
/// way, so that they can be put there and the next step finds the contact. A body whose core already touches something
/// slides along it. Only these bodies cost anything. Bodies connected by joints stop together, so that no joint is
/// torn.
///
/// Works in three stages: finds candidates near each fast body, culls those that a plane keeps apart, sweeps the rest.
class ContinuousCollision {
 public:
  explicit ContinuousCollision(int threads) : candidates_(threads), scratch_(threads) {}
  /// Makes it do for so many workers, if it is for fewer.
  void reach(int threads) {
    candidates_.reach(threads);
    scratch_.reach(threads);
  }

  /// The stops of all fast bodies and assemblies, in order, also of what goes all its way; valid until the next call.
  /// Fat AABBs of bodies that left theirs are moved to show where they went: they are to be moved again once bodies are
  /// put where they end. `step.places` is filled in here.
  std::span<const CcdStop> find_stops(CcdStep step, Broadphase& broadphase, jobs::Arena& arena);

 private:
  // Memory of a worker.
  struct Scratch {
    std::vector<CcdPair> pairs;  // of one body
    std::vector<Approach> approaching;
    std::vector<CcdSupport> supports;
    Vector3 carried = Vector3::Zero();  // m, by what is hit first, see way_carried()
  };

  static double first_hit(const CcdStep& step, const FastBody& fast, const Vector3& aside, double first,
                          Scratch& scratch);
  using ListPairs = FunctionRef<void(const FastBody&)>;
  static double meet(const CcdStep& step, const CcdStop& stop, const Vector3& aside, ListPairs list_pairs,
                     Scratch& scratch);
  static void go_on_with_walls(const CcdStep& step, CcdStop& stop, ListPairs list_pairs, Scratch& scratch);
  void list_groups(std::span<const FastBody> fast);
  // `decides` lets it ask about what it meets aside; else it may be left undecided.
  void find_stop(CcdStep& step, const Broadphase& broadphase, CcdStop& stop, Scratch& scratch, bool decides) const;

  std::vector<std::uint32_t> places_;  // by body, see CcdStep; all 0 between calls
  std::vector<CcdStop> stops_;         // in order of fast bodies
  CcdCandidates candidates_;
  jobs::Scratch<Scratch> scratch_;
};

}  // namespace atl::collision
