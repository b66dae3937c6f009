// Scenes written out as files and read again are the scenes they were.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "support/expect_error.h"
#include "support/words.h"

namespace atl {
namespace {

std::vector<std::string> scenes() {
  std::vector<std::string> all = test::words_of(
      "pile:bodies=30 pyramid3d:layers=4 wall:base=5,planar=1 rocks:bodies=20 mixed:bodies=30 "
      "terrain:bodies=15 ragdolls:count=3 vehicle conveyor drum chain joint-grid:n=3 marbles:bodies=9 "
      "slider-crank rolling-resistance cradle hopper:bodies=20 hanging-chain:links=4");
  for (const auto& file : std::filesystem::directory_iterator(ATOLL_SOURCE_DIR "/runtime/scene/examples")) {
    if (file.path().extension() == ".json") all.push_back(file.path().string());
  }
  return all;
}

std::uint64_t hash_after(const Scene& scene, int steps) {
  World world({.gravity = scene.gravity, .settings = scene.settings});
  const std::vector<BodyId> ids = build_scene(scene, world);
  for (int i = 0; i < steps; ++i) {
    apply_forces(scene, world, ids);
    world.step(scene.dt);
  }
  return world.state_hash();
}

TEST(SceneWriting, WhatIsReadAgainStepsToTheSameBits) {
  for (const std::string& name : scenes()) {
    const Scene scene = load_scene(name);
    const std::string text = scene_text(scene);
    const Scene again = parse_scene(text, "again.json");
    EXPECT_EQ(again.bodies.size(), scene.bodies.size()) << name;
    EXPECT_EQ(again.joints.size(), scene.joints.size()) << name;
    EXPECT_EQ(scene_text(again), text) << name;
    EXPECT_EQ(hash_after(again, 0), hash_after(scene, 0)) << name;
    EXPECT_EQ(hash_after(again, 20), hash_after(scene, 20)) << name;
  }
}

TEST(SceneWriting, SignsOfZeroAndOfATurnAreKept) {
  Scene scene;
  for (const Quaternion& orientation : {Quaternion(1, -0.0, 0, -0.0), Quaternion(-1, 0, 0, 0)}) {
    scene.bodies.push_back({.def = {.orientation = orientation, .velocity = {0, -0.0, 0}}});
  }
  EXPECT_EQ(hash_after(parse_scene(scene_text(scene), "again.json"), 0), hash_after(scene, 0));
}

TEST(SceneWriting, AWorldIsTakenAsItIsNow) {
  for (const std::string& name : scenes()) {
    const Scene scene = load_scene(name);
    World world({.gravity = scene.gravity, .settings = scene.settings});
    const std::vector<BodyId> ids = build_scene(scene, world);
    for (int i = 0; i < 30; ++i) {
      apply_forces(scene, world, ids);
      world.step(scene.dt);
    }
    Scene taken = scene_of(world);
    taken.dt = scene.dt;
    const Scene read = parse_scene(scene_text(taken), "taken.json");
    World copy({.gravity = read.gravity, .settings = read.settings});
    build_scene(read, copy);
    ASSERT_EQ(copy.body_count(), world.body_count()) << name;
    ASSERT_EQ(copy.joint_count(), world.joint_count()) << name;
    for (const BodyId id : world.bodies()) {
      const BodyState a = world.state(id), b = copy.state(id);
      EXPECT_TRUE((a.pose.position - b.pose.position).norm() <= 1e-12 * (1 + a.pose.position.norm())) << name;
      EXPECT_TRUE(a.pose.orientation.coeffs().isApprox(b.pose.orientation.coeffs(), 1e-15)) << name;
      EXPECT_EQ(a.velocity, b.velocity) << name;
      EXPECT_EQ(a.angular_velocity, b.angular_velocity) << name;
      EXPECT_DOUBLE_EQ(copy.mass(id), world.mass(id)) << name;
    }
  }
}

TEST(SceneWriting, ATargetIsWrittenWhereOneIsSet) {
  Scene scene = load_scene("stack:height=2");
  const std::string without = scene_text(scene);
  EXPECT_EQ(without.find("target"), std::string::npos);
  scene.settings.target = {.penetration = 1e-4, .motion = 0.1, .min_substeps = 3, .max_substeps = 77};
  const ErrorTarget read = parse_scene(scene_text(scene), "again.json").settings.target;
  EXPECT_EQ(read.penetration, 1e-4);
  EXPECT_FALSE(read.joint_gap || read.residual);
  EXPECT_EQ(read.motion, 0.1);
  EXPECT_EQ(read.min_substeps, 3);
  EXPECT_EQ(read.max_substeps, 77);
}

TEST(SceneWriting, NothingOfADefinitionIsLost) {
  World world({.settings = {.substeps = 7, .contact_hertz = 25, .contact_solver = ContactSolver::Direct}});
  const BodyId ground = world.add_body({.type = BodyType::Static,
                                        .shape = HalfSpace{{0, 1, 0}, -0.25},
                                        .material = {.friction = 0.1,
                                                     .friction_across = 0.7,
                                                     .friction_direction = {1, 2, 0},
                                                     .restitution = 0.2,
                                                     .rolling_friction = 0.3,
                                                     .friction_rule = CombineRule::Min,
                                                     .restitution_rule = CombineRule::Average},
                                        .surface_velocity = {1, 2, 3},
                                        .surface_angular_velocity = {0, 0, 4},
                                        .filter = {.category = 6, .mask = 0xffffffff, .group = -3},
                                        .contact_event_force = 0,
                                        .user_data = ~std::uint64_t{0}});
  const BodyId body = world.add_body(
      {.shape = Compound{{{.shape = Box{{1, 2, 3}}, .density_factor = 2, .material = Material{.friction = 0.9}},
                          {.shape = Ellipsoid{{0.1, 0.2, 0.3}}, .position = {0, 1, 4}},
                          {.shape = TaperedCapsule{{0.25, 0.125}, 0.5}, .position = {1, 0, 4}},
                          {.shape = Cone{0.25, 0.5}, .position = {0, 0, 4}, .filter = CollisionFilter{.mask = 8}}}},
       .position = {0.1, 0.2, 30},
       .orientation = Quaternion(0.5, 0.5, -0.5, 0.5),
       .velocity = {1, 2, 3},
       .angular_velocity = {4, 5, 6},
       .gravity_scale = 0.5,
       .linear_damping = 0.125,
       .angular_damping = 0.25,
       .continuous = true,
       .name = "a \"crate\"",
       .user_data = 12});
  world.add_body({.type = BodyType::Kinematic,
                  .shape = Sphere{2},
                  .position = {50, 0, 9},
                  .sensor = true,
                  .notices_static = true,
                  .notices_sensors = true});
  const JointId joint = world.add_joint(
      {.kind =
           WheelJoint{.suspension = {.range = {-1, unlimited, 0.5}, .spring = JointSpring{.rest = 0.1, .stiffness = 9}},
                      .steering = {.motor = JointMotor{.speed = 2, .max_force = unlimited}},
                      .spin = {.motor = JointMotor{.max_force = 4, .servo = JointServo{.target = 1, .damping = 3}},
                               .armature = 7,
                               .friction = 3}},
       .first = ground,
       .second = body,
       .frame_second = {{0, 0, -30}, Quaternion::Identity()},
       .collide = true,
       .break_force = 1e9,
       .name = "wheel",
       .user_data = 3});
  Scene taken = scene_of(world);
  taken.name = "all";
  const std::string text = scene_text(taken);
  const Scene read = parse_scene(text, "all.json");
  EXPECT_EQ(scene_text(read), text);
  World copy({.gravity = read.gravity, .settings = read.settings});
  const std::vector<BodyId> ids = build_scene(read, copy);
  taken = scene_of(copy);
  taken.name = "all";
  EXPECT_EQ(scene_text(taken), text);
  EXPECT_EQ(copy.state_hash(), world.state_hash());
  EXPECT_EQ(copy.user_data(ids[0]), ~std::uint64_t{0});
  EXPECT_EQ(copy.find_body("a \"crate\""), body);
  EXPECT_EQ(copy.find_joint("wheel"), joint);
  EXPECT_EQ(copy.joint(joint).user_data, 3u);
  for (int i = 0; i < 30; ++i) {
    world.step(1.0 / 60);
    copy.step(1.0 / 60);
  }
  EXPECT_EQ(copy.state_hash(), world.state_hash());
}

TEST(SceneWriting, AFileIsWholeOrNotThere) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "scene_writing";
  std::filesystem::create_directories(folder);
  const Scene scene = load_scene("wall:base=3");
  write_scene(scene, (folder / "wall.json").string());
  EXPECT_EQ(scene_text(load_scene((folder / "wall.json").string())), scene_text(scene));
  EXPECT_THROW(write_scene(scene, (folder / "none" / "wall.json").string()), SceneError);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
  std::filesystem::remove_all(folder);
}

// No world has such a velocity, but a scene may be made by hand, and no file holds it.
TEST(SceneWriting, RefusesWhatIsNotFinite) {
  World world;
  world.add_body({.shape = Sphere{1e-3}, .mass = 1e-6});
  Scene scene = scene_of(world);
  scene.bodies[0].def.velocity.x() = std::numeric_limits<double>::infinity();
  try {
    scene_text(scene);
    ADD_FAILURE() << "expected a SceneError";
  } catch (const SceneError& error) {
    EXPECT_STREQ(error.what(),
                 "scene_text: /bodies/0/velocity/0 is inf; expected a finite number, as scene files hold "
                 "no others");
  }
}

}  // namespace
}  // namespace atl
