/// The cost of sharing a loop among the workers: a colour of a large island is one such loop.

#include <benchmark/benchmark.h>
#include <jobs/worker_team.h>

#include <atomic>
#include <cstddef>

namespace {

// Loops of so many chunks that do nothing.
void share_a_loop(benchmark::State& state) {
  atl::jobs::Arena arena(static_cast<int>(state.range(0)));
  const auto chunks = static_cast<std::size_t>(state.range(1));
  atl::jobs::WorkerTeam team(arena);
  for (auto _ : state) {
    team.parallel_for(chunks, 1, [](std::size_t begin, std::size_t) { benchmark::DoNotOptimize(begin); });
  }
  state.counters["s/loop"] =
      benchmark::Counter(1, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(share_a_loop)->ArgNames({"threads", "chunks"})->ArgsProduct({{1, 2}, {2, 8, 32}})->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
