// When a force law is called, what it may do, and what becomes of what it must not.

#include <atoll/forces.h>
#include <atoll/recording.h>
#include <atoll/snapshot.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "support/bodies.h"
#include "support/expect_error.h"
#include "support/temporary_file.h"

namespace atl::test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

TEST(ForceLaw, IsCalledAsEachSubstepBeginsAndAsTheLastEnds) {
  World world({.settings = {.substeps = 3}});
  const BodyId id = world.add_body(sphere({0, 0, 5}));
  std::vector<double> times, heights;
  world.step(dt, [&](Forces& forces) {
    times.push_back(forces.time());
    heights.push_back(forces.world().pose(id).position.z());
    EXPECT_TRUE(forces.forces().isZero(0));
    EXPECT_TRUE(forces.torques().isZero(0));
  });
  ASSERT_EQ(times.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    const double t = static_cast<double>(i) * dt / 3;
    EXPECT_DOUBLE_EQ(times[i], t);
    EXPECT_NEAR(heights[i], 5 - g / 2 * t * t, 1e-12);
  }
  EXPECT_EQ(world.settings().substeps, 3);
}

TEST(ForceLaw, AddsToWhatIsAppliedForTheStep) {
  World world({.gravity = Vector3::Zero()});
  const BodyId id = world.add_body({.shape = Sphere{0.5}, .mass = 2.0});
  world.apply_force(id, {6, 0, 0});
  world.step(dt, [&](Forces& forces) { forces.add(id, {0, 4, 0}); });
  EXPECT_LT((world.velocity(id) - dt * Vector3(3, 2, 0)).norm(), 1e-12);
  world.step(dt);
  EXPECT_LT((world.velocity(id) - dt * Vector3(3, 2, 0)).norm(), 1e-12);
}

TEST(ForceLaw, AForceAtAPointTurnsToo) {
  World world({.gravity = Vector3::Zero()});
  const BodyId id = world.add_body({.shape = Sphere{0.5}, .position = {1, 2, 3}, .mass = 2.0});
  world.step(dt, [&](Forces& forces) { forces.add_at(id, {0, 0, 5}, {1.5, 2, 3}); });
  EXPECT_LT((world.velocity(id) - dt * Vector3(0, 0, 2.5)).norm(), 1e-12);
  EXPECT_LT((world.angular_velocity(id) - dt * Vector3(0, -2.5 / 0.2, 0)).norm(), 1e-6);
}

TEST(ForceLaw, WakesWhatItPushesAndNothingElse) {
  World world({.settings = {.sleeping = true, .time_to_sleep = 0.1}});
  world.add_body(ground());
  const BodyId pushed = world.add_body(box({0, 0, 0.5})), left = world.add_body(box({5, 0, 0.5}));
  run(world, 60);
  ASSERT_TRUE(world.is_asleep(pushed));
  world.step(dt, [&](Forces& forces) { forces.add(pushed, {0, 0, 10}); });
  EXPECT_FALSE(world.is_asleep(pushed));
  EXPECT_TRUE(world.is_asleep(left));
}

TEST(ForceLaw, DoesNothingToWhatDoesNotMove) {
  World world;
  const BodyId floor = world.add_body(ground());
  const BodyId lift = world.add_body({.type = BodyType::Kinematic, .shape = Box{}, .position = {0, 0, 3}});
  world.step(dt, [](Forces& forces) { forces.forces().setConstant(100); });
  EXPECT_TRUE(world.velocity(floor).isZero(0));
  EXPECT_TRUE(world.velocity(lift).isZero(0));
}

