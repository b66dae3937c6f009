// Bodies that callers or a solve make non-finite or absurd go into quarantine, and everything else goes on, bit for
// bit, as if they had been removed.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "support/scene_run.h"

namespace atl::test {
namespace {

constexpr double huge = std::numeric_limits<double>::max();

struct Poison {
  Quarantine reason;
  std::function<void(World&, BodyId)> give;
};

// Every way in which calls that are taken one by one make a state that no step can work with.
const std::vector<Poison>& poisons() {
  static const std::vector<Poison> all = {
      {Quarantine::TooMuchForce,
       [](World& world, BodyId id) {
         world.apply_force(id, {1e30, 0, 0});
       }},
      {Quarantine::TooMuchTorque,
       [](World& world, BodyId id) {
         world.apply_force(id, {0, 0, 0}, {0, 1e30, 0});
       }},
      {Quarantine::TooFast,
       [](World& world, BodyId id) {
         world.set_velocity(id, {0, 0, -1e9}, {0, 0, 0});
       }},
      {Quarantine::TooFastSpin,
       [](World& world, BodyId id) {
         world.set_velocity(id, {0, 0, 0}, {1e200, 0, 0});
       }},
      {Quarantine::TooFastSurface,
       [](World& world, BodyId id) {
         world.set_surface_velocity(id, {1e30, 0, 0});
       }},
      {Quarantine::TooFar,
       [](World& world, BodyId id) {
         world.set_pose(id, {.position = {0, 3e12, 0}});
         world.set_pose(id, {.position = {huge, huge, 0}});
       }},
      // The sum overflows.
      {Quarantine::NotFinite,
       [](World& world, BodyId id) {
         for (int i = 0; i < 2; ++i) world.apply_force(id, {huge, 0, 0});
       }},
      // So does that of torques.
      {Quarantine::NotFinite,
       [](World& world, BodyId id) {
         for (int i = 0; i < 2; ++i) world.apply_force(id, {0, 0, 0}, {huge, -huge, 0});
       }},
  };
  return all;
}

bool same_bits(const BodyState& a, const BodyState& b) {
  return a.pose.position == b.pose.position && a.pose.orientation.coeffs() == b.pose.orientation.coeffs() &&
         a.velocity == b.velocity && a.angular_velocity == b.angular_velocity;
}

bool same_bits(const ContactForce& x, const ContactForce& y) {
  return x.a == y.a && x.b == y.b && x.feature_id == y.feature_id && x.position == y.position && x.normal == y.normal &&
         x.normal_force == y.normal_force && x.friction == y.friction && x.separation == y.separation;
}

// All bodies of `expected`, and all that its contacts carry, are in `world`, bit for bit.
void expect_same(const World& world, const World& expected, const std::vector<BodyId>& ids) {
  for (const BodyId id : ids) {
    if (!expected.contains(id)) continue;
    ASSERT_TRUE(same_bits(world.state(id), expected.state(id))) << "body " << id.index;
    ASSERT_EQ(world.is_asleep(id), expected.is_asleep(id)) << "body " << id.index;
  }
  const auto forces = world.contact_forces(), expected_forces = expected.contact_forces();
  ASSERT_EQ(forces.size(), expected_forces.size());
  for (std::size_t i = 0; i < forces.size(); ++i) {
    ASSERT_TRUE(same_bits(forces[i], expected_forces[i]))
        << "bodies " << forces[i].a.index << ", " << forces[i].b.index;
  }
}

// The bodies that carry contact forces and can move, in order.
std::vector<BodyId> bodies_with_impulses(const SceneRun& pile) {
  std::set<BodyId> with_impulses;
  for (const ContactForce& point : pile.world.contact_forces()) {
    for (const BodyId id : {point.a, point.b}) {
      if (pile.world.type(id) == BodyType::Dynamic) with_impulses.insert(id);
    }
  }
  return {with_impulses.begin(), with_impulses.end()};
}

struct Size {
  int bodies;
  int threads;
};

class QuarantinedPile : public testing::TestWithParam<Size> {};

// The other world is always one thread's.
TEST_P(QuarantinedPile, GoesOnAsIfThePoisonedHadBeenRemoved) {
  constexpr int steps_before = 120, steps_after = 60;
  constexpr std::size_t count = 100;
  const std::string scene = "pile:bodies=" + std::to_string(GetParam().bodies);
  SceneRun pile(scene, {.threads = GetParam().threads});
  SceneRun removed(scene, {.threads = 1});
  run(pile.world, steps_before);
  run(removed.world, steps_before);
  EXPECT_TRUE(pile.world.quarantined().empty());

  const std::vector<BodyId> with_impulses = bodies_with_impulses(pile);
  ASSERT_GT(with_impulses.size(), 5 * count);
  // Not in order, as callers needn't be.
  std::vector<BodyId> victims(count);
  std::vector<Pose> poses(count);
  for (std::size_t i = 0; i < count; ++i) victims[i] = with_impulses[i * with_impulses.size() / count];
  for (std::size_t i = count; i-- > 0;) {
    poses[i] = pile.world.pose(victims[i]);
    poisons()[i % poisons().size()].give(pile.world, victims[i]);
  }
  for (const BodyId id : victims) removed.world.remove_body(id);

  for (int step = 0; step < steps_after; ++step) {
    SCOPED_TRACE("step " + std::to_string(step));
    const StepReport report = pile.world.step(dt), expected = removed.world.step(dt);
    ASSERT_EQ(report.quarantined, step == 0 ? static_cast<std::int64_t>(count) : 0);
    ASSERT_EQ(report.first_quarantined, step == 0 ? static_cast<std::int64_t>(victims[0].index) : -1);
    ASSERT_EQ(report.counts.pairs, expected.counts.pairs);
    ASSERT_EQ(report.counts.contacts, expected.counts.contacts);
    ASSERT_EQ(report.counts.active_bodies, expected.counts.active_bodies);
    expect_same(pile.world, removed.world, pile.ids);
    if (HasFatalFailure()) return;
  }

  EXPECT_EQ(pile.world.body_count(), pile.ids.size());
  const auto quarantined = pile.world.quarantined();
  ASSERT_EQ(quarantined.size(), count);
  for (std::size_t i = 0; i < count; ++i) {
    EXPECT_EQ(quarantined[i].id, victims[i]);
    EXPECT_EQ(quarantined[i].reason, poisons()[i % poisons().size()].reason) << quarantined[i].why;
    EXPECT_STREQ(quarantined[i].why, quarantine_reason(quarantined[i].reason));
    EXPECT_EQ(quarantined[i].step, steps_before + 1);
    EXPECT_TRUE(pile.world.is_quarantined(victims[i]));
    EXPECT_TRUE(same_bits(pile.world.state(victims[i]), {.pose = poses[i]})) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, QuarantinedPile, testing::Values(Size{1000, 1}, Size{2000, 2}), [](const auto& param) {
  return std::to_string(param.param.bodies) + "BodiesAnd" + std::to_string(param.param.threads) + "Threads";
});

// A chain that hangs from a static body, at once or joint by joint, over a floor.
struct Chain {
  World world;
  std::vector<BodyId> links;
  std::vector<JointId> joints;

  explicit Chain(JointSolver solver) : world({.settings = {.joint_solver = solver}}) {
    links.push_back(world.add_body(static_box({0, 0, 10}, {0.1, 0.1, 0.1})));
    for (int i = 1; i <= 8; ++i) {
      links.push_back(world.add_body(box({0.5 * i, 0, 10}, {0.2, 0.1, 0.1})));
      joints.push_back(world.add_joint({.first = links[links.size() - 2],
                                        .second = links.back(),
                                        .frame_first = {{0.25, 0, 0}},
                                        .frame_second = {{-0.25, 0, 0}}}));
    }
    world.add_body(ground());
  }
  // m, between the two anchors of a joint.
  double gap(std::size_t joint) const {
    const auto anchor = [this](BodyId id, double x) {
      const Pose pose = world.pose(id);
      return Vector3(pose.position + pose.orientation * Vector3(x, 0, 0));
    };
    return (anchor(links[joint], 0.25) - anchor(links[joint + 1], -0.25)).norm();
  }
};

class QuarantinedChain : public testing::TestWithParam<JointSolver> {};

TEST_P(QuarantinedChain, PartsWhereALinkIsOutAndHoldsWhenItIsBack) {
  Chain chain(GetParam()), removed(GetParam());
  run(chain.world, 20);
  run(removed.world, 20);
  const BodyId victim = chain.links[4];
  const Pose before = chain.world.pose(victim);
  chain.world.apply_force(victim, {0, 1e30, 0});
  removed.world.remove_body(victim);
  for (int step = 0; step < 60; ++step) {
    const StepReport report = chain.world.step(dt);
    EXPECT_EQ(report.counts.joints, removed.world.step(dt).counts.joints);
    expect_same(chain.world, removed.world, chain.links);
    ASSERT_FALSE(HasFatalFailure()) << "step " << step;
  }
  EXPECT_EQ(chain.world.joint_count(), chain.joints.size());
  EXPECT_EQ(chain.world.joint_state(chain.joints[3]).force, Vector3::Zero());
  EXPECT_GT(chain.gap(4), 1);

  chain.world.release(victim);
  EXPECT_EQ(chain.world.pose(victim).position, before.position);
  // Its neighbours where the joints want them.
  const Pose pose = chain.world.pose(chain.links[3]);
  for (int i = 1; i <= 5; ++i) {
    const Vector3 along = pose.orientation * Vector3(0.5 * i, 0, 0);
    const BodyId id = chain.links[3 + static_cast<std::size_t>(i)];
    chain.world.set_pose(id, {pose.position + along, pose.orientation});
    chain.world.set_velocity(id, {0, 0, 0}, {0, 0, 0});
  }
  const StepReport report = run(chain.world, 60);
  EXPECT_EQ(report.counts.joints, 8);
  for (std::size_t joint = 0; joint < chain.joints.size(); ++joint) EXPECT_LT(chain.gap(joint), 0.05) << joint;
}

INSTANTIATE_TEST_SUITE_P(Solvers, QuarantinedChain, testing::Values(JointSolver::Iterative, JointSolver::Direct),
                         [](const auto& param) {
                           return param.param == JointSolver::Direct ? std::string("Direct") : std::string("Iterative");
                         });

struct Sleepers {
  World world{WorldDef{.settings = {.sleeping = true}}};
  BodyId base = world.add_body(ground());
  std::vector<BodyId> stack = add_stack(world, 4);
  std::vector<BodyId> far = add_stack(world, 3, {10, 0, 0});
  std::vector<BodyId> all;

  Sleepers() {
    run(world, 240);
    all = stack;
    all.insert(all.end(), far.begin(), far.end());
  }
};

TEST(Quarantine, SleepersThatWereTouchedWakeAndOthersSleepOn) {
  for (std::size_t kind = 0; kind < poisons().size(); ++kind) {
    SCOPED_TRACE(kind);
    Sleepers poisoned, removed;
    ASSERT_TRUE(poisoned.world.is_asleep(poisoned.stack[0]) && poisoned.world.is_asleep(poisoned.far[0]));
    poisons()[kind].give(poisoned.world, poisoned.stack[1]);
    removed.world.remove_body(removed.stack[1]);
    const Pose far_before = poisoned.world.pose(poisoned.far[2]);
    for (int step = 0; step < 120; ++step) {
      EXPECT_EQ(poisoned.world.step(dt).counts.asleep, removed.world.step(dt).counts.asleep);
      expect_same(poisoned.world, removed.world, poisoned.all);
      ASSERT_FALSE(HasFatalFailure()) << "step " << step;
    }
    EXPECT_NEAR(poisoned.world.pose(poisoned.stack[3]).position.z(), 2.5, 0.01);
    EXPECT_TRUE(poisoned.world.is_asleep(poisoned.far[0]));
    EXPECT_EQ(poisoned.world.pose(poisoned.far[2]).position, far_before.position);
  }
}

// Motors that no body can follow: nobody touched the bodies since they were sound.
TEST(Quarantine, BodiesThatBreakInTheSolveAreLostTogether) {
  struct Motors {
    World world;
    std::vector<BodyId> ids;
    std::array<BodyId, 2> driven;
    JointId motor;

    Motors() {
      world.add_body(ground());
      ids = add_stack(world, 5);
      const std::vector<BodyId> more = add_stack(world, 5, {4, 0, 0});
      ids.insert(ids.end(), more.begin(), more.end());
      driven = {world.add_body(box({8, 0, 0.5})), world.add_body(box({9.1, 0, 0.5}))};
      motor = world.add_joint({.kind = HingeJoint{},
                               .first = driven[0],
                               .second = driven[1],
                               .frame_first = {{0.55, 0, 0}},
                               .frame_second = {{-0.55, 0, 0}}});
      run(world, 30);
    }
  };
  Motors broken, removed;
  const std::array<BodyState, 2> before = {broken.world.state(broken.driven[0]), broken.world.state(broken.driven[1])};
  broken.world.set_joint(broken.motor, HingeJoint{{.motor = JointMotor{.speed = 1e30, .max_force = 1e30}}});
  for (const BodyId id : removed.driven) removed.world.remove_body(id);

  const StepReport report = broken.world.step(dt);
  removed.world.step(dt);
  ASSERT_EQ(report.quarantined, 2);
  EXPECT_EQ(report.first_quarantined, broken.driven[0].index);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(broken.world.quarantined()[i].id, broken.driven[i]);
    EXPECT_EQ(broken.world.quarantined()[i].step, 31);
    EXPECT_TRUE(same_bits(broken.world.state(broken.driven[i]), {.pose = before[i].pose})) << i;
  }
  for (int step = 0; step < 60; ++step) {
    expect_same(broken.world, removed.world, broken.ids);
    ASSERT_FALSE(HasFatalFailure()) << "step " << step;
    EXPECT_EQ(broken.world.step(dt).quarantined, 0);
    removed.world.step(dt);
  }
}

// In the step in which a body breaks it has pushed its neighbours, which may break with it but not later.
TEST(Quarantine, WhatABrokenBodyTouchedIsSoundOrGoesToo) {
  World world({.threads = 2});
  world.add_body(ground());
  std::vector<std::vector<BodyId>> stacks;
  for (int i = 0; i < 6; ++i) stacks.push_back(add_stack(world, 5, {1.0 * i, 0, 0}));
  run(world, 30);
  const std::array<double, 4> strengths = {2e11, 1e20, 1e30, 1e300};
  for (std::size_t i = 0; i < strengths.size(); ++i) {
    const double strength = strengths[i];
    SCOPED_TRACE(strength);
    const BodyId a = stacks[i][2], b = stacks[i + 1][2];
    if (world.is_quarantined(a)) world.release(a);
    const JointId motor =
        world.add_joint({.kind = HingeJoint{{.motor = JointMotor{.speed = strength, .max_force = strength}}},
                         .first = a,
                         .second = b,
                         .frame_first = {{0.5, 0, 0}},
                         .frame_second = {{-0.5, 0, 0}},
                         .collide = true});
    EXPECT_GE(world.step(dt).quarantined, 2);
    EXPECT_TRUE(world.is_quarantined(a) && world.is_quarantined(b));
    world.remove_joint(motor);
    for (int step = 0; step < 20; ++step) {
      EXPECT_EQ(world.step(dt).quarantined, 0);
      ASSERT_TRUE(world.positions().allFinite() && world.orientations().allFinite());
      ASSERT_LE(world.velocities().colwise().norm().maxCoeff(), 1e6);
      ASSERT_LE(world.angular_velocities().colwise().norm().maxCoeff(), 1e6);
    }
  }
}

// A body in quarantine may be anywhere, and a joint to it still tells of numbers.
TEST(Quarantine, JointsToWhatIsFarAwayTellOfFiniteCoordinates) {
  for (const JointKind& kind : {JointKind(DistanceJoint{}), JointKind(SliderJoint{}), JointKind(SixDofJoint{}),
                                JointKind(HingeJoint{{.range = {-1, 1}}}), JointKind(WheelJoint{})}) {
    SCOPED_TRACE(kind.index());
    World world;
    const BodyId a = world.add_body(box({0, 0, 0}));
    const BodyId b = world.add_body(box({2, 0, 0}));
    const JointId joint = world.add_joint({.kind = kind, .first = a, .second = b});
    run(world, 2);
    for (const double far : {1e200, huge}) {
      world.set_pose(a, {{far, far, 0}});
      world.set_pose(b, {{-far, 0, far}});
      run(world, 1);
      ASSERT_TRUE(world.is_quarantined(a) && world.is_quarantined(b));
      const JointState state = world.joint_state(joint);
      for (std::size_t i = 0; i < state.position.size(); ++i) {
        EXPECT_TRUE(std::isfinite(state.position[i]) && std::isfinite(state.speed[i])) << i << " at " << far;
      }
    }
  }
}

// How often a solve that breaks goes on for a tolerance, too, is the same on each instruction set.
TEST(Quarantine, SweepsAreCountedAlikeWhereABodyBreaks) {
  const auto sweeps_on = [](Simd simd) {
    std::vector<std::int64_t> sweeps;
    for (const double gravity : {1e20, 1e30, 1e38, 1e300}) {
      for (const double tolerance : {1e-6, 1e-2, 1.0, 1e3}) {
        World world({.settings = {.iterations = 8, .relax_iterations = 8, .tolerance = tolerance, .simd = simd}});
        world.add_body(ground());
        const std::vector<BodyId> stack = add_stack(world, 5);
        run(world, 10);
        world.set_surface_velocity(stack[2], {1e6, 0, 0});
        world.set_gravity({0, 0, -gravity});
        sweeps.push_back(world.step(dt).counts.sweeps);
      }
    }
    return sweeps;
  };
  const std::vector<std::int64_t> portable = sweeps_on(Simd::Portable);
  for (const Simd simd : {Simd::Sse4, Simd::Avx2, Simd::Avx512, Simd::Neon}) {
    std::vector<std::int64_t> sweeps;
    try {
      sweeps = sweeps_on(simd);
    } catch (const Error&) {
      continue;  // this machine lacks it
    }
    EXPECT_EQ(sweeps, portable) << static_cast<int>(simd);
  }
}

// Gravity breaks all that it moves, and nothing else.
TEST(Quarantine, WholeWorldCanBeLostAndBroughtBack) {
  World world;
  world.add_body(ground());
  const std::vector<BodyId> stack = add_stack(world, 5);
  const BodyId turntable = world.add_body({.type = BodyType::Kinematic,
                                           .shape = Box{{0.5, 0.5, 0.5}},
                                           .position = {9, 0, 5},
                                           .angular_velocity = {0, 0, 1}});
  run(world, 30);
  world.set_gravity({0, 0, -1e300});
  EXPECT_EQ(world.step(dt).quarantined, 5);
  EXPECT_FALSE(world.is_quarantined(turntable));
  EXPECT_EQ(world.step(dt).counts.pairs, 0);
  world.set_gravity({0, 0, -g});
  for (const BodyId id : stack) world.release(id);
  EXPECT_EQ(run(world, 120).quarantined, 0);
  EXPECT_TRUE(world.quarantined().empty());
  for (std::size_t i = 0; i < stack.size(); ++i) {
    EXPECT_NEAR(world.pose(stack[i]).position.z(), static_cast<double>(i) + 0.5, 0.01) << i;
  }
}

}  // namespace
}  // namespace atl::test
