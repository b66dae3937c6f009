#include <jobs/task_order.h>
#include <jobs/worker_team.h>

#include <thread>

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
  void wait() {
    if (++spins_ < 1000) {
      pause();
    } else {
      std::this_thread::yield();
    }
  }

 private:
  int spins_ = 0;
};

constexpr std::uint32_t loop_of(std::uint64_t ticket) { return static_cast<std::uint32_t>(ticket >> 32); }
constexpr std::uint32_t chunk_of(std::uint64_t ticket) { return static_cast<std::uint32_t>(ticket); }
constexpr std::uint32_t closed = 0xffffffff;  // in place of a chunk: this loop is over
constexpr std::uint64_t make_ticket(std::uint32_t loop, std::uint32_t chunk) {
  return std::uint64_t{loop} << 32 | chunk;
}

}  // namespace

WorkerTeam::WorkerTeam(Arena& arena) : arena_(arena), helpers_(arena.threads() - 1) {
  if (helpers_ == 0) return;
  before_tasks();
  arena_.tbb_arena().execute([this] {
    for (int i = 0; i < helpers_; ++i) {
      group_.run([this] {
        task_begins();
        help();
        task_ends();
      });
    }
  });
}

WorkerTeam::~WorkerTeam() {
  if (helpers_ == 0) return;
  stop_.store(true, std::memory_order_release);
  arena_.tbb_arena().execute([this] { group_.wait(); });
  after_tasks();
}

void WorkerTeam::run(Function function, const void* context, std::size_t count, std::size_t grain) {
  const std::uint32_t loop = loop_of(ticket_.load(std::memory_order_relaxed)) + 1;
  const auto chunks = static_cast<std::uint32_t>(Arena::chunk_count(count, grain));
  // Whoever sees one of these sees the last ticket closed (acquire and release), and its claim fails.
  function_.store(function, std::memory_order_release);
  context_.store(context, std::memory_order_release);
  count_.store(count, std::memory_order_release);
  grain_.store(grain, std::memory_order_release);
  chunks_done_.store(0, std::memory_order_relaxed);
  ticket_.store(make_ticket(loop, 0), std::memory_order_release);

  while (take_chunk(loop)) {
  }
  Backoff backoff;
  while (chunks_done_.load(std::memory_order_acquire) != chunks) backoff.wait();
  // A helper may hold the last ticket still. Closing it makes its claim fail before the next loop is written.
  ticket_.store(make_ticket(loop, closed), std::memory_order_relaxed);
}

// Claims one chunk of the given loop and runs it. False when the loop has none left or is over.
bool WorkerTeam::take_chunk(std::uint32_t loop) {
  std::uint64_t ticket = ticket_.load(std::memory_order_acquire);
  while (true) {
    if (loop_of(ticket) != loop || chunk_of(ticket) == closed) return false;
    const std::size_t count = count_.load(std::memory_order_acquire);
    const std::size_t grain = grain_.load(std::memory_order_acquire);
    const Function function = function_.load(std::memory_order_acquire);
    const void* context = context_.load(std::memory_order_acquire);
    const std::size_t begin = chunk_of(ticket) * grain;
    if (begin >= count) return false;
    // Success proves that the loop has not ended since the ticket was read, so what was read is its own.
    if (!ticket_.compare_exchange_weak(ticket, ticket + 1, std::memory_order_acq_rel)) continue;
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
      backoff.wait();
      continue;
    }
    while (take_chunk(loop)) {
    }
    finished = loop;
    backoff = {};
  }
}

}  // namespace atl::jobs
