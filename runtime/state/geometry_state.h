#pragma once
/// Hulls, meshes and height fields for archives (state_archive.h). A hull is told in full, as one that is made of its
/// own vertices may have its faces in another order; the others follow from what they were made of.

#include <collision/shapes/height_field.h>
#include <collision/shapes/hull.h>
#include <collision/shapes/triangle_mesh.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <variant>
#include <vector>

#include "world/body_definition.h"

namespace atl {

/// Visits as many as there are, each of at least so many bytes.
template <typename Archive, typename List, typename Visit>
void visit_each(Archive& archive, List& list, std::size_t min_bytes, const Visit& visit) {
  auto count = static_cast<std::uint32_t>(list.size());
  if constexpr (Archive::reads) {
    count = archive.count_of(min_bytes);
    list.resize(count);
  } else {
    archive.value(count);
  }
  for (auto& each : list) visit(each);
}

template <typename Archive, typename List>
void visit_vectors(Archive& archive, List& list) {
  visit_each(archive, list, 3 * sizeof(double), [&](auto& vector) { visit_value(archive, vector); });
}

template <typename Archive, typename Hull>
void visit_hull(Archive& archive, Hull& hull) {
  visit_vectors(archive, hull.vertices);
  visit_each(archive, hull.planes, 4 * sizeof(double),
             [&](auto& plane) { visit_all(archive, plane.normal, plane.offset); });
  visit_each(archive, hull.edges, 4 * sizeof(std::uint16_t),
             [&](auto& edge) { visit_all(archive, edge.tail, edge.head, edge.left, edge.right); });
  archive.list(hull.face_start);
  archive.list(hull.face_vertices);
  archive.list(hull.face_edges);
  archive.list(hull.vertex_start);
  archive.list(hull.vertex_edges);
  visit_all(archive, hull.mass.volume, hull.mass.centre, hull.mass.unit_inertia, hull.bounding_radius,
            hull.inner_radius, hull.lower, hull.upper, hull.simplified, hull.content);
}

/// Checks that every index of a hull is within its range.
template <typename Archive>
void check_hull(Archive& archive, const collision::Hull& hull) {
  const auto all_below = [&](const std::vector<std::uint16_t>& numbers, std::size_t end) {
    const bool below = std::all_of(numbers.begin(), numbers.end(), [end](std::uint16_t n) { return n < end; });
    archive.check(below, "a hull with a number of something that there is not");
  };
  // Parts of a list, by where each begins.
  const auto all_parts = [&](const std::vector<std::uint16_t>& start, std::size_t parts, std::size_t all) {
    const bool fits = start.size() == parts + 1 && start.front() == 0 && start.back() == all &&
                      std::is_sorted(start.begin(), start.end());
    archive.check(fits, "a hull whose parts don't fit together");
  };
  archive.check(hull.vertices.size() >= 4 && hull.vertices.size() <= collision::Hull::max_vertices &&
                    hull.planes.size() >= 4 && hull.edges.size() >= 6,
                "a hull of too few or too many parts");
  all_parts(hull.face_start, hull.planes.size(), hull.face_vertices.size());
  all_parts(hull.vertex_start, hull.vertices.size(), hull.vertex_edges.size());
  archive.check(hull.face_edges.size() == hull.face_vertices.size(), "a hull whose parts don't fit together");
  all_below(hull.face_vertices, hull.vertices.size());
  all_below(hull.face_edges, hull.edges.size());
  all_below(hull.vertex_edges, hull.edges.size());
  for (const collision::Hull::Edge& edge : hull.edges) {
    archive.check(edge.tail < hull.vertices.size() && edge.head < hull.vertices.size() &&
                      edge.left < hull.planes.size() && edge.right < hull.planes.size(),
                  "a hull with a number of something that there is not");
  }
}

// By what they are made of.
template <typename Archive, typename Mesh>
void visit_mesh(Archive& archive, Mesh& mesh) {
  visit_vectors(archive, mesh.vertices);
  archive.value(mesh.smooth_angle);
  archive.list(mesh.materials);
  visit_each(archive, mesh.triangles, 3 * sizeof(std::uint32_t),
             [&](auto& triangle) { visit_value(archive, triangle); });
}

template <typename Archive, typename Field>
void visit_field_of_heights(Archive& archive, Field& field) {
  visit_all(archive, field.columns, field.rows, field.spacing_x, field.spacing_y, field.smooth);
  archive.list(field.heights);
  archive.list(field.materials);
}

/// Writes the geometry of a collider that has some.
template <typename Archive>
void write_geometry(Archive& archive, const CheckedCollider& collider) {
  archive.value(collider.shape.kind);
  archive.value(collider.content);
  switch (collider.shape.kind) {
    case collision::ShapeKind::Hull:
      return visit_hull(archive, *collider.shape.hull);
    case collision::ShapeKind::Mesh:
      return visit_mesh(archive, *collider.shape.mesh);
    default:
      return visit_field_of_heights(archive, *collider.shape.field);
  }
}

/// Reads a hull and checks all of it.
template <typename Archive>
std::shared_ptr<const collision::Hull> read_hull(Archive& archive) {
  auto hull = std::make_shared<collision::Hull>();
  visit_hull(archive, *hull);
  check_hull(archive, *hull);
  archive.check(collision::content_of(*hull) == hull->content, "a hull of another content than it says");
  archive.check(collision::is_made_of_its_faces(*hull), "a hull that its vertices and faces don't make");
  hull->prepare();
  return hull;
}

/// A hull, mesh or height field that was read.
struct ReadGeometry {
  collision::ShapeKind kind = collision::ShapeKind::Hull;
  std::uint64_t content = 0;
  std::shared_ptr<const void> geometry;
};

template <typename Archive>
ReadGeometry read_geometry(Archive& archive) {
  ReadGeometry result;
  archive.value(result.kind);
  archive.value(result.content);
  const auto take = [&](const auto& geometry) {
    archive.check(geometry->content == result.content, "a hull, mesh or height field of another content");
    result.geometry = geometry;
  };
  const auto take_built = [&](auto built) {
    using Built = std::variant_alternative_t<0, decltype(built)>;
    archive.check(std::holds_alternative<Built>(built), "what makes no mesh or height field");
    take(std::make_shared<const Built>(std::get<Built>(std::move(built))));
  };
  switch (result.kind) {
    case collision::ShapeKind::Hull:
      take(read_hull(archive));
      break;
    case collision::ShapeKind::Mesh: {
      collision::TriangleMesh mesh;
      visit_mesh(archive, mesh);
      take_built(
          collision::build_triangle_mesh(mesh.vertices, mesh.triangles, mesh.smooth_angle, std::move(mesh.materials)));
      break;
    }
    case collision::ShapeKind::HeightField: {
      collision::HeightField field;
      visit_field_of_heights(archive, field);
      take_built(collision::build_height_field(field.columns, field.rows, field.spacing_x, field.spacing_y,
                                               std::move(field.heights), field.smooth, std::move(field.materials)));
      break;
    }
    default:
      archive.check(false, "geometry of a shape that has none");
  }
  return result;
}

}  // namespace atl
