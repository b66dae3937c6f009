/// Time of the narrowphase for one pair, by kinds of shapes: mean over a few hundred poses, always the same.
///
/// "resting" pairs lie on each other, tilted by up to a milliradian; "touching" ones overlap by half a
/// centimetre in random poses. Shapes are about a metre across and the margin is 2 cm. "anew" is a pair that comes to
/// meet, "kept" one whose last manifold is known, after a turn by a milliradian and a shift by a millimetre.
///
/// "mesh" is a million triangles with legs of half a metre on smooth hills, with 10 cm of noise; solids lie on it, all
/// over it, in random poses, and sink in by half a centimetre.

#include <benchmark/benchmark.h>
#include <collision/narrowphase/collide.h>
#include <collision/narrowphase/surface_contacts.h>
#include <collision/shapes/hull.h>
#include <collision/shapes/shape.h>
#include <collision/shapes/triangle_mesh.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <variant>
#include <vector>


namespace {

using namespace atl::collision;

constexpr int pose_count = 256;
constexpr double margin = 0.02;

class Random {
 public:
  double real(double lower, double upper) { return lower + (upper - lower) * (engine_() * 0x1p-32); }
  Vector3 direction() {
    const double z = real(-1, 1);
    const double angle = real(0, 2 * std::numbers::pi);
    const double r = std::sqrt(1 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
  }
  Quaternion rotation(double largest_angle) {
    return Quaternion(Eigen::AngleAxisd(real(-largest_angle, largest_angle), direction()));
  }

 private:
  std::mt19937 engine_{1};
};

struct Pair {
  Shape first, second;
  std::vector<Pose> poses;  // of the second in the frame of the first
};

// The second stands on top of the first, turned by `turn`, with its origin `height` above the other's.
Pair resting(const Shape& first, const Shape& second, const Quaternion& turn, double height) {
  Random random;
  Pair pair{first, second, {}};
  for (int i = 0; i < pose_count; ++i) {
    const Vector3 position(random.real(-0.2, 0.2), random.real(-0.2, 0.2), height + random.real(-2e-3, 2e-3));
    const Quaternion yaw(Eigen::AngleAxisd(random.real(-3, 3), Vector3::UnitZ()));
    pair.poses.push_back({position, (yaw * random.rotation(1e-3) * turn).normalized()});
  }
  if (second.kind < first.kind) {
    std::swap(pair.first, pair.second);
    for (Pose& pose : pair.poses) pose = relative(pose, {Vector3::Zero(), Quaternion::Identity()});
  }
  return pair;
}

Pair touching(const Shape& first, const Shape& second) {
  constexpr double overlap = 5e-3;
  Random random;
  std::vector<Vector3> axes;
  for (int i = 0; i < 500; ++i) axes.push_back(random.direction());
  Pair pair{first, second, {}};
  for (int i = 0; i < pose_count; ++i) {
    const Quaternion turn = random.rotation(std::numbers::pi);
    const Vector3 direction = random.direction();
    // Along each axis that leads away they part at some distance: the nearest parts them altogether.
    double distance = first.bounding_radius + second.bounding_radius;
    for (const Vector3& n : axes) {
      const double reach = reach_along(first, n) + reach_along(second, -(turn.conjugate() * n)) - overlap;
      const double along = n.dot(direction);
      if (along > 0) distance = std::min(distance, reach / along);
    }
    pair.poses.push_back({distance * direction, turn});
  }
  return pair;
}

void collide_pair(benchmark::State& state, const Pair& pair, bool kept) {
  std::vector<Manifold> last(pair.poses.size());
  std::vector<Pose> poses = pair.poses;
  if (kept) {
    Random random;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      Manifold found;
      collide(pair.first, pair.second, poses[i], margin, found);
      last[i] = as_last(found);
      poses[i].position += 1e-3 * random.direction();
      poses[i].orientation = (random.rotation(1e-3) * poses[i].orientation).normalized();
    }
  }
  std::int64_t points = 0;
  std::int64_t asked = 0;
  std::int64_t calls = 0;
  for (auto _ : state) {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      Manifold manifold = last[i];
      asked += asks_fcl(collide(pair.first, pair.second, poses[i], margin, manifold));
      points += manifold.count;
    }
    calls += pose_count;
  }
  using benchmark::Counter;
  state.counters["s/pair"] = Counter(static_cast<double>(calls), Counter::kIsRate | Counter::kInvert);
  state.counters["points"] = static_cast<double>(points) / static_cast<double>(calls);
  state.counters["fcl"] = static_cast<double>(asked) / static_cast<double>(calls);
}

Hull ball_of(int vertices) {
  Random random;
  std::vector<Vector3> points;
  for (int i = 0; i < vertices; ++i) points.push_back(0.5 * random.direction());
  return std::get<Hull>(build_hull(points));
}

