// A modifier in an island so large that it keeps its colours from step to step, as long as contacts stay.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "support/bodies.h"

namespace atl::test::modified_island_test {
namespace {

constexpr int side = 46;  // crates, which makes more than 2048 contacts with one slab
constexpr double downhill = 2;

struct Slope {
  World world{{.gravity = {downhill, 0, -g}, .settings = {.contact_solver = ContactSolver::Iterative}}};
  std::vector<BodyId> crates;

  Slope() {
    BodyDef slab = box({0, 0, -1}, {60, 60, 1});
    slab.locks = {.linear = {true, true, true}, .angular = {true, true, true}};
    slab.material.friction = 0;
    world.add_body(slab);
    for (int i = 0; i < side * side; ++i) {
      BodyDef crate = box({i % side - 0.5 * side, i / side - 0.5 * side, 0.25}, Vector3::Constant(0.25));
      crate.material.friction = 0;
      crates.push_back(world.add_body(crate));
    }
    run(world, 20);
  }

  double slowest() const {
    double min = unlimited;
    for (const BodyId crate : crates) min = std::min(min, world.velocity(crate).x());
    return min;
  }
  double fastest() const {
    double max = 0;
    for (const BodyId crate : crates) max = std::max(max, std::abs(world.velocity(crate).x()));
    return max;
  }
};

TEST(ModifiedIsland, GetsFrictionThatItHadNone) {
  Slope slope;
  const double before = 20 * downhill * dt;
  ASSERT_NEAR(slope.slowest(), before, 1e-4);
  ASSERT_NEAR(slope.fastest(), before, 1e-4);
  slope.world.set_contact_modifier([](ModifiableContact& contact) { contact.friction = 1; });
  run(slope.world, 10);  // 10 m/s^2 less 2 stop 0.67 m/s in 5 steps
  EXPECT_LT(slope.fastest(), 0.02);
  // And loses it again.
  slope.world.set_contact_modifier({});
  run(slope.world, 20);
  EXPECT_NEAR(slope.slowest(), before, 0.02);
}

TEST(ModifiedIsland, IsSolvedAsInAWorldThatWasRestoredWithIt) {
  Slope slope;
  const auto rub_some = [](ModifiableContact& contact) { contact.friction = contact.b.index % 3 == 0 ? 0.1 : 0; };
  slope.world.set_contact_modifier(rub_some);
  run(slope.world, 3);
  Snapshot snapshot;
  slope.world.save(snapshot);
  World other;
  other.restore(snapshot);
  other.set_contact_modifier(rub_some);
  for (int i = 0; i < 3; ++i) {
    slope.world.step(dt);
    other.step(dt);
    EXPECT_EQ(other.state_hash(), slope.world.state_hash());
  }
}

}  // namespace
}  // namespace atl::test::modified_island_test
