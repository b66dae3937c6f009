#include <collision/queries/ray.h>
#include <collision/shapes/hull.h>
#include <features/with_meshes.h>

#include <algorithm>
#include <cmath>

#include "queries/ray_surface.h"

namespace atl::collision {
namespace {

// The stretch of a line within a convex set, and the normal where the line enters.
struct Stretch {
  double enter = -infinity;
  double leave = infinity;
  Vector3 normal = Vector3::Zero();

  bool empty() const { return !(enter <= leave); }
};

// A line through the set's neighbourhood.
struct Line {
  Vector3 origin;
  Vector3 direction;  // unit

  Vector3 at(double t) const { return origin + t * direction; }
};

Stretch nothing() { return {infinity, -infinity, Vector3::Zero()}; }

// Cuts a stretch at a plane: what lies where normal . p <= offset stays.
void cut(const Line& line, const Vector3& normal, double offset, Stretch& stretch) {
  const double speed = normal.dot(line.direction);
  const double depth = offset - normal.dot(line.origin);
  if (speed < 0) {
    const double t = depth / speed;
    if (t > stretch.enter) {
      stretch.enter = t;
      stretch.normal = normal;
    }
  } else if (speed > 0) {
    stretch.leave = std::min(stretch.leave, depth / speed);
  } else if (depth < 0) {
    stretch = nothing();
  }
}

void cut_between(const Line& line, double low, double high, Stretch& stretch) {
  cut(line, Vector3::UnitZ(), high, stretch);
  cut(line, -Vector3::UnitZ(), -low, stretch);
}

Stretch of_sphere(const Line& line, const Vector3& centre, double radius) {
  const Vector3 seen = line.origin - centre;
  const double middle = -seen.dot(line.direction);
  // Measured from the point closest to the centre, at which squares don't cancel.
  const double square = radius * radius - (seen + middle * line.direction).squaredNorm();
  if (square < 0) return nothing();
  const double half = std::sqrt(square);
  return {middle - half, middle + half, (line.at(middle - half) - centre).normalized()};
}

// The cylinder about z without ends.
Stretch of_tube(const Line& line, double radius) {
  const Vector3& o = line.origin;
  const Vector3& d = line.direction;
  const double speed_square = d.x() * d.x() + d.y() * d.y();
  const double moment = o.x() * d.y() - o.y() * d.x();
  if (speed_square < 1e-200) return o.x() * o.x() + o.y() * o.y() <= radius * radius ? Stretch() : nothing();
  const double square = radius * radius * speed_square - moment * moment;
  if (square < 0) return nothing();
  const double middle = -(o.x() * d.x() + o.y() * d.y());
  const double half = std::sqrt(square);
  Stretch stretch{(middle - half) / speed_square, (middle + half) / speed_square, {}};
  const Vector3 entry = line.at(stretch.enter);
  stretch.normal = Vector3(entry.x(), entry.y(), 0).normalized();
  return stretch;
}

// Adds one of the convex parts that cover a convex set: it is entered where the first of them is.
void join(const Stretch& part, Stretch& whole) {
  if (part.empty()) return;
  if (part.enter < whole.enter) {
    whole.enter = part.enter;
    whole.normal = part.normal;
  }
  whole.leave = std::max(whole.leave, part.leave);
}

Stretch of_capsule(const Line& line, double radius, double half_height) {
  Stretch whole = of_tube(line, radius);
  cut_between(line, -half_height, half_height, whole);
  if (whole.empty()) whole = nothing();
  for (const double end : {-half_height, half_height}) join(of_sphere(line, Vector3(0, 0, end), radius), whole);
  return whole;
}

// The cone's side: x^2 + y^2 <= w^2 with a radius w >= 0 that falls by the slope along z. `w`: at the line's origin.
Stretch of_cone_side(const Line& line, double slope, double w) {
  const Vector3& o = line.origin;
  const Vector3& d = line.direction;
  const double fall = -slope * d.z();
  const double a = d.x() * d.x() + d.y() * d.y() - fall * fall;
  const double b = o.x() * d.x() + o.y() * d.y() - w * fall;
  const double c = o.x() * o.x() + o.y() * o.y() - w * w;
  // a t^2 + 2 b t + c <= 0, without subtracting what is nearly equal.
  Stretch stretch;
  const double square = b * b - a * c;
  if (square < 0 && a > 0) return nothing();
  const double root = -(b + std::copysign(std::sqrt(std::max(0.0, square)), b));
  if (a > 0) {
    // Between the roots; b = c = 0 is the apex alone.
    const double first = root / a;
    const double second = root != 0 ? c / root : 0;
    stretch.enter = std::min(first, second);
    stretch.leave = std::max(first, second);
  } else if (a < 0) {
    // Outside of the roots: the one half-line is on this cone, the other on its mirror image above the apex.
    const double first = root / a;
    const double second = root != 0 ? c / root : 0;
    (fall > 0 ? stretch.enter : stretch.leave) = fall > 0 ? std::max(first, second) : std::min(first, second);
  } else if (b != 0) {
    (b < 0 ? stretch.enter : stretch.leave) = -c / (2 * b);
  } else if (c > 0) {
    return nothing();
  }
  if (stretch.enter > -infinity) {
    const Vector3 entry = line.at(stretch.enter);
    const double across = std::sqrt(entry.x() * entry.x() + entry.y() * entry.y());
    const Vector3 outwards = across > 0 ? Vector3(entry.x() / across, entry.y() / across, slope) : Vector3::UnitZ();
    stretch.normal = outwards.normalized();
  }
  return stretch;
}

// The side from the base at -half_height to the apex at half_height; its mirror image above the apex is cut off.
Stretch of_cone(const Line& line, double radius, double half_height) {
  const double slope = radius / (2 * half_height);
  return of_cone_side(line, slope, slope * (half_height - line.origin.z()));
}

// Two balls and the cone around both, between the circles in which it touches them.
Stretch of_tapered_capsule(const Line& line, double bottom, double top, double half_height) {
  const double sine = (bottom - top) / (2 * half_height);  // of the lean of the cone's normals
  const double cosine = std::sqrt((1 - sine) * (1 + sine));
  const double slope = sine / cosine;
  Stretch whole = of_cone_side(line, slope, (0.5 * (bottom + top) - sine * line.origin.z()) / cosine);
  cut_between(line, -half_height + bottom * sine, half_height + top * sine, whole);
  if (whole.empty()) whole = nothing();
  join(of_sphere(line, Vector3(0, 0, -half_height), bottom), whole);
  join(of_sphere(line, Vector3(0, 0, half_height), top), whole);
  return whole;
}

// A unit ball where lengths are counted in half axes.
Stretch of_ellipsoid(const Line& line, const Vector3& half_axes) {
  const Vector3 origin = line.origin.cwiseQuotient(half_axes);
  const Vector3 direction = line.direction.cwiseQuotient(half_axes);
  const double speed = direction.norm();
  const Stretch ball = of_sphere({origin, direction / speed}, Vector3::Zero(), 1);
  if (ball.empty()) return nothing();
  return {ball.enter / speed, ball.leave / speed, ball.normal.cwiseQuotient(half_axes).normalized()};
}

Stretch of_box(const Line& line, const Vector3& half_extents) {
  Stretch stretch;
  for (int axis = 0; axis < 3; ++axis) {
    cut(line, Vector3::Unit(axis), half_extents[axis], stretch);
    cut(line, -Vector3::Unit(axis), half_extents[axis], stretch);
  }
  return stretch;
}

Stretch of_solid(const Shape& shape, const Line& line) {
  switch (shape.kind) {
    case ShapeKind::Sphere:
      return of_sphere(line, Vector3::Zero(), shape.radius);
    case ShapeKind::Capsule:
      return of_capsule(line, shape.radius, shape.half_height);
    case ShapeKind::Box:
      return of_box(line, shape.half_extents);
    case ShapeKind::Cylinder:
    case ShapeKind::Cone: {
      Stretch stretch = shape.kind == ShapeKind::Cylinder ? of_tube(line, shape.radius)
                                                          : of_cone(line, shape.radius, shape.half_height);
      cut_between(line, -shape.half_height, shape.half_height, stretch);
      return stretch;
    }
    case ShapeKind::Ellipsoid:
      return of_ellipsoid(line, shape.half_extents);
    case ShapeKind::TaperedCapsule:
      return of_tapered_capsule(line, shape.radius, shape.top_radius, shape.half_height);
    case ShapeKind::Hull: {
      Stretch stretch;
      for (const Hull::Plane& plane : shape.hull->planes) cut(line, plane.normal, plane.offset, stretch);
      return stretch;
    }
    default: {
      Stretch stretch;
      cut(line, shape.normal, shape.offset, stretch);
      return stretch;
    }
  }
}

bool cast_ray_at_solid(const Shape& shape, const Ray& ray, RayHit& hit) {
  // Starts at the point of the line closest to the shape's origin, so that a far start costs no precision.
  double ahead = shape.kind == ShapeKind::HalfSpace ? 0 : -ray.origin.dot(ray.direction);
  if (ahead < shape.bounding_radius) ahead = 0;
  const Stretch stretch = of_solid(shape, {ray.origin + ahead * ray.direction, ray.direction});
  const double enter = stretch.enter + ahead;
  const double leave = stretch.leave + ahead;
  if (!(enter <= leave) || !(enter <= ray.max_t)) return false;
  // A start within rounding of the surface counts as on it, for rays that go on from where another one hit.
  const double size = shape.kind == ShapeKind::HalfSpace ? std::abs(shape.offset) : shape.bounding_radius;
  const double slack = 1e-14 * (size + ray.origin.norm());
  if (!(leave > slack)) return false;
  hit = {};
  if (enter < -slack) {
    hit.normal = -ray.direction;
    hit.started_inside = true;
    return true;
  }
  hit.t = std::max(0.0, enter);
  hit.normal = stretch.normal;
  return true;
}

}  // namespace

bool cast_ray(const Shape& shape, const Ray& ray, Sides sides, RayHit& hit) {
  if (with_meshes && shape.kind == ShapeKind::Mesh) return cast_ray_at_mesh(*shape.mesh, ray, sides, hit);
  if (with_meshes && shape.kind == ShapeKind::HeightField) return cast_ray_at_field(*shape.field, ray, sides, hit);
  return cast_ray_at_solid(shape, ray, hit);
}

}  // namespace atl::collision