TriangleMesh hills() {
  constexpr std::uint32_t corners = 708;
  Random random;
  std::vector<Vector3> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (std::uint32_t i = 0; i < corners * corners; ++i) {
    const double x = 0.5 * (i % corners);
    const double y = 0.5 * (i / corners);
    vertices.emplace_back(x, y, std::sin(x / 3) * std::cos(y / 4) + random.real(0, 0.1));
    if (i % corners + 1 == corners || i / corners + 1 == corners) continue;
    triangles.push_back({i, i + 1, i + corners + 1});
    triangles.push_back({i, i + corners + 1, i + corners});
  }
  return std::get<TriangleMesh>(build_triangle_mesh(vertices, triangles));
}

// With each lowered until it touches, and lifted by `above` (m).
void collide_mesh(benchmark::State& state, const Shape& solid, const TriangleMesh& mesh, double above) {
  const Shape surface = Shape::triangle_mesh(mesh);
  Random random;
  std::vector<Pose> poses;
  SurfaceManifolds found;
  for (int i = 0; i < pose_count; ++i) {
    Pose pose{{random.real(10, 340), random.real(10, 340), 3}, random.rotation(std::numbers::pi)};
    for (double step = 1; step > 1e-3; step /= 2) {
      for (int k = 0; k < 8; ++k) {
        collide_surface(solid, surface, pose, 0, found);
        if (found.count > 0) break;
        pose.position.z() -= step;
      }
      pose.position.z() += step;
    }
    pose.position.z() += above;
    poses.push_back(pose);
  }
  std::int64_t points = 0;
  std::int64_t calls = 0;
  for (auto _ : state) {
    for (const Pose& pose : poses) {
      collide_surface(solid, surface, pose, margin, found);
      for (int m = 0; m < found.count; ++m) points += found.manifolds[static_cast<std::size_t>(m)].count;
    }
    calls += pose_count;
  }
  using benchmark::Counter;
  state.counters["s/pair"] = Counter(static_cast<double>(calls), Counter::kIsRate | Counter::kInvert);
  state.counters["points"] = static_cast<double>(points) / static_cast<double>(calls);
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;

  const Hull ball = ball_of(20);
  const Hull ball32 = ball_of(32);
  const Hull cube = box_hull(Vector3::Constant(0.5));
  const Shape hull = Shape::convex_hull(ball);
  const Shape hull32 = Shape::convex_hull(ball32);
  const Shape box_as_hull = Shape::convex_hull(cube);
  const Shape box = Shape::box(Vector3::Constant(0.5));
  const Shape sphere = Shape::sphere(0.5);
  const Shape capsule = Shape::capsule(0.3, 0.4);
  const Shape cylinder = Shape::cylinder(0.3, 0.5);
  const Shape cone = Shape::cone(0.4, 0.5);
  const Quaternion upright = Quaternion::Identity();
  const Quaternion lying(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3::UnitY()));

  const std::pair<std::string, Pair> pairs[] = {
      {"box-box/resting", resting(box, box, upright, 1)},
      {"box-box/touching", touching(box, box)},
      {"box_as_hull-box_as_hull/resting", resting(box_as_hull, box_as_hull, upright, 1)},
      {"hull20-hull20/touching", touching(hull, hull)},
      {"hull32-hull32/touching", touching(hull32, hull32)},
      {"box-hull20/touching", touching(box, hull)},
      {"box-cylinder/standing", resting(box, cylinder, upright, 1)},
      {"box-cylinder/lying", resting(box, cylinder, lying, 0.8)},
      {"box-cylinder/touching", touching(box, cylinder)},
      {"cylinder-cylinder/standing", resting(cylinder, cylinder, upright, 1)},
      {"cylinder-cylinder/touching", touching(cylinder, cylinder)},
      {"box-cone/standing", resting(box, cone, upright, 1)},
      {"box-cone/touching", touching(box, cone)},
      {"capsule-box/lying", resting(box, capsule, lying, 0.8)},
      {"capsule-box/touching", touching(capsule, box)},
      {"capsule-hull20/touching", touching(capsule, hull)},
      {"capsule-capsule/touching", touching(capsule, capsule)},
      {"sphere-hull20/touching", touching(sphere, hull)},
      {"sphere-box/touching", touching(sphere, box)},
  };
  for (const auto& [name, pair] : pairs) {
    benchmark::RegisterBenchmark(("anew/" + name).c_str(), collide_pair, pair, false);
    benchmark::RegisterBenchmark(("kept/" + name).c_str(), collide_pair, pair, true);
  }
  const TriangleMesh mesh = hills();
  const std::pair<std::string, Shape> solids[] = {{"sphere", sphere},
                                                  {"box", box},
                                                  {"capsule", capsule},
                                                  {"cylinder", cylinder},
                                                  {"hull32", Shape::convex_hull(ball32)}};
  for (const auto& [name, solid] : solids) {
    benchmark::RegisterBenchmark(("collide/" + name + "-mesh/touching").c_str(), collide_mesh, solid, mesh, -5e-3);
    benchmark::RegisterBenchmark(("collide/" + name + "-mesh/above").c_str(), collide_mesh, solid, mesh, 0.1);
  }
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}
