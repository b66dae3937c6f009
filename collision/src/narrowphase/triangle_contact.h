#pragma once

#include <collision/narrowphase/manifold.h>

#include "narrowphase/triangle_axis.h"

namespace atl::collision {

/// The contact of a solid with the front of one triangle, in the frame of the surface.
struct TriangleContact {
  static constexpr int capacity = 16;

  Vector3 normal = Vector3::UnitZ();  ///< unit, out of the front
  TriangleAxis::Part part = TriangleAxis::Part::Face;
  int vertex = 0;             ///< of the triangle, where a vertex has the contact
  std::uint8_t material = 0;  ///< the triangle's
  int count = 0;
  std::array<Manifold::Point, capacity> points;
  /// Bit i: point i lies where the solid's feature crosses a flat edge, so it doesn't end there: the
  /// neighbour has the rest of it.
  std::uint32_t inner = 0;
  /// Bit i: point i is the solid's own, whichever triangle it is over.
  std::uint32_t own = 0;

  void add(const Vector3& position, double separation, FeatureId id, bool is_inner = false, bool is_own = false) {
    if (count == capacity) return;
    inner |= static_cast<std::uint32_t>(is_inner) << count;
    own |= static_cast<std::uint32_t>(is_own) << count;
    points[static_cast<std::size_t>(count++)] = {position, separation, id};
  }
  void clear() {
    count = 0;
    inner = 0;
    own = 0;
  }
};

/// True if a point lies over a triangle, or up to `slack` (m) beside.
bool lies_over(const Triangle& triangle, const Vector3& point, double slack);

/// True if a solid may touch a triangle whose vertices and normal are known. If so, `height` (m) is the solid's
/// distance from the triangle's plane.
bool comes_near(const SurfaceSolid& solid, const Triangle& face, double margin, double& height);

/// Finds the points no farther apart than `margin` (m), of what comes near. `number` is the triangle's, part of the
/// points' ids.
///
/// Over the triangle the normal is its own, and separations are those from its plane. At a convex edge or at a vertex
/// of one the normal is the best one between the triangle's and the neighbours'; what is nearer along a neighbour's
/// own is left to the neighbour. At edges that aren't convex the normal stays the triangle's, and there are points
/// only over the triangle. A solid wholly behind has none; one that is partly behind is pushed to the front, never to
/// the back.
void touch_triangle(const SurfaceSolid& solid, const Triangle& triangle, double height, std::uint32_t number,
                    double margin, TriangleContact& contact);

}  // namespace atl::collision
