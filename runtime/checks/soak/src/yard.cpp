#include "yard.h"

#include <array>
#include <utility>

namespace atl::soak {
namespace {

constexpr int half_cells = 20;  // of 1 m, from the middle to the edge
constexpr double hill = 0.5;    // m
constexpr double wall_at = 18;  // m from the middle
constexpr double drop = 6;      // m over the ground that things come from
constexpr int places_a_row = 7;
constexpr double place_pitch = 4.6;  // m; nothing that comes is wider than 2.4 m

// Height of a grid point. Along x = 0, where the two grounds meet, and outside the walls the ground is level.
double height_at(Random& random, int column) { return column == 0 ? 0 : random.uniform(0, hill); }

BodyDef western_hills(Random& random) {
  std::vector<double> heights;
  for (int row = 0; row <= 2 * half_cells; ++row) {
    for (int column = half_cells; column >= 0; --column) heights.push_back(height_at(random, column));
  }
  return {.type = BodyType::Static,
          .shape = HeightField(half_cells + 1, 2 * half_cells + 1, 1, 1, std::move(heights)),
          .position = {-half_cells, -half_cells, 0},
          .name = "western hills"};
}

BodyDef eastern_hills(Random& random) {
  std::vector<Vector3> vertices;
  std::vector<TriangleMesh::Indices> triangles;
  constexpr std::uint32_t columns = half_cells + 1;
  for (int row = 0; row <= 2 * half_cells; ++row) {
    for (int column = 0; column <= half_cells; ++column) {
      vertices.emplace_back(column, row - half_cells, height_at(random, column));
      if (row == 0 || column == 0) continue;
      const auto here = static_cast<std::uint32_t>(vertices.size()) - 1;
      const std::uint32_t left = here - 1, below = here - columns;
      triangles.push_back({below - 1, below, here});
      triangles.push_back({below - 1, here, left});
    }
  }
  return {.type = BodyType::Static, .shape = TriangleMesh(vertices, triangles), .name = "eastern hills"};
}

}  // namespace

std::vector<BodyDef> yard(Random& random) {
  std::vector<BodyDef> bodies = {western_hills(random), eastern_hills(random)};
  for (const Vector3& inward : {Vector3(1, 0, 0), Vector3(-1, 0, 0), Vector3(0, 1, 0), Vector3(0, -1, 0)}) {
    bodies.push_back(
        {.type = BodyType::Static, .shape = HalfSpace{.normal = inward, .offset = -wall_at}, .name = "wall"});
  }
  bodies.push_back({.type = BodyType::Static,
                    .shape = Box{{4, 1, 0.2}},
                    .position = {0, 6, hill + 0.5},
                    .surface_velocity = {1.5, 0, 0},
                    .name = "belt"});
  bodies.push_back(
      {.type = BodyType::Static, .shape = Box{{6, 6, 1}}, .position = {8, -8, 1}, .sensor = true, .name = "sensor"});
  bodies.push_back({.type = BodyType::Kinematic,
                    .shape = Box{{3, 0.2, 0.3}},
                    .position = {-8, -8, hill + 0.8},
                    .angular_velocity = {0, 0, 0.7},
                    .name = "paddle"});
  return bodies;
}

Vector3 place_above(std::size_t number) {
  const auto i = static_cast<int>(number);
  const double middle = 0.5 * (places_a_row - 1);
  return {place_pitch * (i % places_a_row - middle), place_pitch * (i / places_a_row - middle), drop};
}

}  // namespace atl::soak
