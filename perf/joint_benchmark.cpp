// The cost of joints that are swept one after another: a net of balls that hangs by its corners, and a field of gates
// on hinges. Counters are the phases of the step and the step's time per joint and sweep.

#include <atoll/atoll.h>
#include <benchmark/benchmark.h>

#include <algorithm>
#include <vector>

namespace {

double median(std::vector<double>& values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

void run_steps(atl::World& world, benchmark::State& state) {
  for (int i = 0; i < 20; ++i) world.step(1.0 / 60);
  std::vector<double> whole;
  std::vector<double> solve;
  double sweeps = 0;
  for (auto _ : state) {
    const atl::StepReport report = world.step(1.0 / 60);
    whole.push_back(report.ms);
    solve.push_back(report.phase_ms[static_cast<std::size_t>(atl::Phase::SolveIslands)]);
    sweeps = static_cast<double>(report.counts.joints) * 8;  // 4 substeps of 2
  }
  state.counters["step_ms"] = median(whole);
  state.counters["solve_ms"] = median(solve);
  state.counters["ns_a_joint_and_sweep"] = 1e6 * median(solve) / sweeps;
}

void ball_joint_net(benchmark::State& state) {
  const auto size = static_cast<int>(state.range(0));
  atl::World world(
      {.threads = static_cast<int>(state.range(1)), .settings = {.joint_solver = atl::JointSolver::Iterative}});
  std::vector<atl::BodyId> balls;
  for (int i = 0; i < size * size; ++i) {
    const int x = i % size;
    const int y = i / size;
    const bool corner = (x == 0 || x == size - 1) && (y == 0 || y == size - 1);
    // The balls are too large for continuous collision to have anything to do.
    balls.push_back(world.add_body({.type = corner ? atl::BodyType::Static : atl::BodyType::Dynamic,
                                    .shape = atl::Sphere{0.3},
                                    .position = {1.0 * x, 1.0 * y, 0}}));
  }
  const auto join = [&](int a, int b, const atl::Vector3& half) {
    world.add_joint({.kind = atl::BallJoint{},
                     .first = balls[static_cast<std::size_t>(a)],
                     .second = balls[static_cast<std::size_t>(b)],
                     .frame_first = {.position = half},
                     .frame_second = {.position = -half}});
  };
  for (int i = 0; i < size * size; ++i) {
    if (i % size + 1 < size) join(i, i + 1, {0.5, 0, 0});
    if (i / size + 1 < size) join(i, i + size, {0, 0.5, 0});
  }
  run_steps(world, state);
}

void hinged_gates(benchmark::State& state) {
  const auto count = static_cast<int>(state.range(0));
  atl::World world(
      {.threads = static_cast<int>(state.range(1)), .settings = {.joint_solver = atl::JointSolver::Iterative}});
  const atl::BodyId ground =
      world.add_body({.type = atl::BodyType::Static, .shape = atl::Sphere{0.1}, .position = {0, 0, -100}});
  for (int i = 0; i < count; ++i) {
    const atl::Vector3 place(3.0 * (i % 100), 3.0 * (i / 100), 0);
    const atl::BodyId gate =
        world.add_body({.shape = atl::Box{{0.05, 0.5, 0.5}}, .position = place + atl::Vector3(0, 0.5, 0)});
    world.add_joint({.kind = atl::HingeJoint{.angle = {.range = {-1, 1}}},
                     .first = ground,
                     .second = gate,
                     .frame_first = {.position = place + atl::Vector3(0, 0, 100)},
                     .frame_second = {.position = {0, -0.5, 0}}});
  }
  run_steps(world, state);
}

BENCHMARK(ball_joint_net)
    ->ArgNames({"side", "threads"})
    ->Args({100, 1})
    ->Args({100, 2})
    ->Unit(benchmark::kMillisecond)
    ->Iterations(100);
BENCHMARK(hinged_gates)
    ->ArgNames({"gates", "threads"})
    ->Args({2000, 1})
    ->Args({2000, 2})
    ->Unit(benchmark::kMillisecond)
    ->Iterations(100);

}  // namespace

BENCHMARK_MAIN();
