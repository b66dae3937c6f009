#include <collision/collide.h>
#include <collision/fcl_narrowphase.h>
#include <collision/feature_id.h>

namespace atl::collision {

Narrowphase collide(const Shape& first_shape, const Shape& second_shape, const Pose& second, double margin,
                    Manifold& manifold) {
  manifold.count = 0;
  switch (first_shape.kind) {
    case ShapeKind::Sphere:
      switch (second_shape.kind) {
        case ShapeKind::Sphere:
          collide_spheres(first_shape.radius, second_shape.radius, second, margin, manifold);
          return Narrowphase::Fcl;
        case ShapeKind::Box:
          collide_sphere_box(first_shape.radius, second_shape.half_extents, second, margin, manifold);
          return Narrowphase::Fcl;
        case ShapeKind::HalfSpace:
          collide_sphere_half_space(first_shape.radius, second_shape, second, margin, manifold);
          return Narrowphase::ClosedForm;
      }
      break;
    case ShapeKind::Box:
      if (second_shape.kind == ShapeKind::Box) {
        collide_boxes(first_shape.half_extents, second_shape.half_extents, second, margin, manifold);
        return Narrowphase::Fcl;
      }
      collide_box_half_space(first_shape.half_extents, second_shape, second, margin, manifold);
      return Narrowphase::ClosedForm;
    case ShapeKind::HalfSpace:
      break;
  }
  return Narrowphase::ClosedForm;
}

void collide_spheres(double radius_first, double radius_second, const Pose& second, double margin, Manifold& manifold) {
  fcl_narrowphase::Axis axis;
  if (!fcl_narrowphase::sphere_sphere(radius_first, radius_second, second.position, margin, axis)) return;
  manifold.reference_is_second = false;
  manifold.normal = axis.normal;
  manifold.add(second.position - radius_second * axis.normal, axis.separation, single_point_id());
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

void collide_sphere_half_space(double radius, const Shape& half_space, const Pose& second, double margin,
                               Manifold& manifold) {
  const Vector3 centre = second.orientation.conjugate() * -second.position;
  const Vector3 lowest = centre - radius * half_space.normal;
  const double separation = half_space.normal.dot(lowest) - half_space.offset;
  manifold.reference_is_second = true;
  manifold.normal = half_space.normal;
  if (separation <= margin) manifold.add(lowest, separation, single_point_id());
}

void collide_box_half_space(const Vector3& half_extents, const Shape& half_space, const Pose& second, double margin,
                            Manifold& manifold) {
  manifold.reference_is_second = true;
  manifold.normal = half_space.normal;
  const Matrix3 rotation = second.orientation.conjugate().toRotationMatrix();
  const Vector3 centre = rotation * -second.position;
  const double centre_height = half_space.normal.dot(centre) - half_space.offset;
  const Vector3 up = rotation.transpose() * half_space.normal;
  const Vector3 reach = up.cwiseProduct(half_extents);
  if (!(centre_height - reach.cwiseAbs().sum() <= margin)) return;

  // The corners of the face that looks most directly down; it has the lowest corner.
  Eigen::Index axis = 0;
  up.cwiseAbs().maxCoeff(&axis);
  const int lower_side = up[axis] > 0 ? 1 : 0;  // 1: the negative one
  for (int corner = 0; corner < 8; ++corner) {
    if ((corner >> axis & 1) != lower_side) continue;
    const Vector3 sign(corner & 1 ? -1 : 1, corner & 2 ? -1 : 1, corner & 4 ? -1 : 1);
    const double separation = centre_height + sign.dot(reach);
    if (separation > margin) continue;
    manifold.add(centre + rotation * sign.cwiseProduct(half_extents), separation, corner_id(corner));
  }
}

}  // namespace atl::collision
