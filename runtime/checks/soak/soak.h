#pragma once
/// A yard in which bodies and joints come and go for as long as one likes, held against a second world on the way.

#include <atoll/world.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace atl::soak {

struct SoakOptions {
  int threads = 1;         ///< of the first world; the second has another number
  std::uint64_t seed = 1;  ///< the same seed, the same calls
  /// An existing folder for recordings, which are removed when they are no longer needed; those of a fault stay there.
  std::filesystem::path folder = {};
  std::function<bool()> stop = {};  ///< asked between steps of replays, which are then given up
};

/// A body that went where nothing in the yard should send it.
struct LostBody {
  std::int64_t step = 0;  ///< of the soak, the first is 1
  BodyId id = {};
  std::string thing = {};          ///< what it was a part of
  std::string why = {};            ///< "its speed is above 1e6 m/s", "fell through the ground"
  std::string settings = {};       ///< that were in use, where they aren't the defaults
  std::string recording = {};      ///< name of the file that holds it, in SoakOptions::folder
  std::int64_t recorded_step = 0;  ///< after which step of that
};

struct SoakTally {
  std::int64_t steps = 0;            ///< of the first world, without those that were taken back
  std::int64_t came = 0, went = 0;   ///< things
  std::int64_t waiting = 0;          ///< things that found no room in the last step
  std::int64_t tied = 0, broke = 0;  ///< joints
  std::int64_t changes = 0;          ///< calls that changed what was there
  std::int64_t hash_checks = 0;      ///< of the two worlds' states against each other, and of rollbacks
  std::int64_t rollbacks = 0, replays = 0, queries = 0;
  std::int64_t quarantined = 0, fell_through = 0;  ///< bodies
  double fastest = 0;                              ///< m/s, that a body came to
  std::vector<LostBody> lost = {};                 ///< the first max_listed_bodies of these
};
inline constexpr std::size_t max_listed_bodies = 100;

/// A check that failed: what, in which step.
class CheckFailed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A recording that could not be written.
class RecordingFailed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Steps after which about as much memory is held as will be: every place in the population was taken eight times or
/// more, and all choices of settings have been in use eight times. Larger crowds still come by chance, but ever less
/// often: with seed 3 there were 43.7 MB after 7,760 steps, 45.5 after 13,165 and 47.3 after 16,500.
std::int64_t warm_up_steps();
/// A recording ends after as many: what memory is held then is held again and again.
std::int64_t segment_steps();

class Soak {
 public:
  /// Throws Error if there can't be so many threads, or no file in the folder.
  explicit Soak(const SoakOptions& options);
  ~Soak();
  Soak(const Soak&) = delete;
  Soak& operator=(const Soak&) = delete;

  /// All that happens ahead of a step, the step in both worlds, and what is checked after it. Throws CheckFailed
  /// and RecordingFailed.
  StepReport step();
  const SoakTally& tally() const;
  const World& world() const;   ///< the first
  const World& second() const;  ///< that gets the same calls

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace atl::soak
