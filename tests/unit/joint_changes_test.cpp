// A joint's definition, changed under its id: what differs takes effect, and what doesn't leaves no trace.

#include <atoll/snapshot.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <initializer_list>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "support/bodies.h"
#include "support/expect_error.h"

namespace atl::test::joint_changes_test {
namespace {

constexpr double pi = std::numbers::pi;

Quaternion turned_about(const Vector3& axis, double angle) {
  return Quaternion(Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis.normalized())));
}

// A crate on a post for each kind of joint, at frames that are no round numbers; and a tendon.
struct Yard {
  World world;
  BodyId post;
  std::vector<BodyId> crates;
  std::vector<JointId> joints;

  explicit Yard(JointSolver solver, bool sleeping = false)
      : world({.settings = {.joint_solver = solver, .sleeping = sleeping}}),
        post(world.add_body(static_box({0, 0, 20}, {0.5, 0.5, 0.5}))) {
    const JointAxis driven{.range = {-0.6, 0.7},
                           .spring = JointSpring{.hertz = 2, .damping_ratio = 0.3},
                           .motor = JointMotor{.speed = 0.3, .max_force = 20},
                           .armature = 0.5,
                           .friction = 0.2};
    for (const JointKind& kind :
         {JointKind(BallJoint{.friction = 0.4}), JointKind(HingeJoint{driven}), JointKind(SliderJoint{driven}),
          JointKind(FixedJoint{}), JointKind(DistanceJoint{{.range = {0.5, 2}}}),
          JointKind(UniversalJoint{.first = driven}), JointKind(ConeTwistJoint{.swing_limit = 0.6}),
          JointKind(SixDofJoint{.turn = {driven, driven, driven}}), JointKind(GearJoint{.ratio = 0.7}),
          JointKind(WheelJoint{.spin = driven})}) {
      add(kind);
    }
    joints.push_back(world.add_joint(
        {.kind = TendonJoint{{{joints[1], 0, {0.1, 2}}, {joints[2], 0, {0, 1, 0.5}}}, {.range = {-1, 1}}}}));
  }
  JointId add(const JointKind& kind) {
    const double x = 3.0 * static_cast<double>(crates.size());
    crates.push_back(world.add_body(box({x, 0.3, 19})));
    joints.push_back(world.add_joint({.kind = kind,
                                      .first = post,
                                      .second = crates.back(),
                                      .frame_first = {{x, 0.1, -0.3}, turned_about({1, 2, 3}, 0.3)},
                                      .frame_second = {{0.1, -0.2, 0.7}, turned_about({3, 1, -1}, 0.2)},
                                      .break_force = 1e7}));
    return joints.back();
  }
};

class JointChanges : public testing::TestWithParam<JointSolver> {};

TEST_P(JointChanges, ADefinitionThatIsThereAlreadyLeavesNoTrace) {
  Yard set_again(GetParam()), left_alone(GetParam());
  for (int i = 0; i < 40; ++i) {
    for (const JointId joint : set_again.joints) set_again.world.set_joint(joint, set_again.world.joint(joint));
    ASSERT_EQ(set_again.world.state_hash(), left_alone.world.state_hash()) << i;
    set_again.world.step(dt);
    left_alone.world.step(dt);
  }
}

// All that a world derives from joints is derived anew after a restore, and must be what changes left.
TEST_P(JointChanges, AreWhatARestoredWorldGoesOnFrom) {
  const JointAxis stiff{.spring = JointSpring{.stiffness = 1e9, .damping = 1e3}};
  const std::vector<std::function<void(JointDef&)>> changes = {
      [](JointDef& def) { def.frame_first.position.z() -= 0.4; },
      [](JointDef& def) {
        def.frame_second.orientation = turned_about({0, 1, 1}, 0.4);
      },
      [](JointDef& def) { def.break_torque = 1e8; }, [](JointDef& def) { def.collide = true; },
      [&](JointDef& def) {
        if (auto* hinge = std::get_if<HingeJoint>(&def.kind)) hinge->angle = stiff;
        if (auto* gear = std::get_if<GearJoint>(&def.kind)) gear->ratio = -2;
        if (auto* slider = std::get_if<SliderJoint>(&def.kind)) slider->offset.motor->servo = JointServo{0.1, 1e3, 10};
      }};
  Yard yard(GetParam());
  for (const auto& change : changes) {
    run(yard.world, 3);
    for (const JointId joint : yard.joints) {
      JointDef def = yard.world.joint(joint);
      change(def);
      yard.world.set_joint(joint, def);
    }
    Snapshot snapshot;
    yard.world.save(snapshot);
    World restored;
    restored.restore(snapshot);
    for (int i = 0; i < 10; ++i) {
      ASSERT_EQ(restored.state_hash(), yard.world.state_hash()) << &change - changes.data() << " " << i;
      restored.step(dt);
      yard.world.step(dt);
    }
  }
}

