#include <jobs/assert.h>
#include <jobs/task_order.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <cstdlib>
#include <optional>
#include <string_view>
#include <thread>

#include "arena_tbb.h"

namespace atl::jobs {
namespace {

// Loops of fewer may be over before a helper that runs finds one to take.
constexpr std::size_t few_chunks = 4;

bool may_be_dynamic() {
  static const char* const asked = std::getenv("ATOLL_DYNAMIC_THREADS");
  return asked == nullptr || std::string_view(asked) != "0";
}

}  // namespace

Arena::Arena(int threads, bool dynamic) : congestion_(dynamic && may_be_dynamic()) { set_threads(threads); }

void Arena::set_threads(int threads) {
  ATL_ASSERT(threads >= 1, threads);
  threads_ = threads;
  tbb_ = std::make_unique<Tbb>(threads);
  // Only to raise the process's limit: the lowest of all such controls holds, for everybody's tasks.
  if (threads > tbb::info::default_concurrency()) {
    tbb_->allowed.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  }
}

Arena::~Arena() = default;

void Arena::run(Function function, const void* context, std::size_t count, std::size_t grain) {
  static std::atomic<std::uint64_t> last_loop = 0;
  const std::uint64_t loop = ++last_loop;
  const std::thread::id caller = std::this_thread::get_id();
  const Congestion::Clock::time_point begun = Congestion::Clock::now();
  std::atomic<bool> helped = false;
  const auto run_task = [&](std::size_t chunk) {
    task_begins();
    std::optional<StallWatch> watch;
    if (std::this_thread::get_id() != caller) {
      helped.store(true, std::memory_order_relaxed);
      watch.emplace(loop);
    }
    function(context, chunk * grain, std::min(count, (chunk + 1) * grain));
    if (watch && watch->stalled()) congestion_.record_stall();
    task_ends();
  };
  before_tasks();
  const std::size_t chunks = chunk_count(count, grain);
  ATL_ASSERT(grain > 0 && chunks > 1, count, grain);
  tbb_->arena.execute([&] { tbb::parallel_for(std::size_t{0}, chunks, run_task); });
  after_tasks();
  // Helpers that never came had no core for that long.
  if (!helped && chunks >= few_chunks && Congestion::Clock::now() - begun > Congestion::stall)
    congestion_.record_stall();
}

std::size_t worker_index() {
  return static_cast<std::size_t>(std::max(0, tbb::this_task_arena::current_thread_index()));
}

}  // namespace atl::jobs
