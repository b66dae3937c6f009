#include <jobs/assert.h>
#include <jobs/task_order.h>
#include <jobs/worker_team.h>

#include <thread>
#include <utility>

#include "arena_tbb.h"

#if defined(__x86_64__) || defined(__i386__)
#include <immintrin.h>
#endif

namespace atl::jobs {
namespace {

void pause() {
#if defined(__x86_64__) || defined(__i386__)
  _mm_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

// Spins for some microseconds, then lets other threads run: there may be more workers than cores.
class Backoff {
 public:
  // Lets other threads run, and returns for how long.
  Congestion::Clock::duration wait() {
    if (spins_ < 1000) {
      ++spins_;
      pause();
      return {};
    }
    const Congestion::Clock::time_point begun = Congestion::Clock::now();
    std::this_thread::yield();
    return Congestion::Clock::now() - begun;
  }

 private:
  int spins_ = 0;
};

constexpr std::uint32_t loop_of(std::uint64_t ticket) { return static_cast<std::uint32_t>(ticket >> 32); }
constexpr std::size_t taken_in_front(std::uint64_t ticket) { return ticket >> 16 & 0xffff; }
constexpr std::size_t taken_at_back(std::uint64_t ticket) { return ticket & 0xffff; }
constexpr std::uint64_t one_in_front = 1 << 16;
constexpr std::uint64_t one_at_back = 1;
constexpr std::uint64_t closed = 0xffff0000;  // more in front than any loop has: this one is over
constexpr std::size_t max_chunks = 0xfffe;

}  // namespace

WorkerTeam::WorkerTeam(Arena& arena) : arena_(arena), helpers_(arena.congestion_.is_on() ? 0 : arena.threads() - 1) {
  if (helpers_ == 0) return;
  arena_.tbb_->arena.execute([this] {
    for (int i = 0; i < helpers_; ++i) {
      // A task reads what it was made with as it begins, so it is made before its hand-over is told.
      tbb::task_handle helper = group_.defer([this] {
        task_begins();
        help();
        task_ends();
      });
      before_tasks();
      group_.run(std::move(helper));
    }
  });
}

WorkerTeam::~WorkerTeam() {
  if (helpers_ == 0) return;
  stop_.store(true, std::memory_order_release);
  arena_.tbb_->arena.execute([this] { group_.wait(); });
  after_tasks();
}

void WorkerTeam::run(Function function, const void* context, std::size_t count, std::size_t grain) {
  const std::uint32_t loop = loop_of(ticket_.load(std::memory_order_relaxed)) + 1;
  const std::uint64_t fresh_ticket = std::uint64_t{loop} << 32;
  // Loops of one team run one after the other, never within each other.
  ATL_ASSERT(loop == 1 || (ticket_.load(std::memory_order_relaxed) & closed) == closed, loop);
  grain = std::max(grain, Arena::chunk_count(count, max_chunks));
  const auto chunks = static_cast<std::uint32_t>(Arena::chunk_count(count, grain));
  ATL_ASSERT(chunks > 0 && chunks <= max_chunks, count, grain, chunks);
  // Whoever sees one of these sees the last ticket closed (acquire and release), and its claim fails.
  function_.store(function, std::memory_order_release);
  context_.store(context, std::memory_order_release);
  count_.store(count, std::memory_order_release);
  grain_.store(grain, std::memory_order_release);
  chunks_done_.store(0, std::memory_order_relaxed);
  ticket_.store(fresh_ticket, std::memory_order_release);

  while (take_chunk(loop, End::Front)) {
  }
  // A helper that holds a chunk and doesn't run is waited for until it has a core again.
  Backoff backoff;
  while (chunks_done_.load(std::memory_order_acquire) != chunks) {
    if (backoff.wait() > Congestion::stall) arena_.congestion_.record_stall();
  }
  // A helper may hold the last ticket still. Closing it makes its claim fail before the next loop is written.
  ticket_.store(fresh_ticket | closed, std::memory_order_relaxed);
}

// Claims one chunk of the given loop, from one end, and runs it. False when the loop has none left or is over.
bool WorkerTeam::take_chunk(std::uint32_t loop, End end) {
  std::uint64_t ticket = ticket_.load(std::memory_order_acquire);
  while (true) {
    if (loop_of(ticket) != loop) return false;
    const std::size_t count = count_.load(std::memory_order_acquire);
    const std::size_t grain = grain_.load(std::memory_order_acquire);
    const Function function = function_.load(std::memory_order_acquire);
    const void* context = context_.load(std::memory_order_acquire);
    const std::size_t chunks = Arena::chunk_count(count, grain);
    const std::size_t front = taken_in_front(ticket);
    const std::size_t back = taken_at_back(ticket);
    if (front + back >= chunks) return false;
    const std::size_t begin = (end == End::Front ? front : chunks - 1 - back) * grain;
    const std::uint64_t claimed = ticket + (end == End::Front ? one_in_front : one_at_back);
    // Success proves that the loop has not ended since the ticket was read, so what was read is its own.
    if (!ticket_.compare_exchange_weak(ticket, claimed, std::memory_order_acq_rel)) continue;
    ATL_ASSERT(begin < count, begin, count, grain);
    function(context, begin, std::min(count, begin + grain));
    chunks_done_.fetch_add(1, std::memory_order_release);
    return true;
  }
}

void WorkerTeam::help() {
  std::uint32_t finished = 0;
  Backoff backoff;
  while (!stop_.load(std::memory_order_acquire)) {
    const std::uint32_t loop = loop_of(ticket_.load(std::memory_order_acquire));
    if (loop == finished) {
      // Whoever gets the core for that long wants it for more than a breath.
      if (backoff.wait() > Congestion::stall) arena_.congestion_.record_stall();
      continue;
    }
    while (take_chunk(loop, End::Back)) {
    }
    finished = loop;
    backoff = {};
  }
}

}  // namespace atl::jobs
