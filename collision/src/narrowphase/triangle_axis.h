#pragma once

#include <collision/shapes/triangle.h>

#include "narrowphase/surface_solid.h"

namespace atl::collision {

/// The direction that parts a solid from a triangle best, of those in which the triangle's surface can push.
struct TriangleAxis {
  enum class Part : std::uint8_t { Face, Edge, Vertex };

  Vector3 normal = Vector3::UnitZ();  ///< unit, from the triangle to the solid, surface's frame
  double separation = 0;              ///< m, along the normal
  Part part = Part::Face;             ///< of the triangle, that meets the solid
  int index = 0;                      ///< of the edge or vertex
  /// The normal of the triangle beyond the edge, which therefore has the contact as its own.
  bool of_neighbour = false;
  /// m, surface's frame: the solid's (or its core's) nearest point, or the ends of its nearest edge.
  int support_count = 0;
  std::array<Vector3, 2> support = {Vector3::Zero(), Vector3::Zero()};
};

/// Whether nothing lies beyond an edge.
inline bool is_border(const Triangle& triangle, std::size_t edge) {
  return (triangle.convex_edges >> edge & 1) != 0 && triangle.neighbour_normals[edge] == triangle.normal;
}

/// Looks at the triangle's normal, and, where the solid reaches across a convex edge, at those between it and the
/// neighbour's, up to right angles at a border, and at those of the edge's ends. `height` is the solid's over the
/// triangle's plane.
///
/// Around an edge the separation is piecewise smooth in the angle: a polytope's support vertices are walked
/// through, each with its closed form; a cylinder's or cone's are searched.
///
/// Once one parts them by more than `most` (m) it may not be the best.
TriangleAxis find_triangle_axis(const SurfaceSolid& solid, const Triangle& triangle, double height, double most);

}  // namespace atl::collision
