#pragma once

#include <atoll/error.h>

#include <atomic>
#include <string>
#include <thread>

namespace atl {

/// Knows which thread steps a world, so that a call from another one in the meantime is told instead of read from what
/// is half done. A flag and no lock: calls that begin at the very same time may both get through.
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

  /// Throws Error, naming the call, if another thread steps the world.
  void check(const char* call, const char* of = "") const {
    const std::thread::id stepping = stepping_.load(std::memory_order_relaxed);
    if (stepping != std::thread::id() && stepping != std::this_thread::get_id()) refuse(call, of);
  }

 private:
  [[noreturn]] void refuse(const char* call, const char* of = "") const {
    throw Error(std::string(of) + call +
                ": found a step under way on another thread; expected one thread at a time to use a world");
  }

  std::atomic<std::thread::id> stepping_ = {};
};

}  // namespace atl
