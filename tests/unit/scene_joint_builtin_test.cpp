// The built-in scenes with joints: geometry, and that nothing breaks at the start.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace atl {
namespace {

std::vector<BodyState> starting_states(const Scene& scene) {
  std::vector<BodyState> states;
  for (const SceneBody& body : scene.bodies) {
    const BodyDef& def = body.def;
    states.push_back({{def.position, def.orientation.normalized()}, def.velocity, def.angular_velocity});
  }
  return states;
}

const std::vector<const char*>& small_scenes() {
  static const std::vector<const char*> all = {"chain:links=12",   "chain:links=10,ratio=1", "joint-grid:n=10",
                                               "ragdolls:count=3", "bridge:planks=12",       "vehicle",
                                               "pendulum",         "double-pendulum",        "slider-crank",
                                               "spring-damper",    "hanging-chain",          "catenary"};
  return all;
}

TEST(SceneJointBuiltin, AllAreTested) {
  std::set<std::string> tested;
  for (const std::string name : small_scenes()) tested.insert(name.substr(0, name.find(':')));
  for (const BuiltinScene& builtin : builtin_scenes()) {
    if (builtin.name == "islands" || load_scene(builtin.name).joints.empty()) continue;
    EXPECT_TRUE(tested.contains(builtin.name)) << builtin.name;
  }
}

TEST(SceneJointBuiltin, JointsHoldAtTheStart) {
  for (const char* text : small_scenes()) {
    const Scene scene = load_scene(text);
    ASSERT_FALSE(scene.joints.empty()) << text;
    const JointDriftReport drift = measure_joint_drift(placed_joints(scene), starting_states(scene));
    EXPECT_LT(drift.max, 1e-9) << text;
    EXPECT_LT(drift.angle_max, 1e-9) << text;
    EXPECT_LT(drift.excess_max, 1e-9) << text;
    EXPECT_LT(drift.angle_excess_max, 1e-9) << text;
  }
}

TEST(SceneJointBuiltin, NothingOverlapsThatMayTouch) {
  for (const char* text : small_scenes()) {
    const Scene scene = load_scene(text);
    EXPECT_EQ(measure_penetration(placed_shapes(scene), may_touch(scene)).pairs, 0u) << text;
  }
}

TEST(SceneJointBuiltin, RunAndStayFinite) {
  for (const char* text : small_scenes()) {
    const Scene scene = load_scene(text);
    World world({.gravity = scene.gravity, .settings = scene.settings});
    const std::vector<BodyId> ids = build_scene(scene, world);
    EXPECT_EQ(world.joint_count(), scene.joints.size());
    for (int step = 0; step < 60; ++step) {
      ASSERT_EQ(world.step(scene.dt).first_quarantined, -1) << text << ", step " << step;
    }
  }
}

TEST(SceneJointBuiltin, CountsOfBodiesAndJoints) {
  const struct {
    const char* scene;
    std::size_t bodies, joints;
    int steps;
  } cases[] = {{"chain", 102, 101, 600},
               {"chain:links=1", 3, 2, 600},
               {"joint-grid", 10000, 19800 - 6, 100},
               {"joint-grid:n=2", 4, 3, 100},
               {"ragdolls:count=7", 5 + 7 * 13, 7 * 12, 600},
               {"bridge", 1 + 2 + 40 + 5, 41, 600},
               {"vehicle", 6, 4, 600}};
  for (const auto& expected : cases) {
    const Scene scene = load_scene(expected.scene);
    EXPECT_EQ(scene.bodies.size(), expected.bodies) << expected.scene;
    EXPECT_EQ(scene.joints.size(), expected.joints) << expected.scene;
    EXPECT_EQ(scene.steps, expected.steps) << expected.scene;
  }
}

TEST(SceneJointBuiltin, ChainIsLevelAndHeavyAtItsEnd) {
  const Scene scene = load_scene("chain:links=8,ratio=50");
  for (std::size_t i = 1; i <= 8; ++i) {
    const BodyDef& link = scene.bodies[i].def;
    EXPECT_LT((link.position - Vector3(0.5 * static_cast<double>(i) - 0.25, 0, 4)).norm(), 1e-12);
    EXPECT_LT((link.orientation * Vector3::UnitZ() - Vector3::UnitX()).norm(), 1e-12);
    EXPECT_NEAR(body_mass(link).mass, 1, 1e-12);
  }
  EXPECT_NEAR(body_mass(scene.bodies.back().def).mass, 50, 1e-12);
  const MayTouch touch = may_touch(scene);
  for (std::size_t a = 0; a < scene.bodies.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) EXPECT_FALSE(touch(a, b));
  }
}

