// Box against box, held against an exact separating-axis test.

#include <collision/narrowphase/collide.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "support/random.h"

namespace atl::collision {
namespace {

using test::Random;

struct Separation {
  Vector3 normal;  // from the first box to the second
  double distance = -std::numeric_limits<double>::infinity();
  bool face = false;
};

// The axis of greatest separation over 6 face normals, or over 9 cross products of edges.
Separation best_axis(const Vector3& a, const Vector3& b, const Pose& second, bool faces) {
  const Matrix3 r = second.orientation.toRotationMatrix();
  Separation best;
  const auto consider = [&](Vector3 axis) {
    if (axis.norm() < 1e-6) return;
    axis.normalize();
    if (axis.dot(second.position) < 0) axis = -axis;
    const double reach = a.dot(axis.cwiseAbs()) + b.dot((r.transpose() * axis).cwiseAbs());
    const double distance = axis.dot(second.position) - reach;
    if (distance > best.distance) best = {axis, distance, faces};
  };
  for (int i = 0; i < 3; ++i) {
    if (faces) {
      consider(Vector3::Unit(i));
      consider(r.col(i));
    } else {
      for (int j = 0; j < 3; ++j) consider(Vector3::Unit(i).cross(r.col(j)));
    }
  }
  return best;
}

// The normal from the first box to the second, in the first's frame.
Vector3 normal_of(const Manifold& manifold, const Pose& second) {
  return manifold.reference_is_second ? Vector3(-(second.orientation * manifold.normal)) : manifold.normal;
}

// A random direction and a distance at which the boxes just overlap or almost touch, by `gap`.
Pose placed(Random& random, const Vector3& a, const Vector3& b, double gap) {
  Pose second{random.direction(), random.rotation()};
  double near = 0;
  double far = 2 * (a.norm() + b.norm());
  const Vector3 direction = second.position;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (near + far);
    second.position = middle * direction;
    const double distance = std::max(best_axis(a, b, second, true).distance, best_axis(a, b, second, false).distance);
    (distance < gap ? near : far) = middle;
  }
  return second;
}

TEST(CollideBoxes, ShallowOverlapHasTheExactAxisAndDepth) {
  Random random(1);
  int faces = 0;
  int edges = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vector3 a = random.vector(0.4).cwiseAbs() + Vector3::Constant(0.2);
    const Vector3 b = random.vector(0.4).cwiseAbs() + Vector3::Constant(0.2);
    const double size = std::min(a.minCoeff(), b.minCoeff());
    const Pose second = placed(random, a, b, -1e-3 * size);
    const Separation face = best_axis(a, b, second, true);
    const Separation edge = best_axis(a, b, second, false);
    Manifold manifold;
    collide_boxes(a, b, second, 0.02 * size, manifold);
    ASSERT_GT(manifold.count, 0) << i;
    // Between a face and an edge that look the same way, the face may win although it is a little deeper.
    if (face.distance >= edge.distance) {
      const double angle = normal_of(manifold, second).cross(face.normal).norm();
      // Another face may be as good.
      if (angle < 0.0017) ++faces;
      ASSERT_NEAR(manifold.least_separation(), face.distance, 2e-3 * size) << i;
    } else if (face.distance < edge.distance - 0.03 * size) {
      ASSERT_EQ(manifold.count, 1) << i;
      ASSERT_LT(normal_of(manifold, second).cross(edge.normal).norm(), 0.0017) << i;
      ASSERT_NEAR(manifold.least_separation(), edge.distance, 1e-9) << i;
      ++edges;
    }
  }
  EXPECT_GT(faces, 5000);
  EXPECT_GT(edges, 1000);
}

TEST(CollideBoxes, FaceOnFaceHasFourPointsSpreadOverTheOverlap) {
  Random random(2);
  for (int i = 0; i < 2000; ++i) {
    const double turn = random.real(-std::numbers::pi, std::numbers::pi);
    const Vector3 shift(random.real(-0.5, 0.5), random.real(-0.5, 0.5), 0);
    const double gap = random.real(-0.001, 0.02);
    const Pose second{shift + Vector3(0, 0, 1 + gap), Quaternion(Eigen::AngleAxisd(turn, Vector3::UnitZ()))};
    Manifold manifold;
    collide_boxes(Vector3::Constant(0.5), Vector3::Constant(0.5), second, 0.025, manifold);
    ASSERT_EQ(manifold.count, 4) << i;
    std::set<FeatureId> ids;
    Vector3 least = Vector3::Constant(9);
    Vector3 most = Vector3::Constant(-9);
    for (const Manifold::Point& point : manifold.points) {
      EXPECT_NEAR(point.separation, gap, 1e-12);
      ids.insert(point.id);
      least = least.cwiseMin(point.position);
      most = most.cwiseMax(point.position);
    }
    EXPECT_EQ(ids.size(), 4u) << "ids are unique in a manifold";
    EXPECT_GT((most - least).norm(), 0.4);
  }
}

TEST(CollideBoxes, OnlyWithinTheMargin) {
  for (const double gap : {0.0, 0.01, 0.0249, 0.0251, 0.1}) {
    Manifold manifold;
    collide_boxes(Vector3::Constant(0.5), Vector3::Constant(0.5), {Vector3(0.2, 0.1, 1 + gap), Quaternion::Identity()},
                  0.025, manifold);
    EXPECT_EQ(manifold.count, gap <= 0.025 ? 4 : 0) << gap;
  }
}

