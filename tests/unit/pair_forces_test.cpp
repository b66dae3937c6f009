// World::pair_forces() against what contact_forces() adds up to, whichever is asked first and whatever is done between.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "support/bodies.h"

namespace atl::test {
namespace {

// In order of ids, however contacts are ordered.
std::vector<PairForce> summed(std::span<const ContactForce> points) {
  std::map<std::pair<BodyId, BodyId>, PairForce> pairs;
  for (const ContactForce& point : points) {
    const auto [a, b] = std::minmax(point.a, point.b);
    PairForce& pair =
        pairs.try_emplace({a, b}, PairForce{.a = a, .b = b, .separation = point.separation}).first->second;
    pair.force += (point.a < point.b ? 1.0 : -1.0) * (point.normal_force * point.normal + point.friction);
    pair.normal_force += point.normal_force;
    pair.separation = std::min(pair.separation, point.separation);
  }
  std::vector<PairForce> list;
  for (const auto& [ids, pair] : pairs) list.push_back(pair);
  return list;
}

void expect_same(std::span<const PairForce> found, std::span<const PairForce> expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_TRUE(found[i].a == expected[i].a && found[i].b == expected[i].b) << i;
    EXPECT_LE((found[i].force - expected[i].force).norm(), 1e-14 * expected[i].force.norm()) << i;
    EXPECT_NEAR(found[i].normal_force, expected[i].normal_force, 1e-14 * expected[i].normal_force) << i;
    EXPECT_EQ(found[i].separation, expected[i].separation) << i;
  }
}

// The same, with the sums asked before the points are known, and after.
void expect_sums(const World& world) {
  const std::span<const PairForce> asked_first = world.pair_forces();
  const std::vector<PairForce> first(asked_first.begin(), asked_first.end());
  expect_same(first, summed(world.contact_forces()));
  expect_same(world.pair_forces(), first);
}

// Two boxes that stand on each other, one that rolls with two balls in it, and a wall that they all end at.
struct PressedYard {
  World world;
  BodyId floor, lower, upper, dumbbell;

  explicit PressedYard(const Settings& settings, int threads) : world({.threads = threads, .settings = settings}) {
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
        PressedYard yard({.contact_solver = solver, .sleeping = sleeping}, threads);
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
  PressedYard yard({}, 1);
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

TEST(PairForces, AreInOrderWhateverShapesBodiesGet) {
  PressedYard yard({}, 1);
  const auto legs = [](double x) {
    return Compound{{{.shape = Sphere{0.3}, .position = {-x, 0, 0}}, {.shape = Sphere{0.3}, .position = {x, 0, 0}}}};
  };
  for (int step = 0; step < 60; ++step) {
    // New shapes have the highest numbers, and those of one body may lie on both sides of another's.
    if (step == 10) yard.world.set_shape(yard.floor, HalfSpace{});
    if (step == 20) yard.world.set_shape(yard.dumbbell, legs(0.5));
    if (step == 30) yard.world.set_shape(yard.lower, Box{{0.5, 0.5, 0.5}});
    yard.world.step(dt);
    expect_sums(yard.world);
    const std::span<const PairForce> pairs = yard.world.pair_forces();
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      EXPECT_LT(pairs[i].a, pairs[i].b);
      if (i == 0) continue;
      EXPECT_LT(std::pair(pairs[i - 1].a, pairs[i - 1].b), std::pair(pairs[i].a, pairs[i].b));
    }
  }
  EXPECT_EQ(yard.world.pair_forces().size(), 4u);
}

TEST(PairForces, FollowWhatIsTakenAwayAndPutBack) {
  for (const bool points_known : {false, true}) {
    PressedYard yard({}, 1);
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
