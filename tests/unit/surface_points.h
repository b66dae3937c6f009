#pragma once
/// Random points of shapes' surfaces with a normal there: two that face each other across a gap are, by
/// convexity, the closest points of their shapes, so the distance is known without computing one.

#include <collision/shapes/hull.h>
#include <collision/shapes/pose.h>
#include <collision/shapes/shape.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "support/min_turn.h"
#include "support/random.h"

namespace atl::test {

using collision::Pose;
using collision::Quaternion;
using collision::Shape;
using collision::ShapeKind;
using collision::Vector3;

struct SurfacePoint {
  Vector3 point;
  Vector3 normal;  // unit, outwards
};

inline Vector3 around_z(double angle, double radius, double z) {
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

inline SurfacePoint random_of_box(const Vector3& half, Random& random) {
  // Over a face, an edge or a corner.
  SurfacePoint result{random.vector(1).cwiseProduct(half), Vector3::Zero()};
  const auto axes = 1 + random.below(3);
  const auto start = random.below(3);
  for (std::uint32_t k = 0; k < axes; ++k) {
    const Eigen::Index axis = (start + k) % 3;
    const double side = random.chance(0.5) ? 1 : -1;
    result.point[axis] = side * half[axis];
    result.normal[axis] = side * random.real(0.01, 1);
  }
  result.normal.normalize();
  return result;
}

inline SurfacePoint random_of_cylinder(double radius, double half_height, Random& random) {
  const double angle = random.real(0, 2 * std::numbers::pi);
  const double side = random.chance(0.5) ? 1 : -1;
  switch (random.below(3)) {
    case 0:
      return {around_z(angle, radius * random.real(0, 1), side * half_height), Vector3(0, 0, side)};
    case 1:
      return {around_z(angle, radius, half_height * random.real(-1, 1)), around_z(angle, 1, 0)};
    default: {
      const double tilt = random.real(0, std::numbers::pi / 2);
      return {around_z(angle, radius, side * half_height), around_z(angle, std::cos(tilt), side * std::sin(tilt))};
    }
  }
}

inline SurfacePoint random_of_cone(double radius, double half_height, Random& random) {
  const double angle = random.real(0, 2 * std::numbers::pi);
  const double side_tilt = std::atan2(radius, 2 * half_height);  // of the side's normal above the horizontal
  const auto outwards = [&](double tilt) { return around_z(angle, std::cos(tilt), std::sin(tilt)); };
  switch (random.below(4)) {
    case 0:
      return {around_z(angle, radius * random.real(0, 1), -half_height), -Vector3::UnitZ()};
    case 1: {
      const double t = random.real(0, 1);
      return {around_z(angle, radius * (1 - t), half_height * (2 * t - 1)), outwards(side_tilt)};
    }
    case 2:
      return {around_z(angle, radius, -half_height), outwards(random.real(-std::numbers::pi / 2, side_tilt))};
    default:
      return {Vector3(0, 0, half_height), outwards(random.real(side_tilt, std::numbers::pi / 2))};
  }
}

// At a vertex: the normal is any direction that the vertex lies farthest along.
inline SurfacePoint random_of_hull(const collision::Hull& hull, Random& random) {
  const Vector3 normal = random.direction();
  const auto reach = [&](const Vector3& v) { return v.dot(normal); };
  const auto farthest = std::max_element(hull.vertices.begin(), hull.vertices.end(),
                                         [&](const Vector3& v, const Vector3& w) { return reach(v) < reach(w); });
  return {*farthest, normal};
}

inline SurfacePoint random_surface_point(const Shape& shape, Random& random) {
  switch (shape.kind) {
    case ShapeKind::Box:
      return random_of_box(shape.half_extents, random);
    case ShapeKind::Cylinder:
      return random_of_cylinder(shape.radius, shape.half_height, random);
    case ShapeKind::Cone:
      return random_of_cone(shape.radius, shape.half_height, random);
    case ShapeKind::Hull:
      return random_of_hull(*shape.hull, random);
    case ShapeKind::Capsule: {
      // Half of them on the side.
      Vector3 normal = random.direction();
      if (random.chance(0.5)) normal = around_z(random.real(0, 6.3), 1, 0);
      const double z = normal.z() == 0 ? random.real(-1, 1) : (normal.z() > 0 ? 1 : -1);
      return {Vector3(0, 0, z * shape.half_height) + shape.radius * normal, normal};
    }
    case ShapeKind::Ellipsoid: {
      const Vector3 ball = random.direction();
      return {ball.cwiseProduct(shape.half_extents), ball.cwiseQuotient(shape.half_extents).normalized()};
    }
    case ShapeKind::TaperedCapsule: {
      // Half of them on the side, where the normals of both balls are those of the cone around them.
      const double lean = std::asin((shape.radius - shape.top_radius) / (2 * shape.half_height));
      const bool on_side = random.chance(0.5);
      const Vector3 normal =
          on_side ? around_z(random.real(0, 6.3), std::cos(lean), std::sin(lean)) : random.direction();
      const double up = on_side ? random.real(0, 1) : (normal.z() > std::sin(lean) ? 1 : 0);
      return {Vector3(0, 0, (2 * up - 1) * shape.half_height) +
                  (shape.radius + up * (shape.top_radius - shape.radius)) * normal,
              normal};
    }
    default: {
      const Vector3 normal = random.direction();
      return {shape.radius * normal, normal};
    }
  }
}

/// The pose of the second shape in the frame of the first that lays the points a gap apart, turned at random
/// about the line between them.
inline Pose facing(const SurfacePoint& first, const SurfacePoint& second, double gap, Random& random) {
  const auto turn = min_turn(second.normal, -first.normal).normalized();
  const Eigen::AngleAxisd twist(random.real(-3, 3), first.normal);
  const Quaternion orientation((Eigen::Quaterniond(twist) * turn).normalized());
  return {first.point + gap * first.normal - orientation * second.point, orientation};
}

}  // namespace atl::test