TEST(SceneJointBuiltin, GridHangsByTheMiddleOfItsUpperEdge) {
  const Scene scene = load_scene("joint-grid:n=20");
  for (const SceneBody& body : scene.bodies) {
    const bool held = body.def.position.z() == 0 && std::abs(body.def.position.x() - 10) <= 3;
    EXPECT_EQ(body.def.type, held ? BodyType::Static : BodyType::Dynamic) << body.name;
  }
  for (const SceneJoint& joint : scene.joints) {
    const Vector3 apart = scene.bodies[joint.second].def.position - scene.bodies[joint.first].def.position;
    EXPECT_EQ(apart.norm(), 1);
    EXPECT_EQ(joint.def.frame_first.position, Vector3(apart / 2));
  }
}

TEST(SceneJointBuiltin, RagdollsAreOfHumanSize) {
  const Scene scene = load_scene("ragdolls:count=1");
  const SceneBody* pelvis = nullptr;
  double mass = 0;
  for (const SceneBody& body : scene.bodies) {
    if (body.def.type != BodyType::Dynamic) continue;
    if (body.name == "doll_0_pelvis") pelvis = &body;
    mass += body_mass(body.def).mass;
  }
  ASSERT_NE(pelvis, nullptr);
  EXPECT_NEAR(mass, 72, 3);
  // Upright again, from the soles to the top of the head.
  double low = 0, high = 0;
  for (const SceneBody& body : scene.bodies) {
    if (body.def.type != BodyType::Dynamic) continue;
    const double z = (pelvis->def.orientation.conjugate() * (body.def.position - pelvis->def.position)).z();
    low = std::min(low, z);
    high = std::max(high, z);
  }
  EXPECT_NEAR(high - low + 0.11 + 0.035, 1.87, 0.02);
}

TEST(SceneJointBuiltin, RagdollsDependOnTheSeed) {
  const auto pelvis = [](std::uint64_t seed) { return load_scene("ragdolls:count=2", seed).bodies[5].def.orientation; };
  EXPECT_EQ(pelvis(3).coeffs(), pelvis(3).coeffs());
  EXPECT_NE(pelvis(3).coeffs(), pelvis(4).coeffs());
}

TEST(SceneJointBuiltin, BridgeSpansItsBanks) {
  for (const char* text : {"bridge:planks=4", "bridge:planks=39"}) {
    const Scene scene = load_scene(text);
    const BodyDef* west = nullptr;
    const BodyDef* east = nullptr;
    for (const SceneBody& body : scene.bodies) {
      if (body.name == "bank_west") west = &body.def;
      if (body.name == "bank_east") east = &body.def;
    }
    ASSERT_TRUE(west != nullptr && east != nullptr);
    EXPECT_NEAR(west->position.z(), east->position.z(), 1e-12) << text;
    EXPECT_NEAR(west->position.x(), -east->position.x(), 1e-12) << text;
  }
}

// Moments about any joint vanish, so each link is in equilibrium under its weight and the pulls at its ends.
TEST(SceneJointBuiltin, CatenaryIsInEquilibrium) {
  for (const char* text : {"catenary", "catenary:links=7,slack=3", "catenary:links=2,slack=1.01"}) {
    const Scene scene = load_scene(text);
    const std::size_t links = scene.bodies.size() - 2;
    std::vector<Vector3> along;
    for (std::size_t i = 1; i <= links; ++i) along.push_back(scene.bodies[i].def.orientation * Vector3::UnitZ());
    // The slope grows by the same amount from link to link: the weight of one over the horizontal pull.
    const auto slope = [&](std::size_t i) { return along[i].z() / along[i].x(); };
    const double step = slope(1) - slope(0);
    EXPECT_GT(step, 0) << text;
    for (std::size_t i = 1; i < links; ++i) EXPECT_NEAR(slope(i) - slope(i - 1), step, 1e-9) << text;
    const double span = (scene.bodies.back().def.position - scene.bodies.front().def.position).norm();
    const double slack =
        text[8] == '\0' ? 1.3 : std::stod(std::string(text).substr(std::string(text).find("slack=") + 6));
    EXPECT_NEAR(static_cast<double>(links) * 0.5 / span, slack, 1e-9) << text;
  }
}

}  // namespace
}  // namespace atl
