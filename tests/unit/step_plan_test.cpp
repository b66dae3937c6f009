// What a step leaves out, and what it says of that.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "support/bodies.h"

namespace atl::test {
namespace {

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
  for (std::size_t i = 0; i < feature_count; ++i) {
    const FeatureReport& feature = report.features[i];
    EXPECT_STREQ(feature.name, feature_name(static_cast<Feature>(i)));
    EXPECT_FALSE(feature.run) << feature.name;
    EXPECT_EQ(feature.items, 0) << feature.name;
    EXPECT_EQ(feature.ms, 0) << feature.name;
    EXPECT_FALSE(std::string(feature.why).empty()) << feature.name;
    EXPECT_FALSE(std::string(feature.unit).empty()) << feature.name;
  }
}

TEST(StepPlan, BallsOnTheGroundNeedNeitherSeveralPointsNorTwoMovableBodies) {
  World world;
  world.add_body(ground());
  for (int i = 0; i < 20; ++i) world.add_body({.shape = Sphere{0.5}, .position = {2.0 * i, 0, 0.5}});
  const StepReport report = run(world, 5);
  EXPECT_EQ(report.feature(Feature::ContactSolver).items, 20);
  EXPECT_FALSE(report.feature(Feature::SeveralPoints).run);
  EXPECT_FALSE(report.feature(Feature::TwoMovableBodies).run);
  EXPECT_FALSE(report.feature(Feature::GyroscopicTorque).run);
  EXPECT_TRUE(report.feature(Feature::Friction).run);
}

TEST(StepPlan, FrictionIsLeftOutWhereNoContactHasIt) {
  World world;
  add_field(world, 40, {.friction = 0});
  const StepReport report = run(world, 5);
  EXPECT_EQ(report.counts.contacts, 40);
  EXPECT_FALSE(report.feature(Feature::Friction).run);
  EXPECT_STREQ(report.feature(Feature::Friction).why, "no contact has friction");
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