TEST(ForceLaw, KeepsToMotionLocks) {
  World world({.gravity = Vector3::Zero()});
  BodyDef def = sphere({0, 0, 0});
  def.locks.linear = {false, true, false};
  def.locks.angular = {true, true, true};
  const BodyId id = world.add_body(def);
  double sign = 1;
  for (int i = 0; i < 10; ++i) {
    world.step(dt,
               [&](Forces& forces) { forces.add(id, sign * Vector3(5, 7, 9), sign * Vector3(1, 2, 3)), sign = -sign; });
  }
  EXPECT_EQ(world.pose(id).position.y(), 0);
  EXPECT_TRUE(world.angular_velocity(id).isZero(0));
}

TEST(ForceLaw, EventsAndCountsAreOfTheWholeStep) {
  World world({.settings = {.contact_events = true}});
  world.add_body(ground());
  const BodyId ball = world.add_body(sphere({0, 0, 0.51}, 0.5));
  world.set_velocity(ball, {0, 0, -1}, Vector3::Zero());
  int began = 0;
  for (int i = 0; i < 30; ++i) {
    const StepReport report = world.step(dt, [](Forces&) {});
    began += static_cast<int>(world.contact_events().size());
    if (i > 5) {
      EXPECT_EQ(report.counts.recycled_manifolds + report.counts.recomputed_manifolds, 4) << "one a substep";
    }
    EXPECT_EQ(report.counts.active_bodies, 1);
    EXPECT_TRUE(report.feature(Feature::ContactSolver).run);
  }
  EXPECT_EQ(began, 1);
}

TEST(ForceLaw, WhatIsWrongWithItIsSaid) {
  World world;
  const BodyId id = world.add_body(sphere({0, 0, 0}));
  const BodyId gone = world.add_body(sphere({5, 0, 0}));
  world.remove_body(gone);
  expect_error([&] { world.step(dt, ForceLaw{}); }, {"force law is empty"});
  expect_error([&] { world.step(-1, [](Forces&) {}); }, {"dt is -1"});
  expect_error([&] { world.step(dt, [&](Forces& forces) {
                       forces.add(gone, {1, 0, 0});
                     }); },
               {"Forces::add", "no body has the id"});
  expect_error([&] { world.step(dt, [&](Forces& forces) {
                       forces.add_at(gone, {1, 0, 0}, {0, 0, 0});
                     }); },
               {"Forces::add_at", "no body has the id"});
  expect_error([&] { world.step(dt, [&](Forces& forces) {
                       forces.add(id, {nan, 0, 0});
                     }); },
               {"Forces::add: force", "three finite numbers"});
  expect_error([&] { world.step(dt, [&](Forces&) { world.step(dt); }); }, {"under way", "force law"});
}

TEST(ForceLaw, WhatItThrowsGoesThroughAndLeavesWholeSubsteps) {
  World world({.settings = {.substeps = 4}});
  const BodyId id = world.add_body(sphere({0, 0, 0}));
  int calls = 0;
  const auto law = [&](Forces& forces) {
    if (++calls == 3) throw std::runtime_error("enough");
    forces.add(id, {1, 0, 0});
  };
  EXPECT_THROW(world.step(dt, law), std::runtime_error);
  const double fallen = 2 * dt / 4;
  EXPECT_NEAR(world.velocity(id).z(), -g * fallen, 1e-12);
  world.step(dt);
  EXPECT_NEAR(world.velocity(id).z(), -g * (fallen + dt), 1e-12);
}

// They were told with the next step, unless the world was restored in between.
TEST(ForceLaw, ContactsOfAStepThatItBrokeOffAreNotToldLater) {
  const WorldDef events = {.settings = {.contact_events = true}};
  World world(events), restored(events);
  BodyId ball;
  for (World* each : {&world, &restored}) {
    each->add_body(ground());
    BodyDef bouncing = sphere({0, 0, 0.501});
    bouncing.velocity = {0, 0, -5};
    bouncing.material.restitution = 1;
    ball = each->add_body(bouncing);
  }
  int calls = 0;
  const auto law = [&](Forces&) {
    if (++calls == 4) throw std::runtime_error("enough");
  };
  EXPECT_THROW(world.step(dt, law), std::runtime_error);
  ASSERT_GT(world.velocity(ball).z(), 4) << "it has bounced";
  world.set_pose(ball, {{0, 0, 5}, Quaternion::Identity()});
  Snapshot saved;
  world.save(saved);
  restored.restore(Snapshot::from_bytes(saved.to_bytes()));
  for (World* each : {&world, &restored}) {
    each->step(dt);
    EXPECT_TRUE(each->contact_events().empty());
  }
  EXPECT_EQ(world.state_hash(), restored.state_hash());
}

