#pragma once

#include <collision/shapes/shape.h>

#include <array>
#include <cmath>
#include <cstdint>

namespace atl::collision {

/// A triangle of a surface, in the surface's frame: solid behind, so only its front can be touched.
struct Triangle {
  std::array<Vector3, 3> vertices;  ///< m, counter-clockwise seen from the front
  Vector3 normal;                   ///< unit
  /// The normal of the triangle beyond the edge from vertex i to i + 1; the triangle's own normal if there is none.
  std::array<Vector3, 3> neighbour_normals;
  /// Bit i: the surface is convex (or ends) at that edge, so something can touch the edge itself. At the
  /// others, flat or concave, a neighbour always touches first and a contact's normal is the triangle's.
  std::uint8_t convex_edges = 0;
  /// Unit, by vertex: those of the smooth surface that the triangles stand for. Set on smooth surfaces alone.
  std::array<Vector3, 3> corner_normals;
};

/// Angle (rad) from which on a surface that bends outwards at an edge counts as convex there. Below it a contact
/// with the edge is a ghost: the normal it could have is within 1e-3 of the triangle's own.
inline constexpr double convex_edge_angle = 1e-3;

/// True if a surface is convex at an edge between triangles with unit normals `front` and `beyond`. The edge, of any
/// length, is directed as in the triangle in front. A surface folded right back (180 degrees) is convex.
inline bool is_convex_edge(const Vector3& front, const Vector3& beyond, const Vector3& edge) {
  const double sine = edge.dot(front.cross(beyond));
  const double cosine = edge.norm() * front.dot(beyond);
  return sine > convex_edge_angle * std::abs(cosine) || (cosine < 0 && sine > convex_edge_angle * cosine);
}

}  // namespace atl::collision
