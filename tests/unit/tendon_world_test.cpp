// Tendons as the World has them: what they are made of, and how they come and go with their joints.

#include <atoll/mechanism.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "support/bodies.h"
#include "support/expect_error.h"

namespace atl::test {
namespace {

struct CoupledCubes {
  explicit CoupledCubes(int count = 2, JointSolver solver = JointSolver::Auto)
      : world({.gravity = Vector3::Zero(), .settings = {.joint_solver = solver}}) {
    post = world.add_body({.type = BodyType::Static, .shape = Sphere{0.1}});
    for (int i = 0; i < count; ++i) {
      cubes.push_back(world.add_body(box({2.0 * i, 0, 0})));
      hinges.push_back(
          world.add_joint(joint_at(world, HingeJoint{}, post, cubes.back(), {2.0 * i, 0, 0}, Vector3::UnitZ())));
    }
  }
  TendonJoint mimic() const {
    return {.terms = {{.joint = hinges[0]}, {.joint = hinges[1], .polynomial = {0, -1}}}, .length = {.range = {0, 0}}};
  }
  void push() { world.apply_force(cubes[0], Vector3::Zero(), {0, 0, 100}); }
  double speed(std::size_t cube) const { return world.angular_velocity(cubes[cube]).z(); }

  World world;
  BodyId post;
  std::vector<BodyId> cubes;
  std::vector<JointId> hinges;
};

TEST(TendonWorld, HasTheBodiesOfItsJoints) {
  CoupledCubes of;
  const JointId id = of.world.add_joint({.kind = of.mimic(), .first = of.cubes[1], .break_force = 7, .name = "mimic"});
  const JointDef& def = of.world.joint(id);
  EXPECT_EQ(def.first, of.post);
  EXPECT_EQ(def.second, of.cubes[0]);
  EXPECT_TRUE(def.collide);
  EXPECT_EQ(def.break_force, 7);
  EXPECT_EQ(of.world.find_joint("mimic"), id);
  EXPECT_EQ(of.world.joint_axis(id).range.upper, 0);
  EXPECT_TRUE(Mechanism(of.world, of.post).loops().empty()) << "its forces are applied ones";
}

TEST(TendonWorld, JoinsIslandsOfWhatItCouples) {
  CoupledCubes of(3);
  EXPECT_EQ(of.world.step(dt).counts.islands, 3);
  of.world.add_joint(
      {.kind = TendonJoint{.terms = {{.joint = of.hinges[0]}, {.joint = of.hinges[1]}, {.joint = of.hinges[2]}},
                           .length = {.range = {0, 0}}}});
  EXPECT_EQ(of.world.step(dt).counts.islands, 1);
}

// A joint of no rows of its own is in no list of those that act, and its bodies are in the tendon's system all the
// same.
TEST(TendonWorld, PullsOverJointsThatDoNothing) {
  constexpr double g = 9.81;
  for (const BodyType of_base : {BodyType::Static, BodyType::Kinematic, BodyType::Dynamic}) {
    for (const JointSolver solver : {JointSolver::Auto, JointSolver::Iterative, JointSolver::Direct}) {
      World world({.settings = {.joint_solver = solver}});
      const BodyId base = world.add_body({.type = of_base, .shape = Box{{0.1, 0.1, 0.1}}, .filter = {.mask = 0}});
      TendonJoint rope{.length = {.range = {0, 0}}};
      for (int i = 0; i < 3; ++i) {
        const BodyId load = world.add_body(
            {.shape = Sphere{0.1}, .position = {1.0 * i, 0, -2}, .mass = 1.0 + i, .filter = {.mask = 0}});
        const JointId free = world.add_joint({.kind = DistanceJoint{JointAxis{}},
                                              .first = base,
                                              .second = load,
                                              .frame_first = {.position = {1.0 * i, 0, 0}}});
        rope.terms.push_back({.joint = free, .polynomial = {-2, 1}});
      }
      const JointId id = world.add_joint({.kind = rope});
      for (int i = 0; i < 30; ++i) world.step(dt);
      // Each load falls by g less the rope's pull over its mass, and all together not at all.
      const double pull = of_base == BodyType::Dynamic ? 0 : 3 * g / (1.0 + 1.0 / 2 + 1.0 / 3);
      EXPECT_NEAR(-world.joint_state(id).force.x(), pull, 1e-3) << static_cast<int>(of_base);
      EXPECT_NEAR(world.joint_state(id).position[0], 0, 2e-3) << static_cast<int>(solver);
    }
  }
}

TEST(TendonWorld, RefusesTermsThatItCantHave) {
  CoupledCubes of;
  const auto refuse = [&](std::vector<TendonTerm> terms, std::initializer_list<std::string_view> words) {
    expect_error([&] { of.world.add_joint({.kind = TendonJoint{.terms = std::move(terms)}}); }, words);
  };
  const TendonTerm good = {.joint = of.hinges[0]};
  refuse({}, {"terms: there are 0", "expected 1 to 4"});
  refuse({good, good, good, good, good}, {"terms: there are 5", "expected 1 to 4"});
  refuse({good, {.joint = of.hinges[0], .coordinate = 1}}, {"terms[1].coordinate is 1", "HingeJoint"});
  refuse({{.joint = of.hinges[0], .polynomial = {3}}}, {"terms[0].polynomial", "are 0"});
  refuse({{.joint = of.hinges[0], .polynomial = {0, std::nan("")}}}, {"terms[0].polynomial"});
  refuse({{.joint = {7, 0}}}, {"terms[0].joint is (index 7", "has not been removed"});
  const JointId tendon = of.world.add_joint({.kind = of.mimic()});
  refuse({{.joint = tendon}}, {"terms[0].joint is a tendon"});
  const JointId gear = of.world.add_joint({.kind = GearJoint{}, .first = of.cubes[0], .second = of.cubes[1]});
  refuse({{.joint = gear}}, {"terms[0].coordinate is 0", "GearJoint", "rate"});
  EXPECT_EQ(of.world.joint_count(), 4u);
}

TEST(TendonWorld, GoesWithTheFirstOfItsJointsThatGoes) {
  CoupledCubes of(3);
  const JointId first = of.world.add_joint({.kind = of.mimic()});
  const JointId other = of.world.add_joint({.kind = TendonJoint{.terms = {{.joint = of.hinges[2]}}}});
  of.world.remove_joint(of.hinges[1]);
  EXPECT_FALSE(of.world.contains(first));
  EXPECT_TRUE(of.world.contains(other));
  of.world.remove_body(of.cubes[2]);
  EXPECT_FALSE(of.world.contains(other));
  EXPECT_EQ(of.world.joint_count(), 1u);
  of.push();
  of.world.step(dt);
  EXPECT_GT(of.speed(0), 0);
}

TEST(TendonWorld, ActsWhileAllItsJointsDo) {
  for (const JointSolver solver : {JointSolver::Iterative, JointSolver::Direct}) {
    CoupledCubes of(2, solver);
    const JointId tendon = of.world.add_joint({.kind = of.mimic()});
    of.push();
    of.world.step(dt);
    EXPECT_GT(of.speed(1), 0);
    EXPECT_NE(of.world.joint_state(tendon).force.x(), 0);
    of.world.set_joint_enabled(of.hinges[0], false);
    EXPECT_EQ(of.world.joint_state(tendon).force.x(), 0);
    const double before = of.speed(1);
    of.push();
    of.world.step(dt);
    EXPECT_NEAR(of.speed(1), before, 1e-9);
    of.world.set_joint_enabled(of.hinges[0], true);
    of.push();
    of.world.step(dt);
    EXPECT_GT(of.speed(1), before);
    of.world.set_joint_enabled(tendon, false);
    const double alone = of.speed(1);
    of.push();
    of.world.step(dt);
    EXPECT_NEAR(of.speed(1), alone, 1e-9);
  }
}

TEST(TendonWorld, TakesOtherTermsAndLaws) {
  CoupledCubes of(3);
  const JointId tendon = of.world.add_joint({.kind = of.mimic()});
  TendonJoint other = of.mimic();
  other.terms[1].joint = of.hinges[2];
  of.world.set_joint(tendon, other);
  of.push();
  run(of.world, 2);
  EXPECT_NEAR(of.speed(0), of.speed(2), 1e-9);
  EXPECT_EQ(of.speed(1), 0);
  of.world.set_joint_axis(tendon, {.motor = JointMotor{.speed = 3, .max_force = 1e4}});
  run(of.world, 10);
  EXPECT_NEAR(of.world.joint_state(tendon).speed[0], 3, 1e-6);
  of.world.set_motor_speed(tendon, -1);
  run(of.world, 10);
  EXPECT_NEAR(of.speed(0) - of.speed(2), -1, 1e-6);
}

TEST(TendonWorld, BreaksUnderMoreThanItsForce) {
  CoupledCubes of;
  const JointId tendon = of.world.add_joint({.kind = of.mimic(), .break_force = 30});
  of.push();  // 50 N m of which go over
  of.world.step(dt);
  ASSERT_EQ(of.world.joint_events().size(), 1u);
  EXPECT_EQ(of.world.joint_events()[0].kind, JointEventKind::Broke);
  EXPECT_NEAR(std::abs(of.world.joint_events()[0].force.x()), 50, 1e-3);
  EXPECT_TRUE(of.world.joint_state(tendon).broken);
}

TEST(TendonWorld, CountsTheTurnsThatItsJointsDo) {
  CoupledCubes of;
  of.world.set_joint(of.hinges[0], HingeJoint{{.range = {-100, 100}}});
  const JointId tendon = of.world.add_joint({.kind = TendonJoint{.terms = {{.joint = of.hinges[0]}}}});
  of.world.count_turns_from(of.hinges[0], 12);
  const double turns = of.world.joint_state(of.hinges[0]).position[0];
  EXPECT_GT(turns, 12);
  EXPECT_EQ(of.world.joint_state(tendon).position[0], turns);
}

// The text has places of joints that come first.
TEST(TendonWorld, IsPartOfScenes) {
  CoupledCubes of;
  of.world.remove_joint(of.world.add_joint({.kind = BallJoint{}, .first = of.cubes[0], .second = of.cubes[1]}));
  const JointId tendon = of.world.add_joint({.kind = of.mimic(), .name = "mimic"});
  of.world.set_joint_axis(tendon, {.range = {-0.1, 0.3}, .friction = 2});
  const Scene read = parse_scene(scene_text(scene_of(of.world)), "text");
  World copy({.gravity = Vector3::Zero()});
  std::vector<JointId> joints;
  build_scene(read, copy, joints);
  ASSERT_EQ(joints.size(), 3u);
  const auto& kind = std::get<TendonJoint>(copy.joint(joints[2]).kind);
  ASSERT_EQ(kind.terms.size(), 2u);
  EXPECT_EQ(kind.terms[1].joint, joints[1]);
  EXPECT_EQ(kind.terms[1].polynomial[1], -1);
  EXPECT_EQ(kind.length.range.upper, 0.3);
  EXPECT_EQ(kind.length.friction, 2);
  EXPECT_EQ(copy.joint(joints[2]).name, "mimic");
}

std::string with_tendon(const std::string& joint) {
  return R"({"format": "atoll-scene", "version": 1, "bodies": [
    {"name": "post", "type": "static", "shape": {"type": "sphere", "radius": 0.1}},
    {"name": "wheel", "shape": {"type": "sphere", "radius": 0.1}}],
    "joints": [{"name": "axle", "kind": "hinge", "first": "post", "second": "wheel", "at": [0, 0, 0]},
    )" + joint +
         "]}";
}

TEST(TendonWorld, SceneFilesNameItsJoints) {
  const Scene scene = parse_scene(
      with_tendon(
          R"({"kind": "tendon", "terms": [{"joint": "axle", "polynomial": [1, 2, 3]}], "length": {"upper": 4}})"),
      "text");
  const auto& tendon = std::get<TendonJoint>(scene.joints[1].def.kind);
  EXPECT_EQ(scene.joints[1].terms, std::vector<std::size_t>{0});
  EXPECT_EQ(tendon.terms[0].polynomial, (std::array<double, 5>{1, 2, 3, 0, 0}));
  EXPECT_EQ(tendon.length.range.upper, 4);
  const auto refuse = [](const std::string& joint, std::initializer_list<std::string_view> words) {
    expect_error([&] { parse_scene(with_tendon(joint), "text"); }, words);
  };
  refuse(R"({"kind": "tendon", "terms": []})", {"/joints/1/terms", "0 terms", "1 to 4"});
  refuse(R"({"kind": "tendon", "terms": [{"joint": "axel"}]})", {"/joints/1/terms/0/joint", "axel", "\"axle\""});
  refuse(R"({"kind": "tendon", "terms": [{"joint": 1}]})", {"/joints/1/terms/0/joint", "found 1"});
  refuse(R"({"kind": "tendon", "terms": [{"joint": 0, "polynomial": [1]}]})", {"/polynomial", "2 to 5"});
  refuse(R"({"kind": "tendon", "terms": [{"joint": 0, "polynomial": [1, 0]}]})", {"/polynomial", "a constant"});
  refuse(R"({"kind": "tendon", "first": "post", "terms": [{"joint": 0}]})", {"/joints/1", "first"});
}

}  // namespace
}  // namespace atl::test
