// Solids on the front of a triangle: the face that looks down, clipped to the triangle, or where a convex edge or a
// vertex of it has the contact, what of the solid lies there.

#include <collision/narrowphase/feature_id.h>
#include <collision/narrowphase/support_feature.h>

#include <algorithm>
#include <cmath>

#include "narrowphase/line_contact.h"
#include "narrowphase/point_distance.h"
#include "narrowphase/triangle_contact.h"

namespace atl::collision {
namespace {

using Part = TriangleAxis::Part;

// Part of the solid's size within which, as for two solids (collide_convex.cpp), a face stands in for the best axis; it
// must also look the same way, within 8 degrees.
constexpr double face_tolerance = 0.02;
// m, over the solid's size: corners so little beside a triangle count as over it, so that none is lost between two.
constexpr double over_slack = 1e-6;

// Part of the solid's size by which the point of contact may lie beside the edge, seen along the normal. Without it,
// 0.4% of cylinders and cones in random poses on jagged ground, sunk in by up to a tenth, had no contact.
constexpr double aside_slack = 0.025;

constexpr std::uint32_t number_mask = (1u << 28) - 1;

// A feature of the solid on an edge (0-2) or vertex (3-5) of the triangle, or on its face (6). The triangle's part
// has bits of its own, beside what with_triangle() uses.
FeatureId part_id(int kind, int number, int part, int place, std::uint32_t triangle) {
  const FeatureId id = feature_pair_id(kind, number, 0, 0, place) | static_cast<FeatureId>(part) << 14;
  return with_triangle(id, triangle & number_mask);
}
constexpr int on_vertex = 3;
constexpr int on_face = 6;

bool is_flat_edge(const Triangle& triangle, std::size_t edge) {
  const Vector3& beyond = triangle.neighbour_normals[edge];
  return (triangle.convex_edges >> edge & 1) == 0 && beyond.dot(triangle.normal) > 0 &&
         beyond.cross(triangle.normal).squaredNorm() < convex_edge_angle * convex_edge_angle;
}

// True if a corner belongs to the solid, and was not cut by the triangle.
bool is_own(const OutlineCorner& corner) { return ((corner.edge_in | corner.edge_out) & reference_edge) == 0; }
// The same from face_point_id().
bool is_own_id(FeatureId id) {
  constexpr FeatureId edges = FeatureId{reference_edge} << 9 | FeatureId{reference_edge};
  return (id & edges) == 0;
}

bool is_inner(const Triangle& triangle, const OutlineCorner& corner) {
  bool inner = false;
  for (const int edge : {int{corner.edge_in}, int{corner.edge_out}}) {
    if ((edge & reference_edge) == 0) continue;
    if (!is_flat_edge(triangle, static_cast<std::size_t>(edge & 3))) return false;
    inner = true;
  }
  return inner;
}

// Only the points that matter, where there are more than there is room for.
void reduce(const Outline& outline, const Triangle& triangle, const std::array<double, Outline::capacity>& heights,
            const std::array<FeatureId, Outline::capacity>& ids, double margin, TriangleContact& contact) {
  std::array<Manifold::Point, Outline::capacity> points;
  int count = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(outline.count); ++i) {
    if (heights[i] > margin || is_inner(triangle, outline.corners[i])) continue;
    points[static_cast<std::size_t>(count++)] = {outline.corners[i].position, heights[i], ids[i]};
  }
  Manifold few;
  few.normal = triangle.normal;
  reduce_points(points.data(), count, few);
  for (int i = 0; i < few.count; ++i) {
    const Manifold::Point& point = few.points[static_cast<std::size_t>(i)];
    contact.add(point.position, point.separation, point.id, false, is_own_id(point.id));
  }
}

void touch_face(const SurfaceSolid& solid, const Triangle& triangle, std::uint32_t number, double margin,
                TriangleContact& contact) {
  const Vector3 down = solid.turned(Vector3(-triangle.normal));
  const Polytope& polytope = solid.core.polytope();
  FacePolygon face;
  face.normal = triangle.normal;
  face.offset = triangle.normal.dot(triangle.vertices[0]);
  face.number = 0;
  for (const Vector3& vertex : triangle.vertices) face.add(vertex);
  Outline outline;
  const double lowest = triangle.normal.dot(solid.support(Vector3(-triangle.normal)) - triangle.vertices[0]);
  const int incident = incident_outline(solid.shape, polytope, down, margin - lowest, outline);
  bool has_lowest = solid.shape.kind != ShapeKind::Hull;
  for (int i = 0; i < outline.count; ++i) {
    Vector3& corner = outline.corners[static_cast<std::size_t>(i)].position;
    corner = solid.placed(corner);
    const double height = triangle.normal.dot(corner - triangle.vertices[0]);
    has_lowest |= height <= lowest + 1e-9 * solid.shape.inner_radius;
  }
  // Over an edge that is bent outwards, but by too little to count, a ball's foot is on neither side: on both, then.
  const bool has_foot = solid.shape.kind == ShapeKind::Sphere || is_smooth(solid.shape.kind);
  const double slack = (has_foot ? convex_edge_angle : over_slack) * solid.shape.inner_radius;
  clip(outline, face, slack);

  contact.normal = triangle.normal;
  contact.part = Part::Face;
  std::array<double, Outline::capacity> heights;
  std::array<FeatureId, Outline::capacity> ids;
  int near = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(outline.count); ++i) {
    const OutlineCorner& corner = outline.corners[i];
    heights[i] = triangle.normal.dot(corner.position - triangle.vertices[0]);
    ids[i] = with_triangle(face_point_id(true, 0, incident, corner.edge_in, corner.edge_out), number & number_mask);
    near += heights[i] <= margin;
  }
  if (near >= TriangleContact::capacity) {
    reduce(outline, triangle, heights, ids, margin, contact);
  } else {
    for (std::size_t i = 0; i < static_cast<std::size_t>(outline.count); ++i) {
      const OutlineCorner& corner = outline.corners[i];
      if (heights[i] <= margin)
        contact.add(corner.position, heights[i], ids[i], is_inner(triangle, corner), is_own(corner));
    }
  }
  // The face of a hull that looks most directly down need not have its lowest corner.
  if (has_lowest) return;
  const int vertex = polytope.support(down);
  const Vector3 corner = solid.placed(polytope.vertices[vertex]);
  if (lies_over(triangle, corner, slack))
    contact.add(corner, lowest, part_id(0, vertex, on_face, 0, number), false, true);
}

