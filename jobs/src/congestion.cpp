#include <jobs/congestion.h>

#include <algorithm>
#include <ctime>

namespace atl::jobs {
namespace {

using Clock = Congestion::Clock;

// The first pause costs little where a stall was chance. The longest bounds how often a machine that stays busy is
// tried again, which takes some time slices each time: see "shared machines" in perf/README.md.
constexpr Clock::duration shortest_pause = std::chrono::milliseconds(40);
constexpr Clock::duration longest_pause = std::chrono::seconds(2);
constexpr int growth = 4;

// Times of a thread as it began to work on a loop.
struct ThreadTimes {
  std::uint64_t loop = 0;
  Clock::time_point wall;
  Clock::duration running;
};
thread_local ThreadTimes times_of_loop;

// The time for which this thread has had a core.
Clock::duration running_time() {
  std::timespec time = {};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

}  // namespace

bool Congestion::is_on_at(Clock::time_point now) {
  const std::lock_guard lock(looking_);
  if (stalled_.exchange(false, std::memory_order_relaxed) && now >= until_) {
    const bool soon = now < until_ + 4 * pause_;
    pause_ = soon ? std::min<Clock::duration>(growth * pause_, longest_pause) : shortest_pause;
    until_ = now + pause_;
    waits_.store(true, std::memory_order_relaxed);
  }
  const bool is_on = now < until_;
  if (!is_on) waits_.store(false, std::memory_order_relaxed);
  return is_on;
}

StallWatch::StallWatch(std::uint64_t loop) : begun_(Clock::now()) {
  if (times_of_loop.loop != loop) times_of_loop = {loop, begun_, running_time()};
}

bool StallWatch::stalled() const {
  const Clock::time_point now = Clock::now();
  if (now - begun_ < Congestion::stall) return false;
  return now - times_of_loop.wall - (running_time() - times_of_loop.running) > Congestion::stall;
}

}  // namespace atl::jobs
