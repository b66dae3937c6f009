#include <jobs/task_order.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>

#include "arena_tbb.h"

namespace atl::jobs {

Arena::Arena(int threads) : threads_(threads), tbb_(std::make_unique<Tbb>(threads)) {
  // Only to raise the process's limit: the lowest of all such controls holds, for everybody's tasks.
  if (threads > tbb::info::default_concurrency()) {
    tbb_->allowed.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  }
}

Arena::~Arena() = default;

void Arena::run(Function function, const void* context, std::size_t count, std::size_t grain) {
  const auto run_task = [=](std::size_t chunk) {
    task_begins();
    function(context, chunk * grain, std::min(count, (chunk + 1) * grain));
    task_ends();
  };
  before_tasks();
  tbb_->arena.execute([&] { tbb::parallel_for(std::size_t{0}, chunk_count(count, grain), run_task); });
  after_tasks();
}

std::size_t worker_index() {
  return static_cast<std::size_t>(std::max(0, tbb::this_task_arena::current_thread_index()));
}

}  // namespace atl::jobs