struct Ends {
  Vector3 tail, head;
};

Ends ends_of(const Triangle& triangle, int edge) {
  const auto i = static_cast<std::size_t>(edge);
  return {triangle.vertices[i], triangle.vertices[(i + 1) % 3]};
}

// A flat face of the solid on the edge.
void touch_edge_with_face(const SurfaceSolid& solid, const Ends& edge, const TriangleAxis& axis, std::uint32_t number,
                          double margin, TriangleContact& contact) {
  const Polytope& polytope = solid.core.polytope();
  const Vector3 normal = solid.turned(axis.normal);
  const FlatFace flat = flat_face_along(solid.shape, polytope, -normal);
  if (flat.number < 0 || flat.cosine < same_direction) return;
  FacePolygon face;
  face_polygon(solid.shape, polytope, flat.number, face);
  Outline outline;
  const Vector3 onto_face = axis.separation * axis.normal;
  outline.add_end(solid.seen(edge.tail + onto_face));
  outline.add_end(solid.seen(edge.head + onto_face));
  clip(outline, face, over_slack * solid.shape.inner_radius);
  for (int i = 0; i < outline.count; ++i) {
    const Vector3& near_face = outline.corners[static_cast<std::size_t>(i)].position;
    const double rest = (face.normal.dot(near_face) - face.offset) / -face.normal.dot(normal);
    const double separation = axis.separation + rest;
    if (!(separation <= margin)) continue;
    contact.add(solid.placed(near_face + rest * normal), separation, part_id(2, flat.number, axis.index, i, number));
  }
}

