// Work that a step leaves out, and its report of that.

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

std::size_t held_by(const World& world, const std::string& name) {
  for (const MemoryUse& use : world.memory()) {
    if (use.name == name) return use.bytes;
  }
  ADD_FAILURE() << "no part " << name;
  return 0;
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
  const auto held = [&](const char* name) { return held_by(world, name); };
  for (const char* name :
       {"running_surfaces", "direct_contacts", "joints", "contact_events", "sensors", "contact_problem"}) {
    EXPECT_EQ(held(name), 0u) << name;
  }
  for (const char* name : {"bodies", "shapes", "broadphase", "contacts", "islands", "contact_solver"}) {
    EXPECT_GT(held(name), 0u) << name;
  }
  world.set_settings({.contact_events = true, .keep_contact_problem = true});
  world.add_body({.type = BodyType::Static, .shape = Box{{2, 2, 2}}, .sensor = true});
  run(world, 1);
  EXPECT_GT(held("contact_events"), 0u);
  EXPECT_GT(held("sensors"), 0u);
  EXPECT_GT(held("contact_problem"), 0u);
}

// Ten columns shrink to one, and then to one box.
TEST(StepPlan, IslandsThatAreGoneLeaveNoMemoryBehind) {
  constexpr std::size_t columns = 10, height = 12;
  World world({.settings = {.contact_solver = ContactSolver::Direct, .sleeping = false}});
  world.add_body(ground());
  std::vector<BodyId> boxes;
  for (std::size_t i = 0; i < columns * height; ++i) {
    boxes.push_back(world.add_body(
        {.shape = Box{{0.5, 0.5, 0.5}},
         .position = {3.0 * static_cast<double>(i / height), 0, 0.5 + static_cast<double>(i % height)}}));
  }
  const auto keep = [&](std::size_t count) {
    for (; boxes.size() > count; boxes.pop_back()) world.remove_body(boxes.back());
    run(world, 2);
    return held_by(world, "direct_contacts");
  };
  const std::size_t of_all = keep(columns * height);
  const std::size_t of_column = keep(height);
  EXPECT_LT(of_column, 2 * of_all / columns);
  EXPECT_LT(keep(1), of_column / 4);
}

}  // namespace
}  // namespace atl::test
