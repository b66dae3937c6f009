#include <algorithm>

#include "builtin.h"
#include "loose_solids.h"

namespace atl::scene {
namespace hilly {

constexpr double cell = 0.5;   // m
constexpr double hills = 8;    // m, from crest to crest
constexpr double slope = 0.3;  // of all of it, down along x

// Smooth between random heights on a coarse grid, by cubic weights in both directions.
class Hills {
 public:
  Hills(Random& random, int count) : count_(count), heights_(static_cast<std::size_t>(count * count)) {
    for (double& height : heights_) height = random.uniform(0, 1.5);
  }
  double at(double x, double y) const {
    const int column = std::min(static_cast<int>(x), count_ - 2), row = std::min(static_cast<int>(y), count_ - 2);
    const auto smooth = [](double t) { return t * t * (3 - 2 * t); };
    const double u = smooth(x - column), v = smooth(y - row);
    const auto of = [&](int i, int j) { return heights_[static_cast<std::size_t>(j * count_ + i)]; };
    return (1 - v) * ((1 - u) * of(column, row) + u * of(column + 1, row)) +
           v * ((1 - u) * of(column, row + 1) + u * of(column + 1, row + 1));
  }

 private:
  int count_;
  std::vector<double> heights_;
};

TriangleMesh mesh(Random& random, int cells) {
  const int corners = cells + 1;
  const double half = 0.5 * cell * cells;
  const Hills shape(random, static_cast<int>(cell * cells / hills) + 2);
  std::vector<Vector3> vertices;
  for (int i = 0; i < corners * corners; ++i) {
    const double x = cell * (i % corners), y = cell * (i / corners);
    vertices.push_back(
        {x - half, y - half, shape.at(x / hills, y / hills) + 0.1 * random.uniform(0, 1) - slope * (x - half)});
  }
  std::vector<TriangleMesh::Indices> triangles;
  for (int row = 0; row < cells; ++row) {
    for (int column = 0; column < cells; ++column) {
      const auto a = static_cast<std::uint32_t>(row * corners + column);
      const auto above = a + static_cast<std::uint32_t>(corners);
      triangles.push_back({a, a + 1, above + 1});
      triangles.push_back({a, above + 1, above});
    }
  }
  return TriangleMesh(vertices, triangles);
}

// Twenty rocks around a middle one, as a burr.
Compound burr(Random& random) {
  Compound compound;
  compound.children.push_back({.shape = random_rock(random, 0.5, 12, 20)});
  for (int i = 1; i < 20; ++i) {
    const Vector3 out = random.rotation() * Vector3::UnitX();
    compound.children.push_back({.shape = random_rock(random, 0.3, 12, 20), .position = 0.6 * out});
  }
  return compound;
}

}  // namespace hilly

Scene build_terrain(const ParameterValues& values, std::uint64_t seed) {
  using namespace hilly;
  Scene scene = scene_on_ground(600, false);
  scene.bodies.front().def.position.z() = -50;
  Random random(seed);
  // Two triangles a cell.
  const int cells = std::max(8, static_cast<int>(std::sqrt(0.5 * values["triangles"])));
  scene.bodies.push_back(
      {.name = "terrain",
       .def = {.type = BodyType::Static, .shape = mesh(random, cells), .material = builtin_material}});
  constexpr int kinds = 10;
  std::vector<Compound> burrs;
  burrs.reserve(kinds);
  for (int i = 0; i < kinds; ++i) burrs.push_back(burr(random));
  const LoosePlaces places(3, 0.3 * cell * cells, 3);
  const Vector3 uphill(-0.15 * cell * cells, 0, 0);
  for (int i = 0; i < values.integer("bodies"); ++i) {
    SceneBody body = loose_solid("burr_" + std::to_string(i), burrs[static_cast<std::size_t>(i % kinds)],
                                 places[i] + uphill, random.rotation());
    body.def.position.z() -= slope * body.def.position.x();
    // One after the other: compilers evaluate the arguments of a call in orders of their own.
    const double across = random.uniform(-1, 1), down = random.uniform(0, 1);
    body.def.velocity = 5 * Vector3(down, across, 0);
    scene.bodies.push_back(body);
  }
  return scene;
}

}  // namespace atl::scene