// A pendulum whose pivot is moved, on either body, hangs under the new one, at the length of the new arm.
TEST_P(JointChanges, AMovedFrameIsWhereTheJointHoldsFromThenOn) {
  World world({.settings = {.joint_solver = GetParam()}});
  const BodyId post = world.add_body(static_box({0, 0, 0}, {0.1, 0.1, 0.1}));
  BodyDef weight = sphere({0, 0, -1}, 0.1);
  weight.linear_damping = weight.angular_damping = 3;
  const BodyId ball = world.add_body(weight);
  const JointId joint = world.add_joint({.first = post, .second = ball, .frame_second = {{0, 0, 1}}});
  run(world, 30);
  JointDef def = world.joint(joint);
  def.frame_first.position = {0.3, 0, 0.2};
  def.frame_second.position = {0, 0, 1.5};
  world.set_joint(joint, def);
  EXPECT_EQ(world.joint(joint).frame_first.position, Vector3(0.3, 0, 0.2));
  run(world, 1200);
  EXPECT_LT((world.pose(ball).position - Vector3(0.3, 0, -1.3)).norm(), 1e-3) << world.pose(ball).position.transpose();
}

// An angle is measured between the frames, and keeps its full turns as one of them is turned.
TEST_P(JointChanges, AnAngleCountsOnAsItsFrameIsTurned) {
  World world({.gravity = Vector3::Zero(), .settings = {.joint_solver = GetParam()}});
  const BodyId post = world.add_body({.type = BodyType::Static, .shape = Box{}});
  BodyDef def = box({0, 0, 0});
  def.angular_velocity = {4 * pi, 0, 0};
  const BodyId wheel = world.add_body(def);
  const JointId joint = world.add_joint({.kind = HingeJoint{{.range = {-100, 100}}}, .first = post, .second = wheel});
  run(world, 60);
  const double before = world.joint_state(joint).position[0];
  ASSERT_NEAR(before, 4 * pi, 0.01);
  JointDef turned = world.joint(joint);
  turned.frame_first.orientation = turned_about({1, 0, 0}, 0.7);
  world.set_joint(joint, turned);
  EXPECT_NEAR(world.joint_state(joint).position[0], before - 0.7, 1e-6);
  run(world, 60);
  EXPECT_NEAR(world.joint_state(joint).position[0], before - 0.7 + 4 * pi, 0.01);
}

TEST_P(JointChanges, AJointBreaksByLimitsThatItGotLater) {
  Yard yard(GetParam());
  run(yard.world, 20);
  const JointId joint = yard.joints[3];
  JointDef def = yard.world.joint(joint);
  def.break_force = 0.5 * yard.world.mass(yard.crates[3]) * g;
  yard.world.set_joint(joint, def);
  yard.world.step(dt);
  EXPECT_TRUE(yard.world.joint_state(joint).broken);
  EXPECT_TRUE(yard.world.contains(joint));
}

INSTANTIATE_TEST_SUITE_P(Solvers, JointChanges,
                         testing::Values(JointSolver::Iterative, JointSolver::Direct, JointSolver::Auto));

// Two crates that overlap.
struct Pair {
  World world{WorldDef{.gravity = Vector3::Zero(), .settings = {.sleeping = true}}};
  BodyId a = world.add_body(box({0, 0, 0}));
  BodyId b = world.add_body(box({0.9, 0, 0}));

  JointId join(bool collide) { return world.add_joint({.first = a, .second = b, .collide = collide}); }
  void set(JointId joint, const std::function<void(JointDef&)>& change) {
    JointDef def = world.joint(joint);
    change(def);
    world.set_joint(joint, def);
  }
  void let_collide(JointId joint, bool collide) {
    set(joint, [&](JointDef& def) { def.collide = collide; });
  }
  bool touch() { return world.step(dt).counts.contacts == 1; }
};

TEST(JointChange, OfCollideCountsAmongJointsOfAPair) {
  Pair pair;
  const JointId one = pair.join(false), other = pair.join(true);
  EXPECT_FALSE(pair.touch());
  pair.let_collide(one, true);
  EXPECT_TRUE(pair.touch());
  pair.let_collide(other, false);
  pair.let_collide(one, false);
  pair.let_collide(other, true);
  EXPECT_FALSE(pair.touch()) << "one of the two still forbids it";
  pair.world.set_joint_enabled(one, false);
  EXPECT_TRUE(pair.touch());
  pair.let_collide(one, true);
  pair.world.set_joint_enabled(one, true);
  EXPECT_TRUE(pair.touch()) << "it was changed while it did nothing";
}

