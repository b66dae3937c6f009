// Calls on bodies in quarantine, and their absence from the rest of the world.

#include <atoll/atoll.h>
#include <atoll/snapshot.h>
#include <gtest/gtest.h>

#include <vector>

#include "support/bodies.h"
#include "support/expect_error.h"

namespace atl::test {
namespace {

// A crate on the ground that was pushed too hard.
struct Lost {
  World world;
  BodyId floor;
  BodyId crate;

  explicit Lost(const Settings& settings = {}, const MotionLocks& locks = {}) : world({.settings = settings}) {
    floor = world.add_body(ground());
    BodyDef def = box({0, 0, 0.5});
    def.locks = locks;
    crate = world.add_body(def);
    run(world, 10);
    world.apply_force(crate, {1e30, 0, 0});
    run(world, 1);
  }
};

TEST(Quarantine, BoundsAreWhereTheyAreSaidToBe) {
  World world({.gravity = Vector3::Zero()});
  const auto lost_of = [&](const BodyDef& def) {
    const BodyId id = world.add_body(def);
    const std::int64_t lost = world.step(1e-3).quarantined;
    EXPECT_EQ(world.is_quarantined(id), lost == 1);
    world.remove_body(id);
    return lost;
  };
  BodyDef def = sphere({0, 0, 0});
  def.velocity = {0.999e6, 0, 0};
  EXPECT_EQ(lost_of(def), 0);
  def.velocity = {0.8e6, 0.8e6, 0};
  EXPECT_EQ(lost_of(def), 1);
  def = sphere({0, 0, 0});
  def.angular_velocity = {0, 0.999e6, 0};
  EXPECT_EQ(lost_of(def), 0);
  def.angular_velocity = {0, 1.001e6, 0};
  EXPECT_EQ(lost_of(def), 1);
  EXPECT_EQ(lost_of(sphere({0, 0.999e12, 0})), 0);
  EXPECT_EQ(lost_of(sphere({0, 1.001e12, 0})), 1);
  EXPECT_EQ(lost_of(static_box({0, 1.001e12, 0}, {1, 1, 1})), 1);
  def = sphere({0, 0, 0});
  def.surface_velocity = {1.001e6, 0, 0};
  EXPECT_EQ(lost_of(def), 1);

  // A step of 1 ms from rest: 2 kg take 2e9 N to be at 1e6 m/s.
  for (const double force : {1.999e9, 2.001e9}) {
    def = sphere({0, 0, 0});
    def.mass = 2;
    const BodyId id = world.add_body(def);
    world.apply_force(id, {0, 0, force});
    EXPECT_EQ(world.step(1e-3).quarantined, force > 2e9);
    world.remove_body(id);
  }
}

TEST(Quarantine, StepThatCarriesABodyTooFarIsTakenBack) {
  World world({.gravity = Vector3::Zero()});
  BodyDef def = sphere({1e12 - 1e5, 0, 0});
  def.velocity = {0.9e6, 0, 0};
  const BodyId id = world.add_body(def);
  EXPECT_EQ(world.step(0.1).quarantined, 0);
  const Vector3 before = world.pose(id).position;
  EXPECT_EQ(world.step(0.1).quarantined, 1);
  EXPECT_EQ(world.quarantined()[0].reason, Quarantine::TooFar);
  EXPECT_EQ(world.pose(id).position, before);
  EXPECT_EQ(world.velocity(id), Vector3::Zero());
}

TEST(Quarantine, ReleasedBodyKeepsItsLocks) {
  Lost lost({}, MotionLocks::plane(Axis::Y));
  ASSERT_TRUE(lost.world.is_quarantined(lost.crate));
  lost.world.set_pose(lost.crate, {.position = {0, 0, 0.5}});
  lost.world.release(lost.crate);
  lost.world.apply_impulse(lost.crate, {1000, 1000, 0}, {0, 0, 0.5});
  run(lost.world, 10);
  EXPECT_GT(lost.world.pose(lost.crate).position.x(), 0.05);
  EXPECT_EQ(lost.world.pose(lost.crate).position.y(), 0);
}

// A change made to a body in quarantine holds once it is back.
TEST(Quarantine, FilterThatIsSetMeanwhileHolds) {
  for (const bool declared_static : {false, true}) {
    Lost lost;
    if (declared_static) {
      lost.world.set_collision_enabled(lost.floor, lost.crate, false);
    } else {
      lost.world.set_filter(lost.crate, {.category = 2, .mask = 0});
    }
    lost.world.release(lost.crate);
    run(lost.world, 60);
    EXPECT_LT(lost.world.pose(lost.crate).position.z(), -1);
  }
}

// A ball that is given the shape of a plate tumbles as one: and as it does after a restore.
TEST(Quarantine, ShapeThatIsSetMeanwhileHolds) {
  World world({.gravity = Vector3::Zero()});
  const BodyId body = world.add_body(sphere({0, 0, 0}));
  world.set_velocity(body, {1e7, 0, 0}, Vector3::Zero());
  ASSERT_EQ(world.step(dt).quarantined, 1);
  world.set_shape(body, Box{{0.1, 0.5, 1}});
  world.release(body);
  world.set_velocity(body, Vector3::Zero(), {3, 0.1, 2});
  Snapshot before;
  world.save(before);
  run(world, 60);
  const std::uint64_t hash = world.state_hash();
  EXPECT_GT((world.angular_velocity(body) - Vector3(3, 0.1, 2)).norm(), 0.1);
  world.restore(before);
  run(world, 60);
  EXPECT_EQ(world.state_hash(), hash);
}

TEST(Quarantine, ReleaseRefusesWhatCanNotTakePart) {
  Lost lost;
  expect_error([&] { lost.world.release(lost.floor); }, {"World::release", "index 0", "not in quarantine"});
  lost.world.set_pose(lost.crate, {.position = {1e13, 0, 0}});
  expect_error([&] { lost.world.release(lost.crate); }, {"World::release", "index 1", "1e12 m", "1e+13"});
  lost.world.set_pose(lost.crate, {.position = {0, 0, 1}});
  lost.world.set_velocity(lost.crate, {0, 0, 2e6}, {0, 0, 0});
  expect_error([&] { lost.world.release(lost.crate); }, {"World::release", "1e6 m/s", "2e+06"});
  lost.world.set_velocity(lost.crate, {0, 0, 0}, {0, 0, 0});
  lost.world.release(lost.crate);
  expect_error([&] { lost.world.release(lost.crate); }, {"not in quarantine"});
  lost.world.remove_body(lost.crate);
  expect_error([&] { lost.world.release(lost.crate); }, {"World::release", "generation 0"});
  expect_error([&] { lost.world.is_quarantined(lost.crate); }, {"World::is_quarantined"});
}

TEST(Quarantine, PoseThatIsTakenBackBeforeTheStepHarmsNothing) {
  World world;
  world.add_body(ground());
  const BodyId crate = world.add_body(box({0, 0, 0.5}));
  world.set_pose(crate, {.position = {1e15, 0, 0}});
  world.set_pose(crate, {.position = {1, 0, 0.5}});
  EXPECT_EQ(run(world, 30).quarantined, 0);
  EXPECT_NEAR(world.pose(crate).position.z(), 0.5, 1e-3);
  // Moved where it may be, and then where it may not.
  world.set_pose(crate, {.position = {2, 0, 0.5}});
  world.set_pose(crate, {.position = {1e15, 0, 0}});
  EXPECT_EQ(world.step(dt).quarantined, 1);
  EXPECT_EQ(world.pose(crate).position, Vector3(2, 0, 0.5));
}

TEST(Quarantine, NothingIsLeftAfterManyRounds) {
  World world;
  world.add_body(ground());
  const std::vector<BodyId> stack = add_stack(world, 3);
  const JointId joint = world.add_joint(
      {.first = stack[1], .second = stack[2], .frame_first = {{0, 0, 0.5}}, .frame_second = {{0, 0, -0.5}}});
  run(world, 30);
  const StepReport before = world.step(dt);
  const Pose pose = world.pose(stack[1]);
  for (int round = 0; round < 50; ++round) {
    world.apply_force(stack[1], {0, 0, 1e200});
    const StepReport report = world.step(dt);
    ASSERT_EQ(report.quarantined, 1);
    ASSERT_EQ(report.counts.joints, 0);
    world.set_pose(stack[1], pose);
    world.release(stack[1]);
    world.set_pose(stack[2], {.position = {0, 0, 2.5}});
    world.set_velocity(stack[2], {0, 0, 0}, {0, 0, 0});
  }
  const StepReport after = run(world, 30);
  EXPECT_EQ(after.counts.pairs, before.counts.pairs);
  EXPECT_EQ(after.counts.contacts, before.counts.contacts);
  EXPECT_EQ(after.counts.joints, before.counts.joints);
  EXPECT_EQ(after.counts.active_bodies, before.counts.active_bodies);
  EXPECT_EQ(world.body_count(), 4u);
  EXPECT_EQ(world.joint_count(), 1u);
  EXPECT_TRUE(world.joint_state(joint).enabled);
  EXPECT_NEAR(world.pose(stack[2]).position.z(), 2.5, 0.01);
}

TEST(Quarantine, JointsToABodyThatIsOutWaitForIt) {
  Lost lost;
  const BodyId weight = lost.world.add_body(sphere({0, 0, 3}, 0.1));
  const JointId joint = lost.world.add_joint({.first = lost.crate, .second = weight, .frame_first = {{0, 0, 2.5}}});
  EXPECT_EQ(lost.world.step(dt).counts.joints, 0);
  EXPECT_EQ(lost.world.joint_state(joint).force, Vector3::Zero());
  lost.world.set_joint_enabled(joint, false);
  lost.world.set_joint_enabled(joint, true);
  EXPECT_EQ(lost.world.step(dt).counts.joints, 0);
  lost.world.release(lost.crate);
  EXPECT_EQ(lost.world.step(dt).counts.joints, 1);

  // Either may go first.
  lost.world.apply_force(lost.crate, {1e30, 0, 0});
  lost.world.apply_force(weight, {1e30, 0, 0});
  EXPECT_EQ(lost.world.step(dt).quarantined, 2);
  lost.world.release(weight);
  EXPECT_EQ(lost.world.step(dt).counts.joints, 0);
  lost.world.remove_body(lost.crate);
  EXPECT_FALSE(lost.world.contains(joint));
  EXPECT_EQ(lost.world.joint_count(), 0u);
  EXPECT_EQ(lost.world.step(dt).counts.joints, 0);
}

TEST(Quarantine, ContactsThatEndAreTold) {
  World world({.settings = {.contact_events = true}});
  const BodyId floor = world.add_body(ground());
  const BodyId crate = world.add_body(box({0, 0, 0.5}));
  run(world, 10);
  world.apply_force(crate, {1e30, 0, 0});
  run(world, 1);
  ASSERT_EQ(world.contact_events().size(), 1u);
  EXPECT_EQ(world.contact_events()[0].a, floor);
  EXPECT_EQ(world.contact_events()[0].b, crate);
  EXPECT_FALSE(world.contact_events()[0].began);
  run(world, 1);
  EXPECT_TRUE(world.contact_events().empty());
  world.release(crate);
  run(world, 1);
  ASSERT_EQ(world.contact_events().size(), 1u);
  EXPECT_TRUE(world.contact_events()[0].began);
}

TEST(Quarantine, IsPartOfTheStateHash) {
  Lost lost;
  World same;
  same.add_body(ground());
  const BodyId crate = same.add_body(box({0, 0, 0.5}));
  run(same, 10);
  const std::uint64_t before = same.state_hash();
  same.apply_force(crate, {1e30, 0, 0});
  run(same, 1);
  EXPECT_EQ(same.state_hash(), lost.world.state_hash());
  EXPECT_NE(same.state_hash(), before);
  const std::uint64_t out = same.state_hash();
  same.release(crate);
  EXPECT_NE(same.state_hash(), out);
}

}  // namespace
}  // namespace atl::test
