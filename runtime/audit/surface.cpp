#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "placed.h"

namespace atl::audit {
namespace {

using Corners = std::array<Vector3, 3>;

Eigen::AlignedBox3d bounds_of(const Corners& corners) {
  Eigen::AlignedBox3d box(corners[0]);
  return box.extend(corners[1]).extend(corners[2]);
}

/// A solid's bounds in the surface's frame.
Eigen::AlignedBox3d bounds_in(const PlacedSurface& surface, const Solid& solid) {
  const Vector3 centre = surface.axes.transpose() * (solid.centre - surface.origin);
  Vector3 low, high;
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = centre[axis] - reach(solid, -surface.axes.col(axis));
    high[axis] = centre[axis] + reach(solid, surface.axes.col(axis));
  }
  return {low, high};
}

bool is_hole(double height) { return std::isnan(height); }

/// A triangle in the world's axes about its first corner.
Corners turned(const PlacedSurface& surface, const Corners& corners) {
  return {Vector3::Zero(), surface.axes * (corners[1] - corners[0]), surface.axes * (corners[2] - corners[0])};
}

Vector3 placed(const PlacedSurface& surface, const Vector3& point) { return surface.origin + surface.axes * point; }

/// Calls visit(corners, column depth) for the triangles whose bounds meet a box, in the surface's frame. A plate's
/// depth is 0.
template <class Visit>
void visit_plates(const PlacedSurface& surface, const TriangleMesh& mesh, const Eigen::AlignedBox3d& box,
                  const Visit& visit) {
  const auto triangles = mesh.triangles();
  for (std::size_t block = 0; block < surface.blocks.size(); ++block) {
    if (!surface.blocks[block].intersects(box)) continue;
    const std::size_t begin = block * PlacedSurface::block_size;
    const std::size_t end = std::min(begin + PlacedSurface::block_size, triangles.size());
    for (std::size_t i = begin; i < end; ++i) {
      const Corners corners = {mesh.vertices()[triangles[i][0]], mesh.vertices()[triangles[i][1]],
                               mesh.vertices()[triangles[i][2]]};
      if (bounds_of(corners).intersects(box)) visit(corners, 0.0);
    }
  }
}

/// Cells that an interval reaches into, as [begin, end).
std::pair<std::size_t, std::size_t> cells_within(double low, double high, double spacing, std::uint32_t samples) {
  const double last = samples - 1;
  const double begin = std::clamp(std::floor(low / spacing), 0.0, last);
  const double end = std::clamp(std::ceil(high / spacing), 0.0, last);
  return {static_cast<std::size_t>(begin), static_cast<std::size_t>(end)};
}

template <class Visit>
void visit_columns(const HeightField& field, bool has_holes, const Eigen::AlignedBox3d& box, const Visit& visit) {
  const auto [low_x, high_x] = cells_within(box.min().x(), box.max().x(), field.spacing_x(), field.columns());
  const auto [low_y, high_y] = cells_within(box.min().y(), box.max().y(), field.spacing_y(), field.rows());
  const auto sample = [&](std::size_t i, std::size_t j) {
    return Vector3(static_cast<double>(i) * field.spacing_x(), static_cast<double>(j) * field.spacing_y(),
                   field.heights()[j * field.columns() + i]);
  };
  for (std::size_t j = low_y; j < high_y; ++j) {
    for (std::size_t i = low_x; i < high_x; ++i) {
      const Vector3 begin = sample(i, j);
      const Vector3 end = sample(i + 1, j + 1);
      for (const Corners& corners : {Corners{begin, sample(i + 1, j), end}, Corners{begin, end, sample(i, j + 1)}}) {
        if (is_hole(corners[0].z() + corners[1].z() + corners[2].z())) continue;
        const Eigen::AlignedBox3d bounds = bounds_of(corners);
        const double below = bounds.max().z() - box.min().z();
        if (has_holes) {
          if (bounds.intersects(box)) visit(corners, 0.0);
        } else if (below >= 0) {
          // So deep that the way out downwards is longer than any other.
          visit(corners, 4 * (below + box.diagonal().norm() + bounds.diagonal().norm()));
        }
      }
    }
  }
}

template <class Visit>
void visit_triangles(const PlacedSurface& surface, const Eigen::AlignedBox3d& box, const Visit& visit) {
  if (const auto* mesh = std::get_if<TriangleMesh>(&surface.geometry)) {
    visit_plates(surface, *mesh, box, visit);
  } else {
    visit_columns(std::get<HeightField>(surface.geometry), surface.has_holes, box, visit);
  }
}

Solid solid_of(const PlacedSurface& surface, const Corners& corners, double depth) {
  const Vector3 centre = placed(surface, corners[0]);
  const Corners about = turned(surface, corners);
  if (depth == 0) return {centre, Polytope::plate(about)};
  return {centre, Polytope::column(about, -surface.axes.col(2), depth)};
}

}  // namespace

