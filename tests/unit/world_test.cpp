// The public contract of World: ids, views, settings, and what a call that throws leaves behind.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <string_view>
#include <utility>
#include <vector>

#include "support/bodies.h"
#include "support/expect_error.h"

namespace atl::test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

TEST(World, DefinitionOutOfRangeIsRefusedByName) {
  const auto expect_refused = [](const WorldDef& def, std::string_view field, std::string_view value) {
    expect_error([&] { World world(def); }, {field, value});
  };
  expect_refused({.threads = 0}, "threads", "0");
  expect_refused({.threads = -3}, "threads", "-3");
  expect_refused({.threads = 1025}, "threads", "1025");
  expect_refused({.gravity = {0, nan, 0}}, "gravity", "nan");
}

struct BadSettings {
  Settings settings;
  std::string_view field;
  std::string_view value;
};

std::vector<BadSettings> bad_settings() {
  return {
      {{.substeps = 0}, "substeps", "0"},
      {{.substeps = 1025}, "substeps", "1025"},
      {{.iterations = 0}, "iterations", "0"},
      {{.iterations = 1025}, "iterations", "1025"},
      {{.relax_iterations = -1}, "relax_iterations", "-1"},
      {{.relax_iterations = 1025}, "relax_iterations", "1025"},
      {{.tolerance = -0.5}, "tolerance", "-0.5"},
      {{.tolerance = infinity}, "tolerance", "inf"},
      {{.tolerance = nan}, "tolerance", "nan"},
      {{.stabilisation = static_cast<Stabilisation>(7)}, "stabilisation", "7"},
      {{.stabilisation = static_cast<Stabilisation>(-1)}, "stabilisation", "-1"},
      {{.correction = 0}, "correction", "0"},
      {{.correction = -0.5}, "correction", "-0.5"},
      {{.correction = 1.25}, "correction", "1.25"},
      {{.correction = nan}, "correction", "nan"},
      {{.slop = -0.5}, "slop", "-0.5"},
      {{.slop = nan}, "slop", "nan"},
      {{.contact_hertz = 0}, "contact_hertz", "0"},
      {{.contact_hertz = nan}, "contact_hertz", "nan"},
      {{.contact_damping_ratio = -1.5}, "contact_damping_ratio", "-1.5"},
      {{.contact_push_speed = -1.5}, "contact_push_speed", "-1.5"},
      {{.contact_push_speed = infinity}, "contact_push_speed", "inf"},
      {{.restitution_threshold = -1.5}, "restitution_threshold", "-1.5"},
      {{.joint_solver = static_cast<JointSolver>(7)}, "joint_solver", "7"},
      {{.joint_solver = static_cast<JointSolver>(-1)}, "joint_solver", "-1"},
      {{.joint_hertz = 0}, "joint_hertz", "0"},
      {{.joint_hertz = infinity}, "joint_hertz", "inf"},
      {{.joint_damping_ratio = -1.5}, "joint_damping_ratio", "-1.5"},
      {{.sleep_speed = nan}, "sleep_speed", "nan"},
      {{.time_to_sleep = -1.5}, "time_to_sleep", "-1.5"},
  };
}

TEST(World, SettingsOutOfRangeAreRefusedByName) {
  World world({.settings = {.substeps = 7}});
  const std::uint64_t hash = world.state_hash();
  for (const BadSettings& bad : bad_settings()) {
    expect_error([&] { World other({.settings = bad.settings}); }, {bad.field, bad.value});
    expect_error([&] { world.set_settings(bad.settings); }, {bad.field, bad.value});
    EXPECT_EQ(world.settings().substeps, 7);
    EXPECT_EQ(world.state_hash(), hash);
  }
}

TEST(World, SettingsGravityAndThreadsReadBack) {
  World world({.gravity = {1, 2, 3}, .threads = 3, .settings = {.substeps = 7}});
  EXPECT_EQ(world.gravity(), Vector3(1, 2, 3));
  EXPECT_EQ(world.threads(), 3);
  EXPECT_EQ(world.settings().substeps, 7);
  EXPECT_NE(world.simd(), Simd::Auto);
  world.set_gravity({0, 0, 5});
  world.set_settings({.substeps = 2});
  EXPECT_EQ(world.gravity(), Vector3(0, 0, 5));
  EXPECT_EQ(world.settings().substeps, 2);
  expect_error([&] { world.set_gravity({0, 0, infinity}); }, {"gravity", "inf"});
  EXPECT_EQ(world.gravity(), Vector3(0, 0, 5));
}

TEST(World, StepNeedsAPositiveTimeOfAtMostASecond) {
  World world;
  const BodyId id = world.add_body(sphere({0, 0, 5}));
  const std::uint64_t hash = world.state_hash();
  for (const double bad : {0.0, -1.0, 1.5, nan, infinity}) {
    EXPECT_THROW(world.step(bad), Error) << bad;
    EXPECT_EQ(world.state_hash(), hash) << bad;
  }
  expect_error([&] { world.step(-1); }, {"dt", "-1"});
  EXPECT_NO_THROW(world.step(1));
  EXPECT_LT(world.pose(id).position.z(), 5);
}

