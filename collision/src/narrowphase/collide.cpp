#include <collision/narrowphase/collide.h>
#include <collision/narrowphase/fcl_narrowphase.h>
#include <collision/narrowphase/feature_id.h>
#include <collision/shapes/shape.h>

#include <algorithm>
#include <cmath>

namespace atl::collision {
namespace {

// Whether what FCL says of a sphere is what it comes to, m. Rounding is a part of 1e-16 of the coordinates.
bool agrees(double found, double expected, double scale) { return std::abs(found - expected) <= 1e-9 * scale; }

// From a sphere to the nearest point of a box, in the frame of the box; out of the nearest face if the centre is
// inside.
fcl_narrowphase::Axis sphere_to_box(double radius, const Vector3& half_extents, const Vector3& centre) {
  const Vector3 away = centre - centre.cwiseMax(-half_extents).cwiseMin(half_extents);
  const double distance = away.norm();
  if (distance > 0) return {away / -distance, distance - radius, 1};
  Eigen::Index face = 0;
  const double depth = (half_extents - centre.cwiseAbs()).minCoeff(&face);
  return {(centre[face] < 0 ? 1.0 : -1.0) * Vector3::Unit(face), -depth - radius, 1};
}

}  // namespace

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
      return collide_spheres(first_shape.radius, second_shape.radius, second, margin, manifold);
    }
    if (second_kind == ShapeKind::Box) {
      return collide_sphere_box(first_shape.radius, second_shape.half_extents, second, margin, manifold);
    }
    return collide_convex(first_shape, second_shape, second, margin, manifold);
  }
  if (first_kind == ShapeKind::Box && second_kind == ShapeKind::Box) {
    return collide_boxes(first_shape.half_extents, second_shape.half_extents, second, margin, manifold);
  }
  return collide_convex(first_shape, second_shape, second, margin, manifold);
}

Narrowphase collide_spheres(double radius_first, double radius_second, const Pose& second, double margin,
                            Manifold& manifold) {
  fcl_narrowphase::Axis axis;
  if (!fcl_narrowphase::sphere_sphere(radius_first, radius_second, second.position, margin, axis)) {
    return Narrowphase::Fcl;
  }
  const double distance = second.position.norm();
  const double separation = distance - radius_first - radius_second;
  const bool fits = agrees(axis.normal.dot(second.position), distance, distance) &&
                    agrees(axis.separation, separation, distance + radius_first + radius_second);
  if (!fits) axis = {distance > 0 ? Vector3(second.position / distance) : Vector3::UnitZ(), separation, 1};
  manifold.reference_is_second = false;
  manifold.normal = axis.normal;
  manifold.add(second.position - radius_second * axis.normal, axis.separation, single_point_id());
  return fits ? Narrowphase::Fcl : Narrowphase::Repaired;
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

Narrowphase collide_sphere_box(double radius, const Vector3& half_extents, const Pose& box, double margin,
                               Manifold& manifold) {
  const Vector3 centre = box.orientation.conjugate() * -box.position;
  fcl_narrowphase::Axis axis;
  if (!fcl_narrowphase::sphere_box(radius, half_extents, centre, margin, axis)) return Narrowphase::Fcl;
  const auto along = [&](const Vector3& normal) {
    return -normal.dot(centre) - normal.cwiseAbs().dot(half_extents) - radius;
  };
  const fcl_narrowphase::Axis best = sphere_to_box(radius, half_extents, centre);
  const double scale = centre.norm() + half_extents.sum() + radius;
  const bool fits =
      agrees(along(axis.normal), best.separation, scale) && agrees(axis.separation, best.separation, scale);
  if (!fits) axis = best;
  manifold.reference_is_second = true;
  manifold.normal = -axis.normal;
  manifold.add(centre + radius * axis.normal, axis.separation, single_point_id());
  return fits ? Narrowphase::Fcl : Narrowphase::Repaired;
}

}  // namespace atl::collision
