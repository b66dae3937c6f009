#include <collision/collide.h>
#include <collision/convex.h>
#include <collision/fcl_narrowphase.h>
#include <collision/feature_id.h>

#include <algorithm>
#include <cmath>

namespace atl::collision {

Narrowphase collide(const Shape& first_shape, const Shape& second_shape, const Pose& second, double margin,
                    Manifold& manifold) {
  manifold.count = 0;
  const ShapeKind first_kind = first_shape.kind;
  const ShapeKind second_kind = second_shape.kind;
  if (!is_convex_solid(first_kind)) return Narrowphase::ClosedForm;
  if (second_kind == ShapeKind::HalfSpace) {
    collide_half_space(first_shape, second_shape, second, margin, manifold);
    return Narrowphase::ClosedForm;
  }
  if (!is_convex_solid(second_kind)) return Narrowphase::ClosedForm;
  if (first_kind == ShapeKind::Sphere) {
    if (second_kind == ShapeKind::Sphere) {
      collide_spheres(first_shape.radius, second_shape.radius, second, margin, manifold);
      return Narrowphase::Fcl;
    }
    if (second_kind == ShapeKind::Box) {
      collide_sphere_box(first_shape.radius, second_shape.half_extents, second, margin, manifold);
      return Narrowphase::Fcl;
    }
    collide_convex(first_shape, second_shape, second, margin, manifold);
    return Narrowphase::ClosedForm;
  }
  if (first_kind == ShapeKind::Box && second_kind == ShapeKind::Box) {
    const bool asked = collide_boxes(first_shape.half_extents, second_shape.half_extents, second, margin, manifold);
    return asked ? Narrowphase::Fcl : Narrowphase::ClosedForm;
  }
  collide_convex(first_shape, second_shape, second, margin, manifold);
  return second_kind == ShapeKind::Capsule ? Narrowphase::ClosedForm : Narrowphase::Fcl;
}

void collide_spheres(double radius_first, double radius_second, const Pose& second, double margin, Manifold& manifold) {
  fcl_narrowphase::Axis axis;
  if (!fcl_narrowphase::sphere_sphere(radius_first, radius_second, second.position, margin, axis)) return;
  manifold.reference_is_second = false;
  manifold.normal = axis.normal;
  manifold.add(second.position - radius_second * axis.normal, axis.separation, single_point_id());
}

void meet_at_impact(double radius_first, double radius_second, const Pose& second, const Vector3& shift,
                    Manifold& manifold) {
  const double reach = radius_first + radius_second;
  const Vector3& start = second.position;
  // |start + t shift| = reach, t in [0, 1]; the root that does not cancel.
  const double a = shift.squaredNorm();
  const double b = -start.dot(shift);
  const double c = start.squaredNorm() - reach * reach;
  if (!(c > 0) || !(b > 0)) return;
  const double discriminant = b * b - a * c;
  const double time = std::min(discriminant >= 0 ? c / (b + std::sqrt(discriminant)) : b / a, 1.0);
  manifold.normal = (start + time * shift).normalized();
  manifold.count = 0;
  manifold.add(start - radius_second * manifold.normal, manifold.normal.dot(start) - reach, single_point_id());
}

void collide_sphere_box(double radius, const Vector3& half_extents, const Pose& box, double margin,
                        Manifold& manifold) {
  const Vector3 centre = box.orientation.conjugate() * -box.position;
  fcl_narrowphase::Axis axis;
  if (!fcl_narrowphase::sphere_box(radius, half_extents, centre, margin, axis)) return;
  manifold.reference_is_second = true;
  manifold.normal = -axis.normal;
  manifold.add(centre + radius * axis.normal, axis.separation, single_point_id());
}

}  // namespace atl::collision