// A line of the solid along the edge.
void touch_edge_with_line(const SurfaceSolid& solid, const Ends& edge, const TriangleAxis& axis, std::uint32_t number,
                          double margin, TriangleContact& contact) {
  SurfaceLine line{axis.support[0], axis.support[1], 1, 0};
  const SideLine side = side_line(solid.shape, solid.turned(Vector3(-axis.normal)));
  if (side.exists) {
    line = {solid.placed(side.tail), solid.placed(side.head), 2, 2};
  } else if (axis.support_count < 2 || solid.core.radius() > 0) {
    return;
  }
  Manifold manifold;
  if (!line_points({edge.tail, edge.head, 1, axis.index}, line, axis.normal, margin, manifold)) return;
  for (int i = 0; i < manifold.count; ++i) {
    const Manifold::Point& point = manifold.points[static_cast<std::size_t>(i)];
    const FeatureId id = part_id(line.kind, line.number, axis.index, 1 + i, number);
    contact.add(point.position, point.separation, id);
  }
}

// A point of the solid on the edge.
void touch_edge_with_point(const SurfaceSolid& solid, const Ends& edge, const TriangleAxis& axis, std::uint32_t number,
                           TriangleContact& contact) {
  const Vector3 along = edge.head - edge.tail;
  const double length = along.norm();
  if (!(length > 0)) return;
  const Vector3 unit = along / length;
  Vector3 point = axis.support[0];
  if (axis.support_count == 2) {
    // The place where the two lines come nearest each other, seen along the normal.
    const Vector3 line = axis.support[1] - axis.support[0];
    const Vector3 across = axis.normal.cross(unit);
    const double rate = across.dot(line);
    const double t = rate != 0 ? across.dot(edge.tail - axis.support[0]) / rate : 0.5;
    point += std::clamp(t, 0.0, 1.0) * line;
  }
  const double at = unit.dot(point - edge.tail);
  // A rim that goes over a vertex may have its best direction a little past the ends of all edges there.
  const bool has_rim = solid.shape.kind == ShapeKind::Cylinder || solid.shape.kind == ShapeKind::Cone;
  const double past_end = has_rim ? aside_slack : over_slack;
  if (std::max(-at, at - length) > past_end * solid.shape.inner_radius) return;
  // At the last direction that a border allows the nearest point may lie elsewhere.
  const double aside = (point - (edge.tail + at * unit)).cross(axis.normal).norm();
  if (aside > aside_slack * solid.shape.inner_radius) return;
  contact.add(point - solid.core.radius() * axis.normal, axis.separation, part_id(1, 0, axis.index, 0, number));
}

void touch_edge(const SurfaceSolid& solid, const Triangle& triangle, const TriangleAxis& axis, std::uint32_t number,
                double margin, TriangleContact& contact) {
  const Ends edge = ends_of(triangle, axis.index);
  contact.normal = axis.normal;
  contact.part = Part::Edge;
  touch_edge_with_face(solid, edge, axis, number, margin, contact);
  if (contact.count == 0) touch_edge_with_line(solid, edge, axis, number, margin, contact);
  if (contact.count == 0) touch_edge_with_point(solid, edge, axis, number, contact);
}

void touch_vertex(const SurfaceSolid& solid, const Triangle& triangle, const TriangleAxis& axis, std::uint32_t number,
                  TriangleContact& contact) {
  contact.normal = axis.normal;
  contact.part = Part::Vertex;
  contact.vertex = axis.index;
  const FeatureId id = part_id(0, 0, on_vertex + axis.index, 0, number);
  if (axis.support_count > 0) {
    contact.add(axis.support[0] - solid.core.radius() * axis.normal, axis.separation, id);
    return;
  }
  // A face of the solid, if the vertex is below it and not beside.
  const Vector3& vertex = triangle.vertices[static_cast<std::size_t>(axis.index)];
  const Polytope& polytope = solid.core.polytope();
  const FlatFace flat = flat_face_along(solid.shape, polytope, solid.turned(Vector3(-axis.normal)));
  if (flat.number < 0) return;
  FacePolygon face;
  face_polygon(solid.shape, polytope, flat.number, face);
  Outline outline;
  outline.add_end(solid.seen(vertex));
  clip(outline, face, over_slack * solid.shape.inner_radius);
  if (outline.count > 0) contact.add(vertex + axis.separation * axis.normal, axis.separation, id);
}

