// What a scene at rest costs: 100,000 boxes on the ground, awake or asleep. Counters are phases of the step.

#include <atoll/atoll.h>
#include <benchmark/benchmark.h>

#include <algorithm>
#include <vector>

namespace {

double median(std::vector<double>& values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

void resting_bodies(benchmark::State& state) {
  atl::World world({.threads = static_cast<int>(state.range(1)), .settings = {.sleeping = state.range(2) != 0}});
  world.add_body({.type = atl::BodyType::Static, .shape = atl::HalfSpace{}});
  const auto count = static_cast<int>(state.range(0));
  for (int i = 0; i < count; ++i) world.add_body({.position = {2.0 * (i % 400), 2.0 * (i / 400), 0.5}});
  for (int i = 0; i < 60; ++i) world.step(1.0 / 60);
  std::vector<double> find_pairs;
  std::vector<double> update_contacts;
  for (auto _ : state) {
    const atl::StepReport report = world.step(1.0 / 60);
    find_pairs.push_back(report.phase_ms[static_cast<std::size_t>(atl::Phase::FindPairs)]);
    update_contacts.push_back(report.phase_ms[static_cast<std::size_t>(atl::Phase::UpdateContacts)]);
  }
  state.counters["find_pairs_ms"] = median(find_pairs);
  state.counters["update_contacts_ms"] = median(update_contacts);
}

BENCHMARK(resting_bodies)
    ->ArgNames({"bodies", "threads", "sleeping"})
    ->Args({100'000, 1, 0})
    ->Args({100'000, 1, 1})
    ->Unit(benchmark::kMillisecond)
    ->Iterations(50);

}  // namespace

BENCHMARK_MAIN();
