#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <limits>

namespace atl::collision {

inline constexpr double infinity = std::numeric_limits<double>::infinity();

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;

struct Hull;
struct TriangleMesh;
struct HeightField;
struct Pose;

/// The kinds of shapes, in the order of dispatch: the shape of the lower kind comes first in a pair. Kinds up to
/// TaperedCapsule are bounded and convex; a mesh and a height field are surfaces, on static and kinematic bodies only.
enum class ShapeKind : std::uint8_t {
  Sphere,
  Capsule,
  Box,
  Cylinder,
  Cone,
  Hull,
  Ellipsoid,
  TaperedCapsule,
  HalfSpace,
  Mesh,
  HeightField
};

constexpr bool is_convex_solid(ShapeKind kind) { return kind <= ShapeKind::TaperedCapsule; }
/// Flat at an end, and round about its axis.
constexpr bool is_round(ShapeKind kind) { return kind == ShapeKind::Cylinder || kind == ShapeKind::Cone; }
/// Round everywhere, with neither corners nor flat faces, and not of one radius.
constexpr bool is_smooth(ShapeKind kind) { return kind == ShapeKind::Ellipsoid || kind == ShapeKind::TaperedCapsule; }
constexpr bool is_surface(ShapeKind kind) { return kind >= ShapeKind::Mesh; }

/// A shape in a frame of its own, which a collider places on a body. Which fields count depends on the kind.
/// Geometry that is pointed to is immutable and outlives the shape.
struct Shape {
  ShapeKind kind = ShapeKind::Box;
  Vector3 half_extents = Vector3::Zero();  ///< box; half axes of the ellipsoid, m
  /// Sphere, capsule, cylinder, base of the cone, ball of the tapered capsule at -half_height, m.
  double radius = 0;
  double top_radius = 0;  ///< ball of the tapered capsule at +half_height, m
  /// Half the height along z, m. Capsules: of the segment between the centres of the caps. Cone: base at -half_height,
  /// apex at +half_height.
  double half_height = 0;
  Vector3 normal = Vector3::UnitZ();  ///< half-space: solid where normal . p <= offset
  double offset = 0;                  ///< half-space, m
  union {
    const Hull* hull = nullptr;
    const TriangleMesh* mesh;
    const HeightField* field;
  };
  double bounding_radius = 0;  ///< m, about the shape's origin; infinite for half-spaces
  /// m, of the largest inscribed sphere: the size that tolerances are parts of. Infinite for half-spaces and
  /// surfaces, which have no size of their own.
  double inner_radius = 0;

  static Shape sphere(double radius);
  static Shape capsule(double radius, double half_height);
  static Shape box(const Vector3& half_extents);
  static Shape cylinder(double radius, double half_height);
  static Shape cone(double radius, double half_height);
  static Shape ellipsoid(const Vector3& half_axes);
  /// Neither ball holds the other, see parts_balls().
  static Shape tapered_capsule(double bottom_radius, double top_radius, double half_height);
  static Shape convex_hull(const Hull& hull);
  static Shape half_space(const Vector3& unit_normal, double offset);
  static Shape triangle_mesh(const TriangleMesh& mesh);
  static Shape height_field(const HeightField& field);
};

/// Tells if neither ball of a tapered capsule holds the other: the sine of the lean of its side is at most 1 - 1e-9, so
/// that rounding leaves it a cosine.
constexpr bool parts_balls(double bottom_radius, double top_radius, double half_height) {
  const double difference = bottom_radius < top_radius ? top_radius - bottom_radius : bottom_radius - top_radius;
  return difference <= (1 - 1e-9) * (2 * half_height);
}

/// Volume, centre of mass and inertia of a solid of uniform density. Unbounded shapes and surfaces have an
/// infinite volume and inertia, about their origin.
struct MassProperties {
  double volume = 0;                 ///< m^3
  Vector3 centre = Vector3::Zero();  ///< m, in the shape's frame
  /// The inertia about the centre, per kg of mass, in m^2, along the axes of the shape's frame.
  Matrix3 unit_inertia = Matrix3::Zero();
};
MassProperties mass_properties(const Shape& shape);

// Common to all bounded convex solids (Sphere to TaperedCapsule). `second` is always the pose of the second
// shape in the frame of the first.

/// The point of the solid that lies farthest along a direction (any length, not zero), shape's frame.
Vector3 support_point(const Shape& shape, const Vector3& direction);

/// The reach (m) of the solid along a unit direction: support_point . direction.
double reach_along(const Shape& shape, const Vector3& unit_direction);

/// A lower bound of the distance of two solids, from the planes across the line of their centres. It is cheap enough to
/// come before any other test.
struct CentreLine {
  Vector3 direction;  ///< unit, from the first centre to the second; zero where they coincide
  double gap;         ///< m, a lower bound of the distance; minus infinity where they coincide
};
CentreLine centre_line(const Shape& first, const Pose& at_first, const Shape& second, const Pose& at_second);

}  // namespace atl::collision
