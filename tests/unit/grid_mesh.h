#pragma once

#include <collision/shapes/triangle_mesh.h>

#include <cstdint>
#include <functional>
#include <variant>
#include <vector>

namespace atl::test {

/// Cells over [-reach, reach]^2, at heights given by (x, y).
inline collision::TriangleMesh grid(int cells, double reach, const std::function<double(double, double)>& height) {
  std::vector<collision::Vector3> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  const auto row = static_cast<std::uint32_t>(cells + 1);
  for (int j = 0; j <= cells; ++j) {
    for (int i = 0; i <= cells; ++i) {
      const double x = reach * (2.0 * i / cells - 1);
      const double y = reach * (2.0 * j / cells - 1);
      vertices.emplace_back(x, y, height(x, y));
    }
  }
  for (std::uint32_t j = 0; j + 1 < row; ++j) {
    for (std::uint32_t i = 0; i + 1 < row; ++i) {
      const std::uint32_t a = j * row + i;
      triangles.push_back({a, a + 1, a + row + 1});
      triangles.push_back({a, a + row + 1, a + row});
    }
  }
  return std::get<collision::TriangleMesh>(collision::build_triangle_mesh(vertices, triangles));
}

}  // namespace atl::test
