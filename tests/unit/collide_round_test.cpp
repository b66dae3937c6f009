// Spheres against spheres and boxes, against closed forms.

#include <collision/narrowphase/collide.h>
#include <collision/narrowphase/feature_id.h>
#include <collision/shapes/shape.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/random.h"

namespace atl::collision {
namespace {

using test::Random;

// The one point of a manifold: normal, position and separation in the reference shape's frame.
void expect_point(const Manifold& manifold, const Vector3& normal, const Vector3& position, double separation,
                  double tolerance) {
  ASSERT_EQ(manifold.count, 1);
  EXPECT_LT((manifold.normal - normal).norm(), 1e-9);
  EXPECT_LT((manifold.points[0].position - position).norm(), tolerance);
  EXPECT_NEAR(manifold.points[0].separation, separation, tolerance);
  EXPECT_EQ(manifold.points[0].id, single_point_id());
}

TEST(CollideSpheres, MatchesDistanceOfCentres) {
  Random random(1);
  for (int i = 0; i < 5000; ++i) {
    const double r1 = random.magnitude(0.01, 10);
    const double r2 = random.magnitude(0.01, 10);
    const double margin = random.real(0, 0.3) * std::min(r1, r2);
    const Vector3 direction = random.direction();
    const double separation = random.real(-0.9, 0.5) * std::min(r1, r2);
    const Pose second{(r1 + r2 + separation) * direction, random.rotation()};
    Manifold manifold;
    EXPECT_EQ(collide(Shape::sphere(r1), Shape::sphere(r2), second, margin, manifold), Narrowphase::Fcl);
    if (separation > margin) {
      EXPECT_EQ(manifold.count, 0);
    } else {
      EXPECT_FALSE(manifold.reference_is_second);
      expect_point(manifold, direction, (r1 + separation) * direction, separation, 1e-12 * (r1 + r2));
    }
  }
}

TEST(CollideSpheres, CoincidentCentresPartAlongSomeAxis) {
  Manifold manifold;
  collide_spheres(0.5, 0.25, {Vector3::Zero(), Quaternion::Identity()}, 0.01, manifold);
  ASSERT_EQ(manifold.count, 1);
  EXPECT_NEAR(manifold.normal.norm(), 1, 1e-12);
  EXPECT_NEAR(manifold.points[0].separation, -0.75, 1e-12);
}

// The closed form: nearest point of the box, or the nearest face if the centre is inside.
struct Nearest {
  Vector3 normal;
  double distance;  // of the centre from the surface; negative inside
};
Nearest nearest(const Vector3& half, const Vector3& centre) {
  const Vector3 outside = centre - centre.cwiseMax(-half).cwiseMin(half);
  if (outside.norm() > 0) return {outside.normalized(), outside.norm()};
  Eigen::Index axis = 0;
  const double depth = (half - centre.cwiseAbs()).minCoeff(&axis);
  return {std::copysign(1.0, centre[axis]) * Vector3::Unit(axis), -depth};
}

void expect_sphere_on_box(double radius, const Vector3& half, const Vector3& centre, double margin, Random& random) {
  // The box as the sphere sees it, in any orientation.
  const Quaternion orientation = random.rotation();
  const Pose box{-(orientation * centre), orientation};
  const Nearest expected = nearest(half, centre);
  Manifold manifold;
  EXPECT_EQ(collide(Shape::sphere(radius), Shape::box(half), box, margin, manifold), Narrowphase::Fcl);
  if (expected.distance - radius > margin) {
    EXPECT_EQ(manifold.count, 0);
    return;
  }
  EXPECT_TRUE(manifold.reference_is_second);
  expect_point(manifold, expected.normal, centre - radius * expected.normal, expected.distance - radius,
               1e-11 * (1 + half.norm()));
}

TEST(CollideSphereBox, CentreOutsideMatchesNearestPoint) {
  Random random(2);
  for (int i = 0; i < 5000; ++i) {
    const Vector3 half(random.real(0.1, 2), random.real(0.1, 2), random.real(0.1, 2));
    const double radius = random.magnitude(0.05, 2);
    // Beyond one, two or three faces: over a face, an edge or a corner.
    const int faces = 1 + i % 3;
    Vector3 centre = random.vector(1).cwiseProduct(half);
    for (int k = 0; k < faces; ++k) {
      const Eigen::Index axis = (i / 3 + k) % 3;
      centre[axis] = std::copysign(half[axis] + random.real(0.01, 1) * radius, centre[axis]);
    }
    const double margin = random.chance(0.5) ? 0 : 0.2 * radius;
    if (std::abs(nearest(half, centre).distance - radius - margin) < 1e-9) continue;
    expect_sphere_on_box(radius, half, centre, margin, random);
  }
}

TEST(CollideSphereBox, CentreOnTheSurfaceOrInTheMiddle) {
  const Vector3 half(0.5, 1, 2);
  for (const Vector3& centre : {Vector3(0.5, 0.2, 0.3), Vector3(0.5, 1, 0), Vector3(0.5, 1, 2), Vector3(0, 0, 0)}) {
    Manifold manifold;
    collide_sphere_box(0.1, half, {-centre, Quaternion::Identity()}, 0.01, manifold);
    ASSERT_EQ(manifold.count, 1) << centre.transpose();
    EXPECT_NEAR(manifold.normal.norm(), 1, 1e-12);
    // Moved out along the normal by the overlap it just touches.
    const Vector3 parted = centre - manifold.points[0].separation * manifold.normal;
    EXPECT_NEAR(nearest(half, parted).distance, 0.1, 1e-12);
  }
}

}  // namespace
}  // namespace atl::collision
