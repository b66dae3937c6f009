#pragma once

#include <atoll/recording.h>
#include <atoll/report.h>
#include <atoll/settings.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace atl {

class World;

struct PlaybackOptions {
  int threads = 1;  ///< workers, in [1, 1024]
  Simd simd = Simd::Auto;
  /// What snapshots may take, bytes. Half of it is for key frames on the way, from which it goes back: every 8 steps, and
  /// half as many each time there is no more room. The other half is for the steps near where it stands, which another
  /// world makes. With 0 there is none, and going back makes all steps again.
  std::size_t key_frame_bytes = std::size_t{1} << 30;
};

/// A recording that is looked at step by step, forwards and backwards: its calls are made again in a world of its own.
/// Going back restores a snapshot, and makes the steps from there again, with the same bits. A step back takes about as
/// long as one on, a restore and a snapshot, as long as there is room for those of two intervals between key frames.
///
/// Throws Error as replay() does.
class Playback {
 public:
  /// Stands ahead of the first step, with all calls made that were made ahead of it.
  explicit Playback(const std::string& path, const PlaybackOptions& options = {});
  ~Playback();
  Playback(Playback&&) noexcept;
  Playback& operator=(Playback&&) noexcept;

  std::int64_t steps() const;  ///< in all of the recording
  std::int64_t step() const;   ///< how many were made of them to come to this state
  /// As it was after that step, ahead of what was then done to it. It is the same one all the time. What the step
  /// reported (forces, events) is empty after going back, until the next one.
  const World& world() const;

  /// Goes one step on. False, and nothing done, at the end.
  bool advance();
  /// Goes to the state after so many steps, in [0, steps()], else Error. Ends before where the replay has come to
  /// another state, in which the recorded calls can't be made.
  void seek(std::int64_t step);

  const StepReport& report() const;  ///< of the last step that was made
  double dt() const;                 ///< s, of that step
  /// Where the steps so far parted from what was recorded.
  const std::optional<ReplayDivergence>& divergence() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace atl
