// The joints of scene files: what they turn into, and what is refused.

#include <atoll/scene.h>
#include <gtest/gtest.h>

#include <numbers>

#include "support/expect_error.h"

namespace atl {
namespace {

constexpr double exact = 1e-14;

// Two boxes and a static ball, and then these members.
std::string jointed_scene(const std::string& members) {
  return R"({"format": "atoll-scene", "version": 1,
             "bodies": [{"name": "post", "type": "static", "shape": {"type": "sphere", "radius": 0.1}},
                        {"name": "arm", "shape": {"type": "box", "half_extents": [1, 0.1, 0.1]}, "position": [1, 0, 2],
                         "orientation": [0, 0, 1, 1]},
                        {"name": "hand", "shape": {"type": "sphere", "radius": 0.2}, "position": [3, 0, 2]},
                        {"name": "rail", "type": "static", "shape": {"type": "half_space"}}],
)" + members +
         "}";
}

std::string joint(const std::string& members) { return jointed_scene("\"joints\": [{\n" + members + "}]"); }
std::string arm(const std::string& kind, const std::string& members) {
  return joint(R"("kind": ")" + kind + R"(", "first": "post", "second": "arm")" + (members.empty() ? "" : ", ") +
               members);
}

SceneJoint read(const std::string& text) { return parse_scene(text, "folder/test.json").joints.at(0); }

/// A frame of a joint in the world, where the scene starts.
Pose in_world(const BodyDef& body, const Pose& frame) {
  const Quaternion turn = body.orientation.normalized();
  return {body.position + turn * frame.position, turn * frame.orientation};
}

std::pair<Pose, Pose> frames(const std::string& text) {
  const Scene scene = parse_scene(text, "folder/test.json");
  const SceneJoint& joint = scene.joints.at(0);
  return {in_world(scene.bodies[joint.first].def, joint.def.frame_first),
          in_world(scene.bodies[joint.second].def, joint.def.frame_second)};
}

TEST(SceneJointFile, DefaultsAreThoseOfTheApi) {
  const SceneJoint ball = read(arm("ball", R"("at": [0, 0, 0])"));
  EXPECT_EQ(ball.name, "");
  EXPECT_EQ(ball.first, 0u);
  EXPECT_EQ(ball.second, 1u);
  EXPECT_EQ(std::get<BallJoint>(ball.def.kind).friction, 0);
  EXPECT_FALSE(ball.def.collide);
  EXPECT_EQ(ball.def.break_force, unlimited);
  EXPECT_EQ(ball.def.break_torque, unlimited);
  const auto hinge = std::get<HingeJoint>(read(arm("hinge", R"("at": [0, 0, 0])")).def.kind);
  EXPECT_EQ(hinge.angle.range.lower, -unlimited);
  EXPECT_EQ(hinge.angle.range.upper, unlimited);
  EXPECT_FALSE(hinge.angle.spring);
  EXPECT_FALSE(hinge.angle.motor);
  const auto wheel = std::get<WheelJoint>(read(arm("wheel", R"("at": [0, 0, 0])")).def.kind);
  EXPECT_EQ(wheel.suspension.spring->hertz, WheelJoint{}.suspension.spring->hertz);
  EXPECT_EQ(wheel.steering.range.upper, 0);
  EXPECT_TRUE(parse_scene(jointed_scene("\"joints\": []"), "test.json").joints.empty());
}

TEST(SceneJointFile, ReadsWhatJointsHave) {
  const SceneJoint joint =
      read(arm("hinge", R"("name": "elbow", "at": [0, 0, 2], "collide": true, "break_force": 100, "break_torque": 5,
                      "angle": {"range": [-1, 2], "spring": {"hertz": 3, "damping_ratio": 0.5, "rest": 0.25},
                                "motor": {"speed": -2, "max_force": 40}})"));
  EXPECT_EQ(joint.name, "elbow");
  EXPECT_TRUE(joint.def.collide);
  EXPECT_EQ(joint.def.break_force, 100);
  EXPECT_EQ(joint.def.break_torque, 5);
  const JointAxis& angle = std::get<HingeJoint>(joint.def.kind).angle;
  EXPECT_EQ(angle.range.lower, -1);
  EXPECT_EQ(angle.range.upper, 2);
  EXPECT_EQ(angle.spring->hertz, 3);
  EXPECT_EQ(angle.spring->damping_ratio, 0.5);
  EXPECT_EQ(angle.spring->rest, 0.25);
  EXPECT_EQ(angle.motor->speed, -2);
  EXPECT_EQ(angle.motor->max_force, 40);
}

TEST(SceneJointFile, ReadsEveryKind) {
  EXPECT_EQ(std::get<BallJoint>(read(arm("ball", R"("at": [0, 0, 0], "friction": 3)")).def.kind).friction, 3);
  const auto slider =
      std::get<SliderJoint>(read(arm("slider", R"("at": [0, 0, 0], "offset": {"upper": 0.5})")).def.kind);
  EXPECT_EQ(slider.offset.range.lower, -unlimited);
  EXPECT_EQ(slider.offset.range.upper, 0.5);
  EXPECT_TRUE(std::holds_alternative<FixedJoint>(read(arm("fixed", R"("at": [0, 0, 0])")).def.kind));
  const auto universal = std::get<UniversalJoint>(
      read(arm("universal", R"("at": [0, 0, 0], "angle_first": {"range": [0, 1]}, "angle_second": {"lower": -2})"))
          .def.kind);
  EXPECT_EQ(universal.first.range.upper, 1);
  EXPECT_EQ(universal.second.range.lower, -2);
  const auto cone = std::get<ConeTwistJoint>(
      read(arm("cone_twist",
               R"("at": [0, 0, 0], "swing_limit": 0.7, "swing_friction": 3, "twist": {"range": [-0.1, 0.2]})"))
          .def.kind);
  EXPECT_EQ(cone.swing_limit, 0.7);
  EXPECT_EQ(cone.twist.range.upper, 0.2);
  EXPECT_EQ(cone.swing_friction, 3);
  const auto six =
      std::get<SixDofJoint>(read(arm("six_dof", R"("at": [0, 0, 0], "offset": [{"range": [0, 0]}, {}, {"lower": -1}],
                             "turn": [{}, {"range": [-0.5, 0.5]}, {}])"))
                                .def.kind);
  EXPECT_EQ(six.offset[0].range.upper, 0);
  EXPECT_EQ(six.offset[1].range.upper, unlimited);
  EXPECT_EQ(six.offset[2].range.lower, -1);
  EXPECT_EQ(six.turn[1].range.lower, -0.5);
  const auto ball = std::get<BallJoint>(
      read(arm("ball", R"("at": [0, 0, 0], "servo": {"target": [0, 0, 1, 0], "stiffness": 2, "max_torque": 5})"))
          .def.kind);
  EXPECT_EQ(ball.servo->target.z(), 1);
  EXPECT_EQ(ball.servo->max_torque, 5);
  const auto gimbal = std::get<SixDofJoint>(
      read(arm("six_dof", R"("at": [0, 0, 0], "turns": "angles_xzy", "turn": [{}, {"range": [-3, 3]}, {}])")).def.kind);
  EXPECT_EQ(gimbal.turns, SixDofTurns::AnglesXZY);
  EXPECT_EQ(gimbal.turn[1].range.lower, -3);
  const auto gear = std::get<GearJoint>(
      read(arm("gear", R"("axis": [0, 0, 1], "axis_second": [0, 1, 0], "ratio": -2.5, "rack": true)")).def.kind);
  EXPECT_EQ(gear.ratio, -2.5);
  EXPECT_TRUE(gear.rack);
  const auto wheel =
      std::get<WheelJoint>(read(arm("wheel", R"("at": [0, 0, 0], "suspension": {"range": [0, 0]}, "steering": {},
                           "spin": {"motor": {"speed": 9, "max_force": 1}})"))
                               .def.kind);
  EXPECT_FALSE(wheel.suspension.spring) << "what a file says of an axis replaces all of its default";
  EXPECT_EQ(wheel.steering.range.upper, unlimited);
  EXPECT_EQ(wheel.spin.motor->speed, 9);
}

TEST(SceneJointFile, ReadsServosArmaturesFrictionAndBounces) {
  const auto hinge = std::get<HingeJoint>(
      read(arm("hinge",
               R"("at": [0, 0, 0], "angle": {"range": [-1, 1], "restitution": 0.4, "armature": 0.02, "friction": 0.3,
                           "motor": {"max_force": 9, "servo": {"target": 0.5, "stiffness": 40, "damping": 3}}})"))
          .def.kind);
  EXPECT_EQ(hinge.angle.range.restitution, 0.4);
  EXPECT_EQ(hinge.angle.armature, 0.02);
  EXPECT_EQ(hinge.angle.friction, 0.3);
  ASSERT_TRUE(hinge.angle.motor && hinge.angle.motor->servo);
  EXPECT_EQ(hinge.angle.motor->servo->target, 0.5);
  EXPECT_EQ(hinge.angle.motor->servo->stiffness, 40);
  EXPECT_EQ(hinge.angle.motor->servo->damping, 3);
}

TEST(SceneJointFile, PlacesBothFramesInTheWorld) {
  const auto [first, second] = frames(arm("hinge", R"("at": [0, 1, 2], "axis": [0, 0, -3])"));
  EXPECT_LT((first.position - Vector3(0, 1, 2)).norm(), exact);
  EXPECT_LT((second.position - Vector3(0, 1, 2)).norm(), exact);
  EXPECT_LT((first.orientation * Vector3::UnitX() + Vector3::UnitZ()).norm(), exact);
  EXPECT_LT(first.orientation.angularDistance(second.orientation), 1e-7);
}

TEST(SceneJointFile, TurnsFramesAsTheirKindHasThem) {
  const auto [cross, same] = frames(arm("universal", R"("at": [0, 0, 0], "axis": [0, 2, 0], "across": [0, 0, 1])"));
  EXPECT_LT((cross.orientation * Vector3::UnitX() - Vector3::UnitY()).norm(), exact);
  EXPECT_LT((cross.orientation * Vector3::UnitY() - Vector3::UnitZ()).norm(), exact);
  const auto [wheel, hub] = frames(arm("wheel", R"("at": [0, 0, 0], "axis": [0, 0, 2], "across": [1, 0, 0.5])"));
  EXPECT_LT((hub.orientation * Vector3::UnitY() - Vector3(1, 0, 0.5).normalized()).norm(), exact)
      << "the axle is what wheels roll about";
  const auto [upright, any] = frames(arm("wheel", R"("at": [0, 0, 0])"));
  EXPECT_LT((upright.orientation * Vector3::UnitZ() - Vector3::UnitZ()).norm(), exact);
  EXPECT_LT((upright.orientation * Vector3::UnitY() - Vector3::UnitY()).norm(), exact);
  const auto [driving, driven] = frames(arm("gear", R"("axis": [0, 0, 1], "axis_second": [0, 1, 0])"));
  EXPECT_LT((driving.orientation * Vector3::UnitX() - Vector3::UnitZ()).norm(), exact);
  EXPECT_LT((driven.orientation * Vector3::UnitX() - Vector3::UnitY()).norm(), exact);
}

TEST(SceneJointFile, TakesFramesOfTheBodies) {
  const SceneJoint joint =
      read(arm("fixed", R"("frame_second": {"position": [1, 2, 3], "orientation": [0, 0, 2, 0]})"));
  EXPECT_EQ(joint.def.frame_first.position, Vector3::Zero());
  EXPECT_EQ(joint.def.frame_second.position, Vector3(1, 2, 3));
  EXPECT_EQ(joint.def.frame_second.orientation.z(), 2);
}

TEST(SceneJointFile, RodIsAsLongAsItStarts) {
  const auto rod = [](const std::string& members) {
    return std::get<DistanceJoint>(read(arm("distance", members)).def.kind).distance.range;
  };
  EXPECT_NEAR(rod(R"("at": [0, 0, 0], "at_second": [0, 3, 4])").lower, 5, exact);
  EXPECT_NEAR(rod(R"("at": [0, 0, 0], "at_second": [0, 3, 4])").upper, 5, exact);
  EXPECT_NEAR(rod(R"("frame_first": {})").lower, std::sqrt(5), exact) << "the origin of the arm from that of the post";
  EXPECT_EQ(rod(R"("at": [0, 0, 0], "at_second": [0, 3, 4], "distance": {"upper": 6})").upper, 6);
  EXPECT_EQ(rod(R"("at": [0, 0, 0], "at_second": [0, 3, 4], "distance": {"upper": 6})").lower, -unlimited);
}

TEST(SceneJointFile, FindsBodiesByNameAndByPlace) {
  EXPECT_EQ(read(joint(R"("kind": "ball", "first": 2, "second": "post", "at": [0, 0, 0])")).first, 2u);
  const Scene generated = parse_scene(
      R"({"format": "atoll-scene", "version": 1,
          "generators": [{"body": {"name": "bead", "shape": {"type": "sphere", "radius": 0.1}}, "count": [3, 1, 1]}],
          "joints": [{"kind": "ball", "first": "bead_1", "second": "bead_2", "at": [0.5, 0, 0]}]})",
      "test.json");
  EXPECT_EQ(generated.joints[0].first, 1u);
  EXPECT_EQ(generated.joints[0].second, 2u);
}

TEST(SceneJointFile, ExamplesAreWholeAtTheStart) {
  for (const char* name : {"cart", "lamp"}) {
    const Scene scene = load_scene(std::string(ATOLL_SOURCE_DIR "/runtime/scene/examples/") + name + ".json");
    ASSERT_FALSE(scene.joints.empty()) << name;
    const JointDriftReport drift = measure_joint_drift(placed_joints(scene), [&] {
      std::vector<BodyState> states;
      for (const SceneBody& body : scene.bodies) states.push_back({.pose = {body.def.position, body.def.orientation}});
      return states;
    }());
    EXPECT_LT(drift.max, 1e-9) << name;
    EXPECT_LT(drift.angle_max, 1e-9) << name;
    EXPECT_LT(drift.excess_max, 1e-9) << name;
    EXPECT_LT(drift.angle_excess_max, 1e-9) << name;
    EXPECT_EQ(measure_penetration(placed_shapes(scene), may_touch(scene)).pairs, 0u) << name;
  }
}

struct RefusedJoint {
  std::string text;
  std::string place;     ///< after "bad.json:", up to what was found
  std::string contains;  ///< what was expected
};

void expect_joint_refused(const RefusedJoint& refused) {
  SCOPED_TRACE(refused.text.substr(refused.text.find("\"joints\"")));
  std::string message;
  try {
    parse_scene(refused.text, "bad.json");
  } catch (const SceneError& error) {
    message = error.what();
  }
  EXPECT_TRUE(message.starts_with("bad.json:" + refused.place)) << message;
  EXPECT_NE(message.find("expected " + refused.contains), std::string::npos) << message;
}

TEST(SceneJointFileErrors, SayWhereAndWhatWasExpected) {
  const std::string at = R"("at": [0, 0, 0], )";
  const RefusedJoint cases[] = {
      {jointed_scene("\"joints\": {}"), "7: /joints: found an object", "an array of joints"},
      {jointed_scene("\"joints\": [3]"), "7: /joints/0: found 3", "an object"},
      {joint(R"("first": 0)"), "7: /joints/0/kind: found nothing", "ball, hinge"},
      {joint(R"("kind": "hing")"), "8: /joints/0/kind: found \"hing\"",
       "ball, hinge, slider, fixed, distance, universal, cone_twist, six_dof, gear, wheel or tendon (did you mean "
       "\"hinge\"?)"},
      {joint(R"("kind": "ball", "second": 0)"), "7: /joints/0/first: found nothing", "the name of a body or its place"},
      {joint(R"("kind": "ball", "first": "pst", "second": 1)"), "8: /joints/0/first: found \"pst\"",
       "the name of a body (did you mean \"post\"?)"},
      {joint(R"("kind": "ball", "first": 4, "second": 1)"), "8: /joints/0/first: found 4", "an integer in [0, 3]"},
      {joint(R"("kind": "ball", "first": 1.5, "second": 1)"), "8: /joints/0/first: found 1.5", "an integer in [0, 3]"},
      {joint(R"("kind": "ball", "first": 1, "second": "arm")"), "8: /joints/0/second: found the first body again",
       "another one"},
      {arm("ball", ""), "7: /joints/0/at: found nothing", "[x, y, z] in m"},
      {arm("ball", at + R"("angle": {})"), "8: /joints/0/angle: found the unknown key", "name, kind, first, second"},
      {arm("hinge", at + R"("frame_first": {})"), "8: /joints/0/at: found it next to frames", "one or the other"},
      {arm("hinge", at + R"("axis": [0, 0, 0])"), "8: /joints/0/axis: found a vector of length 0", "a length above 0"},
      {arm("universal", at + R"("axis": [0, 1, 0], "across": [0, 2, 0])"),
       "8: /joints/0/across: found a direction along the axis", "one at right angles"},
      {arm("hinge", at + R"("angle": {"range": [2, 1]})"), "8: /joints/0/angle/range: found [2, 1]",
       "a lower end that is not above"},
      {arm("hinge", at + R"("angle": {"lower": 2, "upper": 1})"), "8: /joints/0/angle/upper: found 1",
       "an upper end that is not below"},
      {arm("hinge", at + R"("angle": {"range": [1]})"), "8: /joints/0/angle/range: found an array of 1",
       "an array of two numbers"},
      {arm("hinge", at + R"("angle": {"range": [0, 1], "lower": 0})"), "8: /joints/0/angle/lower: found it next to",
       "a range or a single end"},
      {arm("hinge", at + R"("angle": {"spring": {}})"), "8: /joints/0/angle/spring/hertz: found nothing",
       "a number > 0, in Hz"},
      {arm("hinge", at + R"("angle": {"spring": {"hertz": 0}})"), "8: /joints/0/angle/spring/hertz: found 0",
       "a number > 0"},
      {arm("hinge", at + R"("angle": {"motor": {"speed": 1}})"), "8: /joints/0/angle/motor/max_force: found nothing",
       "a number >= 0, in N"},
      {arm("hinge", at + R"("angle": {"motor": {"max_force": -1}})"), "8: /joints/0/angle/motor/max_force: found -1",
       "a number >= 0"},
      {arm("hinge", at + R"("angle": {"restitution": 2})"), "8: /joints/0/angle/restitution: found 2",
       "a number in [0, 1]"},
      {arm("hinge", at + R"("angle": {"armature": -1})"), "8: /joints/0/angle/armature: found -1", "a number >= 0"},
      {arm("hinge", at + R"("angle": {"friction": -2})"), "8: /joints/0/angle/friction: found -2", "a number >= 0"},
      {arm("hinge", at + R"("angle": {"motor": {"max_force": 1, "servo": {"target": 1}}})"),
       "8: /joints/0/angle/motor/servo: found a servo without", "one of them above 0"},
      {arm("hinge", at + R"("angle": {"mtor": {}})"), "8: /joints/0/angle/mtor: found the unknown key",
       "range, lower, upper, restitution, spring, motor, armature or friction (did you mean \"motor\"?)"},
      {arm("cone_twist", at + R"("swing_limit": 4)"), "8: /joints/0/swing_limit: found 4", "a number in (0, 3.14159"},
      {arm("cone_twist", at + R"("twist": {"range": [-4, 0]})"), "8: /joints/0/twist/range/0: found -4",
       "a number in [-3.14159"},
      {arm("six_dof", at + R"("turn": [{}, {}])"), "8: /joints/0/turn: found an array of 2",
       "an array of three objects"},
      {arm("distance", at + R"("at_second": [0, 0, 0])"), "8: /joints/0/at_second: found the ends", "two places apart"},
      {arm("distance", R"("at": [0, 0, 0])"), "7: /joints/0/at_second: found the ends", "two places apart"},
      {arm("distance", at + R"("at_second": [1, 0, 0], "distance": {"range": [-1, 1]})"),
       "8: /joints/0/distance/range/0: found -1", "a number >= 0"},
      {arm("six_dof", at + R"("turn": [{}, {"upper": 3}, {}])"), "8: /joints/0/turn/1/upper: found 3",
       "a number in [-2, 2]"},
      {arm("distance", at + R"("at_second": [1, 0, 0], "distance": {"upper": 0})"),
       "8: /joints/0/distance: found a largest distance of 0", "one above 0"},
      {arm("gear", R"("ratio": 0)"), "8: /joints/0/ratio: found 0", "a number that is not 0"},
      {arm("ball", at + R"("friction": -1)"), "8: /joints/0/friction: found -1", "a number >= 0"},
      {arm("ball", at + R"("break_force": 0)"), "8: /joints/0/break_force: found 0", "a number > 0"},
      {arm("ball", at + R"("collide": 1)"), "8: /joints/0/collide: found 1", "true or false"},
      {jointed_scene(R"("joints": [{"name": "a", "kind": "ball", "first": 0, "second": 1, "at": [0, 0, 0]},
                           {"name": "a", "kind": "ball", "first": 0, "second": 2, "at": [0, 0, 0]}])"),
       "8: /joints/1/name: found a second joint named \"a\"", "a name that no other joint has"},
  };
  for (const RefusedJoint& refused : cases) expect_joint_refused(refused);
}

TEST(SceneJointBuild, NamesTheJointThatTheWorldRefuses) {
  Scene scene;
  scene.name = "made";
  scene.bodies = {{.def = {.shape = Sphere{}}}, {.def = {.shape = Sphere{}, .position = {3, 0, 0}}}};
  SceneJoint bad;
  bad.name = "bad";
  bad.second = 1;
  bad.def.kind = HingeJoint{.angle = {.range = {1, 0}}};
  scene.joints = {SceneJoint{.def = {.kind = BallJoint{}}, .first = 0, .second = 1}, bad};
  World world;
  test::expect_error([&] { build_scene(scene, world); }, {"made: joint 1 \"bad\"", "range"});
}

TEST(SceneJointBuild, AddsJointsBetweenTheBodiesThatItNames) {
  const Scene scene = parse_scene(arm("hinge", R"("at": [0, 0, 2], "angle": {"range": [-1, 1]})"), "test.json");
  World world;
  std::vector<JointId> joints;
  const std::vector<BodyId> ids = build_scene(scene, world, joints);
  ASSERT_EQ(joints.size(), 1u);
  EXPECT_EQ(world.joint_count(), 1u);
  EXPECT_EQ(world.joint(joints[0]).first, ids[0]);
  EXPECT_EQ(world.joint(joints[0]).second, ids[1]);
  EXPECT_EQ(std::get<HingeJoint>(world.joint(joints[0]).kind).angle.range.upper, 1);
}

}  // namespace
}  // namespace atl
