#include "view/triangles.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <type_traits>

namespace atl::view {
namespace {

using std::numbers::pi;

struct Ring {
  double radius, z;
};

// Rings about the z axis from below, closed by a point where the first or last has no radius, else by a flat end.
Triangles revolved(const std::vector<Ring>& rings, int around) {
  Triangles result;
  std::vector<std::uint32_t> starts;
  for (const Ring& ring : rings) {
    starts.push_back(static_cast<std::uint32_t>(result.vertices.size()));
    const int count = ring.radius > 0 ? around : 1;
    for (int i = 0; i < count; ++i) {
      const double angle = 2 * pi * i / around;
      result.vertices.emplace_back(ring.radius * std::cos(angle), ring.radius * std::sin(angle), ring.z);
    }
  }
  const auto at = [&](std::size_t ring, int i) {
    return starts[ring] + (rings[ring].radius > 0 ? static_cast<std::uint32_t>(i % around) : 0u);
  };
  for (std::size_t r = 0; r + 1 < rings.size(); ++r) {
    for (int i = 0; i < around; ++i) {
      if (rings[r].radius > 0) result.triangles.push_back({at(r, i), at(r, i + 1), at(r + 1, i)});
      if (rings[r + 1].radius > 0) result.triangles.push_back({at(r, i + 1), at(r + 1, i + 1), at(r + 1, i)});
    }
  }
  const auto close = [&](std::size_t ring, bool below) {
    if (!(rings[ring].radius > 0)) return;
    for (int i = 1; i + 1 < around; ++i) {
      if (below) {
        result.triangles.push_back({at(ring, 0), at(ring, i + 1), at(ring, i)});
      } else {
        result.triangles.push_back({at(ring, 0), at(ring, i), at(ring, i + 1)});
      }
    }
  };
  close(0, true);
  close(rings.size() - 1, false);
  return result;
}

Triangles capsule(double radius, double half_height, int around) {
  const int levels = std::max(2, around / 4);
  std::vector<Ring> rings;
  for (int side : {-1, 1}) {
    for (int i = 0; i <= levels; ++i) {
      const double angle = pi / 2 * (side < 0 ? i - levels : i) / levels;
      const bool pole = std::abs(angle) > pi / 2 - 1e-9;
      rings.push_back({pole ? 0 : radius * std::cos(angle), side * half_height + radius * std::sin(angle)});
    }
    if (half_height == 0 && side < 0) rings.pop_back();
  }
  return revolved(rings, around);
}

Triangles surface_of(const Sphere& ball, int around) { return capsule(ball.radius, 0, around); }
Triangles surface_of(const Capsule& of, int around) { return capsule(of.radius, of.half_height, around); }
Triangles surface_of(const Cylinder& of, int around) {
  return revolved({{of.radius, -of.half_height}, {of.radius, of.half_height}}, around);
}
Triangles surface_of(const Cone& of, int around) {
  return revolved({{of.radius, -of.half_height}, {0, of.half_height}}, around);
}

Triangles surface_of(const Ellipsoid& of, int around) {
  Triangles result = capsule(1, 0, around);
  for (Vector3& vertex : result.vertices) vertex = vertex.cwiseProduct(of.half_axes);
  return result;
}
// Balls up to the circles in which the cone around both touches them, of which the straight part is the cone.
Triangles surface_of(const TaperedCapsule& of, int around) {
  const double lean = std::asin((of.radii[0] - of.radii[1]) / (2 * of.half_height));
  const int levels = std::max(2, around / 4);
  std::vector<Ring> rings;
  for (std::size_t side : {0, 1}) {
    const double radius = of.radii[side];
    const double from = side == 0 ? -pi / 2 : lean;
    const double to = side == 0 ? lean : pi / 2;
    for (int i = 0; i <= levels; ++i) {
      const double angle = from + (to - from) * i / levels;
      const bool pole = i == (side == 0 ? 0 : levels);
      rings.push_back({pole ? 0 : radius * std::cos(angle),
                       (side == 0 ? -of.half_height : of.half_height) + radius * std::sin(angle)});
    }
  }
  return revolved(rings, around);
}

Triangles surface_of(const Box& box, int) {
  Triangles result;
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3 side(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    result.vertices.push_back(side.cwiseProduct(box.half_extents));
  }
  for (const auto& [a, b, c, d] : std::array<std::array<std::uint32_t, 4>, 6>{
           {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}}) {
    result.triangles.push_back({a, b, c});
    result.triangles.push_back({a, c, d});
  }
  return result;
}

Triangles surface_of(const HalfSpace& half_space, int) {
  constexpr double half = 100;
  const Vector3 normal = half_space.normal.stableNormalized();
  const Vector3 middle = half_space.offset / half_space.normal.stableNorm() * normal;
  const Vector3 along = normal.unitOrthogonal();
  const Vector3 across = normal.cross(along);
  Triangles result;
  for (const auto& [x, y] : {std::pair{-half, -half}, {half, -half}, {half, half}, {-half, half}}) {
    result.vertices.push_back(middle + x * along + y * across);
  }
  result.triangles = {{0, 1, 2}, {0, 2, 3}};
  return result;
}

Triangles surface_of(const ConvexHull& hull, int) {
  Triangles result;
  result.vertices.assign(hull.vertices().begin(), hull.vertices().end());
  for (std::size_t f = 0; f < hull.face_count(); ++f) {
    const std::span<const std::uint16_t> face = hull.face(f);
    for (std::size_t i = 1; i + 1 < face.size(); ++i) result.triangles.push_back({face[0], face[i], face[i + 1]});
  }
  return result;
}

Triangles surface_of(const TriangleMesh& mesh, int) {
  Triangles result;
  result.vertices.assign(mesh.vertices().begin(), mesh.vertices().end());
  result.triangles.assign(mesh.triangles().begin(), mesh.triangles().end());
  return result;
}

Triangles surface_of(const HeightField& field, int) {
  Triangles result;
  const std::span<const double> heights = field.heights();
  const auto is_hole = [&](double height) { return std::isnan(height); };
  const auto ground = std::find_if_not(heights.begin(), heights.end(), is_hole);
  double last = ground == heights.end() ? 0 : *ground;  // samples of holes are no triangle's, but need a place
  for (std::uint32_t row = 0; row < field.rows(); ++row) {
    for (std::uint32_t column = 0; column < field.columns(); ++column) {
      const double height = heights[std::size_t{row} * field.columns() + column];
      if (!is_hole(height)) last = height;
      result.vertices.emplace_back(column * field.spacing_x(), row * field.spacing_y(), last);
    }
  }
  for (std::uint32_t row = 0; row + 1 < field.rows(); ++row) {
    for (std::uint32_t column = 0; column + 1 < field.columns(); ++column) {
      const std::uint32_t a = row * field.columns() + column, b = a + 1, c = a + field.columns(), d = c + 1;
      if (is_hole(heights[a] + heights[d])) continue;
      if (!is_hole(heights[b])) result.triangles.push_back({a, b, d});
      if (!is_hole(heights[c])) result.triangles.push_back({a, d, c});
    }
  }
  return result;
}

Triangles surface_of(const Compound& compound, int around) {
  Triangles result;
  for (const CompoundChild& child : compound.children) {
    std::visit(
        [&](const auto& kind) {
          result.add(surface_of(kind, around), {child.position, child.orientation.normalized()});
        },
        child.shape);
  }
  return result;
}

}  // namespace

void Triangles::add(const Triangles& other, const Pose& at) {
  const auto first = static_cast<std::uint32_t>(vertices.size());
  for (const Vector3& vertex : other.vertices) vertices.push_back(at.position + at.orientation * vertex);
  for (const auto& [a, b, c] : other.triangles) triangles.push_back({first + a, first + b, first + c});
}

Triangles triangles_of(const Shape& shape, int around) {
  return std::visit([&](const auto& kind) { return surface_of(kind, around); }, shape);
}

}  // namespace atl::view
