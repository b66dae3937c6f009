#pragma once

#include <jobs/arena.h>
#include <tbb/task_group.h>

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace atl::jobs {

/// A fork-join team for a run of many short loops, as the colours of a large island: its helpers keep spinning
/// between two loops, so starting one costs a cache line's round trip and no task.
///
/// The caller takes part in every loop and can finish it alone, so it does not matter when (or whether)
/// helpers arrive, and any number of workers is safe on any number of cores. Idea: Box2D v3's solver stages.
class WorkerTeam {
 public:
  /// Starts up to arena.threads() - 1 helpers.
  explicit WorkerTeam(Arena& arena);
  /// Sends the helpers home.
  ~WorkerTeam();
  WorkerTeam(const WorkerTeam&) = delete;
  WorkerTeam& operator=(const WorkerTeam&) = delete;

  /// Runs body(begin, end) over chunks of `grain` of [0, count). Returns when all have run and their writes
  /// are visible. Loops too short to share run on the caller.
  template <typename Body>
  void parallel_for(std::size_t count, std::size_t grain, const Body& body) {
    if (helpers_ == 0 || count <= grain || is_congested()) {
      if (count > 0) body(std::size_t{0}, count);
      return;
    }
    run([](const void* context, std::size_t begin,
           std::size_t end) { (*static_cast<const Body*>(context))(begin, end); },
        &body, count, grain);
  }

 private:
  using Function = void (*)(const void* context, std::size_t begin, std::size_t end);

  enum class End { Front, Back };

  void run(Function function, const void* context, std::size_t count, std::size_t grain);
  bool is_congested() { return arena_.congestion_.is_on(); }
  void help();
  bool take_chunk(std::uint32_t loop, End end);

  Arena& arena_;
  int helpers_;
  tbb::task_group group_;

  // The loop in progress. Atomics, because a late helper may read them while the next loop is written; its
  // claim on the ticket then fails and it discards what it read.
  std::atomic<Function> function_{nullptr};
  std::atomic<const void*> context_{nullptr};
  std::atomic<std::size_t> count_{0};
  std::atomic<std::size_t> grain_{1};

  // Number of the loop (high half; 0 is none yet) and how many chunks are taken: in front (by the caller) and
  // at the back (by helpers), 16 bits each. Each end belongs to somebody, so that where one loop after another
  // runs over the same data, most of it stays in the same core's cache.
  alignas(64) std::atomic<std::uint64_t> ticket_{0};
  alignas(64) std::atomic<std::uint32_t> chunks_done_{0};
  alignas(64) std::atomic<bool> stop_{false};
};

}  // namespace atl::jobs
