// Two runs that part are found out: at which step, and which bodies differ, in what, by how much.

#include "checks/divergence/divergence.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "support/planted_fault.h"
#include "support/scene_run.h"

namespace atl::test::divergence_test {
namespace {

using divergence::BodyDifference;
using divergence::Divergence;
using divergence::Meddle;
using divergence::Restore;
using divergence::Variant;

constexpr Variant one{.threads = 1, .simd = Simd::Portable};
constexpr Variant two{.threads = 2, .simd = Simd::Portable};

Scene scene_of(std::string_view text, int steps) {
  Scene scene = load_scene(text);
  scene.steps = steps;
  return scene;
}

/// The comparison as `atoll verify` makes it.
std::optional<Divergence> find_divergence(const Scene& scene, const Meddle& meddle) {
  const auto step = first_difference(divergence::follow(scene, one, {}, meddle), scene, two, {}, meddle);
  if (!step) return std::nullopt;
  return explain(scene, one, two, *step, {}, meddle);
}

std::vector<std::string> part_names(const BodyDifference& body) {
  std::vector<std::string> names;
  for (const divergence::PartDifference& part : body.parts) names.push_back(part.part);
  return names;
}

bool has(const std::vector<std::string>& names, const char* name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

TEST(Divergence, RunsThatAreTheSameHaveNone) {
  for (const char* text : {"pile:bodies=30", "ragdolls:count=1"}) {
    EXPECT_FALSE(find_divergence(scene_of(text, 40), {}).has_value()) << text;
  }
}

// Bodies that touch nothing: the fault is all that differs.
TEST(Divergence, TheLastBitsOfOneBodyAreFound) {
  constexpr double by = 1e-18;  // m/s
  const Scene scene = scene_of("pile:bodies=30", 12);
  for (const FaultPlace fault : {FaultPlace{1, 7}, FaultPlace{9, 20}}) {
    const auto found = find_divergence(scene, more_speed_with_threads(fault, by));
    ASSERT_TRUE(found.has_value());
    EXPECT_TRUE(found->seen_again);
    EXPECT_EQ(found->step, fault.step);
    ASSERT_EQ(found->bodies.size(), 1u);
    EXPECT_EQ(found->bodies[0].body, fault.body);
    const std::vector<std::string> names = part_names(found->bodies[0]);
    EXPECT_TRUE(has(names, "velocity"));
    EXPECT_FALSE(has(names, "contacts"));
    EXPECT_FALSE(has(names, "joints"));
    const divergence::PartDifference& velocity =
        *std::find_if(found->bodies[0].parts.begin(), found->bodies[0].parts.end(),
                      [](const divergence::PartDifference& part) { return part.part == "velocity"; });
    EXPECT_NEAR(velocity.by.value_or(0), by, 1e-33);
    EXPECT_EQ(velocity.unit, "m/s");
  }
}

TEST(Divergence, AnOrderThatDependsOnThreadsIsFound) {
  const auto found = find_divergence(scene_of("pile:bodies=30", 12), order_of_forces_by_threads({5, 11}));
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->step, 5);
  ASSERT_EQ(found->bodies.size(), 1u);
  EXPECT_EQ(found->bodies[0].body, 11u);
}

// In a stack the fault spreads within the step, to what touches the body and no further.
TEST(Divergence, WhatTouchesItDiffersToo) {
  const Scene scene = scene_of("islands:count=2,base=3", 40);
  const auto found = find_divergence(scene, more_speed_with_threads({30, 9}));
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->step, 30);
  EXPECT_TRUE(std::any_of(found->bodies.begin(), found->bodies.end(),
                          [](const BodyDifference& body) { return body.body == 9; }));
  EXPECT_LE(found->bodies.size(), 6u) << "one wall";
  for (const BodyDifference& body : found->bodies) EXPECT_FALSE(body.parts.empty());
}

TEST(Divergence, JointsAreTold) {
  const Scene scene = scene_of("chain:links=4", 20);
  const auto found = find_divergence(scene, more_speed_with_threads({10, 2}));
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->step, 10);
  const auto body = std::find_if(found->bodies.begin(), found->bodies.end(),
                                 [](const BodyDifference& difference) { return difference.body == 2; });
  ASSERT_NE(body, found->bodies.end());
  EXPECT_TRUE(has(part_names(*body), "joints"));
}

