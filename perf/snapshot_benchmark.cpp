// The cost of saving and restoring 5,000 bodies that touch, awake and asleep (counters are bytes a body), and of going
// one step back and forth in a recording of 10,000 bodies (counters are the median and the worst, ms).

#include <atoll/atoll.h>
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

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

void record_times(benchmark::State& state, const char* name, std::vector<double> ms) {
  std::sort(ms.begin(), ms.end());
  state.counters[std::string(name) + "_median"] = ms[ms.size() / 2];
  state.counters[std::string(name) + "_worst"] = ms.back();
}

// All of a recording, once forwards and once backwards.
void play(benchmark::State& state) {
  const std::filesystem::path path = std::filesystem::temp_directory_path() / "atoll_snapshot_benchmark.rec";
  const atl::Scene scene = atl::load_scene("pile:bodies=10000");
  {
    atl::World world({.gravity = scene.gravity, .settings = scene.settings});
    world.record(path);
    atl::build_scene(scene, world);
    for (int i = 0; i < 600; ++i) world.step(scene.dt);
  }
  std::vector<double> on, back;
  const auto timed = [](std::vector<double>& ms, const auto& move) {
    const auto begin = std::chrono::steady_clock::now();
    move();
    ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
  };
  for (auto _ : state) {
    atl::Playback playback(path);
    for (bool more = true; more;) timed(on, [&] { more = playback.advance(); });
    while (playback.step() > 0) timed(back, [&] { playback.seek(playback.step() - 1); });
    for (const std::int64_t to : {333, 64, 512, 16}) {
      playback.seek(to);
      for (int i = 0; i < 16; ++i) timed(back, [&] { playback.seek(playback.step() - 1); });
    }
  }
  record_times(state, "on", on);
  record_times(state, "back", back);
  std::filesystem::remove(path);
}

BENCHMARK(play)->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK(save)->ArgNames({"scene", "asleep"})->ArgsProduct({{0, 1, 2}, {0, 1}})->Unit(benchmark::kMicrosecond);
BENCHMARK(restore)
    ->ArgNames({"scene", "asleep"})
    ->ArgsProduct({{0, 1, 2}, {0, 1}})
    ->Unit(benchmark::kMicrosecond)
    ->Iterations(20);

}  // namespace

BENCHMARK_MAIN();
