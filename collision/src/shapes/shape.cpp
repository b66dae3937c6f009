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
    case ShapeKind::HalfSpace:
    case ShapeKind::Mesh:
    case ShapeKind::HeightField:
      break;
  }
  return {infinity, Vector3::Zero(), Matrix3::Identity() * infinity};
}

}  // namespace atl::collision
