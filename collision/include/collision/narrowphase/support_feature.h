#pragma once

#include <collision/narrowphase/clip.h>
#include <collision/shapes/polytope.h>
#include <collision/shapes/pose.h>

namespace atl::collision {

// Support features of a solid: the flat face, line or corner that looks along a direction, in the shape's own frame.
// `core` is the polytope (at any level) of a box or hull; other shapes don't read it.

/// Two directions count as the same, and a line as lying in a plane, within 8 degrees: a tilt that a contact of
/// faces survives. As for boxes.
inline constexpr double same_direction = 0.99;

/// A flat face that looks along a direction.
struct FlatFace {
  int number = -1;  ///< -1: the shape has no flat face
  Vector3 normal = Vector3::UnitZ();
  double cosine = -1;  ///< of the angle between normal and direction
};
FlatFace flat_face_along(const Shape& shape, const Polytope& core, const Vector3& unit_direction);
/// The same of a box or a hull, of the faces that meet in a vertex alone.
FlatFace flat_face_at(const Polytope& core, int vertex, const Vector3& unit_direction);
/// A face by its number; number -1 where there is no such face.
FlatFace flat_face(const Shape& shape, const Polytope& core, int number, const Vector3& unit_direction);

/// Corners of a flat face that others are clipped against. A disc becomes a polygon of 16 sides around it.
void face_polygon(const Shape& shape, const Polytope& core, int number, FacePolygon& face);

/// Finds the outline of a solid that is clipped against a reference face: the face that looks most directly along a
/// direction or, for round shapes, the line on the side that does; else the farthest corner, which is the solid's
/// farthest point. A disc becomes eight points of its rim, which stay the same as long as it lies flat; one that is
/// tilted by so much that its other side lies more than `reach` (m) back touches, and rolls, on its farthest point
/// alone. For a box or a hull, a `vertex` that is farthest along the direction limits the choice to the faces that meet
/// there. Returns the number of the face: that of a flat face, or 2 for a line on the side.
int incident_outline(const Shape& shape, const Polytope& core, const Vector3& unit_direction, double reach,
                     Outline& outline, int vertex = -1);

/// The line on the side of a capsule, plain or tapered, cylinder or cone that looks along a direction.
struct SideLine {
  bool exists = false;  ///< and lies across the direction, within 8 degrees
  Vector3 tail, head;   ///< m, on the surface
};
SideLine side_line(const Shape& shape, const Vector3& unit_direction);

}  // namespace atl::collision
