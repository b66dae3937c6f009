// Joints that break, and that reach and leave the ends of their ranges.

#include <gtest/gtest.h>

#include <numbers>
#include <vector>

#include "support/bodies.h"

namespace atl::test {
namespace {

const Quaternion x_to_z(Eigen::AngleAxisd(-std::numbers::pi / 2, Vector3::UnitY()));

// A crate that hangs from a post by a joint.
struct Weight {
  World world;
  BodyId post = world.add_body({.type = BodyType::Static, .shape = Box{}});
  BodyId crate = world.add_body(box({0, 0, -3}));
  double weight = world.mass(crate) * g;
  JointId joint;

  explicit Weight(double break_force, double break_torque = unlimited, const JointKind& kind = BallJoint{}) {
    joint = world.add_joint({.kind = kind,
                             .first = post,
                             .second = crate,
                             .frame_second = {{0, 0, 3}, Quaternion::Identity()},
                             .break_force = break_force * weight,
                             .break_torque = break_torque});
  }
};

// It goes into quarantine, which suspends the joint; that the joint broke as well would be told with no number to it.
TEST(JointBreaking, IsNotToldOfABodyThatTheSolveBroke) {
  Weight driven(1000, unlimited, SliderJoint{{.motor = JointMotor{.speed = 1e300, .max_force = unlimited}}});
  driven.world.step(dt);
  EXPECT_TRUE(driven.world.is_quarantined(driven.crate));
  EXPECT_TRUE(driven.world.joint_events().empty());
  EXPECT_FALSE(driven.world.joint_state(driven.joint).broken);
  EXPECT_TRUE(driven.world.joint_state(driven.joint).force.allFinite());
}

TEST(JointBreaking, ComesWithMoreForceThanItBears) {
  Weight strong(1.1);
  for (int i = 0; i < 120; ++i) {
    strong.world.step(dt);
    ASSERT_TRUE(strong.world.joint_events().empty()) << i;
  }
  EXPECT_FALSE(strong.world.joint_state(strong.joint).broken);
  EXPECT_NEAR(strong.world.pose(strong.crate).position.z(), -3, 1e-2);

  Weight weak(0.9);
  weak.world.step(dt);
  const auto events = weak.world.joint_events();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].joint, weak.joint);
  EXPECT_EQ(events[0].kind, JointEventKind::Broke);
  const JointState state = weak.world.joint_state(weak.joint);
  EXPECT_TRUE(state.broken);
  EXPECT_FALSE(state.enabled);
  EXPECT_GT(state.force.norm(), 0.9 * weak.weight) << "what broke it";
  EXPECT_TRUE(weak.world.contains(weak.joint));

  const StepReport report = weak.world.step(dt);
  EXPECT_EQ(report.counts.joints, 0);
  EXPECT_TRUE(weak.world.joint_events().empty()) << "it breaks once";
  run(weak.world, 58);
  EXPECT_NEAR(weak.world.velocity(weak.crate).z(), -g * 59 * dt, 1e-3 * g) << "it falls";
}

TEST(JointBreaking, ComesWithMoreTorqueThanItBears) {
  // A beam 1 m out is held up by a fixed joint at the post.
  const auto breaks = [](double share) {
    World world;
    const BodyId post = world.add_body({.type = BodyType::Static, .shape = Box{}});
    const BodyId beam = world.add_body(box({1, 0, 0}));
    world.add_joint({.kind = FixedJoint{},
                     .first = post,
                     .second = beam,
                     .frame_second = {{-1, 0, 0}, Quaternion::Identity()},
                     .break_torque = share * world.mass(beam) * g * 1});
    for (int i = 0; i < 120; ++i) {
      world.step(dt);
      if (!world.joint_events().empty()) return true;
    }
    return false;
  };
  EXPECT_TRUE(breaks(0.8));
  EXPECT_FALSE(breaks(1.25));
}

