#pragma once

#include <collision/shapes/shape.h>

namespace atl::collision::fcl_narrowphase {

/// FCL's answer for a pair: an axis of contact. The separation is exact along the normal.
struct Axis {
  Vector3 normal = Vector3::Zero();  ///< unit, from the first shape to the second, first shape's frame
  double separation = 0;             ///< m, negative where the shapes overlap
  /// Boxes: 1-3 a face axis of the first, 4-6 of the second, 7-15 the cross product of edge (code - 7) / 3 of
  /// the first and (code - 7) % 3 of the second. Spheres: 1.
  int code = 0;
};

// FCL 0.7 stands behind these functions alone. They allocate nothing in a steady state, never throw, and
// answer false (no contact) for poses that are not finite. `position` and `rotation` take the second shape's
// frame to the first's. Pairs farther apart than `margin` (m, >= 0) give false.

/// Separating-axis test of FCL's boxBox2 (from ODE), which prefers a face axis to an edge axis that is less
/// than 5% better.
bool box_box(const Vector3& half_first, const Vector3& half_second, const Vector3& position, const Matrix3& rotation,
             double margin, Axis& axis);

bool sphere_sphere(double radius_first, double radius_second, const Vector3& position, double margin, Axis& axis);

/// The sphere is the first shape, the box the second; here `centre` is the sphere's, and the normal is given,
/// in the frame of the box.
bool sphere_box(double radius, const Vector3& half_extents, const Vector3& centre, double margin, Axis& axis);

/// Any two solids, by libccd's portal refinement (Snethen, "XenoCollide", Game Programming Gems 7, 2008): finds
/// the way out along the line of centres, so the normal is good where the overlap is shallow and a mere start
/// where it is deep. The shape with the larger inner radius is grown about its centre by the margin and 1.5% of the
/// smaller inner radius, so that pairs which just touch are found. `separation` is the depth that the refinement came
/// to, to within 1% of that radius, less the growth.
bool convex(const Shape& first_shape, const Shape& second_shape, const Vector3& position, const Matrix3& rotation,
            double margin, Axis& axis);

}  // namespace atl::collision::fcl_narrowphase
