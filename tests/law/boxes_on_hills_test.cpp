// Boxes that lie on hills of triangles cover ridges: where an edge of the hills is inside a box, no other face that the
// box touches frees it.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace atl::test::boxes_on_hills_test {
namespace {

constexpr int cells = 30;  // of 1 m, each way

double hills(double x, double y) {
  constexpr double turn = 2 * std::numbers::pi;
  const double rim = std::max(std::abs(x), std::abs(y)) / (cells / 2);
  return 0.8 * std::sin(turn * x / 17) * std::cos(turn * y / 21) + 0.4 * std::sin(turn * (x + 2 * y) / 31) +
         2 * std::pow(rim, 6);
}

Vector3 sample(int column, int row) {
  const double x = column - cells / 2, y = row - cells / 2;
  return {x, y, hills(x, y)};
}

TriangleMesh hill_mesh() {
  std::vector<Vector3> vertices;
  std::vector<TriangleMesh::Indices> triangles;
  for (int row = 0; row <= cells; ++row) {
    for (int column = 0; column <= cells; ++column) {
      vertices.push_back(sample(column, row));
      if (row == cells || column == cells) continue;
      const auto a = static_cast<std::uint32_t>(row * (cells + 1) + column), above = a + cells + 1;
      triangles.push_back({a, a + 1, above + 1});
      triangles.push_back({a, above + 1, above});
    }
  }
  return {vertices, triangles};
}

HeightField hill_field() {
  std::vector<double> heights;
  for (int row = 0; row <= cells; ++row) {
    for (int column = 0; column <= cells; ++column) heights.push_back(sample(column, row).z());
  }
  return {cells + 1, cells + 1, 1, 1, heights};
}

// m: how far the places of an edge are inside a box, at most.
double edge_inside(const Vector3& tail, const Vector3& head, const Vector3& half, const Pose& box) {
  double max = 0;
  for (int i = 0; i <= 64; ++i) {
    const Vector3 place = tail + (head - tail) * (i / 64.0);
    const Vector3 seen = box.orientation.conjugate() * (place - box.position);
    max = std::max(max, (half - seen.cwiseAbs()).minCoeff());
  }
  return max;
}

// The same of all edges of the hills.
double hills_inside(const Vector3& half, const Pose& box) {
  double max = 0;
  const int column = static_cast<int>(std::floor(box.position.x())) + cells / 2;
  const int row = static_cast<int>(std::floor(box.position.y())) + cells / 2;
  for (int j = std::max(0, row - 1); j <= std::min(cells - 1, row + 1); ++j) {
    for (int i = std::max(0, column - 1); i <= std::min(cells - 1, column + 1); ++i) {
      for (const auto& [across, along] : {std::pair(1, 0), std::pair(0, 1), std::pair(1, 1)}) {
        max = std::max(max, edge_inside(sample(i, j), sample(i + across, j + along), half, box));
      }
    }
  }
  return max;
}

class BoxesOnHills : public testing::TestWithParam<bool> {};

TEST_P(BoxesOnHills, LieOnTheRidgesToo) {
  World world;
  BodyDef ground{.type = BodyType::Static, .shape = hill_mesh()};
  if (GetParam()) {
    ground.shape = hill_field();
    ground.position = {-cells / 2, -cells / 2, 0};
  }
  world.add_body(ground);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> size(0.2, 0.4);
  std::normal_distribution<double> normal;
  std::vector<std::pair<BodyId, Vector3>> boxes;
  for (int i = 0; i < 256; ++i) {
    const double x = 1.5 * (i % 16) - 11.25, y = 1.5 * (i / 16) - 11.25;
    const Vector3 half(size(random), size(random), size(random));
    const Quaternion turn(normal(random), normal(random), normal(random), normal(random));
    boxes.emplace_back(
        world.add_body({.shape = Box{half}, .position = {x, y, hills(x, y) + 1.2}, .orientation = turn.normalized()}),
        half);
  }
  for (int i = 0; i < 360; ++i) world.step(1.0 / 60);
  for (const auto& [box, half] : boxes) {
    EXPECT_LT(hills_inside(half, world.pose(box)), 3e-3) << "of body " << box.index;
  }
}

INSTANTIATE_TEST_SUITE_P(On, BoxesOnHills, testing::Bool(),
                         [](const testing::TestParamInfo<bool>& of) { return of.param ? "AHeightField" : "AMesh"; });

}  // namespace
}  // namespace atl::test::boxes_on_hills_test
