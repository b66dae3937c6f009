#pragma once

#include <jobs/congestion.h>

#include <algorithm>
#include <cstddef>
#include <memory>

namespace atl::jobs {

/// The workers of one world. Loops are cut into chunks of `grain` indices whatever the number of workers, so
/// a body that writes only to its own indices (or to its chunk's slot) gives the same bits on any of them.
class Arena {
 public:
  /// threads >= 1, the calling thread among them. More threads than cores is allowed. Where they are `dynamic`, loops
  /// are run by the caller alone while others take the cores: see Congestion. The environment's
  /// ATOLL_DYNAMIC_THREADS=0, as of tests, has none be.
  explicit Arena(int threads, bool dynamic = true);
  ~Arena();
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;

  int threads() const { return threads_; }
  /// Not while a loop runs.
  void set_threads(int threads);

  /// Runs body(begin, end) over the chunks of [0, count). Returns when all have run.
  template <typename Body>
  void parallel_for(std::size_t count, std::size_t grain, const Body& body) {
    if (threads_ == 1 || count <= grain || congestion_.is_on()) {
      for (std::size_t begin = 0; begin < count; begin += grain) body(begin, std::min(count, begin + grain));
      return;
    }
    run([](const void* context, std::size_t begin,
           std::size_t end) { (*static_cast<const Body*>(context))(begin, end); },
        &body, count, grain);
  }

  static std::size_t chunk_count(std::size_t count, std::size_t grain) { return (count + grain - 1) / grain; }

 private:
  friend class WorkerTeam;
  using Function = void (*)(const void* context, std::size_t begin, std::size_t end);
  struct Tbb;  // kept out of this header, which nearly every file includes

  void run(Function function, const void* context, std::size_t count, std::size_t grain);

  int threads_ = 0;
  Congestion congestion_;
  std::unique_ptr<Tbb> tbb_;
};

/// The number of the calling worker inside a loop of an arena, from 0; 0 outside.
std::size_t worker_index();

}  // namespace atl::jobs
