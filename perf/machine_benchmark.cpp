/// Peak rates of this machine: the read bandwidth of each level of its memory, and arithmetic the way the kernels do it
/// (single precision, no fused multiply-add). They are the roofs to compare the times of the solver's phases with.

#include <benchmark/benchmark.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace {

// The compiler makes one of each for the vector widths of x86-64, and the program picks the best at run time.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define ATOLL_WIDEST __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define ATOLL_WIDEST
#endif

// Integers, so that the sum may be taken in any order.
ATOLL_WIDEST std::uint64_t sum(const std::uint64_t* values, std::size_t count) {
  std::uint64_t total = 0;
  for (std::size_t i = 0; i < count; ++i) total += values[i];
  return total;
}

// Each thread reads an array of its own.
void read(benchmark::State& state) {
  const auto bytes = static_cast<std::size_t>(state.range(0));
  const std::vector<std::uint64_t> values(bytes / sizeof(std::uint64_t), 1);
  for (auto _ : state) benchmark::DoNotOptimize(sum(values.data(), values.size()));
  state.SetBytesProcessed(static_cast<std::int64_t>(bytes) * state.iterations());
}

constexpr std::size_t chains = 128;  // enough vectors in flight to hide the latency of an operation

// One multiplication and one addition a chain and round.
ATOLL_WIDEST void multiply_and_add(std::array<float, chains>& values, float factor, float term, int rounds) {
  std::array<float, chains> v = values;
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i < chains; ++i) v[i] = v[i] * factor + term;
  }
  values = v;
}

void arithmetic(benchmark::State& state) {
  constexpr int rounds = 1000;
  std::array<float, chains> values = {};
  float factor = 0.5f;
  benchmark::DoNotOptimize(factor);
  for (auto _ : state) {
    multiply_and_add(values, factor, 1.0f, rounds);
    benchmark::DoNotOptimize(values);
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(2 * chains * rounds) * state.iterations());  // operations
}

// From the first-level cache to memory.
BENCHMARK(read)->RangeMultiplier(4)->Range(16 << 10, 256 << 20)->Threads(1)->Threads(2)->UseRealTime();
BENCHMARK(arithmetic)->Threads(1)->Threads(2)->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
