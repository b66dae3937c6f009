#include <collision/shapes/height_field.h>
#include <collision/shapes/hull.h>
#include <collision/shapes/shape.h>
#include <collision/shapes/triangle_mesh.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "shapes/hypotenuse.h"

namespace atl::collision {
namespace {

Shape round_shape(ShapeKind kind, double radius, double half_height) {
  Shape shape;
  shape.kind = kind;
  shape.radius = radius;
  shape.half_height = half_height;
  return shape;
}

// Moments about x (and y), and about z, per kg.
Matrix3 about_z(double across, double along) { return Vector3(across, across, along).asDiagonal(); }

// A cylinder of height 2 h and two half spheres, each 3/8 r beyond its end.
MassProperties capsule_mass(double r, double h) {
  const double cylinder = 2 * std::numbers::pi * r * r * h;
  const double sphere = 4.0 / 3.0 * std::numbers::pi * r * r * r;
  const double total = cylinder + sphere;
  const double along = (cylinder * 0.5 + sphere * 0.4) * r * r;
  const double cylinder_across = cylinder * (r * r / 4 + h * h / 3);
  const double sphere_across = sphere * (0.4 * r * r + h * h + 0.75 * r * h);
  return {total, Vector3::Zero(), about_z((cylinder_across + sphere_across) / total, along / total)};
}

// Moments of the area across z of a solid of revolution, over a stretch of z: of discs of radius R, all over pi.
struct Discs {
  double volume = 0;  // integral of R^2
  double first = 0;   // of R^2 z
  double second = 0;  // of R^2 z^2
  double fourth = 0;  // of R^4

