#include <collision/narrowphase/collide.h>
#include <collision/narrowphase/fcl_narrowphase.h>
#include <collision/narrowphase/feature_id.h>
#include <collision/shapes/shape.h>

#include <algorithm>
#include <cmath>

namespace atl::collision {
namespace {

// FCL's answer about a sphere, unless it is refuted by the separation (m) along its axis: that is what it says, and the
// best there is. Rounding is a part of 1e-16 of the coordinates.
Narrowphase take(const fcl_narrowphase::Axis& answer, double along, double scale, fcl_narrowphase::Axis& best) {
  const double error = 1e-9 * scale;
  if (!(std::abs(along - answer.separation) <= error && std::abs(along - best.separation) <= error)) {
    return Narrowphase::Repaired;
  }
  best = answer;
  return Narrowphase::Fcl;
}

// The axis from a sphere to the nearest point of a box, in the frame of the box; out of the nearest face if the centre
// is inside.
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
  const double distance = second.position.norm();
  const double separation = distance - radius_first - radius_second;
  fcl_narrowphase::Axis axis{distance > 0 ? Vector3(second.position / distance) : Vector3::UnitZ(), separation, 1};
  Narrowphase by = Narrowphase::Kept;
  if (!manifold.known) {
    fcl_narrowphase::Axis answer;
    if (!fcl_narrowphase::sphere_sphere(radius_first, radius_second, second.position, margin, answer)) {
      return Narrowphase::Fcl;
    }
    by = take(answer, answer.normal.dot(second.position) - radius_first - radius_second,
              distance + radius_first + radius_second, axis);
  } else if (!(separation <= margin)) {
    return by;
  }
  manifold.reference_is_second = false;
  manifold.normal = axis.normal;
  manifold.add(second.position - radius_second * axis.normal, axis.separation, single_point_id());
  return by;
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
  fcl_narrowphase::Axis axis = sphere_to_box(radius, half_extents, centre);
  Narrowphase by = Narrowphase::Kept;
  if (!manifold.known) {
    fcl_narrowphase::Axis answer;
    if (!fcl_narrowphase::sphere_box(radius, half_extents, centre, margin, answer)) return Narrowphase::Fcl;
    const double along = -answer.normal.dot(centre) - answer.normal.cwiseAbs().dot(half_extents) - radius;
    by = take(answer, along, centre.norm() + half_extents.sum() + radius, axis);
  } else if (!(axis.separation <= margin)) {
    return by;
  }
  manifold.reference_is_second = true;
  manifold.normal = -axis.normal;
  manifold.on_face = axis.normal.cwiseAbs().maxCoeff() == 1;
  manifold.add(centre + radius * axis.normal, axis.separation, single_point_id());
  return by;
}

}  // namespace atl::collision