TEST(ForceLaw, ARecordingOfOneThatThrewIsReplayed) {
  const TemporaryFile file(".thrown");
  World world;
  const BodyId id = world.add_body(sphere({0, 0, 0}));
  world.record(file.path());
  int calls = 0;
  const auto law = [&](Forces& forces) {
    if (++calls == 7) throw std::runtime_error("enough");
    forces.add(id, {100, 0, 0});
  };
  world.step(dt, law);
  EXPECT_THROW(world.step(dt, law), std::runtime_error);
  world.step(dt);
  world.stop_recording();
  const ReplayResult result = replay(file.path());
  EXPECT_FALSE(result.divergence.has_value());
  EXPECT_EQ(result.steps, 3);
  EXPECT_EQ(result.hash, world.state_hash());
}

TEST(ForceLaw, WhatIsNotFiniteInBulkGoesIntoQuarantine) {
  World world;
  const BodyId broken = world.add_body(sphere({0, 0, 0})), well = world.add_body(sphere({5, 0, 0}));
  const StepReport report = world.step(dt, [&](Forces& forces) {
    if (forces.time() > 0.4 * dt) forces.forces()(0, broken.index) = nan;
  });
  EXPECT_EQ(report.quarantined, 1);
  EXPECT_EQ(report.first_quarantined, static_cast<std::int64_t>(broken.index));
  EXPECT_TRUE(world.is_quarantined(broken));
  EXPECT_NEAR(world.velocity(well).z(), -g * dt, 1e-12);
}

// In any substep: what touched until then is told to have ended.
TEST(ForceLaw, WhatEndsInASubstepIsToldAfterTheStep) {
  World world({.settings = {.substeps = 4, .contact_events = true}});
  world.add_body(ground());
  const BodyId crate = world.add_body(box({0, 0, 0.5}));
  world.step(dt);
  ASSERT_EQ(world.contact_events().size(), 1u);
  const StepReport report = world.step(dt, [&](Forces& forces) {
    if (forces.time() > 0.2 * dt && forces.time() < 0.3 * dt) forces.add(crate, {1e15, 0, 0});
  });
  EXPECT_EQ(report.quarantined, 1);
  ASSERT_EQ(world.contact_events().size(), 1u);
  EXPECT_FALSE(world.contact_events()[0].began);
  Snapshot after;
  world.save(after);
  world.step(dt);
  const std::uint64_t hash = world.state_hash();
  world.restore(after);
  world.step(dt);
  EXPECT_EQ(world.state_hash(), hash);
}

// In substeps before, what rests has pushed what it rests on.
TEST(ForceLaw, WhatFallsAsleepInASubstepTouchesOnce) {
  for (int substep = 0; substep < 4; ++substep) {
    World world(
        {.settings = {
             .substeps = 4, .sleeping = true, .time_to_sleep = 0.1 + substep * dt / 4, .contact_events = true}});
    world.add_body(ground());
    const BodyId crate = world.add_body(box({0, 0, 0.5}));
    std::size_t events = 0;
    for (int i = 0; i < 30; ++i) {
      world.step(dt, [](Forces&) {});
      events += world.contact_events().size();
    }
    EXPECT_TRUE(world.is_asleep(crate));
    EXPECT_EQ(events, 1u) << substep;
  }
}

}  // namespace
}  // namespace atl::test
