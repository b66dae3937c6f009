/// Time of the broadphase alone, as a world uses it: unit boxes at random, each of which overlaps 9.6 others on
/// average (48,000 pairs of 10,000), in a cube with walls that turn them round.
///
/// A step replaces the fat boxes that were outgrown, finds new pairs, and goes over all known ones to drop those
/// that parted. The times are of this thread's processor, so that other load on the machine matters less.

#include <benchmark/benchmark.h>
#include <collision/broadphase/broadphase.h>
#include <collision/broadphase/fat_box.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <random>
#include <vector>

namespace {

using namespace atl::collision;

double thread_ms() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

enum class Motion { None, Jitter, Straight };

class Cloud {
 public:
  Cloud(std::uint32_t count, Motion motion, double margin = 0.1)
      : motion_(motion),
        margin_(margin),
        side_(std::cbrt(count / boxes_per_volume)),
        positions_(count),
        displacements_(count) {
    for (std::uint32_t i = 0; i < count; ++i) {
      positions_[i] = side_ * Vector3(number(), number(), number());
      displacements_[i] = (motion == Motion::None ? 0 : step_length) * direction();
      broadphase_.add_box(i, fat(i), false);
    }
  }

  void move() {
    if (motion_ == Motion::None) return;
    for (std::size_t i = 0; i < positions_.size(); ++i) {
      if (motion_ == Motion::Jitter) displacements_[i] = step_length * direction();
      for (Eigen::Index k = 0; k < 3; ++k) {
        const double next = positions_[i][k] + displacements_[i][k];
        if (next < 0 || next > side_) displacements_[i][k] *= -1;
      }
      positions_[i] += displacements_[i];
    }
  }

  void step() {
    for (std::uint32_t i = 0; i < positions_.size(); ++i) {
      const Bounds tight = bounds(i);
      if (broadphase_.proxies().fat_box(i).contains(Aabb::around(tight.lower, tight.upper))) continue;
      broadphase_.move_box(i, fat(i));
      ++moves_;
    }
    find_pairs();
  }

  void find_pairs() {
    const std::span<const Pair> found = broadphase_.find_new_pairs(known_, arena_);
    std::size_t kept = 0;
    for (const Pair pair : pairs_) {
      const bool moved = broadphase_.has_moved(pair.first) || broadphase_.has_moved(pair.second);
      if (moved && !broadphase_.overlap(pair.first, pair.second)) {
        known_.erase(pair);
      } else {
        pairs_[kept++] = pair;
      }
    }
    pairs_.resize(kept);
    for (const Pair pair : found) {
      known_.insert(pair);
      pairs_.push_back(pair);
    }
    broadphase_.forget_moves();
  }

  Broadphase& broadphase() { return broadphase_; }
  std::size_t pairs() const { return pairs_.size(); }
  std::size_t moves() const { return moves_; }

 private:
  static constexpr double boxes_per_volume = 1.31;  // 47,700 pairs of 10,000 boxes, counted
  static constexpr double step_length = 0.05;

  double number() { return engine_() * 0x1p-32; }
  Vector3 direction() {
    while (true) {
      const Vector3 v(2 * number() - 1, 2 * number() - 1, 2 * number() - 1);
      if (v.squaredNorm() < 1 && v.squaredNorm() > 0.01) return v.normalized();
    }
  }
  Bounds bounds(std::uint32_t i) const {
    return {positions_[i] - Vector3::Constant(0.5), positions_[i] + Vector3::Constant(0.5)};
  }
  // Bodies that change direction in every step get no swept margin: their velocity doesn't predict where they go.
  Aabb fat(std::uint32_t i) const {
    return fattened(bounds(i), margin_, (motion_ == Motion::Straight ? 1 : 0) * displacements_[i]);
  }

  std::mt19937 engine_{1};
  Motion motion_;
  double margin_;  // m, on each side
  double side_;
  std::vector<Vector3> positions_, displacements_;
  Broadphase broadphase_;
  PairSet known_;
  std::vector<Pair> pairs_;
  atl::jobs::Arena arena_{1};
  std::size_t moves_ = 0;
};

void step(benchmark::State& state, Motion motion) {
  Cloud cloud(static_cast<std::uint32_t>(state.range(0)), motion, 0.01 * static_cast<double>(state.range(1)));
  cloud.find_pairs();
  for (int i = 0; i < 20; ++i) {
    cloud.move();
    cloud.step();
  }
  std::vector<double> ms;
  const std::size_t moves_before = cloud.moves();
  for (auto _ : state) {
    cloud.move();
    const double start = thread_ms();
    cloud.step();
    ms.push_back(thread_ms() - start);
    state.SetIterationTime(1e-3 * ms.back());
  }
  const auto steps = static_cast<double>(ms.size());
  std::sort(ms.begin(), ms.end());
  state.counters["median_ms"] = ms[ms.size() / 2];
  state.counters["mean_ms"] = std::accumulate(ms.begin(), ms.end(), 0.0) / steps;
  state.counters["max_ms"] = ms.back();
  state.counters["moves"] = static_cast<double>(cloud.moves() - moves_before) / steps;
  state.counters["fat_pairs"] = static_cast<double>(cloud.pairs());
}

// The cost of a step in which nothing moved, without the world's own checks of its bodies and contacts.
void find_pairs_at_rest(benchmark::State& state) {
  Cloud cloud(static_cast<std::uint32_t>(state.range(0)), Motion::None);
  cloud.find_pairs();
  const PairSet none;
  atl::jobs::Arena arena(1);
  for (auto _ : state) {
    benchmark::DoNotOptimize(cloud.broadphase().find_new_pairs(none, arena).size());
    cloud.broadphase().forget_moves();
  }
}

void find_all_pairs(benchmark::State& state) {
  for (auto _ : state) {
    Cloud cloud(static_cast<std::uint32_t>(state.range(0)), Motion::None);
    const double start = thread_ms();
    cloud.find_pairs();
    state.SetIterationTime(1e-3 * (thread_ms() - start));
  }
}

void sizes_and_margins(benchmark::internal::Benchmark* step_benchmark) {
  step_benchmark->ArgNames({"boxes", "margin%"})->ArgsProduct({{10'000, 100'000}, {5, 10, 15}});
  step_benchmark->Iterations(200)->UseManualTime()->Unit(benchmark::kMillisecond);
}

BENCHMARK_CAPTURE(step, jitter, Motion::Jitter)->Apply(sizes_and_margins);
BENCHMARK_CAPTURE(step, straight, Motion::Straight)->Apply(sizes_and_margins);
BENCHMARK(find_pairs_at_rest)->Arg(100'000);
BENCHMARK(find_all_pairs)->Arg(10'000)->Arg(100'000)->Iterations(5)->UseManualTime()->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
