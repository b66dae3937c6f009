#pragma once

#include <jobs/task_order.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstddef>
#include <optional>

namespace atl::jobs {

/// The workers of one world. Loops are cut into chunks of `grain` indices whatever the number of workers, so
/// a body that writes only to its own indices (or to its chunk's slot) gives the same bits on any of them.
class Arena {
 public:
  /// threads >= 1, the calling thread among them. More threads than cores is allowed.
  explicit Arena(int threads) : threads_(threads), arena_(threads) {
    // Only to raise the process's limit: the lowest of all such controls holds, for everybody's tasks.
    if (threads > tbb::info::default_concurrency()) {
      allowed_.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    }
  }

  int threads() const { return threads_; }

  /// Runs body(begin, end) over the chunks of [0, count). Returns when all have run.
  template <typename Body>
  void parallel_for(std::size_t count, std::size_t grain, const Body& body) {
    const std::size_t chunks = chunk_count(count, grain);
    const auto run_chunk = [&](std::size_t chunk) { body(chunk * grain, std::min(count, (chunk + 1) * grain)); };
    if (threads_ == 1 || chunks <= 1) {
      for (std::size_t chunk = 0; chunk < chunks; ++chunk) run_chunk(chunk);
    } else {
      const auto run_task = [&](std::size_t chunk) {
        task_begins();
        run_chunk(chunk);
        task_ends();
      };
      before_tasks();
      arena_.execute([&] { tbb::parallel_for(std::size_t{0}, chunks, run_task); });
      after_tasks();
    }
  }

  static std::size_t chunk_count(std::size_t count, std::size_t grain) { return (count + grain - 1) / grain; }

  tbb::task_arena& tbb_arena() { return arena_; }

 private:
  int threads_;
  tbb::task_arena arena_;
  std::optional<tbb::global_control> allowed_;
};

}  // namespace atl::jobs
