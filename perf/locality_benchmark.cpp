// Measures whether one body with a special need slows down all others: 10,000 boxes rest in stacks of two to five,
// alone or beside one island whose body bounces, is fast, tumbles or is joined. The step should take longer only by the
// cost of that island.

#include <atoll/atoll.h>
#include <benchmark/benchmark.h>

#include <algorithm>
#include <vector>

namespace {

enum Guest { None, Plain, Bouncy, Fast, Tumbling, Jointed };

// Stacks of two, three, four and five, and again.
void add_stacks(atl::World& world, int boxes) {
  int stack = 0;
  for (int left = boxes; left > 0; ++stack) {
    const int height = std::min(left, 2 + stack % 4);
    for (int level = 0; level < height; ++level) {
      world.add_body({.position = {2.0 * (stack % 60), 2.0 * (stack / 60), 0.5 + level}});
    }
    left -= height;
  }
}

void add_guest(atl::World& world, Guest guest) {
  if (guest == None) return;
  const atl::Vector3 place(-10, -10, 0.5);
  atl::BodyDef def{.position = place};
  if (guest == Bouncy) def.material.restitution = 0.5;
  if (guest == Fast || guest == Tumbling) def.material.friction = 0;
  if (guest == Fast) {
    def.continuous = true;
    def.velocity = {-1, 0, 0};
  }
  if (guest == Tumbling) {
    def.shape = atl::Box{.half_extents = {0.5, 0.4, 0.5}};
    def.angular_velocity = {0, 0, 3};
  }
  const atl::BodyId body = world.add_body(def);
  if (guest != Jointed) return;
  const atl::BodyId other = world.add_body({.position = place - atl::Vector3(2, 0, 0)});
  world.add_joint({.first = body, .second = other, .frame_first = {{-1, 0, 0}}, .frame_second = {{1, 0, 0}}});
}

void guest(benchmark::State& state) {
  atl::World world;
  world.add_body({.type = atl::BodyType::Static, .shape = atl::HalfSpace{}});
  add_stacks(world, 10'000);
  add_guest(world, static_cast<Guest>(state.range(0)));
  for (int i = 0; i < 60; ++i) world.step(1.0 / 60);
  std::vector<double> ms;
  for (auto _ : state) ms.push_back(world.step(1.0 / 60).ms);
  const auto median = ms.begin() + static_cast<std::ptrdiff_t>(ms.size() / 2);
  std::nth_element(ms.begin(), median, ms.end());
  state.counters["median_ms"] = *median;
}

BENCHMARK(guest)
    ->ArgName("guest")
    ->Arg(None)
    ->Arg(Plain)
    ->Arg(Bouncy)
    ->Arg(Fast)
    ->Arg(Tumbling)
    ->Arg(Jointed)
    ->Unit(benchmark::kMillisecond)
    ->Iterations(200);

}  // namespace

BENCHMARK_MAIN();
