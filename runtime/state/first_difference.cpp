// Finds the step at which two recordings diverge.

#include <atoll/error.h>
#include <atoll/first_difference.h>
#include <features/with_recording.h>

#include <algorithm>
#include <cstddef>
#include <vector>

#include "state/recorder.h"
#include "state/replay.h"
#include "world/left_out.h"
#include "world/world_impl.h"

namespace atl {
namespace {

// The state hash after each step, by the number of steps made: the last hash recorded before the next step, 0 if none.
std::vector<std::uint64_t> recorded_hashes(const std::string& path) {
  RecordingReader reader(path);
  std::vector<std::uint64_t> hashes(1, 0);
  while (reader.next()) {
    if (reader.kind() == RecordKind::Step) hashes.push_back(0);
    if (reader.kind() != RecordKind::Hash) continue;
    StateReader record(reader.content(), {"", "record", "World::record", true});
    record.value(hashes.back());
  }
  return hashes;
}

// At the state after so many steps.
void take_to(Replay& replay, const std::string& path, std::int64_t step) {
  while (replay.result().steps < step && replay.advance()) {
  }
  if (const auto& divergence = replay.result().divergence) {
    throw Error("find_first_difference: " + path + " comes to other states here than it holds, from step " +
                std::to_string(divergence->step) + " on; expected a recording that is replayed to the same bits");
  }
}

// The first of a step's results that differs. What differs in bodies alone is the solver's, or if it is none of their
// motion, of what ends the step.
Phase differing_phase(const StepReport& a, const StepReport& b, const std::vector<ReplayedBody>& bodies) {
  const auto differ = [&](auto... count) { return ((a.counts.*count != b.counts.*count) || ...); };
  using Counts = StepCounts;
  if (differ(&Counts::active_bodies)) return Phase::Plan;
  if (differ(&Counts::pairs, &Counts::aabb_updates, &Counts::filtered_pairs)) return Phase::FindPairs;
  if (differ(&Counts::contacts, &Counts::points, &Counts::recycled_manifolds, &Counts::recomputed_manifolds,
             &Counts::id_matches, &Counts::asked_contacts)) {
    return Phase::UpdateContacts;
  }
  if (differ(&Counts::islands, &Counts::joints, &Counts::groups)) return Phase::BuildIslands;
  if (differ(&Counts::swept, &Counts::stopped)) return Phase::SweepFastBodies;
  const bool motion = std::any_of(bodies.begin(), bodies.end(), [](const ReplayedBody& body) {
    return std::any_of(body.parts.begin(), body.parts.end(), [](const std::string& part) {
      return part == "pose" || part == "velocity" || part == "contacts" || part == "joints";
    });
  });
  return motion ? Phase::SolveIslands : Phase::Finish;
}

}  // namespace

FirstDifferenceResult find_first_difference(const std::string& first, const std::string& second,
                                            const FirstDifferenceOptions& options) {
  if constexpr (!with_recording) throw_left_out("find_first_difference is called", "recordings", "RECORDING");
  const std::vector<std::uint64_t> a = recorded_hashes(first), b = recorded_hashes(second);
  FirstDifferenceResult result{.steps = static_cast<std::int64_t>(std::min(a.size(), b.size())) - 1};
  // Ahead of the first step there may be a hash or none.
  const auto common = static_cast<std::ptrdiff_t>(result.steps) + 1;
  const auto parted = std::mismatch(a.begin() + 1, a.begin() + common, b.begin() + 1).first;
  if (parted == a.begin() + common) return result;

  FirstDifference difference{.step = parted - a.begin()};
  const ReplayOptions machine{.threads = options.threads, .simd = options.simd};
  Replay one(first, machine), other(second, machine);
  result.replays = 2;
  take_to(one, first, difference.step - 1);
  take_to(other, second, difference.step - 1);
  one.make_calls();
  other.make_calls();
  const auto compare = [&] { return differing_bodies(one.bodies(), other.bodies()); };
  difference.by_calls = one.world().state_hash() != other.world().state_hash();
  difference.bodies = compare();
  // If the bodies don't differ yet, the first later step after which some do gives the bodies and the phase.
  while (difference.bodies.empty() && one.advance() && other.advance()) {
    difference.bodies = compare();
    difference.phase = differing_phase(one.report(), other.report(), difference.bodies);
  }
  if (difference.bodies.empty()) {
    difference.phase.reset();
  } else {
    difference.bodies_step = std::max(difference.step, one.result().steps);
  }
  result.difference = std::move(difference);
  return result;
}

}  // namespace atl