// A box on a box, flush and shifted: what a rounding error away makes of it must not change any id.
TEST(CollideBoxes, IdsOutlastNoise) {
  Random random(3);
  for (const Vector3& shift : {Vector3(0, 0, 1), Vector3(0.5, 0, 1), Vector3(0.5, 0.5, 1), Vector3(0.51, -0.51, 1)}) {
    std::set<FeatureId> ids;
    Manifold manifold;
    for (int i = 0; i < 500; ++i) {
      const Vector3 turn = random.vector(1e-7);
      const Pose second{shift + random.vector(1e-7), Quaternion(1, turn.x(), turn.y(), turn.z()).normalized()};
      manifold = as_last(manifold);
      collide_boxes(Vector3::Constant(0.5), Vector3::Constant(0.5), second, 0.025, manifold);
      ASSERT_EQ(manifold.count, 4);
      for (const Manifold::Point& point : manifold.points) ids.insert(point.id);
    }
    EXPECT_EQ(ids.size(), 4u) << shift.transpose();
  }
}

// Boxes at rest on each other, tilted by a hair, touch deepest where edges cross; they still want a face.
TEST(CollideBoxes, RestingBoxesKeepTheirFaceWhenTheyRock) {
  Random random(4);
  Manifold manifold;
  collide_boxes(Vector3::Constant(0.5), Vector3::Constant(0.5), {Vector3(0.51, 0.51, 1 - 5e-4), Quaternion::Identity()},
                0.025, manifold);
  for (int i = 0; i < 2000; ++i) {
    const Vector3 turn = random.vector(1e-3);
    const Pose second{Vector3(0.51, 0.51, 1 - 5e-4), Quaternion(1, turn.x(), turn.y(), turn.z()).normalized()};
    manifold = as_last(manifold);
    collide_boxes(Vector3::Constant(0.5), Vector3::Constant(0.5), second, 0.025, manifold);
    ASSERT_EQ(manifold.count, 4) << i;
  }
}

TEST(CollideBoxes, ExtremePairsStayFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Vector3 unit = Vector3::Constant(0.5);
  struct Case {
    Vector3 a, b, position;
  };
  const Case cases[] = {{unit, unit, Vector3::Zero()},
                        {unit, unit, Vector3(1, 1, 1)},
                        {unit, unit, Vector3(0, 0, 1)},
                        {unit, unit, Vector3(nan, 0, 0)},
                        {unit, unit, Vector3(1e300, 0, 0)},
                        {Vector3::Constant(500), Vector3::Constant(0.005), Vector3(3, 4, 500.004)},
                        {Vector3::Constant(1e5), Vector3::Constant(1), Vector3(0, 0, 1e5)},
                        {Vector3(1, 1, 1e-6), unit, Vector3(0, 0, 0.5)}};
  for (const Case& c : cases) {
    Manifold manifold;
    collide_boxes(c.a, c.b, {c.position, Quaternion::Identity()}, 0.01, manifold);
    ASSERT_LE(manifold.count, 4);
    for (int i = 0; i < manifold.count; ++i) {
      const Manifold::Point& point = manifold.points[static_cast<std::size_t>(i)];
      EXPECT_TRUE(point.position.allFinite() && std::isfinite(point.separation));
    }
    EXPECT_TRUE(manifold.normal.allFinite());
  }
}

// Boxes that come fast get more points than the crossing of edges, each on a surface at both its ends.
TEST(CollideBoxes, OtherCornersLieOnBothSurfaces) {
  Random random(31);
  int corners = 0;
  const auto beyond = [](const Vector3& half, const Vector3& point) { return (point.cwiseAbs() - half).maxCoeff(); };
  for (int run = 0; run < 3000; ++run) {
    const Vector3 first(random.real(0.2, 1), random.real(0.2, 1), random.real(0.2, 1));
    const Vector3 second(random.real(0.2, 1), random.real(0.2, 1), random.real(0.2, 1));
    Pose pose{random.vector(1).normalized(), random.rotation()};
    // To where they touch.
    for (int round = 0; round < 3; ++round) {
      const Separation edges = best_axis(first, second, pose, false), faces = best_axis(first, second, pose, true);
      const Separation& best = edges.distance > faces.distance ? edges : faces;
      pose.position -= best.distance * best.normal;
    }
    Manifold slow, fast;
    const double size = std::min(first.minCoeff(), second.minCoeff());
    collide_boxes(first, second, pose, 0.05 * size, slow);
    collide_boxes(first, second, pose, 0.5 * size, fast);
    if (slow.count != 1 || fast.count == 0 || fast.reference_is_second) continue;
    EXPECT_NEAR(fast.least_separation(), slow.least_separation(), 1e-12);
    for (int i = 0; i < fast.count; ++i) {
      const Manifold::Point& point = fast.points[static_cast<std::size_t>(i)];
      if (point.separation < 1e-6) continue;
      ++corners;
      const Vector3 opposite = point.position - point.separation * fast.normal;
      EXPECT_NEAR(beyond(first, opposite), 0, 1e-9);
      EXPECT_NEAR(beyond(second, pose.orientation.conjugate() * (point.position - pose.position)), 0, 1e-9);
    }
  }
  EXPECT_GT(corners, 300);
}

}  // namespace
}  // namespace atl::collision