Penetration penetration(const Solid& solid, const PlacedSurface& surface) {
  Penetration deepest{0, Vector3::UnitZ()};
  visit_triangles(surface, bounds_in(surface, solid), [&](const Corners& corners, double depth) {
    // The way out along the triangle's normal is no shorter than the shortest: mostly enough to pass it over.
    const Corners about = turned(surface, corners);
    const Vector3 normal = about[1].cross(about[2]).normalized();
    const double forwards = reach(solid, -normal) - normal.dot(solid.centre - placed(surface, corners[0]));
    if (forwards <= deepest.depth) return;
    const Penetration found = penetration(solid, solid_of(surface, corners, depth));
    if (found.depth > deepest.depth) deepest = found;
  });
  if (deepest.depth <= 0) deepest.depth = -gap_to_bounds(surface, solid);
  return deepest;
}

std::vector<Solid> triangles_of(const PlacedSurface& surface) {
  std::vector<Solid> result;
  visit_triangles(surface, surface_bounds(surface),
                  [&](const Corners& corners, double depth) { result.push_back(solid_of(surface, corners, depth)); });
  return result;
}

double gap_to_bounds(const PlacedSurface& surface, const Solid& solid) {
  Eigen::AlignedBox3d bounds = surface_bounds(surface);
  const Eigen::AlignedBox3d box = bounds_in(surface, solid);
  if (std::holds_alternative<HeightField>(surface.geometry) && !surface.has_holes) {
    bounds.min().z() = std::min(bounds.min().z(), box.min().z());  // solid below
  }
  return bounds.exteriorDistance(box);
}

std::vector<Vector3> vertices_of(const PlacedSurface& surface) {
  std::vector<Vector3> result;
  if (const auto* mesh = std::get_if<TriangleMesh>(&surface.geometry)) {
    for (const Vector3& vertex : mesh->vertices()) result.push_back(placed(surface, vertex));
    return result;
  }
  const auto& field = std::get<HeightField>(surface.geometry);
  for (std::size_t i = 0; i < field.heights().size(); ++i) {
    if (is_hole(field.heights()[i])) continue;
    result.push_back(
        placed(surface, {static_cast<double>(i % field.columns()) * field.spacing_x(),
                         static_cast<double>(i / field.columns()) * field.spacing_y(), field.heights()[i]}));
  }
  return result;
}

Eigen::AlignedBox3d surface_bounds(const PlacedSurface& surface) {
  Eigen::AlignedBox3d box;
  if (std::holds_alternative<TriangleMesh>(surface.geometry)) {
    for (const Eigen::AlignedBox3d& block : surface.blocks) box.extend(block);
    return box;
  }
  const auto& field = std::get<HeightField>(surface.geometry);
  const Vector3 corner((field.columns() - 1) * field.spacing_x(), (field.rows() - 1) * field.spacing_y(), 0);
  for (const double height : field.heights()) {
    if (is_hole(height)) continue;
    box.extend(Vector3(0, 0, height)).extend(corner + height * Vector3::UnitZ());
  }
  return box;
}

}  // namespace atl::audit
