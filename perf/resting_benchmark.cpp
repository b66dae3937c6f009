// The cost of a scene at rest: 100,000 boxes on the ground, all awake, all asleep, or all asleep except one. Counters
// are phases of the step.

#include <atoll/atoll.h>
#include <benchmark/benchmark.h>

#include <algorithm>
#include <vector>

namespace {

double median(std::vector<double>& values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

enum Rest { Awake, Asleep, AllButOneAsleep };

void resting_bodies(benchmark::State& state) {
  const auto rest = static_cast<Rest>(state.range(2));
  atl::World world({.threads = static_cast<int>(state.range(1)), .settings = {.sleeping = rest != Awake}});
  world.add_body({.type = atl::BodyType::Static, .shape = atl::HalfSpace{}});
  const auto count = static_cast<int>(state.range(0));
  atl::BodyId last = {};
  for (int i = 0; i < count; ++i) last = world.add_body({.position = {2.0 * (i % 400), 2.0 * (i / 400), 0.5}});
  for (int i = 0; i < 60; ++i) world.step(1.0 / 60);
  std::vector<double> whole;
  std::vector<double> find_pairs;
  std::vector<double> update_contacts;
  std::vector<double> build_islands;
  for (auto _ : state) {
    if (rest == AllButOneAsleep) world.wake(last);
    const atl::StepReport report = world.step(1.0 / 60);
    const auto phase = [&](atl::Phase which) { return report.phase_ms[static_cast<std::size_t>(which)]; };
    whole.push_back(report.ms);
    find_pairs.push_back(phase(atl::Phase::FindPairs));
    update_contacts.push_back(phase(atl::Phase::UpdateContacts));
    build_islands.push_back(phase(atl::Phase::BuildIslands));
  }
  state.counters["step_ms"] = median(whole);
  state.counters["find_pairs_ms"] = median(find_pairs);
  state.counters["update_contacts_ms"] = median(update_contacts);
  state.counters["build_islands_ms"] = median(build_islands);
}

BENCHMARK(resting_bodies)
    ->ArgNames({"bodies", "threads", "rest"})
    ->Args({100'000, 1, Awake})
    ->Args({100'000, 1, Asleep})
    ->Args({100'000, 1, AllButOneAsleep})
    ->Args({100'000, 2, Asleep})
    ->Unit(benchmark::kMillisecond)
    ->Iterations(50);

}  // namespace

BENCHMARK_MAIN();