TEST(World, StaleIdIsCaughtByEveryCall) {
  World world;
  world.add_body(ground());
  const BodyId removed = world.add_body(box({0, 0, 5}));
  world.remove_body(removed);
  const BodyId reused = world.add_body(box({0, 0, 7}));
  ASSERT_EQ(reused.index, removed.index);
  const std::uint64_t hash = world.state_hash();

  for (const BodyId id : {removed, BodyId{}, BodyId{.index = 99, .generation = 0}}) {
    const std::vector<std::function<void()>> calls = {
        [&] { world.remove_body(id); },
        [&] { world.pose(id); },
        [&] { world.velocity(id); },
        [&] { world.angular_velocity(id); },
        [&] { world.mass(id); },
        [&] { world.type(id); },
        [&] { world.is_asleep(id); },
        [&] { world.set_pose(id, {}); },
        [&] {
          world.set_velocity(id, {0, 0, 0}, {0, 0, 0});
        },
        [&] {
          world.apply_force(id, {1, 0, 0});
        },
        [&] {
          world.apply_impulse(id, {1, 0, 0}, {0, 0, 0});
        },
        [&] { world.wake(id); },
    };
    for (std::size_t i = 0; i < calls.size(); ++i) EXPECT_THROW(calls[i](), Error) << "call " << i;
    EXPECT_FALSE(world.contains(id));
  }
  EXPECT_EQ(world.state_hash(), hash);
  EXPECT_TRUE(world.contains(reused));
}

TEST(World, UnusableStateIsRefusedAndChangesNothing) {
  World world;
  const BodyId id = world.add_body(box({0, 0, 5}));
  const std::uint64_t hash = world.state_hash();
  expect_error([&] { world.set_pose(id, {.position = {nan, 0, 0}}); }, {"position", "nan"});
  expect_error([&] { world.set_pose(id, {.orientation = Quaternion(0, 0, 0, 0)}); }, {"orientation", "0"});
  expect_error([&] { world.set_velocity(id, {0, infinity, 0}, {0, 0, 0}); }, {"velocity", "inf"});
  expect_error([&] { world.set_velocity(id, {0, 0, 0}, {0, nan, 0}); }, {"angular", "nan"});
  expect_error([&] { world.apply_force(id, {nan, 0, 0}); }, {"force", "nan"});
  expect_error([&] { world.apply_force(id, {0, 0, 0}, {nan, 0, 0}); }, {"torque", "nan"});
  expect_error([&] { world.apply_impulse(id, {nan, 0, 0}, {0, 0, 0}); }, {"impulse", "nan"});
  expect_error([&] { world.apply_impulse(id, {1, 0, 0}, {0, 0, nan}); }, {"point", "nan"});
  EXPECT_EQ(world.state_hash(), hash);
}

TEST(World, MoveTakesTheBodiesAlong) {
  World world;
  const BodyId id = world.add_body(sphere({0, 0, 5}));
  World moved = std::move(world);
  EXPECT_EQ(moved.pose(id).position, Vector3(0, 0, 5));
  World other;
  other = std::move(moved);
  EXPECT_EQ(other.body_count(), 1u);
  other.step(dt);
  EXPECT_LT(other.pose(id).position.z(), 5);
}

// A pair that was found apart is left alone until something moves. Turning by hand is moving.
TEST(World, TurningARestingBodyByHandIntoAnotherIsSeen) {
  World world({.gravity = Vector3::Zero(), .settings = {.contact_events = true}});
  world.add_body({.shape = Box{.half_extents = {0.5, 0.5, 0.5}}});
  const atl::Pose beside{.position = {1.4, 0, 0}};
  const BodyId bar = world.add_body(
      {.type = BodyType::Static, .shape = Box{.half_extents = {0.25, 2, 0.25}}, .position = beside.position});
  for (int i = 0; i < 3; ++i) world.step(1.0 / 60);
  ASSERT_TRUE(world.contact_events().empty());
  const double half_turn = std::numbers::pi / 4;  // of a right angle
  world.set_pose(bar, {.position = beside.position, .orientation = {std::cos(half_turn), 0, 0, std::sin(half_turn)}});
  world.step(1.0 / 60);
  ASSERT_EQ(world.contact_events().size(), 1u);
  EXPECT_TRUE(world.contact_events()[0].began);
}

TEST(World, ViewsThatAreKeptCanBeReadToItsEnd) {
  World world;
  world.keep_views();
  std::vector<Eigen::Map<const Eigen::Matrix3Xd>> views;
  Snapshot few;
  for (int i = 0; i < 1000; ++i) {
    world.add_body({.position = {i + 0.5, 0, 0}, .velocity = {0, 2.0 * i, 0}});
    if (i == 2) world.save(few);
    views.push_back(i % 2 == 0 ? world.positions() : world.velocities());
  }
  world.restore(few);
  world.step(1.0 / 60);
  ASSERT_EQ(world.body_count(), 3u);
  for (int i = 3; i < 1000; ++i) {
    const auto& view = views[static_cast<std::size_t>(i)];
    ASSERT_EQ(view.cols(), i + 1);
    ASSERT_EQ(view(i % 2, i), i % 2 == 0 ? i + 0.5 : 2.0 * i) << i;
  }
  EXPECT_EQ(world.positions().cols(), 3);
}

}  // namespace
}  // namespace atl::test
