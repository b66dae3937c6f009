// What it costs to save and restore 5,000 bodies that touch, awake and asleep. Counters are bytes a body.

#include <atoll/atoll.h>
#include <benchmark/benchmark.h>

#include <string>

namespace {

constexpr const char* scenes[] = {"pile:bodies=5000", "islands:count=91,base=10", "pyramid3d:layers=24"};

atl::World make_world(benchmark::State& state, bool asleep) {
  const atl::Scene scene = atl::load_scene(scenes[state.range(0)]);
  state.SetLabel(scenes[state.range(0)]);
  atl::World world({.gravity = scene.gravity, .settings = {.sleeping = asleep, .sleep_speed = asleep ? 1.0 : 0.05}});
  atl::build_scene(scene, world);
  for (int i = 0; i < 240; ++i) world.step(scene.dt);
  return world;
}

void note(benchmark::State& state, const atl::Snapshot& snapshot, const atl::World& world) {
  state.counters["bytes_a_body"] = static_cast<double>(snapshot.size()) / static_cast<double>(world.body_count());
  state.counters["bodies"] = static_cast<double>(world.body_count());
}

void save(benchmark::State& state) {
  const atl::World world = make_world(state, state.range(1) != 0);
  atl::Snapshot snapshot;
  world.save(snapshot);
  for (auto _ : state) world.save(snapshot);
  note(state, snapshot, world);
}

// Back by ten steps, each time.
void restore(benchmark::State& state) {
  atl::World world = make_world(state, state.range(1) != 0);
  atl::Snapshot snapshot;
  world.save(snapshot);
  for (auto _ : state) {
    state.PauseTiming();
    for (int i = 0; i < 10; ++i) world.step(1.0 / 60);
    state.ResumeTiming();
    world.restore(snapshot);
  }
  note(state, snapshot, world);
}

BENCHMARK(save)->ArgNames({"scene", "asleep"})->ArgsProduct({{0, 1, 2}, {0, 1}})->Unit(benchmark::kMicrosecond);
BENCHMARK(restore)
    ->ArgNames({"scene", "asleep"})
    ->ArgsProduct({{0, 1, 2}, {0, 1}})
    ->Unit(benchmark::kMicrosecond)
    ->Iterations(20);

}  // namespace

BENCHMARK_MAIN();
