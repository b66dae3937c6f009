/// Queries a second of a pile-like world: 4096 boxes, capsules and hulls close together over a height field.

#include <atoll/atoll.h>
#include <atoll/queries.h>
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace {

constexpr double half_width = 12;  // m, of the pile
constexpr std::size_t batch = 4096;

class Numbers {
 public:
  double in(double lower, double upper) { return lower + (upper - lower) * (engine_() * 0x1p-32); }
  atl::Vector3 within(double x, double y, double z) {
    const double a = in(-x, x);
    const double b = in(-y, y);
    return {a, b, in(-z, z)};
  }
  atl::Quaternion rotation() {
    const double w = in(-1, 1);
    const atl::Vector3 v = within(1, 1, 1);
    return atl::Quaternion(w, v.x(), v.y(), v.z()).normalized();
  }

 private:
  std::mt19937 engine_{1};
};

atl::World pile(int threads) {
  atl::World world({.threads = threads});
  Numbers numbers;
  std::vector<double> heights(65 * 65);
  for (double& height : heights) height = numbers.in(-0.5, 0);
  world.add_body(
      {.type = atl::BodyType::Static, .shape = atl::HeightField(65, 65, 0.5, 0.5, heights), .position = {-16, -16, 0}});
  std::vector<atl::Vector3> corners;
  for (int i = 0; i < 24; ++i) corners.push_back(0.45 * numbers.within(1, 1, 1).normalized());
  const atl::Shape shapes[] = {atl::Box{{0.4, 0.3, 0.3}}, atl::Capsule{0.25, 0.3}, atl::ConvexHull(corners)};
  for (int i = 0; i < 4096; ++i) {
    atl::BodyDef def{.shape = shapes[i % 3]};
    def.position = numbers.within(half_width, half_width, 3) + atl::Vector3(0, 0, 3.5);
    def.orientation = numbers.rotation();
    world.add_body(def);
  }
  return world;
}

// From above and from the sides to anywhere in the pile.
std::vector<atl::Ray> rays() {
  Numbers numbers;
  std::vector<atl::Ray> made(batch);
  for (std::size_t i = 0; i < batch; ++i) {
    const atl::Vector3 to = numbers.within(half_width, half_width, 3) + atl::Vector3(0, 0, 3.5);
    atl::Vector3 from = numbers.within(30, 30, 5) + atl::Vector3(0, 0, 15);
    made[i] = {.origin = from, .direction = to - from, .max_distance = 100};
  }
  return made;
}

void report(benchmark::State& state) {
  state.counters["queries/s"] =
      benchmark::Counter(static_cast<double>(batch), benchmark::Counter::kIsIterationInvariantRate);
}

void cast_rays(benchmark::State& state) {
  const atl::World world = pile(static_cast<int>(state.range(0)));
  const atl::Queries queries(world);
  const std::vector<atl::Ray> asked = rays();
  for (auto _ : state) benchmark::DoNotOptimize(queries.cast_rays(asked));
  report(state);
}

void are_blocked(benchmark::State& state) {
  const atl::World world = pile(static_cast<int>(state.range(0)));
  const atl::Queries queries(world);
  const std::vector<atl::Ray> asked = rays();
  for (auto _ : state) benchmark::DoNotOptimize(queries.are_blocked(asked));
  report(state);
}

void cast_shapes(benchmark::State& state) {
  const atl::World world = pile(static_cast<int>(state.range(0)));
  const atl::Queries queries(world);
  std::vector<atl::ShapeCast> asked;
  for (const atl::Ray& ray : rays()) {
    asked.push_back({.shape = atl::Sphere{0.2}, .position = ray.origin, .translation = ray.direction});
  }
  for (auto _ : state) benchmark::DoNotOptimize(queries.cast_shapes(asked));
  report(state);
}

std::vector<atl::QueryShape> places(bool points) {
  Numbers numbers;
  std::vector<atl::QueryShape> made(batch);
  for (atl::QueryShape& place : made) {
    place.position = numbers.within(half_width, half_width, 4) + atl::Vector3(0, 0, 4);
    if (!points) place.shape = atl::Box{{0.5, 0.5, 0.5}};
  }
  return made;
}

void overlapping(benchmark::State& state) {
  const atl::World world = pile(static_cast<int>(state.range(0)));
  const atl::Queries queries(world);
  const std::vector<atl::QueryShape> asked = places(false);
  for (auto _ : state) benchmark::DoNotOptimize(queries.overlapping(asked));
  report(state);
}

void closest_points(benchmark::State& state) {
  const atl::World world = pile(static_cast<int>(state.range(0)));
  const atl::Queries queries(world);
  const std::vector<atl::QueryShape> asked = places(true);
  for (auto _ : state) benchmark::DoNotOptimize(queries.closest_points(asked, 2));
  report(state);
}

BENCHMARK(cast_rays)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();
BENCHMARK(are_blocked)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();
BENCHMARK(cast_shapes)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();
BENCHMARK(overlapping)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();
BENCHMARK(closest_points)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
