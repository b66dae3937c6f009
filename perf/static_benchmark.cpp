// The cost of a world of static boxes alone: adding them one by one, the first step and the second, the first ray (it
// has their tree built), and memory. The boxes are alike, of a thousand sizes, or each of a size of its own.

#include <atoll/atoll.h>
#include <benchmark/benchmark.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <fstream>

namespace {

enum Sizes { Alike, Thousand, AllDifferent };

double ms_of(const auto& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

// Memory of this process that is in use, by the kernel.
double resident_bytes() {
  std::ifstream file("/proc/self/statm");
  long all = 0, resident = 0;
  file >> all >> resident;
  return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE));
}

void add_boxes(atl::World& world, std::int64_t count, Sizes sizes) {
  constexpr std::int64_t side = 1000;
  for (std::int64_t i = 0; i < count; ++i) {
    const auto number = static_cast<double>(i);
    const double share = sizes == Alike ? 0 : sizes == Thousand ? static_cast<double>(i % 1000) / 1000 : number / 1e7;
    const auto x = static_cast<double>(i % side), y = static_cast<double>(i / side % side);
    world.add_body({.type = atl::BodyType::Static,
                    .shape = atl::Box{.half_extents = atl::Vector3::Constant(0.5 - 0.2 * share)},
                    .position = {1.5 * x, 1.5 * y, 1.5 * static_cast<double>(i / side / side)}});
  }
}

void static_boxes(benchmark::State& state) {
  const std::int64_t count = state.range(0);
  for (auto _ : state) {
    const double before = resident_bytes();
    atl::World world({.threads = static_cast<int>(state.range(1))});
    state.counters["add_ms"] = ms_of([&] { add_boxes(world, count, static_cast<Sizes>(state.range(2))); });
    state.counters["first_step_ms"] = ms_of([&] { world.step(1.0 / 60); });
    state.counters["second_step_ms"] = ms_of([&] { world.step(1.0 / 60); });
    state.counters["first_ray_ms"] = ms_of([&] {
      benchmark::DoNotOptimize(atl::Queries(world).cast_ray({.origin = {3, 3, 50}, .direction = {0, 0, -1}}));
    });
    std::size_t bytes = 0;
    for (const atl::MemoryUse& use : world.memory()) bytes += use.bytes;
    state.counters["bytes_a_body"] = static_cast<double>(bytes) / static_cast<double>(count);
    state.counters["resident_bytes_a_body"] = (resident_bytes() - before) / static_cast<double>(count);
  }
}

// The same under a thousand boxes that fall, whose first step has the tree built.
void boxes_on_static_boxes(benchmark::State& state) {
  for (auto _ : state) {
    atl::World world({.threads = static_cast<int>(state.range(1))});
    add_boxes(world, state.range(0), Alike);
    for (int i = 0; i < 1000; ++i) {
      world.add_body({.shape = atl::Box{}, .position = {1.5 * (i * 37 % 1000), 1.5 * (i * 11 % 1000), 1.2}});
    }
    state.counters["first_step_ms"] = ms_of([&] { world.step(1.0 / 60); });
    state.counters["second_step_ms"] = ms_of([&] { world.step(1.0 / 60); });
  }
}

constexpr std::int64_t million = 1'000'000;

BENCHMARK(static_boxes)
    ->ArgNames({"boxes", "threads", "sizes"})
    ->Args({million, 2, Alike})
    ->Args({million, 1, Alike})
    ->Args({million, 2, Thousand})
    ->Args({million, 2, AllDifferent})
    ->Unit(benchmark::kMillisecond)
    ->Iterations(1);
BENCHMARK(boxes_on_static_boxes)
    ->ArgNames({"boxes", "threads"})
    ->Args({million, 1})
    ->Args({million, 2})
    ->Unit(benchmark::kMillisecond)
    ->Iterations(1);

}  // namespace

BENCHMARK_MAIN();
