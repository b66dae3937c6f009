#pragma once
/// Solids of random sizes, a few tenths of a metre.

#include <collision/shapes/hull.h>
#include <collision/shapes/shape.h>

#include <cmath>
#include <deque>
#include <utility>
#include <variant>
#include <vector>

#include "support/random.h"

namespace atl::test {

inline collision::Hull hull_of(const std::vector<Eigen::Vector3d>& points) {
  return std::get<collision::Hull>(collision::build_hull(points));
}

/// Hulls stay where they are as long as the store does.
class Solids {
 public:
  /// A hull is that of so many points on a sphere.
  collision::Shape random(collision::ShapeKind kind, Random& random, int points_of_hull = 16) {
    using collision::Shape, collision::ShapeKind;
    switch (kind) {
      case ShapeKind::Sphere:
        return Shape::sphere(random.real(0.1, 0.5));
      case ShapeKind::Capsule:
        return Shape::capsule(random.real(0.1, 0.4), random.real(0.1, 0.6));
      case ShapeKind::Box:
        return Shape::box({random.real(0.1, 0.5), random.real(0.1, 0.5), random.real(0.1, 0.5)});
      case ShapeKind::Cylinder:
        return Shape::cylinder(random.real(0.1, 0.5), random.real(0.1, 0.5));
      case ShapeKind::Cone:
        return Shape::cone(random.real(0.15, 0.5), random.real(0.15, 0.5));
      case ShapeKind::Ellipsoid:
        return Shape::ellipsoid({random.real(0.15, 0.5), random.real(0.15, 0.5), random.real(0.15, 0.5)});
      case ShapeKind::TaperedCapsule: {
        const double bottom = random.real(0.1, 0.4);
        const double top = random.real(0.1, 0.4);
        return Shape::tapered_capsule(bottom, top, std::abs(bottom - top) + random.real(0.05, 0.5));
      }
      default: {
        std::vector<Eigen::Vector3d> points;
        for (int i = 0; i < points_of_hull; ++i) points.push_back(0.5 * random.direction());
        return hull(hull_of(points));
      }
    }
  }
  collision::Shape hull(collision::Hull hull) {
    hulls_.push_back(std::move(hull));
    return collision::Shape::convex_hull(hulls_.back());
  }

 private:
  std::deque<collision::Hull> hulls_;
};

}  // namespace atl::test