TEST(JointBreaking, EnablingMakesItWhole) {
  Weight weak(0.9);
  weak.world.step(dt);
  ASSERT_TRUE(weak.world.joint_state(weak.joint).broken);
  weak.world.set_joint_enabled(weak.joint, true);
  const JointState state = weak.world.joint_state(weak.joint);
  EXPECT_FALSE(state.broken);
  EXPECT_TRUE(state.enabled);
  EXPECT_EQ(state.force, Vector3(0, 0, 0));
  weak.world.step(dt);
  ASSERT_EQ(weak.world.joint_events().size(), 1u) << "and it breaks again";
}

TEST(JointBreaking, LetsTheBodiesTouch) {
  World world({.gravity = Vector3::Zero()});
  const BodyId a = world.add_body(box({0, 0, 0}));
  const BodyId b = world.add_body(box({0.9, 0, 0}));
  JointDef def{.first = a, .second = b, .break_force = 1};
  def.frame_second.position = {-0.9, 0, 0};
  world.add_joint(def);
  EXPECT_EQ(world.step(dt).counts.contacts, 0);
  world.apply_force(b, {10, 0, 0});
  world.step(dt);
  ASSERT_EQ(world.joint_events().size(), 1u);
  world.set_pose(a, {});
  world.set_pose(b, {.position = {0.9, 0, 0}});
  EXPECT_EQ(world.step(dt).counts.contacts, 1);
}

// Islands come in order of their bodies, events in that of the joints.
TEST(JointEvents, ComeInOrderOfIds) {
  World world;
  const BodyId post = world.add_body({.type = BodyType::Static, .shape = Box{}});
  std::vector<BodyId> balls;
  for (int i = 0; i < 6; ++i) balls.push_back(world.add_body(sphere({3.0 * i, 0, -3})));
  std::vector<JointId> joints;
  for (std::size_t i = balls.size(); i-- > 0;) {
    joints.push_back(world.add_joint({.first = post,
                                      .second = balls[i],
                                      .frame_first = {{3.0 * static_cast<double>(i), 0, 0}, Quaternion::Identity()},
                                      .frame_second = {{0, 0, 3}, Quaternion::Identity()},
                                      .break_force = 1}));
  }
  world.step(dt);
  const auto events = world.joint_events();
  ASSERT_EQ(events.size(), joints.size());
  for (std::size_t i = 0; i < joints.size(); ++i) EXPECT_EQ(events[i].joint, joints[i]);
}

// A lift: it falls to the lower end of its shaft, is driven up to the other, and is let go of.
TEST(JointEvents, EndsOfARangeAreReachedAndLeftOnce) {
  World world;
  const BodyId shaft = world.add_body({.type = BodyType::Static, .shape = Box{}});
  const BodyId lift = world.add_body(box({0, 0, 0}));
  SliderJoint slider{{.range = {-0.5, 0.5}}};
  const JointId joint = world.add_joint({.kind = slider,
                                         .first = shaft,
                                         .second = lift,
                                         .frame_first = {{0, 0, 0}, x_to_z},
                                         .frame_second = {{0, 0, 0}, x_to_z}});
  std::vector<JointEventKind> kinds;
  const auto watch = [&](int steps) {
    for (int i = 0; i < steps; ++i) {
      world.step(dt);
      for (const JointEvent& event : world.joint_events()) {
        EXPECT_EQ(event.joint, joint);
        kinds.push_back(event.kind);
      }
    }
  };
  using Kinds = std::vector<JointEventKind>;
  watch(10);
  EXPECT_EQ(kinds, Kinds{}) << "it falls";
  watch(60);
  EXPECT_EQ(kinds, Kinds{JointEventKind::ReachedLimit});
  EXPECT_NEAR(world.joint_state(joint).position[0], -0.5, 5e-3);
  kinds.clear();
  slider.offset.motor = JointMotor{.speed = 1, .max_force = 3 * world.mass(lift) * g};
  world.set_joint(joint, slider);
  watch(90);
  EXPECT_EQ(kinds, (Kinds{JointEventKind::LeftLimit, JointEventKind::ReachedLimit}));
  EXPECT_NEAR(world.joint_state(joint).position[0], 0.5, 5e-3);
  kinds.clear();
  slider.offset.motor.reset();
  world.set_joint(joint, slider);
  watch(10);
  EXPECT_EQ(kinds, Kinds{JointEventKind::LeftLimit});
}

}  // namespace
}  // namespace atl::test
