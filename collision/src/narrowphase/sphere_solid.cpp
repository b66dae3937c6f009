// Spheres against solids: from where the centre is against the solid's surface.

#include "narrowphase/sphere_solid.h"

#include <collision/narrowphase/feature_id.h>
#include <collision/narrowphase/gauss_map_descent.h>
#include <collision/shapes/polytope.h>

#include <algorithm>
#include <cmath>

namespace atl::collision {
namespace {

// Of a point from a surface: outward unit normal, and distance (m), negative inside.
struct Surface {
  Vector3 normal;
  double distance;
};

Vector3 outwards_from_axis(const Vector3& point) {
  const double across = length_2d(point.x(), point.y());
  return across > 0 ? Vector3(point.x() / across, point.y() / across, 0) : Vector3(Vector3::UnitX());
}

Surface from_capsule(const Shape& capsule, const Vector3& point) {
  const double z = std::clamp(point.z(), -capsule.half_height, capsule.half_height);
  const Vector3 offset = point - z * Vector3::UnitZ();
  const double distance = offset.norm();
  const Vector3 normal = distance > 0 ? Vector3(offset / distance) : Vector3(Vector3::UnitX());
  return {normal, distance - capsule.radius};
}

Surface from_cylinder(const Shape& cylinder, const Vector3& point) {
  const Vector3 outwards = outwards_from_axis(point);
  const Vector3 up = point.z() < 0 ? Vector3(-Vector3::UnitZ()) : Vector3(Vector3::UnitZ());
  const double beside = length_2d(point.x(), point.y()) - cylinder.radius;
  const double above = std::abs(point.z()) - cylinder.half_height;
  if (beside > 0 && above > 0) {
    const double distance = length_2d(beside, above);
    return {(beside * outwards + above * up) / distance, distance};
  }
  return above >= beside ? Surface{up, above} : Surface{outwards, beside};
}

Surface from_cone(const Shape& cone, const Vector3& point) {
  const double r = cone.radius;
  const double h = cone.half_height;
  const double slant = length_2d(r, 2 * h);
  const Vector3 outwards = outwards_from_axis(point);
  const double across = length_2d(point.x(), point.y());
  const Vector3 side_normal = (2 * h * outwards + r * Vector3::UnitZ()) / slant;
  const double beside = side_normal.dot(point - h * Vector3::UnitZ());
  const double below = -h - point.z();
  // How far up the side, from the rim to the apex, the point lies.
  const double along = ((r - across) * r + (point.z() + h) * 2 * h) / slant;
  Surface side{side_normal, beside};
  Surface base{-Vector3::UnitZ(), below};
  if (beside <= 0 && below <= 0) return below >= beside ? base : side;
  if (below > 0 && across <= r) return base;
  if (beside > 0 && along >= 0 && along <= slant) return side;
  const Vector3 nearest = along > slant ? Vector3(0, 0, h) : Vector3(r * outwards - h * Vector3::UnitZ());
  const double distance = (point - nearest).norm();
  if (!(distance > 0)) return side;
  return {(point - nearest) / distance, distance};
}

Surface from_polytope(const Shape& shape, const Vector3& point) {
  Core solid;
  solid.build(shape);
  const Polytope& polytope = solid.polytope();
  int best = 0;
  double distance = -INFINITY;
  for (int f = 0; f < polytope.face_count; ++f) {
    const double above = polytope.planes[f].normal.dot(point) - polytope.planes[f].offset;
    if (above <= distance) continue;
    distance = above;
    best = f;
  }
  if (distance <= 0) return {polytope.planes[best].normal, distance};
  Core sphere;
  sphere.build(Shape::sphere(0));
  const LocalAxis axis =
      GaussMapDescent(polytope, sphere.polytope(), point, Matrix3::Identity()).from_face_of_first(best);
  return {axis.normal, axis.separation};
}

Surface surface(const Shape& shape, const Vector3& point) {
  switch (shape.kind) {
    case ShapeKind::Sphere: {
      const double distance = point.norm();
      const Vector3 normal = distance > 0 ? Vector3(point / distance) : Vector3(Vector3::UnitZ());
      return {normal, distance - shape.radius};
    }
    case ShapeKind::Capsule:
      return from_capsule(shape, point);
    case ShapeKind::Cylinder:
      return from_cylinder(shape, point);
    case ShapeKind::Cone:
      return from_cone(shape, point);
    default:
      return from_polytope(shape, point);
  }
}

}  // namespace

void collide_sphere_solid(double radius, const Shape& solid, const Pose& second, double margin, Manifold& manifold) {
  const Vector3 centre = second.orientation.conjugate() * -second.position;
  if (!centre.allFinite()) return;
  const Surface nearest = surface(solid, centre);
  const double separation = nearest.distance - radius;
  if (!(separation <= margin)) return;
  manifold.reference_is_second = true;
  manifold.normal = nearest.normal;
  manifold.add(centre - radius * nearest.normal, separation, single_point_id());
}

}  // namespace atl::collision
