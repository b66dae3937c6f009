#pragma once

#include <atoll/error.h>

#include <atomic>
#include <new>
#include <string>
#include <thread>

namespace atl {

/// Knows which thread steps a world, so that a call from another one in the meantime is told instead of read from what
/// is half done. A flag and no lock: calls that begin at the very same time may both get through. And knows whether
/// memory ran out in the midst of a change.
class StepGuard {
 public:
  /// A step, on this thread, as long as this lives. Throws Error if there is one on another.
  class Step {
   public:
    Step(StepGuard& guard, const char* call) : guard_(guard) {
      std::thread::id nobody;
      if (!guard_.stepping_.compare_exchange_strong(nobody, std::this_thread::get_id())) guard_.refuse(call);
    }
    ~Step() { guard_.stepping_.store({}); }
    Step(const Step&) = delete;
    Step& operator=(const Step&) = delete;

   private:
    StepGuard& guard_;
  };

  /// Throws Error, naming the call, if another thread steps the world, or a change of it is half done.
  void check(const char* call, const char* of = "") const {
    check_thread(call, of);
    check_whole(call, of);
  }
  void check_thread(const char* call, const char* of = "") const {
    const std::thread::id stepping = stepping_.load(std::memory_order_relaxed);
    if (stepping != std::thread::id() && stepping != std::this_thread::get_id()) refuse(call, of);
  }
  void check_whole(const char* call, const char* of = "") const {
    if (!half_done_) return;
    throw Error(std::string(of) + call +
                ": memory ran out within an earlier call; expected the world to be restored, or destroyed");
  }

  /// Makes a change. If memory runs out within it, what is half done can't be undone without memory.
  template <typename Change>
  decltype(auto) change(const Change& make) {
    try {
      return make();
    } catch (const std::bad_alloc&) {
      half_done_ = true;
      throw;
    }
  }
  bool is_half_done() const { return half_done_; }
  void begin_anew() { half_done_ = false; }

 private:
  [[noreturn]] void refuse(const char* call, const char* of = "") const {
    throw Error(std::string(of) + call +
                ": found a step under way on another thread; expected one thread at a time to use a world");
  }

  std::atomic<std::thread::id> stepping_ = {};
  std::atomic<bool> half_done_ = false;
};

}  // namespace atl