TEST(JointChange, OfNamesAndUserDataWakesNobody) {
  World world({.settings = {.sleeping = true}});
  const BodyId post = world.add_body(static_box({0, 0, 0}, {0.1, 0.1, 0.1}));
  const BodyId ball = world.add_body(sphere({0, 0, -2}));
  const JointId joint = world.add_joint({.first = post, .second = ball, .frame_second = {{0, 0, 2}}});
  run(world, 60);
  ASSERT_TRUE(world.is_asleep(ball));
  world.set_name(joint, "knee");
  world.set_user_data(joint, 7);
  world.set_joint(joint, world.joint(joint));
  EXPECT_TRUE(world.is_asleep(ball));
  EXPECT_EQ(world.find_joint("knee"), joint);
  EXPECT_EQ(world.name(joint), "knee");
  EXPECT_EQ(world.user_data(joint), 7u);
  Snapshot snapshot;
  world.save(snapshot);
  World restored;
  restored.restore(snapshot);
  EXPECT_EQ(restored.name(joint), "knee");
  EXPECT_EQ(restored.user_data(joint), 7u);
  JointDef def = world.joint(joint);
  def.break_force = 1e6;
  world.set_joint(joint, def);
  EXPECT_FALSE(world.is_asleep(ball));
}

TEST(JointChange, ThatNoJointCanTakeIsRefused) {
  Pair pair;
  const BodyId other = pair.world.add_body(box({5, 0, 0}));
  const JointId rod = pair.world.add_joint({.kind = DistanceJoint{}, .first = pair.a, .second = pair.b});
  const std::uint64_t hash = pair.world.state_hash();
  const auto refused = [&](const std::function<void(JointDef&)>& change,
                           std::initializer_list<std::string_view> words) {
    expect_error([&] { pair.set(rod, change); }, words);
    EXPECT_EQ(pair.world.state_hash(), hash);
  };
  refused([](JointDef& def) { def.kind = BallJoint{}; },
          {"World::set_joint: kind is BallJoint", "expected DistanceJoint"});
  refused([&](JointDef& def) { def.second = other; }, {"World::set_joint: the bodies are", "(index 2", "expected"});
  refused([](JointDef& def) { def.frame_first.position = {0.9, 0, 0}; }, {"origins", "coincide"});
  refused([](JointDef& def) { def.break_force = -1; }, {"JointDef.break_force", "-1", "above 0"});
  refused([](JointDef& def) { def.frame_second.orientation.coeffs().setZero(); },
          {"JointDef.frame_second.orientation"});
  expect_error([&] { pair.world.set_name(rod, "\xff"); }, {"World::set_name: name", "UTF-8"});
  pair.world.remove_joint(rod);
  expect_error([&] { pair.world.set_name(rod, "gone"); }, {"World::set_name", "no joint has the id"});
  expect_error([&] { pair.world.set_user_data(rod, 1); }, {"World::set_user_data", "no joint has the id"});
}

// set_motor_speed() and set_servo_target() are a short way to what set_joint_axis() does.
TEST(JointChanges, AControlIsAChangeOfTheAxis) {
  for (const JointSolver solver : {JointSolver::Iterative, JointSolver::Direct}) {
    Yard by_control(solver, true), by_axis(solver, true);
    const auto controls = [](Yard& yard, const auto& control) {
      for (const JointId id : {yard.joints[1], yard.joints[2], yard.joints[5]}) control(id, 0);
      for (const std::size_t turn : {3, 4, 5}) control(yard.joints[7], turn);
      control(yard.joints[9], 2);
      control(yard.joints[10], 0);
    };
    const JointMotor servo{.max_force = 30, .servo = JointServo{.stiffness = 40, .damping = 2}};
    for (Yard* yard : {&by_control, &by_axis}) {
      controls(*yard, [&](JointId id, std::size_t coordinate) {
        JointAxis axis = yard->world.joint_axis(id, coordinate);
        if (coordinate != 4) axis.motor = servo;
        yard->world.set_joint_axis(id, axis, coordinate);
      });
    }
    for (int step = 0; step < 60; ++step) {
      const double to = 0.2 * std::floor(step / 7.0);
      controls(by_control, [&](JointId id, std::size_t coordinate) {
        if (coordinate == 4) return by_control.world.set_motor_speed(id, to, coordinate);
        by_control.world.set_servo_target(id, to, coordinate);
      });
      controls(by_axis, [&](JointId id, std::size_t coordinate) {
        JointAxis axis = by_axis.world.joint_axis(id, coordinate);
        (coordinate == 4 ? axis.motor->speed : axis.motor->servo->target) = to;
        by_axis.world.set_joint_axis(id, axis, coordinate);
      });
      ASSERT_EQ(by_control.world.state_hash(), by_axis.world.state_hash()) << step;
      by_control.world.step(dt);
      by_axis.world.step(dt);
    }
    controls(by_control,
             [&](JointId id, std::size_t) { EXPECT_EQ(by_control.world.joint(id), by_axis.world.joint(id)); });
  }
}

}  // namespace
}  // namespace atl::test::joint_changes_test