// A step after which nothing is reported yet is one ahead of which the state was taken on.
TEST(Divergence, RestoringIsDoneAndLosesNothing) {
  for (const Restore restore : {Restore::SameWorld, Restore::FreshWorld}) {
    for (const char* text : {"islands:count=2,base=3", "ragdolls:count=1", "conveyor:boxes=6",
                             ATOLL_SOURCE_DIR "/runtime/scene/examples/shapes.json"}) {
      Scene scene = scene_of(text, 40);
      scene.settings.sleeping = true;
      scene.settings.time_to_sleep = 0.1;
      const Variant variant{.threads = 2, .simd = Simd::Portable, .restore = restore};
      const auto trail = divergence::follow(scene, one);
      EXPECT_EQ(first_difference(trail, scene, variant), std::nullopt) << text;
    }
    const Scene wall = scene_of("islands:count=2,base=3", 40);
    int restored = 0;
    const Variant variant{.threads = 1, .simd = Simd::Portable, .restore = restore};
    divergence::follow(wall, variant, {}, [&](World& world, const auto&, std::int64_t step, const Variant&) {
      restored += step > 10 && world.contact_forces().empty();
    });
    EXPECT_GE(restored, 4);
    EXPECT_LE(restored, 16);
  }
}

TEST(Divergence, WhatRestoringLosesIsFound) {
  const Scene scene = scene_of("pile:bodies=30", 12);
  const Variant restored{.threads = 1, .simd = Simd::Portable, .restore = Restore::FreshWorld};
  const Meddle lose = [](World& world, const auto& ids, std::int64_t step, const Variant& variant) {
    if (step != 6 || variant.restore != Restore::FreshWorld) return;
    world.set_velocity(ids[9], (1 - 1e-9) * world.velocity(ids[9]), world.angular_velocity(ids[9]));
  };
  const auto step = first_difference(divergence::follow(scene, one, {}, lose), scene, restored, {}, lose);
  ASSERT_EQ(step, 6);
  const Divergence found = explain(scene, one, restored, *step, {}, lose);
  EXPECT_TRUE(found.seen_again);
  ASSERT_EQ(found.bodies.size(), 1u);
  EXPECT_EQ(found.bodies[0].body, 9u);
}

// A fault that is there in the first run alone is told as such.
TEST(Divergence, WhatDoesNotHappenAgainIsToldApart) {
  const Scene scene = scene_of("pile:bodies=10", 10);
  const auto trail = divergence::follow(scene, one);
  const auto step = first_difference(trail, scene, two, {}, more_speed_with_threads({4, 8}));
  ASSERT_EQ(step, 4);
  const Divergence found = explain(scene, one, two, *step);
  EXPECT_FALSE(found.seen_again);
  EXPECT_EQ(found.step, 4);
  EXPECT_TRUE(found.bodies.empty());
}

TEST(Divergence, WhatIsNoBodysIsToldApart) {
  const Scene scene = scene_of("pile:bodies=10", 10);
  const auto found = find_divergence(scene, [](World& world, const auto&, std::int64_t step, const Variant& variant) {
    if (step == 3 && variant.threads == 2) world.remove_body(world.add_body(static_box({0, 0, 900}, {1, 1, 1})));
  });
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->step, 3);
  EXPECT_TRUE(found->elsewhere);
  EXPECT_FALSE(found->events);
  EXPECT_TRUE(found->bodies.empty());
}

}  // namespace
}  // namespace atl::test::divergence_test
