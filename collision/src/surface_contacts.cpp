#include <collision/aabb.h>
#include <collision/height_field.h>
#include <collision/surface_contacts.h>
#include <collision/triangle_mesh.h>

#include "surface_clusters.h"

namespace atl::collision {
namespace {

// Calls visit(triangle, number) for those near a box.
template <typename Visit>
void visit_triangles(const Shape& surface, const Aabb& box, const Visit& visit) {
  if (surface.kind == ShapeKind::Mesh) {
    surface.mesh->tree.query(box, [&](std::uint32_t i) { visit(surface.mesh->triangle(i), i); });
  } else if (surface.kind == ShapeKind::HeightField) {
    surface.field->query(box, [&](std::uint32_t i) { visit(surface.field->triangle(i), i); });
  }
}

// Whether a triangle that has a vertex reaches ahead of it along a direction, and so is touched first.
bool reaches_ahead(const Triangle& triangle, const Vector3& vertex, const Vector3& direction) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (triangle.vertices[i] != vertex) continue;
    for (const std::size_t k : {(i + 1) % 3, (i + 2) % 3}) {
      const Vector3 along = triangle.vertices[k] - vertex;
      if (along.dot(direction) > convex_edge_angle * along.norm()) return true;
    }
  }
  return false;
}

bool can_push_at_vertex(const Shape& surface, const Vector3& vertex, const Vector3& direction) {
  bool can = true;
  visit_triangles(surface, Aabb::around(vertex, vertex), [&](const Triangle& triangle, std::uint32_t) {
    can = can && !reaches_ahead(triangle, vertex, direction);
  });
  return can;
}

}  // namespace

void collide_surface(const Shape& solid, const Shape& surface, const Pose& solid_pose, double margin,
                     SurfaceManifolds& result) {
  result.count = 0;
  if (!is_convex_solid(solid.kind) || !is_surface(surface.kind)) return;
  if (!solid_pose.position.allFinite() || !solid_pose.orientation.coeffs().allFinite()) return;
  const SurfaceSolid placed(solid, solid_pose);
  const Bounds bounds = bounds_of(solid, placed.position, placed.rotation);
  const Vector3 around = Vector3::Constant(margin);
  const Aabb box = Aabb::around(bounds.lower - around, bounds.upper + around);
  SurfaceClusters clusters(placed);
  TriangleContact contact;
  visit_triangles(surface, box, [&](const Triangle& triangle, std::uint32_t number) {
    touch_triangle(placed, triangle, number, margin, contact);
    if (contact.part == TriangleAxis::Part::Vertex && contact.count > 0 &&
        !can_push_at_vertex(surface, triangle.vertices[static_cast<std::size_t>(contact.vertex)], contact.normal)) {
      return;
    }
    clusters.add(contact);
  });
  clusters.finish(result);
}

}  // namespace atl::collision
