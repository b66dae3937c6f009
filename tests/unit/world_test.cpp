// The public contract of World: ids, views, settings, and what a call that throws leaves behind.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "support/bodies.h"
#include "support/expect_error.h"

namespace atl::test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

TEST(World, ExampleOfTheDesignCompilesAndSettles) {
  World world({.gravity = {0, 0, -9.81}, .threads = 2});
  world.add_body({.type = BodyType::Static, .shape = HalfSpace{.normal = {0, 0, 1}}});
  const BodyId crate = world.add_body({.shape = Box{.half_extents = {0.5, 0.5, 0.5}},
                                       .position = {0, 0, 3},
                                       .density = 600,
                                       .material = {.friction = 0.6}});
  for (int i = 0; i < 600; ++i) {
    [[maybe_unused]] StepReport report = world.step(1.0 / 60);
  }
  EXPECT_NEAR(world.pose(crate).position.z(), 0.5, 1e-3);
  double force = 0;
  for (const ContactForce& f : world.contact_forces()) force += f.normal_force;
  EXPECT_NEAR(force, 600 * 9.81, 0.01 * 600 * 9.81);
}

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

TEST(World, SolverTimesAreTheProfilesAlone) {
  for (const bool profile : {false, true}) {
    World world({.settings = {.profile = profile}});
    world.add_body(ground());
    add_stack(world, 3);
    const StepReport report = run(world, 5);
    double all = 0;
    for (const double ms : report.solver_ms) all += ms;
    EXPECT_EQ(all > 0, profile);
  }
}

TEST(World, SolverStagesHaveNamesOfTheirOwn) {
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < solver_phase_count; ++i) names.insert(solver_phase_name(static_cast<SolverPhase>(i)));
  EXPECT_EQ(names.size(), solver_phase_count);
  EXPECT_FALSE(names.contains(""));
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

TEST(World, EmptyWorldSteps) {
  World world;
  const StepReport report = run(world, 3);
  EXPECT_EQ(report.counts.pairs, 0);
  EXPECT_EQ(report.first_quarantined, -1);
  EXPECT_EQ(world.body_count(), 0u);
  EXPECT_EQ(world.positions().cols(), 0);
  EXPECT_TRUE(world.contact_forces().empty());
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

TEST(World, IndexIsUsedAgainWithAnotherGeneration) {
  World world;
  const BodyId first = world.add_body(box({0, 0, 0}));
  const BodyId second = world.add_body(box({2, 0, 0}));
  world.remove_body(first);
  EXPECT_EQ(world.body_count(), 1u);
  const BodyId third = world.add_body(sphere({4, 0, 0}));
  EXPECT_EQ(third.index, first.index);
  EXPECT_NE(third.generation, first.generation);
  EXPECT_EQ(world.body_count(), 2u);
  EXPECT_EQ(world.pose(second).position, Vector3(2, 0, 0));
  EXPECT_EQ(world.pose(third).position, Vector3(4, 0, 0));
}

TEST(World, BulkViewsAgreeWithTheSingleCalls) {
  World world;
  std::vector<BodyId> ids = {world.add_body(ground())};
  for (BodyId id : add_stack(world, 3)) ids.push_back(id);
  ids.push_back(world.add_body(
      {.type = BodyType::Kinematic, .position = {9, 0, 0}, .velocity = {1, 0, 0}, .angular_velocity = {0, 1, 0}}));
  ids.push_back(world.add_body({.position = {-9, 0, 5}, .angular_velocity = {3, 2, 1}}));
  const auto expect_agreement = [&] {
    ASSERT_EQ(world.positions().cols(), static_cast<Eigen::Index>(ids.size()));
    for (BodyId id : ids) {
      const auto column = static_cast<Eigen::Index>(id.index);
      EXPECT_EQ(world.positions().col(column), world.pose(id).position);
      EXPECT_EQ(world.orientations().col(column), world.pose(id).orientation.coeffs());
      EXPECT_EQ(world.velocities().col(column), world.velocity(id));
      EXPECT_EQ(world.angular_velocities().col(column), world.angular_velocity(id));
    }
  };
  expect_agreement();
  run(world, 20);
  expect_agreement();
  world.set_pose(ids[1], {.position = {5, 5, 5}, .orientation = Quaternion(0, 1, 0, 0)});
  world.set_velocity(ids[2], {1, 2, 3}, {4, 5, 6});
  world.apply_impulse(ids[3], {100, 0, 0}, {0, 0, 0});
  expect_agreement();
  EXPECT_EQ(world.pose(ids[1]).position, Vector3(5, 5, 5));
  EXPECT_EQ(world.velocity(ids[2]), Vector3(1, 2, 3));
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

TEST(World, BodyThatStopsBeingFiniteIsNamed) {
  World world;
  world.add_body(ground());
  const std::vector<BodyId> stack = add_stack(world, 2);
  const BodyId lost = world.add_body({.shape = Sphere{0.5}, .position = {9, 0, 5}, .mass = 1e-3});
  EXPECT_EQ(run(world, 10).first_quarantined, -1);
  world.apply_force(lost, {std::numeric_limits<double>::max(), 0, 0});
  EXPECT_EQ(world.step(dt).first_quarantined, static_cast<std::int64_t>(lost.index));
  EXPECT_NO_THROW(run(world, 10));
  for (BodyId id : stack) EXPECT_TRUE(world.pose(id).position.allFinite());
}

TEST(World, ReportNamesEveryStageAndSaysWhy) {
  World world;
  world.add_body(ground());
  add_stack(world, 2);
  const StepReport report = run(world, 10);
  ASSERT_FALSE(report.features.empty());
  for (const FeatureReport& feature : report.features) {
    EXPECT_GT(std::string_view(feature.name).size(), 0u);
    EXPECT_GT(std::string_view(feature.why).size(), 0u) << feature.name;
  }
  EXPECT_EQ(report.counts.contacts, 2);
  EXPECT_EQ(report.counts.points, 8);
  EXPECT_EQ(report.counts.islands, 1);
  EXPECT_EQ(report.counts.joints, 0);
  EXPECT_GE(report.counts.pairs, 2);
}

TEST(World, BodiesComeAndGoWhileItRuns) {
  World world;
  world.add_body(ground());
  std::vector<BodyId> ids;
  for (int i = 0; i < 200; ++i) {
    if (i % 2 == 0) ids.push_back(world.add_body(box({0.3 * (i % 7), 0.3 * (i % 5), 2.0 + i % 3})));
    if (i % 5 == 4) {
      const std::size_t victim = static_cast<std::size_t>(i * 7) % ids.size();
      world.remove_body(ids[victim]);
      ids.erase(ids.begin() + static_cast<std::ptrdiff_t>(victim));
    }
    ASSERT_EQ(world.step(dt).first_quarantined, -1) << i;
    ASSERT_EQ(world.body_count(), ids.size() + 1);
    for (const ContactForce& point : world.contact_forces()) {
      ASSERT_TRUE(world.contains(point.a) && world.contains(point.b)) << i;
    }
  }
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
