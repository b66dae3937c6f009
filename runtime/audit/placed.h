#pragma once
/// A PlacedShape resolved to world-frame doubles, the form in which the audit computes.

#include <atoll/errors.h>

#include <variant>
#include <vector>

#include "polytope.h"
#include "revolved.h"
#include "smooth.h"

namespace atl::audit {

/// A bounded convex solid: all points within `rounding` of its core.
struct Solid {
  Vector3 centre;  ///< m, the point that the core is given about
  std::variant<Polytope, Revolved, Smooth> core;
  double rounding = 0;  ///< m, the radius of a sphere (whose core is a point) or of a capsule (a segment)
};

/// Solid where normal . p <= offset.
struct PlacedHalfSpace {
  Vector3 normal;  ///< unit
  double offset;
};

/// Triangles of a mesh or a height field, in a frame of their own.
struct PlacedSurface {
  Vector3 origin;
  Matrix3 axes;  ///< columns: the surface's axes in the world frame
  std::variant<TriangleMesh, HeightField> geometry;
  std::vector<Eigen::AlignedBox3d> blocks;  ///< of a mesh: bounds of each `block_size` triangles, surface frame
  bool has_holes = false;                   ///< of a height field, which is not solid below then

  static constexpr std::size_t block_size = 64;
};

/// The solids of a compound, or the only one of any other bounded shape.
using PlacedSolids = std::vector<Solid>;
using Placed = std::variant<PlacedSolids, PlacedHalfSpace, PlacedSurface>;

Placed place(const PlacedShape& shape);

/// Bounds in the world frame; not of a half-space.
Eigen::AlignedBox3d bounds_of(const Placed& placed);
Eigen::AlignedBox3d bounds_of(const Solid& solid);

/// How far a solid reaches along a unit direction, from its centre.
inline double reach(const Solid& solid, const Vector3& direction) {
  return solid.rounding + std::visit([&](const auto& core) { return reach(core, direction); }, solid.core);
}

/// The least translation that parts a pair: `b` is moved by depth along the normal.
struct Penetration {
  double depth;    ///< m; see overlap() of errors.h for what it is where it is negative
  Vector3 normal;  ///< unit, from a to b
};

/// Either the other way round.
inline Penetration swapped(const Penetration& found) { return {found.depth, -found.normal}; }

Penetration penetration(const Placed& a, const Placed& b);
Penetration penetration(const Solid& a, const Solid& b);
Penetration penetration(const Solid& solid, const PlacedSurface& surface);

/// Signed overlap, defined as the public overlap() of errors.h.
double overlap(const Placed& a, const Placed& b);

/// The cores alone, of two solids whose centres are `offset` (m, from a's to b's) apart. For polytopes the least
/// overlap over all axes of the separating-axis test, infinite if they have none (points).
Penetration penetration(const Polytope& a, const Polytope& b, const Vector3& offset);
/// At least one of them a cylinder or cone.
Penetration penetration(const Polytope& a, const Revolved& b, const Vector3& offset);
Penetration penetration(const Revolved& a, const Revolved& b, const Vector3& offset);

/// The second an ellipsoid or a tapered capsule. Exact apart, too.
Penetration penetration(const Polytope& a, const Smooth& b, const Vector3& offset);
Penetration penetration(const Revolved& a, const Smooth& b, const Vector3& offset);
Penetration penetration(const Smooth& a, const Smooth& b, const Vector3& offset);

/// The shortest way from a point or segment to a polytope that it does not meet; 0 where they touch.
Vector3 shortest_way(const Polytope& from, const Polytope& to, const Vector3& offset);

/// Every triangle as the solid that stands for it: see overlap() of errors.h.
std::vector<Solid> triangles_of(const PlacedSurface& surface);
/// World frame, m.
std::vector<Vector3> vertices_of(const PlacedSurface& surface);
/// In the surface's frame, m.
Eigen::AlignedBox3d surface_bounds(const PlacedSurface& surface);
/// A lower bound of the gap to all triangles, m.
double gap_to_bounds(const PlacedSurface& surface, const Solid& solid);

/// m, of a ball about the middle of the shape's own bounds; infinite for half-spaces and surfaces.
double bounding_radius(const Shape& shape);

}  // namespace atl::audit