  void add(const Discs& about, double place) {
    volume += about.volume;
    first += about.first + place * about.volume;
    second += about.second + place * (2 * about.first + place * about.volume);
    fourth += about.fourth;
  }
};

// A ball's part below a height, R^2 = r^2 - z^2, about its centre.
Discs ball_below(double r, double height) {
  const double x = height / r;
  const double r3 = r * r * r;
  return {r3 * (2 + x * (3 - x * x)) / 3, r3 * r * (x * x * (2 - x * x) - 1) / 4,
          r3 * r * r * (2 + x * x * x * (5 - 3 * x * x)) / 15,
          r3 * r * r * (8 + x * (15 - x * x * (10 - 3 * x * x))) / 15};
}

// A cone's part, R = middle + slope z for |z| <= half, about its middle.
Discs frustum(double middle, double slope, double half) {
  const double m = middle * middle;
  const double k = slope * half * slope * half;
  const double h2 = half * half;
  return {2 * half * (m + k / 3), 4.0 / 3 * middle * slope * half * h2, 2 * half * h2 * (m / 3 + k / 5),
          2 * half * (m * m + 2 * m * k + k * k / 5)};
}

// The parts of the balls beyond the circles in which the cone around both touches them, and the cone between.
MassProperties tapered_capsule_mass(double bottom, double top, double h) {
  const double sine = (bottom - top) / (2 * h);  // of the lean of the cone's normals
  const double cosine = std::sqrt((1 - sine) * (1 + sine));
  const double low = -h + bottom * sine;
  const double high = h + top * sine;
  Discs whole;
  whole.add(ball_below(bottom, bottom * sine), -h);
  whole.add(frustum(0.5 * cosine * (bottom + top), -sine / cosine, 0.5 * (high - low)), 0.5 * (low + high));
  Discs above = ball_below(top, -top * sine);
  above.first = -above.first;
  whole.add(above, h);
  const double centre = whole.first / whole.volume;
  const double along = whole.second / whole.volume - centre * centre;
  const double across = whole.fourth / (4 * whole.volume);
  return {std::numbers::pi * whole.volume, centre * Vector3::UnitZ(), about_z(across + along, 2 * across)};
}

}  // namespace

Shape Shape::sphere(double radius) {
  Shape shape = round_shape(ShapeKind::Sphere, radius, 0);
  shape.bounding_radius = radius;
  shape.inner_radius = radius;
  return shape;
}

Shape Shape::capsule(double radius, double half_height) {
  Shape shape = round_shape(ShapeKind::Capsule, radius, half_height);
  shape.bounding_radius = radius + half_height;
  shape.inner_radius = radius;
  return shape;
}

Shape Shape::box(const Vector3& half_extents) {
  Shape shape;
  shape.kind = ShapeKind::Box;
  shape.half_extents = half_extents;
  shape.bounding_radius = half_extents.norm();
  shape.inner_radius = half_extents.minCoeff();
  return shape;
}

Shape Shape::cylinder(double radius, double half_height) {
  Shape shape = round_shape(ShapeKind::Cylinder, radius, half_height);
  shape.bounding_radius = hypotenuse(radius, half_height);
  shape.inner_radius = std::min(radius, half_height);
  return shape;
}

// The sphere that touches base and side: r h / (r + slant) of a triangle with base 2 r and height h.
Shape Shape::cone(double radius, double half_height) {
  Shape shape = round_shape(ShapeKind::Cone, radius, half_height);
  shape.bounding_radius = hypotenuse(radius, half_height);
  shape.inner_radius = 2 * radius * half_height / (radius + hypotenuse(radius, 2 * half_height));
  return shape;
}

Shape Shape::ellipsoid(const Vector3& half_axes) {
  Shape shape;
  shape.kind = ShapeKind::Ellipsoid;
  shape.half_extents = half_axes;
  shape.bounding_radius = half_axes.maxCoeff();
  shape.inner_radius = half_axes.minCoeff();
  return shape;
}

Shape Shape::tapered_capsule(double bottom_radius, double top_radius, double half_height) {
  Shape shape = round_shape(ShapeKind::TaperedCapsule, bottom_radius, half_height);
  shape.top_radius = top_radius;
  shape.inner_radius = std::max(bottom_radius, top_radius);
  shape.bounding_radius = half_height + shape.inner_radius;
  return shape;
}

Shape Shape::convex_hull(const Hull& hull) {
  Shape shape;
  shape.kind = ShapeKind::Hull;
  shape.hull = &hull;
  shape.bounding_radius = hull.bounding_radius;
  shape.inner_radius = hull.inner_radius;
  return shape;
}

Shape Shape::half_space(const Vector3& unit_normal, double offset) {
  Shape shape;
  shape.kind = ShapeKind::HalfSpace;
  shape.normal = unit_normal;
  shape.offset = offset;
  shape.bounding_radius = infinity;
  shape.inner_radius = infinity;
  return shape;
}

Shape Shape::triangle_mesh(const TriangleMesh& mesh) {
  Shape shape;
  shape.kind = ShapeKind::Mesh;
  shape.mesh = &mesh;
  shape.bounding_radius = mesh.bounding_radius;
  shape.inner_radius = infinity;
  return shape;
}

Shape Shape::height_field(const HeightField& field) {
  Shape shape;
  shape.kind = ShapeKind::HeightField;
  shape.field = &field;
  shape.bounding_radius = field.bounding_radius;
  shape.inner_radius = infinity;
  return shape;
}

MassProperties mass_properties(const Shape& shape) {
  const double r = shape.radius;
  const double h = shape.half_height;
  switch (shape.kind) {
    case ShapeKind::Sphere:
      return {4.0 / 3.0 * std::numbers::pi * r * r * r, Vector3::Zero(), Matrix3::Identity() * (0.4 * r * r)};
    case ShapeKind::Capsule:
      return capsule_mass(r, h);
    case ShapeKind::Box: {
      const Vector3 square = shape.half_extents.cwiseAbs2();
      return {8 * shape.half_extents.prod(), Vector3::Zero(),
              (Vector3::Constant(square.sum()) - square).asDiagonal().toDenseMatrix() / 3};
    }
    case ShapeKind::Cylinder:
      return {2 * std::numbers::pi * r * r * h, Vector3::Zero(), about_z(r * r / 4 + h * h / 3, r * r / 2)};
    case ShapeKind::Cone:
      // Height 2 h; the centre a quarter of it above the base.
      return {2.0 / 3.0 * std::numbers::pi * r * r * h, Vector3(0, 0, -0.5 * h),
              about_z(3.0 / 20 * (r * r + h * h), 0.3 * r * r)};
    case ShapeKind::Hull:
      return shape.hull->mass;
    case ShapeKind::Ellipsoid: {
      const Vector3 square = shape.half_extents.cwiseAbs2();
      return {4.0 / 3.0 * std::numbers::pi * shape.half_extents.prod(), Vector3::Zero(),
              (Vector3::Constant(square.sum()) - square).asDiagonal().toDenseMatrix() / 5};
    }
    case ShapeKind::TaperedCapsule:
      return tapered_capsule_mass(r, shape.top_radius, h);
    case ShapeKind::HalfSpace:
    case ShapeKind::Mesh:
    case ShapeKind::HeightField:
      break;
  }
  return {infinity, Vector3::Zero(), Matrix3::Identity() * infinity};
}

}  // namespace atl::collision
