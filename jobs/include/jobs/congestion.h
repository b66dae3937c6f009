#pragma once

#include <atomic>
#include <chrono>
#include <mutex>

namespace atl::jobs {

/// Decides whether loops may use helper threads, from how often helpers were preempted. Where other processes want the
/// same cores, a helper can lose its core in the midst of a loop, and the loop then waits for the others' time slices
/// to end. After such a stall the caller works alone for a while; the wait grows with each stall that follows soon
/// after the last. Only times depend on this, never a result.
class Congestion {
 public:
  using Clock = std::chrono::steady_clock;

  /// A helper that didn't run held a part of a loop, for longer than this: far longer than a part takes or a core needs
  /// to wake up, and shorter than a time slice (0.75 to 4 ms on Linux).
  static constexpr Clock::duration stall = std::chrono::microseconds(400);

  /// Never on unless it `watches`.
  explicit Congestion(bool watches) : watches_(watches) {}

  /// Records a stall. May be called from any thread.
  void record_stall() {
    if (watches_) stalled_.store(true, std::memory_order_relaxed);
  }

  /// True while loops should run without helpers.
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
