// Changes of a body's definition after it was made: the body is as if it had been made like that, in all modes, and
// back.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <vector>

#include "support/bodies.h"

namespace atl::test {
namespace {

struct Change {
  const char* name;
  std::function<void(BodyDef&)> in_definition;
  std::function<void(World&, BodyId)> later;
  bool keeps_numbers = true;  // of colliders, which order contacts
};

Compound two_halves() {
  return {{{.shape = Box{{0.2, 0.4, 0.3}}, .position = {-0.2, 0, 0}, .material = Material{.friction = 0.1}},
           {.shape = Sphere{0.3}, .position = {0.3, 0, 0}, .density_factor = 2}}};
}

void redefine(World& world, BodyId id, const std::function<void(BodyDef&)>& change) {
  BodyDef def = world.definition(id);
  change(def);
  world.set_definition(id, def);
}

// Powers of two, so that a mass that is changed has the bits of one that was given.
const std::vector<Change>& changes() {
  static const std::vector<Change> all = {
      {"friction", [](BodyDef& def) { def.material.friction = 0.1; },
       [](World& world, BodyId id) { world.set_material(id, {.friction = 0.1}); }},
      {"restitution", [](BodyDef& def) { def.material.restitution = 0.5; },
       [](World& world, BodyId id) { world.set_material(id, {.restitution = 0.5}); }},
      {"rolling_friction", [](BodyDef& def) { def.material.rolling_friction = 0.05; },
       [](World& world, BodyId id) { world.set_material(id, {.rolling_friction = 0.05}); }},
      {"mass", [](BodyDef& def) { def.density *= 4; },
       [](World& world, BodyId id) { world.set_mass(id, 4 * world.mass(id)); }},
      {"gravity_scale", [](BodyDef& def) { def.gravity_scale = 0.25; },
       [](World& world, BodyId id) { world.set_gravity_scale(id, 0.25); }},
      {"damping", [](BodyDef& def) { def.linear_damping = 0.5, def.angular_damping = 2; },
       [](World& world, BodyId id) { world.set_damping(id, 0.5, 2); }},
      {"shape",
       [](BodyDef& def) {
         def.mass = 1024;
         def.shape = Cone{0.4, 0.5};
       },
       [](World& world, BodyId id) {
         world.set_mass(id, 1024);
         world.set_shape(id, Cone{0.4, 0.5});
       }},
      {"compound",
       [](BodyDef& def) {
         def.mass = 512;
         def.shape = two_halves();
       },
       [](World& world, BodyId id) {
         world.set_mass(id, 512);
         world.set_shape(id, Sphere{0.3});
         world.set_shape(id, two_halves());
       },
       false},
      {"type", [](BodyDef& def) { def.type = BodyType::Kinematic; },
       [](World& world, BodyId id) { redefine(world, id, [](BodyDef& def) { def.type = BodyType::Kinematic; }); }},
      {"sensor", [](BodyDef& def) { def.sensor = true; },
       [](World& world, BodyId id) { redefine(world, id, [](BodyDef& def) { def.sensor = true; }); }},
      {"continuous", [](BodyDef& def) { def.continuous = true; },
       [](World& world, BodyId id) { redefine(world, id, [](BodyDef& def) { def.continuous = true; }); }},
      {"disabled", [](BodyDef&) {}, [](World& world, BodyId id) { world.set_enabled(id, false); }, false},
  };
  return all;
}

struct Scene {
  World world;
  std::vector<BodyId> bodies;
};

// Spheres and boxes that fall onto each other on a slope, two of them joined.
Scene scene(const Settings& settings, int threads, const std::function<void(BodyDef&)>& change) {
  Scene made{World({.threads = threads, .settings = settings}), {}};
  made.world.add_body({.type = BodyType::Static,
                       .shape = HalfSpace{},
                       .orientation = Quaternion(Eigen::AngleAxisd(0.2, Vector3::UnitY()))});
  for (int i = 0; i < 12; ++i) {
    BodyDef def{.shape = i % 2 == 0 ? Shape(Box{{0.5, 0.4, 0.3}}) : Shape(Sphere{0.4}),
                .position = {1.1 * (i % 3), 1.05 * (i % 2), 1.2 + 1.3 * (i / 3)}};
    if (i % 4 == 0) change(def);
    made.bodies.push_back(made.world.add_body(def));
  }
  made.world.add_joint(joint_at(made.world, BallJoint{}, made.bodies[0], made.bodies[1], {0, 0.5, 1.2}));
  return made;
}

void change_later(Scene& scene, const Change& change) {
  for (std::size_t i = 0; i < scene.bodies.size(); i += 4) change.later(scene.world, scene.bodies[i]);
}

void run(World& world, int steps) {
  for (int i = 0; i < steps; ++i) world.step(dt);
}

TEST(BodyChanges, AChangeIsAsGoodAsADefinition) {
  for (const ContactSolver solver : {ContactSolver::Auto, ContactSolver::Direct}) {
    for (const int threads : {1, 2}) {
      for (const Change& change : changes()) {
        if (!change.keeps_numbers) continue;
        const Settings settings{.contact_solver = solver};
        Scene defined = scene(settings, threads, change.in_definition);
        Scene changed = scene(settings, threads, [](BodyDef&) {});
        change_later(changed, change);
        run(defined.world, 150);
        run(changed.world, 150);
        EXPECT_EQ(changed.world.state_hash(), defined.world.state_hash()) << change.name << ", " << threads;
      }
    }
  }
}

// In the middle of a run, with contacts and sleepers there: saved before, after, and replayed.
TEST(BodyChanges, SnapshotsAndRecordingsFollow) {
  const auto path = std::filesystem::path(testing::TempDir()) / "body_changes.rec";
  for (const Change& change : changes()) {
    Scene made = scene({}, 2, [](BodyDef&) {});
    World& world = made.world;
    world.record(path.string(), {.body_hash_interval = 1});
    run(world, 100);
    Snapshot before;
    world.save(before);
    const std::uint64_t hash_before = world.state_hash();
    run(world, 20);
    const std::uint64_t unchanged = world.state_hash();
    world.restore(before);
    change_later(made, change);
    Snapshot after;
    world.save(after);
    run(world, 40);
    const std::uint64_t changed = world.state_hash();
    world.stop_recording();
    EXPECT_NE(changed, unchanged) << change.name;
    EXPECT_FALSE(replay(path.string()).divergence) << change.name;

    world.restore(after);
    run(world, 40);
    EXPECT_EQ(world.state_hash(), changed) << change.name;
    world.restore(before);
    EXPECT_EQ(world.state_hash(), hash_before) << change.name;
    run(world, 20);
    EXPECT_EQ(world.state_hash(), unchanged) << change.name << ": restored, it is as it was before the change";
  }
  std::filesystem::remove(path);
}

TEST(BodyChanges, FrictionThatGoesLetsABlockSlide) {
  World world({.settings = {.sleeping = true}});
  constexpr double slope = 0.3;
  const Quaternion tilt(Eigen::AngleAxisd(slope, Vector3::UnitY()));
  const BodyId ground = world.add_body({.type = BodyType::Static, .shape = HalfSpace{}, .orientation = tilt});
  const BodyId block =
      world.add_body({.shape = Box{{0.5, 0.5, 0.2}}, .position = tilt * Vector3(0, 0, 0.2), .orientation = tilt});
  run(world, 200);
  ASSERT_TRUE(world.is_asleep(block));
  world.set_material(ground, {.friction = 0});
  EXPECT_FALSE(world.is_asleep(block)) << "what lies on it wakes";
  run(world, 60);
  EXPECT_NEAR(world.velocity(block).norm(), 9.81 * std::sin(slope), 0.02 * 9.81 * std::sin(slope));
  EXPECT_EQ(world.material(ground).friction, 0);
}

TEST(BodyChanges, AShapeLeavesTheFrameAndTheMotionOfTheBody) {
  World world({.gravity = Vector3::Zero()});
  const BodyId body = world.add_body(
      {.shape = Box{}, .position = {1, 2, 3}, .velocity = {1, 0, 0}, .angular_velocity = {0, 2, 0}, .mass = 64});
  world.set_shape(body, Cone{0.5, 1});
  EXPECT_EQ(world.pose(body).position, Vector3(1, 2, 3));
  EXPECT_TRUE(world.centre_of_mass(body).isApprox(Vector3(1, 2, 2.5), 1e-15));
  EXPECT_EQ(world.mass(body), 64);
  EXPECT_TRUE(world.velocity(body).isApprox(Vector3(1, 0, 0) + Vector3(0, 2, 0).cross(Vector3(0, 0, -0.5)), 1e-15))
      << "as the material point that is there moved";
  const double moment = 3.0 / 10 * 64 * 0.5 * 0.5;
  world.set_velocity(body, Vector3::Zero(), Vector3::Zero());
  world.apply_impulse(body, {0, moment, 0}, world.centre_of_mass(body) + Vector3(1, 0, 0));
  EXPECT_NEAR(world.angular_velocity(body).z(), 1, 1e-12);
}

// It tumbles as one that was made with the second shape, about axes that the first one didn't have.
TEST(BodyChanges, AnotherShapeHasItsOwnPrincipalAxes) {
  const Quaternion tilt(Eigen::AngleAxisd(0.5, Vector3(1, 2, 3).normalized()));
  const Compound leaning{{{.shape = Box{{0.2, 0.4, 0.8}}, .orientation = tilt}}};
  const Box straight{{0.2, 0.4, 0.8}};
  const auto tumble = [](World& world, BodyId id) {
    world.set_velocity(id, Vector3::Zero(), {1, 5, 0.5});
    run(world, 120);
    return world.state(id);
  };
  World world, other;
  const BodyId changed = world.add_body({.shape = leaning, .mass = 3});
  world.set_shape(changed, straight);
  const BodyState found = tumble(world, changed);
  const BodyState expected = tumble(other, other.add_body({.shape = straight, .mass = 3}));
  EXPECT_TRUE(found.angular_velocity.isApprox(expected.angular_velocity, 1e-12))
      << found.angular_velocity.transpose() << " and " << expected.angular_velocity.transpose();
  EXPECT_TRUE(found.pose.orientation.isApprox(expected.pose.orientation, 1e-12));
}

TEST(BodyChanges, RemovingABodyLeavesTheForcesOfOthers) {
  World world;
  world.add_body(ground());
  const BodyId crate = world.add_body(box({0, 0, 0.5}));
  const BodyId other = world.add_body(box({3, 0, 0.5}));
  run(world, 10);
  Snapshot snapshot;
  world.save(snapshot);
  world.remove_body(other);
  EXPECT_TRUE(world.contact_forces(crate).size() == 4 && world.contact_forces().size() == 4);
  // Reports of a step are empty until the next one, even after bodies come and go.
  world.restore(snapshot);
  world.remove_body(other);
  EXPECT_TRUE(world.contact_forces().empty());
  run(world, 1);
  EXPECT_EQ(world.contact_forces().size(), 4u);
}

TEST(BodyChanges, WhatStoodOnALargerShapeFallsAndWhatIsWithinOneThatGrowsIsPushedOut) {
  World world({.settings = {.sleeping = true}});
  const BodyId table = world.add_body({.type = BodyType::Static, .shape = Box{{1, 1, 1}}});
  const BodyId crate = world.add_body({.shape = Box{{0.2, 0.2, 0.2}}, .position = {0, 0, 1.2}});
  run(world, 120);
  ASSERT_TRUE(world.is_asleep(crate));
  world.set_shape(table, Box{{1, 1, 0.5}});
  EXPECT_FALSE(world.is_asleep(crate));
  EXPECT_TRUE(world.contact_forces(crate).empty());
  run(world, 180);
  EXPECT_NEAR(world.pose(crate).position.z(), 0.7, 2e-3);
  world.set_shape(table, HalfSpace{{0, 0, 1}, 0.6});
  run(world, 180);
  EXPECT_NEAR(world.pose(crate).position.z(), 0.8, 2e-3);
  EXPECT_THROW(world.set_shape(crate, HalfSpace{}), Error);
  EXPECT_THROW(world.set_shape(crate, Sphere{-1}), Error);
  EXPECT_NEAR(world.pose(crate).position.z(), 0.8, 2e-3);
}

TEST(BodyChanges, NamesStayWithTheirBodies) {
  World world;
  const BodyId a = world.add_body({.name = "crate", .user_data = 7});
  const BodyId b = world.add_body({.position = {3, 0, 0}, .name = "crate"});
  const BodyId c = world.add_body({.position = {6, 0, 0}});
  EXPECT_EQ(world.name(a), "crate");
  EXPECT_EQ(world.name(c), "");
  EXPECT_EQ(world.find_body("crate"), a);
  EXPECT_EQ(world.find_body(""), std::nullopt);
  Snapshot snapshot;
  world.save(snapshot);
  const std::uint64_t hash = world.state_hash();
  world.set_name(a, "");
  world.set_user_data(a, 8);
  world.set_name(c, "lid");
  EXPECT_EQ(world.state_hash(), hash) << "nothing follows from it";
  EXPECT_EQ(world.find_body("crate"), b);
  EXPECT_EQ(world.find_body("lid"), c);
  world.restore(snapshot);
  EXPECT_EQ(world.find_body("crate"), a);
  EXPECT_EQ(world.user_data(a), 7u);
  EXPECT_EQ(world.find_body("lid"), std::nullopt);
  world.remove_body(a);
  EXPECT_EQ(world.find_body("crate"), b);
  EXPECT_EQ(world.name(world.add_body({})), "") << "an index that is used again starts anew";

  const JointId joint = world.add_joint({.kind = BallJoint{}, .first = b, .second = c, .name = "hook", .user_data = 5});
  EXPECT_EQ(world.find_joint("hook"), joint);
  EXPECT_EQ(world.joint(joint).user_data, 5u);
  Snapshot again;
  world.save(again);
  world.remove_joint(joint);
  EXPECT_EQ(world.find_joint("hook"), std::nullopt);
  world.restore(again);
  EXPECT_EQ(world.find_joint("hook"), joint);
}

TEST(BodyChanges, ManyBodiesAtOnceAreAsOneByOne) {
  Scene one = scene({}, 1, [](BodyDef&) {});
  Scene all = scene({}, 1, [](BodyDef&) {});
  const auto count = static_cast<Eigen::Index>(one.bodies.size());
  const Eigen::Matrix3Xd positions =
      Eigen::Matrix3Xd::Random(3, count) * 4 + Eigen::Vector3d(0, 0, 9).replicate(1, count);
  Eigen::Matrix4Xd orientations = Eigen::Matrix4Xd::Random(4, count);
  const Eigen::Matrix3Xd first = Eigen::Matrix3Xd::Random(3, count), second = Eigen::Matrix3Xd::Random(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const BodyId id = one.bodies[static_cast<std::size_t>(i)];
    one.world.set_pose(id, {positions.col(i), Quaternion(Eigen::Vector4d(orientations.col(i)))});
    one.world.set_velocity(id, first.col(i), second.col(i));
    one.world.apply_force(id, second.col(i), first.col(i));
  }
  all.world.set_poses(all.bodies, positions, orientations);
  all.world.set_velocities(all.bodies, first, second);
  all.world.apply_forces(all.bodies, second, first);
  EXPECT_EQ(all.world.state_hash(), one.world.state_hash());

  const std::uint64_t before = all.world.state_hash();
  std::vector<BodyId> with_stale = all.bodies;
  with_stale.back().generation += 1;
  EXPECT_THROW(all.world.set_velocities(with_stale, second, first), Error);
  EXPECT_THROW(all.world.apply_forces(all.bodies, first.leftCols(2), second), Error);
  orientations.col(count - 1).setZero();
  EXPECT_THROW(all.world.set_poses(all.bodies, 2 * positions, orientations), Error);
  EXPECT_EQ(all.world.state_hash(), before) << "all or nothing";
}

TEST(BodyChanges, WhatCannotBeIsRefused) {
  World world;
  const BodyId ground = world.add_body({.type = BodyType::Static, .shape = HalfSpace{}});
  const BodyId box = world.add_body({.position = {0, 0, 2}});
  const std::uint64_t before = world.state_hash();
  EXPECT_THROW(world.set_mass(ground, 1), Error);
  EXPECT_THROW(world.set_mass(box, 0), Error);
  EXPECT_THROW(world.set_mass(box, std::nan("")), Error);
  EXPECT_THROW(world.set_material(box, {.friction = -1}), Error);
  EXPECT_THROW(world.set_material(box, {.restitution = 2}), Error);
  EXPECT_THROW(world.set_damping(box, -1, 0), Error);
  EXPECT_THROW(world.set_gravity_scale(box, INFINITY), Error);
  EXPECT_THROW(world.set_mass({9, 9}, 1), Error);
  EXPECT_EQ(world.state_hash(), before);
}

}  // namespace
}  // namespace atl::test
