// What a step leaves out, what it says of that, and that one body that needs something costs nobody else.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "support/bodies.h"

namespace atl::test {
namespace {

constexpr int block = 8;  // contacts that kernels take together

// Boxes on the ground, each an island of its own.
std::vector<BodyId> add_field(World& world, int count, const Material& material = {}) {
  world.add_body(ground());
  std::vector<BodyId> ids;
  for (int i = 0; i < count; ++i) {
    ids.push_back(world.add_body(
        {.shape = Box{{0.5, 0.5, 0.5}}, .position = {3.0 * (i % 20), 3.0 * (i / 20), 0.5}, .material = material}));
  }
  return ids;
}

TEST(StepPlan, StagesStandInOrderAndSayWhy) {
  World world;
  const StepReport report = world.step(dt);
  for (std::size_t i = 0; i < stage_count; ++i) {
    const StageReport& stage = report.stages[i];
    EXPECT_STREQ(stage.name, stage_name(static_cast<Stage>(i)));
    EXPECT_FALSE(stage.run) << stage.name;
    EXPECT_EQ(stage.items, 0) << stage.name;
    EXPECT_EQ(stage.ms, 0) << stage.name;
    EXPECT_FALSE(std::string(stage.why).empty()) << stage.name;
    EXPECT_FALSE(std::string(stage.unit).empty()) << stage.name;
  }
}

TEST(StepPlan, BallsOnTheGroundNeedNeitherSeveralPointsNorTwoMovableBodies) {
  World world;
  world.add_body(ground());
  for (int i = 0; i < 20; ++i) world.add_body({.shape = Sphere{0.5}, .position = {2.0 * i, 0, 0.5}});
  const StepReport report = run(world, 5);
  EXPECT_EQ(report.stage(Stage::ContactSolver).items, 20);
  EXPECT_FALSE(report.stage(Stage::SeveralPoints).run);
  EXPECT_FALSE(report.stage(Stage::TwoMovableBodies).run);
  EXPECT_FALSE(report.stage(Stage::GyroscopicTorque).run);
  EXPECT_TRUE(report.stage(Stage::Friction).run);
}

TEST(StepPlan, FrictionIsLeftOutWhereNoContactHasIt) {
  World world;
  add_field(world, 40, {.friction = 0});
  const StepReport report = run(world, 5);
  EXPECT_EQ(report.counts.contacts, 40);
  EXPECT_FALSE(report.stage(Stage::Friction).run);
  EXPECT_STREQ(report.stage(Stage::Friction).why, "no contact has friction");
}

TEST(StepPlan, OneBouncyBodyMakesOneBlockBounce) {
  World world;
  add_field(world, 200);
  EXPECT_FALSE(run(world, 5).stage(Stage::Restitution).run);
  world.add_body({.shape = Box{{0.5, 0.5, 0.5}}, .position = {-10, 0, 0.5}, .material = {.restitution = 0.5}});
  const StageReport bounces = run(world, 5).stage(Stage::Restitution);
  EXPECT_TRUE(bounces.run);
  EXPECT_GE(bounces.items, 1);
  EXPECT_LE(bounces.items, block);
}

TEST(StepPlan, OneUnequalBodyIsTheOnlyOneThatTumbles) {
  World world;
  add_field(world, 200);
  world.add_body({.shape = Box{{0.5, 0.6, 0.7}}, .position = {-10, 0, 0.7}});
  EXPECT_EQ(run(world, 5).stage(Stage::GyroscopicTorque).items, 1);
}

TEST(StepPlan, OneFastBodyIsTheOnlyOneSwept) {
  World world;
  add_field(world, 200);
  world.add_body({.shape = Sphere{0.1}, .position = {-10, 0, 5}, .velocity = {-100, 0, 0}});
  EXPECT_EQ(run(world, 2).stage(Stage::ContinuousCollision).items, 1);
}

TEST(StepPlan, OneJointIsSolvedForItsTwoBodies) {
  World world;
  const std::vector<BodyId> ids = add_field(world, 200);
  EXPECT_STREQ(run(world, 2).stage(Stage::JointSolver).why, "there are no joints");
  world.add_joint({.kind = BallJoint{}, .first = ids[0], .second = ids[1]});
  const StepReport report = run(world, 2);
  EXPECT_EQ(report.stage(Stage::JointSolver).items + report.stage(Stage::DirectJoints).items, 1);
}

// No memory is held for what no step has needed.
TEST(StepPlan, WhatIsNotUsedHoldsNoMemory) {
  World world;
  add_field(world, 50);
  run(world, 5);
  const auto held = [&](const std::string& name) {
    for (const MemoryUse& use : world.memory()) {
      if (use.name == name) return use.bytes;
    }
    ADD_FAILURE() << "no part " << name;
    return std::size_t{0};
  };
  for (const char* name :
       {"running_surfaces", "direct_contacts", "joints", "continuous_collision", "contact_events", "contact_problem"}) {
    EXPECT_EQ(held(name), 0u) << name;
  }
  for (const char* name : {"bodies", "shapes", "broadphase", "contacts", "islands", "contact_solver"}) {
    EXPECT_GT(held(name), 0u) << name;
  }
  world.set_settings({.contact_events = true, .keep_contact_problem = true});
  run(world, 1);
  EXPECT_GT(held("contact_events"), 0u);
  EXPECT_GT(held("contact_problem"), 0u);
}

}  // namespace
}  // namespace atl::test
