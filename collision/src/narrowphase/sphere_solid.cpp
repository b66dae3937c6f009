// Spheres against solids: from where the centre is against the solid's surface.

#include "narrowphase/sphere_solid.h"

#include <collision/narrowphase/feature_id.h>
#include <collision/narrowphase/gauss_map_descent.h>
#include <collision/shapes/polytope.h>

#include <algorithm>
#include <cmath>

namespace atl::collision {
namespace {

SurfaceDistance from_capsule(const Shape& capsule, const Vector3& point) {
  const double z = std::clamp(point.z(), -capsule.half_height, capsule.half_height);
  const Vector3 offset = point - z * Vector3::UnitZ();
  const double distance = offset.norm();
  const Vector3 normal = distance > 0 ? Vector3(offset / distance) : Vector3(Vector3::UnitX());
  return {normal, distance - capsule.radius};
}

SurfaceDistance from_cylinder(const Shape& cylinder, const Vector3& point) {
  const Vector3 outwards = outwards_from_axis(point);
  const Vector3 up = point.z() < 0 ? Vector3(-Vector3::UnitZ()) : Vector3(Vector3::UnitZ());
  const double beside = length_2d(point.x(), point.y()) - cylinder.radius;
  const double above = std::abs(point.z()) - cylinder.half_height;
  if (beside > 0 && above > 0) {
    const double distance = length_2d(beside, above);
    return {(beside * outwards + above * up) / distance, distance};
  }
  return above >= beside ? SurfaceDistance{up, above} : SurfaceDistance{outwards, beside};
}

SurfaceDistance from_cone(const Shape& cone, const Vector3& point) {
  const double r = cone.radius;
  const double h = cone.half_height;
  const double slant = length_2d(r, 2 * h);
  const Vector3 outwards = outwards_from_axis(point);
  const double across = length_2d(point.x(), point.y());
  const Vector3 side_normal = (2 * h * outwards + r * Vector3::UnitZ()) / slant;
  const double beside = side_normal.dot(point - h * Vector3::UnitZ());
  const double below = -h - point.z();
  // The place of the point up the side, from the rim to the apex.
  const double along = ((r - across) * r + (point.z() + h) * 2 * h) / slant;
  SurfaceDistance side{side_normal, beside};
  SurfaceDistance base{-Vector3::UnitZ(), below};
  if (beside <= 0 && below <= 0) return below >= beside ? base : side;
  if (below > 0 && across <= r) return base;
  if (beside > 0 && along >= 0 && along <= slant) return side;
  const Vector3 nearest = along > slant ? Vector3(0, 0, h) : Vector3(r * outwards - h * Vector3::UnitZ());
  const double distance = (point - nearest).norm();
  if (!(distance > 0)) return side;
  return {(point - nearest) / distance, distance};
}

SurfaceDistance from_polytope(const Shape& shape, const Vector3& point) {
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

SurfaceDistance from_ball(const Vector3& centre, double radius, const Vector3& anywhere, const Vector3& point) {
  const Vector3 offset = point - centre;
  const double distance = offset.norm();
  return {distance > 0 ? Vector3(offset / distance) : anywhere, distance - radius};
}

// The foot of the cone's normal on the axis tells whether a ball or the cone between is nearest.
SurfaceDistance from_tapered_capsule(const Shape& shape, const Vector3& point) {
  const double h = shape.half_height;
  const double up = (shape.radius - shape.top_radius) / (2 * h);
  const double radial = std::sqrt((1 - up) * (1 + up));
  const Vector3 end = h * Vector3::UnitZ();
  const double foot = point.z() - up / radial * length_2d(point.x(), point.y());
  if (foot <= -h) return from_ball(-end, shape.radius, -Vector3::UnitZ(), point);
  if (foot >= h) return from_ball(end, shape.top_radius, Vector3::UnitZ(), point);
  const Vector3 normal = radial * outwards_from_axis(point) + up * Vector3::UnitZ();
  return {normal, normal.dot(point + end) - shape.radius};
}

// The foot x of a point p has p - x = t (x_i / e_i^2), so x_i = e_i^2 p_i / (t + e_i^2) with t the one root of
// f(t) = sum (e_i p_i / (t + e_i^2))^2 - 1 above minus the least e_i^2 (Eberly, "Distance from a point to an ellipse,
// an ellipsoid, or a hyperellipsoid", 2013, section 4). f falls and is convex: Newton's method from its left comes up
// to the root without passing it. Unknown is s = t + least e_i^2, in which nothing cancels.
SurfaceDistance from_ellipsoid(const Vector3& half_axes, const Vector3& point) {
  Eigen::Index shortest = 0;
  const double min = half_axes.minCoeff(&shortest);
  const Vector3 e = half_axes / min;
  const Vector3 p = point / min;
  const Vector3 beyond = (e - Vector3::Ones()).cwiseProduct(e + Vector3::Ones());  // e_i^2 - 1
  const Vector3 pull = e.cwiseProduct(p.cwiseAbs());
  double s = std::max(0.0, (pull - beyond).maxCoeff());
  // A point inside, on the plane across a shortest axis, may be nearest to two points beside that plane.
  const auto gradient_at = [&](double at) -> Vector3 {
    Vector3 gradient = Vector3::Zero();
    for (Eigen::Index i = 0; i < 3; ++i) {
      if (p[i] != 0) gradient[i] = p[i] / (at + beyond[i]);
    }
    return gradient;
  };
  if (s == 0) {
    Vector3 gradient = gradient_at(0);
    const double rest = 1 - e.cwiseProduct(gradient).squaredNorm();
    if (rest > 0) {
      gradient[shortest] = std::sqrt(rest);
      const double length = gradient.norm();
      return {gradient / length, -min * length};
    }
  }
  constexpr int max_steps = 60;
  for (int step = 0; step < max_steps; ++step) {
    double value = -1;
    double slope = 0;
    for (Eigen::Index i = 0; i < 3; ++i) {
      if (pull[i] == 0) continue;
      const double term = pull[i] / (s + beyond[i]);
      value += term * term;
      slope += 2 * term * term / (s + beyond[i]);
    }
    const double next = s + value / slope;
    if (!(next > s)) break;
    s = next;
  }
  const Vector3 gradient = gradient_at(s);
  const double length = gradient.norm();
  return {gradient / length, min * (s - 1) * length};
}

}  // namespace

SurfaceDistance distance_to_surface(const Shape& shape, const Vector3& point) {
  switch (shape.kind) {
    case ShapeKind::Sphere:
      return from_ball(Vector3::Zero(), shape.radius, Vector3::UnitZ(), point);
    case ShapeKind::Capsule:
      return from_capsule(shape, point);
    case ShapeKind::Cylinder:
      return from_cylinder(shape, point);
    case ShapeKind::Cone:
      return from_cone(shape, point);
    case ShapeKind::Ellipsoid:
      return from_ellipsoid(shape.half_extents, point);
    case ShapeKind::TaperedCapsule:
      return from_tapered_capsule(shape, point);
    default:
      return from_polytope(shape, point);
  }
}

void collide_sphere_solid(double radius, const Shape& solid, const Pose& second, double margin, Manifold& manifold) {
  const Vector3 centre = second.orientation.conjugate() * -second.position;
  if (!centre.allFinite()) return;
  const SurfaceDistance nearest = distance_to_surface(solid, centre);
  const double separation = nearest.distance - radius;
  if (!(separation <= margin)) return;
  manifold.reference_is_second = true;
  manifold.normal = nearest.normal;
  manifold.add(centre - radius * nearest.normal, separation, single_point_id());
}

}  // namespace atl::collision
