// The cost of keeping a manifold: the contact update of a scene at rest, per pair.

#include <benchmark/benchmark.h>
#include <collision/contacts/update_contacts.h>
#include <solver/sweep/kernels.h>

#include <vector>

namespace {

using namespace atl::collision;

// Columns of unit cubes, each resting on the one below, which have sunk in by a tenth of a millimetre.
struct Columns {
  explicit Columns(int columns, int height) {
    for (int column = 0; column < columns; ++column) {
      for (int level = 0; level < height; ++level) {
        add({2.0 * (column % 64), 2.0 * (column / 64), 0.9999 * level}, level);
      }
    }
    dynamic.assign(colliders.size(), 1);
    turned.assign(colliders.size(), 0.0);
    reaches.assign(colliders.size(), StepReach{});
  }

  void add(const Vector3& position, int level) {
    const auto body = static_cast<std::uint32_t>(colliders.size());
    const Shape cube = Shape::box(Vector3::Constant(0.5));
    colliders.add(body, 0, cube, {Vector3::Zero(), Quaternion::Identity()});
    positions.insert(positions.end(), position.begin(), position.end());
    orientations.insert(orientations.end(), {0, 0, 0, 1});
    const Vector3 reach = Vector3::Constant(0.55);
    broadphase.add_box(body, Aabb::around(position - reach, position + reach), false);
    if (level == 0) return;
    const Pair pair{body - 1, body};
    cache.set_active(std::span(&body, 1), {});
    cache.add(std::span(&pair, 1),
              [](Pair p) { return ContactCache::Start{p.first, p.second, 0.6f, 0, 0.5f, false, 1}; });
  }

  ContactUpdateCounts update(const NarrowphaseKernels& kernels) {
    const PoseView poses{positions.data(), orientations.data()};
    update_contacts(cache, broadphase, {colliders, poses, dynamic, dynamic, turned, reaches, kernels}, arena, result);
    return result.counts;
  }

  ColliderTable colliders;
  std::vector<double> positions;
  std::vector<double> orientations;
  std::vector<std::uint8_t> dynamic;
  std::vector<double> turned;
  std::vector<StepReach> reaches;
  Broadphase broadphase;
  ContactCache cache;
  atl::jobs::Arena arena{1};
  ContactUpdate result;
};

void keep_manifolds(benchmark::State& state, const NarrowphaseKernels* kernels) {
  Columns scene(static_cast<int>(state.range(0)), 10);
  scene.update(*kernels);
  scene.broadphase.forget_moves();
  ContactUpdateCounts counts;
  for (auto _ : state) counts = scene.update(*kernels);
  const auto pairs = static_cast<double>(scene.cache.order().size());
  state.counters["recycled"] = static_cast<double>(counts.recycled) / pairs;
  state.counters["pair"] =
      benchmark::Counter(pairs, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

}  // namespace

int main(int argc, char** argv) {
  for (const atl::solver::Kernels* set : atl::solver::available_kernels()) {
    const std::string name = std::string("keep_manifolds/") + set->name;
    const NarrowphaseKernels* kernels = find_narrowphase_kernels(set->name);
    benchmark::RegisterBenchmark(name.c_str(), keep_manifolds, kernels)->Arg(100)->Arg(1200);
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
}
