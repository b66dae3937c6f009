#pragma once

#include <atomic>
#include <chrono>
#include <mutex>

namespace atl::jobs {

/// Whether the machine has cores for helpers. Where others want them too, a helper is preempted in the midst of a loop,
/// which then waits for it, for as long as the others' time slices last. Once that was seen, the caller works alone for
/// a while, and for longer each time it is seen again soon after. Only times depend on it, no result.
class Congestion {
 public:
  using Clock = std::chrono::steady_clock;

  /// A helper that didn't run held a part of a loop, for longer than this: far longer than a part takes or a core needs
  /// to wake up, and shorter than a time slice (0.75 to 4 ms on Linux).
  static constexpr Clock::duration stall = std::chrono::microseconds(400);

  /// Never on unless it `watches`.
  explicit Congestion(bool watches) : watches_(watches) {}

  /// From any thread.
  void note_stall() {
    if (watches_) stalled_.store(true, std::memory_order_relaxed);
  }

  /// Whether to do without helpers now.
  bool is_on() {
    if (!stalled_.load(std::memory_order_relaxed) && !waits_.load(std::memory_order_relaxed)) return false;
    return is_on_at(Clock::now());
  }
  bool is_on_at(Clock::time_point now);

 private:
  const bool watches_;
  std::atomic<bool> stalled_ = false;  // since the last look
  std::atomic<bool> waits_ = false;    // `until_` counts
  std::mutex looking_;
  Clock::time_point until_ = {};
  Clock::duration pause_ = {};  // the last one, or the one that lasts
};

/// Finds out whether the thread that it is made on runs while it works on its parts of a loop.
class StallWatch {
 public:
  /// Loops are told apart by their numbers.
  explicit StallWatch(std::uint64_t loop);
  bool stalled() const;

 private:
  Congestion::Clock::time_point begun_;
};

}  // namespace atl::jobs
