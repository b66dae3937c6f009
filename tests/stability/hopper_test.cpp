// Boxes that rush through a funnel press each other against its edges, where continuous collision has to hold them off
// and yet let them go.

#include <gtest/gtest.h>

#include <vector>

#include "support/scene_run.h"

namespace atl::test {
namespace {

// One that stood still for good was two fifths of a metre deep in others.
TEST(Hopper, NothingThatIsFastStandsStill) {
  SceneRun hopper("hopper", {.threads = 2});
  const std::vector<BodyId> bodies = dynamic_bodies(hopper.world, hopper.ids);
  constexpr double fast = 5;  // m/s: 8 cm a step
  constexpr int patience = 10;
  std::vector<Vector3> places(bodies.size());
  std::vector<int> still(bodies.size());
  for (int step = 0; step < 400; ++step) {
    ASSERT_EQ(hopper.world.step(dt).first_quarantined, -1) << "step " << step;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const Vector3 place = hopper.world.pose(bodies[i]).position;
      const bool stands = (place - places[i]).norm() < 1e-9 && hopper.world.velocity(bodies[i]).norm() > fast;
      still[i] = stands ? still[i] + 1 : 0;
      places[i] = place;
      ASSERT_LT(still[i], patience) << "body " << bodies[i].index << " in step " << step;
    }
  }
  const PenetrationReport found = hopper.penetration();
  EXPECT_LT(found.max, 0.3);
  EXPECT_LT(found.p99, 0.05);
}

}  // namespace
}  // namespace atl::test