// True if a plane through a side of the triangle keeps the solid farther off than the margin. No plane can if the
// solid's centre is within the margin plus the solid's least reach in any direction, which settles most cases early.
bool is_beside(const SurfaceSolid& solid, const Triangle& face, double margin) {
  const double near = margin + (1 - 1e-9) * solid.min_reach;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3& tail = face.vertices[i];
    const Vector3 across = (face.vertices[(i + 1) % 3] - tail).cross(face.normal);
    const double beside = across.dot(solid.position - tail);
    if (near >= 0 && (beside <= 0 || beside * beside <= near * near * across.squaredNorm())) continue;
    const Vector3 outward = across.normalized();
    if (solid.height(outward, tail) > margin) return true;
  }
  return false;
}

double deepest(const TriangleContact& contact) {
  double separation = INFINITY;
  for (int i = 0; i < contact.count; ++i) {
    separation = std::min(separation, contact.points[static_cast<std::size_t>(i)].separation);
  }
  return separation;
}

}  // namespace

bool lies_over(const Triangle& triangle, const Vector3& point, double slack) {
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3& tail = triangle.vertices[i];
    const Vector3 outward = (triangle.vertices[(i + 1) % 3] - tail).cross(triangle.normal);
    if (outward.dot(point - tail) > slack * outward.norm()) return false;
  }
  return true;
}

// Most triangles near a solid are farther away than the margin: by the ball around it, by the triangle's plane or one
// through a side. To find the axis costs twenty times as much.
bool comes_near(const SurfaceSolid& solid, const Triangle& face, double margin, double& height) {
  constexpr double rounding = 1 + 1e-9;
  const double radius = solid.shape.bounding_radius;
  const double reach = radius + margin;
  const double level = face.normal.dot(solid.position - face.vertices[0]);
  if (level > rounding * reach || level < -rounding * radius) return false;
  const Vector3 nearest = closest_point_of_triangle(face.vertices, solid.position);
  if ((nearest - solid.position).squaredNorm() > reach * reach) return false;
  const Vector3 up = solid.turned(face.normal);
  height = level - reach_along(solid.shape, -up);
  if (!(height <= margin)) return false;
  // Wholly behind.
  if (!(height > 0) && !(level + reach_along(solid.shape, up) > 0)) return false;
  return !is_beside(solid, face, margin);
}

void touch_triangle(const SurfaceSolid& solid, const Triangle& triangle, double height, std::uint32_t number,
                    double margin, TriangleContact& contact) {
  contact.clear();
  const TriangleAxis axis = find_triangle_axis(solid, triangle, height, margin);
  if (!(axis.separation <= margin)) return;
  if (axis.part == Part::Face) {
    touch_face(solid, triangle, number, margin, contact);
    return;
  }
  const bool is_ball_like = solid.core.radius() > 0 || is_smooth(solid.shape.kind);
  if (!is_ball_like && axis.normal.dot(triangle.normal) > same_direction) {
    touch_face(solid, triangle, number, margin, contact);
    const double error = std::abs(deepest(contact) - axis.separation);
    if (error <= face_tolerance * solid.shape.inner_radius) return;
    contact.clear();
  }
  if (axis.of_neighbour) return;
  if (axis.part == Part::Edge) {
    touch_edge(solid, triangle, axis, number, margin, contact);
  } else {
    touch_vertex(solid, triangle, axis, number, contact);
  }
}

}  // namespace atl::collision
