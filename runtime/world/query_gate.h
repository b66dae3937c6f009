#pragma once

#include <collision/broadphase/broadphase.h>
#include <jobs/arena.h>

#include <atomic>
#include <mutex>

namespace atl {

/// Has what waits built into the broadphase's tree ahead of queries, once, whichever of several threads asks first.
class QueryGate {
 public:
  /// After a change of the broadphase, by the one who makes it.
  void note(const collision::Broadphase& broadphase) {
    if (broadphase.is_behind()) waits_.store(true, std::memory_order_relaxed);
  }
  void open(collision::Broadphase& broadphase, jobs::Arena& arena) {
    if (!waits_.load(std::memory_order_acquire)) return;
    const std::lock_guard lock(taking_in_);
    if (!waits_.load(std::memory_order_relaxed)) return;
    broadphase.take_in(arena);
    waits_.store(false, std::memory_order_release);
  }

 private:
  std::atomic<bool> waits_ = false;
  std::mutex taking_in_;
};

}  // namespace atl
