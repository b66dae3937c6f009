// Box against box: margins, ids that last, faces that are kept, and points of boxes that come fast.

#include <collision/narrowphase/collide.h>
#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "support/random.h"

namespace atl::collision {
namespace {

using test::Random;

struct Separation {
  Vector3 normal;  // from the first box to the second
  double distance = -std::numeric_limits<double>::infinity();
};

// The axis of greatest separation over 6 face normals and 9 cross products of edges.
Separation best_axis(const Vector3& a, const Vector3& b, const Pose& second) {
  const Matrix3 r = second.orientation.toRotationMatrix();
  Separation best;
  const auto consider = [&](Vector3 axis) {
    if (axis.norm() < 1e-6) return;
    axis.normalize();
    if (axis.dot(second.position) < 0) axis = -axis;
    const double reach = a.dot(axis.cwiseAbs()) + b.dot((r.transpose() * axis).cwiseAbs());
    const double distance = axis.dot(second.position) - reach;
    if (distance > best.distance) best = {axis, distance};
  };
  for (int i = 0; i < 3; ++i) {
    consider(Vector3::Unit(i));
    consider(r.col(i));
    for (int j = 0; j < 3; ++j) consider(Vector3::Unit(i).cross(r.col(j)));
  }
  return best;
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
      const Separation best = best_axis(first, second, pose);
      pose.position -= best.distance * best.normal;
    }
    Manifold slow, fast;
    const double size = std::min(first.minCoeff(), second.minCoeff());
    collide_boxes(first, second, pose, 0.05 * size, slow);
    collide_boxes(first, second, pose, 0.5 * size, fast);
    if (slow.count != 1 || fast.count == 0 || fast.reference_is_second) continue;
    EXPECT_NEAR(fast.min_separation(), slow.min_separation(), 1e-12);
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
