// Records of bodies' motion.

#include <gtest/gtest.h>
#include <solver/integrate/motion.h>

#include <algorithm>

#include "support/random.h"

namespace atl::solver {
namespace {

using test::Random;

TEST(Motion, AnOdometerOfTurnsBoundsHowFarAnyPointGot) {
  Random random(11);
  for (int run = 0; run < 50; ++run) {
    BodyTable bodies;
    bodies.resize(1);
    collision::MotionBounds bounds;
    bounds.resize(1);
    MovedBodies notes;
    const double pace = random.magnitude(1e-4, 3);
    const Quaternion start = random.rotation();
    const Vector3 point = random.direction();
    bodies.set_orientation(0, start);
    double farthest = 0;
    double way = 0;
    for (int step = 0; step < 20; ++step) {
      const BodyPose before{bodies.position(0), bodies.orientation(0)};
      const Quaternion turn = random.rotation(pace);
      bodies.set_orientation(0, (turn * before.orientation).normalized());
      note_motion(bodies, bounds, 0, before, 1.0 / 60, notes);
      farthest = std::max(farthest, (bodies.orientation(0) * point - start * point).norm());
      way += 2 * turn.vec().norm();
    }
    EXPECT_GE(bodies.turned[0], farthest - 1e-12);
    EXPECT_NEAR(bodies.turned[0], way, 1e-12);
  }
}

}  // namespace
}  // namespace atl::solver
