/// Wall time of World::step on each built-in scene, at one and two threads.
///
/// Each benchmark builds its scene anew, warms up and then times a fixed number of steps, so that two
/// versions of Atoll are timed on the same part of the same motion.

#include <atoll/atoll.h>
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace {

constexpr int warm_up_steps = 60;
constexpr int timed_steps = 240;

void step_scene(benchmark::State& state, const std::string& name, int threads) {
  const atl::Scene scene = atl::load_scene(name);
  atl::World world({.gravity = scene.gravity, .threads = threads, .settings = scene.settings});
  atl::build_scene(scene, world);
  for (int i = 0; i < warm_up_steps; ++i) world.step(scene.dt);

  std::vector<double> ms;
  ms.reserve(timed_steps);
  double total_ms = 0;
  std::int64_t points = 0;
  for (auto _ : state) {
    const atl::StepReport report = world.step(scene.dt);
    if (report.first_quarantined >= 0) {
      state.SkipWithError(("body " + std::to_string(report.first_quarantined) + " became non-finite").c_str());
      return;
    }
    ms.push_back(report.ms);
    total_ms += report.ms;
    points += report.counts.points;
  }

  const auto median = ms.begin() + static_cast<std::ptrdiff_t>(ms.size() / 2);
  std::nth_element(ms.begin(), median, ms.end());
  const auto dynamic_bodies = std::count_if(scene.bodies.begin(), scene.bodies.end(), [](const atl::SceneBody& body) {
    return body.def.type == atl::BodyType::Dynamic;
  });
  using benchmark::Counter;
  state.counters["median_s"] = 1e-3 * *median;
  state.counters["bodies/s"] = Counter(static_cast<double>(dynamic_bodies), Counter::kIsIterationInvariantRate);
  state.counters["points"] = static_cast<double>(points) / static_cast<double>(ms.size());
  if (points > 0) state.counters["s/point"] = 1e-3 * total_ms / static_cast<double>(points);
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  for (const atl::BuiltinScene& scene : atl::builtin_scenes()) {
    if (atl::load_scene(scene.name).closed_form) continue;  // a few bodies that move as a formula says
    for (const int threads : {1, 2}) {
      benchmark::RegisterBenchmark(("step/" + scene.name + "/threads:" + std::to_string(threads)).c_str(), step_scene,
                                   scene.name, threads)
          ->Iterations(timed_steps)
          ->Unit(benchmark::kMillisecond)
          ->MeasureProcessCPUTime()
          ->UseRealTime();
    }
  }
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}
