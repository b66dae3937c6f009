#pragma once

#include <atoll/snapshot.h>

#include <filesystem>
#include <functional>
#include <optional>

#include "population.h"

namespace atl::soak {

inline constexpr double step_length = 1.0 / 60;  // s

/// Saves both worlds, goes on in one of them, with bodies that come and go there, and takes it back, again and again:
/// hashes tell whether it comes to what it came to. Leaves both worlds as they were. Throws CheckFailed.
class Rollback {
 public:
  explicit Rollback(Twin& twin) : twin_(twin) {}
  /// Returns how many steps the first world made.
  std::int64_t check(Random& random, SoakTally& tally);
  /// The same in a world that was empty, which goes on from there. `set_functions` gives it those of the others.
  void check_fresh(const std::function<void(World&)>& set_functions, SoakTally& tally);

 private:
  Twin& twin_;
  Snapshot snapshot_;  // keeps its memory
};

/// Rays, overlaps, shapes that are moved and closest points in both worlds: against each other, against other
/// questions of the same, and overlaps of balls with balls and boxes against their closed form. Throws CheckFailed.
void check_queries(Twin& twin, Random& random, SoakTally& tally);

/// Records the first world, in one file after another, and replays each as it ends. Throws CheckFailed.
class Recordings {
 public:
  Recordings(Twin& twin, std::filesystem::path folder, std::function<bool()> stop);
  ~Recordings();
  Recordings(const Recordings&) = delete;
  Recordings& operator=(const Recordings&) = delete;

  /// Ends the recording, replays it as the second world is run, and begins the next.
  void change_over(SoakTally& tally);
  /// The one that is under way is to stay; where and as of which step of it.
  void keep(LostBody& lost);
  /// Keeps the recording, too; returns "NAME, step N".
  std::string keep();
  void count_steps(std::int64_t count) { steps_ += count; }  ///< that the first world made

 private:
  void begin();
  void replay_last(std::uint64_t hash, SoakTally& tally) const;
  std::filesystem::path file() const;

  Twin& twin_;
  std::filesystem::path folder_;
  std::function<bool()> stop_;
  int number_ = 0;
  std::int64_t steps_ = 0;
  bool keep_ = false;
};

}  // namespace atl::soak
