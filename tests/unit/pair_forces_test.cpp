// World::pair_forces() against what contact_forces() adds up to, whichever is asked first and whatever is done between.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "support/bodies.h"

namespace atl::test {
namespace {

std::vector<PairForce> summed(std::span<const ContactForce> points) {
  std::vector<PairForce> pairs;
  for (const ContactForce& point : points) {
    if (pairs.empty() || pairs.back().a != point.a || pairs.back().b != point.b) {
      pairs.push_back({.a = point.a, .b = point.b, .separation = point.separation});
    }
    PairForce& pair = pairs.back();
    pair.force += point.normal_force * point.normal + point.friction;
    pair.normal_force += point.normal_force;
    pair.separation = std::min(pair.separation, point.separation);
  }
  return pairs;
}

void expect_same(std::span<const PairForce> found, std::span<const PairForce> expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_TRUE(found[i].a == expected[i].a && found[i].b == expected[i].b) << i;
    EXPECT_EQ(found[i].force, expected[i].force) << i;
    EXPECT_EQ(found[i].normal_force, expected[i].normal_force) << i;
    EXPECT_EQ(found[i].separation, expected[i].separation) << i;
  }
}

// The same, with the sums asked before the points are known, and after.
void expect_sums(const World& world) {
  const std::span<const PairForce> asked_first = world.pair_forces();
  const std::vector<PairForce> first(asked_first.begin(), asked_first.end());
  const std::vector<PairForce> expected = summed(world.contact_forces());
  expect_same(first, expected);
  expect_same(world.pair_forces(), expected);
}

// Two boxes that stand on each other, one that rolls with two balls in it, and a wall that they all end at.
struct Yard {
  World world;
  BodyId floor, lower, upper, dumbbell;

  explicit Yard(const Settings& settings, int threads) : world({.threads = threads, .settings = settings}) {
    floor = world.add_body(ground());
    lower = world.add_body(box({0, 0, 0.5}));
    upper = world.add_body(box({0, 0, 1.5}));
    dumbbell = world.add_body({.shape = Compound{{{.shape = Sphere{0.3}, .position = {-0.4, 0, 0}},
                                                  {.shape = Sphere{0.3}, .position = {0.4, 0, 0}}}},
                               .position = {4, 0, 0.3},
                               .velocity = {0, 1, 0}});
    world.add_body({.shape = Box{{0.3, 0.3, 0.3}}, .position = {-5, 0, 0.3}, .locks = MotionLocks::plane(Axis::Y)});
  }
};

TEST(PairForces, AreWhatContactForcesAddUpTo) {
  for (const bool sleeping : {false, true}) {
    for (const ContactSolver solver : {ContactSolver::Auto, ContactSolver::Iterative, ContactSolver::Direct}) {
      for (const int threads : {1, 2}) {
        Yard yard({.contact_solver = solver, .sleeping = sleeping}, threads);
        EXPECT_TRUE(yard.world.pair_forces().empty());
        for (int step = 0; step < 120; ++step) {
          yard.world.step(dt);
          if (step % 8 == 0) expect_sums(yard.world);
        }
        EXPECT_EQ(yard.world.is_asleep(yard.upper), sleeping);
        expect_sums(yard.world);
      }
    }
  }
}

TEST(PairForces, OfTwoShapesOfABodyAreOneAndHoldItUp) {
  Yard yard({}, 1);
  run(yard.world, 60);
  const std::span<const PairForce> pairs = yard.world.pair_forces();
  ASSERT_EQ(pairs.size(), 4u);
  const auto on = [&](BodyId a, BodyId b) {
    const auto found = std::find_if(pairs.begin(), pairs.end(), [&](const PairForce& pair) {
      return pair.a == std::min(a, b) && pair.b == std::max(a, b);
    });
    return found == pairs.end() ? Vector3(Vector3::Zero()) : found->force;
  };
  const World& world = yard.world;
  EXPECT_NEAR(on(yard.floor, yard.lower).z(), 9.81 * (world.mass(yard.lower) + world.mass(yard.upper)), 1);
  EXPECT_NEAR(on(yard.lower, yard.upper).z(), 9.81 * world.mass(yard.upper), 1);
  EXPECT_NEAR(on(yard.floor, yard.dumbbell).z(), 9.81 * world.mass(yard.dumbbell), 25);
}

TEST(PairForces, FollowWhatIsTakenAwayAndPutBack) {
  for (const bool points_known : {false, true}) {
    Yard yard({}, 1);
    run(yard.world, 30);
    Snapshot snapshot;
    yard.world.save(snapshot);
    if (points_known) (void)yard.world.contact_forces();
    yard.world.remove_body(yard.upper);
    EXPECT_EQ(yard.world.pair_forces().size(), 3u);
    expect_sums(yard.world);
    const BodyId other = yard.world.add_body(box({0, 0, 1.5}));
    expect_sums(yard.world);
    run(yard.world, 1);
    expect_sums(yard.world);
    EXPECT_TRUE(yard.world.contains(other));
    yard.world.restore(snapshot);
    EXPECT_TRUE(yard.world.pair_forces().empty());
    run(yard.world, 1);
    EXPECT_EQ(yard.world.pair_forces().size(), 4u);
    expect_sums(yard.world);
  }
}

}  // namespace
}  // namespace atl::test
