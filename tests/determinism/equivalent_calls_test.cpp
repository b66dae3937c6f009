// Equal definitions give equal results, however they came about: said as a body was made or later, at once or in parts,
// and whatever else came and went before.

#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "support/bodies.h"

namespace atl::test::equivalent_calls_test {
namespace {

constexpr int steps = 120;

// A pile of boxes and balls on the ground, hit by one more, which is made by `make`.
struct Scenery {
  World world;
  std::vector<BodyId> ids;

  using Make = std::function<BodyId(World&, const BodyDef&)>;

  explicit Scenery(const Make& make, const Settings& settings = {}) : world({.settings = settings}) {
    world.add_body(ground());
    for (int i = 0; i < 12; ++i) {
      const double x = 0.9 * (i % 3), y = 0.9 * (i / 3 % 2), z = 0.5 + 1.05 * (i / 6);
      ids.push_back(world.add_body(i % 4 == 3 ? sphere({x, y, z}, 0.4) : box({x, y, z}, {0.45, 0.4, 0.5})));
    }
    BodyDef def = box({-3, 0.3, 1.2}, {0.3, 0.4, 0.35});
    def.orientation = Quaternion(Eigen::AngleAxisd(0.4, Vector3(1, 2, 3).normalized()));
    def.velocity = {6, 0.5, 1};
    def.angular_velocity = {1, -2, 0.5};
    ids.push_back(make(world, def));
  }
};

// All that can be seen of the bodies, after each step.
std::vector<double> trail(Scenery& scenery) {
  std::vector<double> values;
  for (int i = 0; i < steps; ++i) {
    scenery.world.step(dt);
    for (const BodyId id : scenery.ids) {
      const BodyState state = scenery.world.state(id);
      for (const double x : state.pose.position) values.push_back(x);
      for (const double x : state.pose.orientation.coeffs()) values.push_back(x);
      for (const double x : state.velocity) values.push_back(x);
      for (const double x : state.angular_velocity) values.push_back(x);
    }
  }
  return values;
}

BodyId make_at_once(World& world, const BodyDef& def) { return world.add_body(def); }

std::vector<double> trail_of(const Scenery::Make& make) {
  Scenery scenery(make);
  return trail(scenery);
}

// Vectors are long: what is printed is the first place where they differ.
void expect_same(const std::vector<double>& a, const std::vector<double>& b, const char* what) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    const std::size_t per_step = a.size() / steps;
    ASSERT_EQ(a[i], b[i]) << what << ": step " << i / per_step << ", body " << i % per_step / 13;
  }
}

TEST(EquivalentCalls, VelocityInTheDefinitionOrAfter) {
  expect_same(trail_of([](World& world, BodyDef def) {
                const Vector3 linear = def.velocity, angular = def.angular_velocity;
                def.velocity = def.angular_velocity = Vector3::Zero();
                const BodyId id = world.add_body(def);
                world.set_velocity(id, linear, angular);
                return id;
              }),
              trail_of(make_at_once), "velocity");
}

TEST(EquivalentCalls, PlaceInTheDefinitionOrAfter) {
  expect_same(trail_of([](World& world, BodyDef def) {
                const Pose pose{def.position, def.orientation};
                def.position = {-40, 7, 90};
                const BodyId id = world.add_body(def);
                world.set_pose(id, pose);
                return id;
              }),
              trail_of(make_at_once), "position");
  expect_same(trail_of([](World& world, BodyDef def) {
                const Pose pose{def.position, def.orientation};
                def.orientation = Quaternion::Identity();
                const BodyId id = world.add_body(def);
                world.set_pose(id, pose);
                return id;
              }),
              trail_of(make_at_once), "orientation");
}

TEST(EquivalentCalls, FiltersInTheDefinitionOrAfter) {
  const CollisionFilter filter{.category = 4, .mask = 0xff, .group = 2};
  expect_same(trail_of([&](World& world, const BodyDef& def) {
                const BodyId id = world.add_body(def);
                world.set_filter(id, filter);
                return id;
              }),
              trail_of([&](World& world, BodyDef def) {
                def.filter = filter;
                return world.add_body(def);
              }),
              "filter");
}

TEST(EquivalentCalls, SomethingThatIsTakenBack) {
  const std::vector<double> expected = trail_of(make_at_once);
  expect_same(trail_of([](World& world, const BodyDef& def) {
                const BodyId id = world.add_body(def);
                world.set_filter(id, {.mask = 0});
                world.set_filter(id, {});
                return id;
              }),
              expected, "filter");
  expect_same(trail_of([](World& world, const BodyDef& def) {
                const BodyId id = world.add_body(def);
                world.set_collision_enabled(id, {.index = 3}, false);
                world.set_collision_enabled(id, {.index = 3}, true);
                return id;
              }),
              expected, "collision");
  expect_same(trail_of([](World& world, const BodyDef& def) {
                world.remove_body(world.add_body(sphere({1, 1, 1}, 2)));
                return world.add_body(def);
              }),
              expected, "a body in the same place, under the same index");
  expect_same(trail_of([](World& world, const BodyDef& def) {
                const BodyId id = world.add_body(def);
                world.remove_joint(world.add_joint({.first = {.index = 2}, .second = id}));
                return id;
              }),
              expected, "joint");
  expect_same(trail_of([](World& world, const BodyDef& def) {
                const BodyId id = world.add_body(def);
                world.set_gravity({1, 2, 3});
                world.set_settings({.substeps = 9});
                world.set_gravity({0, 0, -9.81});
                world.set_settings({});
                return id;
              }),
              expected, "gravity and settings");
}

TEST(EquivalentCalls, ForcesAtOnceOrInParts) {
  const auto with_force = [](const std::vector<Vector3>& parts) {
    return trail_of([&](World& world, const BodyDef& def) {
      const BodyId id = world.add_body(def);
      for (const Vector3& part : parts) world.apply_force(id, part, 2 * part);
      return id;
    });
  };
  expect_same(with_force({{64, 0, 32}}), with_force({{32, 0, 0}, {0, 0, 32}, {32, 0, 0}}), "force");
}

TEST(EquivalentCalls, AWorldThatHasRunBeforeAndIsPutBack) {
  // Indices, generations and trees have a history then, and the bodies none.
  const auto run_again = [](int before) {
    World world;
    std::vector<double> places;
    for (int round = 0; round <= before; ++round) {
      std::vector<BodyId> ids = {world.add_body(ground())};
      for (const BodyId id : add_stack(world, 4)) ids.push_back(id);
      BodyDef ball = sphere({-3, 0.1, 2.5}, 0.4);
      ball.velocity = {8, 0, 0};
      ids.push_back(world.add_body(ball));
      places.clear();
      for (int i = 0; i < steps; ++i) {
        world.step(dt);
        for (const BodyId id : ids) {
          for (const double x : world.pose(id).position) places.push_back(x);
        }
      }
      for (std::size_t i = ids.size(); i > 0; --i) world.remove_body(ids[i - 1]);
    }
    return places;
  };
  const std::vector<double> fresh = run_again(0);
  for (const int before : {1, 2}) EXPECT_EQ(run_again(before), fresh) << before;
}

}  // namespace
}  // namespace atl::test::equivalent_calls_test
