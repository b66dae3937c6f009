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
  /// Memory for snapshots, bytes. Half of it is for key frames along the recording, from which it goes back: one every
  /// 8 steps, and half as many each time the room is used up. The other half is for the steps near the current one; a
  /// second world makes these. With 0 there are no snapshots, and going back repeats all steps.
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
  /// The world after the current step, before any later call was applied to it. It is the same object all the time. The
  /// step's reports (forces, events) are empty after going back, until the next step.
  const World& world() const;

  /// Goes one step on. False, and nothing done, at the end.
  bool advance();
  /// Goes to the state after so many steps, in [0, steps()], else Error. Ends before where the replay has come to
  /// another state, in which the recorded calls can't be made.
  void seek(std::int64_t step);

  const StepReport& report() const;  ///< of the last step that was made
  double dt() const;                 ///< s, of that step
  /// The point at which the steps so far diverged from the recording.
  const std::optional<ReplayDivergence>& divergence() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace atl
