// Joints' ids, what they keep from touching, and being changed.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "support/bodies.h"
#include "support/expect_error.h"

namespace atl::test {
namespace {

// Two crates that overlap in mid-air, and one apart.
struct Crates {
  World world{WorldDef{.gravity = Vector3::Zero()}};
  BodyId a = world.add_body(box({0, 0, 0}));
  BodyId b = world.add_body(box({0.9, 0, 0}));
  BodyId c = world.add_body(box({5, 0, 0}));

  JointId add(BodyId first, BodyId second, bool collide = false, const JointKind& kind = BallJoint{}) {
    JointDef def{.kind = kind, .first = first, .second = second, .collide = collide};
    def.frame_second.position = world.pose(first).position - world.pose(second).position;
    return world.add_joint(def);
  }
  /// Pairs of bodies that have contacts after a step.
  std::int64_t contacts() { return world.step(dt).counts.contacts; }
};

TEST(JointWorld, StaleIdsAreCaughtByEveryCall) {
  Crates crates;
  const JointId stale = crates.add(crates.a, crates.b);
  crates.world.remove_joint(stale);
  crates.add(crates.a, crates.b);
  for (const JointId id : {stale, JointId{}, JointId{7, 0}}) {
    const auto expect_refused = [&](const char* call, const auto& body) {
      expect_error(body, {std::string("World::") + call, "no joint has the id", std::to_string(id.index)});
    };
    expect_refused("remove_joint", [&] { crates.world.remove_joint(id); });
    expect_refused("joint", [&] { (void)crates.world.joint(id); });
    expect_refused("joint_state", [&] { (void)crates.world.joint_state(id); });
    expect_refused("set_joint", [&] { crates.world.set_joint(id, BallJoint{}); });
    expect_refused("set_joint_enabled", [&] { crates.world.set_joint_enabled(id, false); });
    expect_refused("count_turns_from", [&] { crates.world.count_turns_from(id, 0); });
    EXPECT_FALSE(crates.world.contains(id));
  }
}

TEST(JointWorld, ReadsBackWhatItWasMadeWith) {
  Crates crates;
  const JointDef def{.kind = HingeJoint{{.range = {-1, 2}}},
                     .first = crates.a,
                     .second = crates.c,
                     .frame_first = {{1, 2, 3}, Quaternion(2, 0, 0, 0)},
                     .collide = true,
                     .break_force = 5};
  const JointId id = crates.world.add_joint(def);
  const JointDef& read = crates.world.joint(id);
  EXPECT_EQ(std::get<HingeJoint>(read.kind).angle.range.upper, 2);
  EXPECT_EQ(read.first, crates.a);
  EXPECT_EQ(read.second, crates.c);
  EXPECT_EQ(read.frame_first.position, Vector3(1, 2, 3));
  EXPECT_EQ(read.frame_first.orientation.w(), 1) << "of unit length";
  EXPECT_TRUE(read.collide);
  EXPECT_EQ(read.break_force, 5);
  EXPECT_EQ(read.break_torque, unlimited);
  EXPECT_TRUE(crates.world.joint_state(id).enabled);
  EXPECT_FALSE(crates.world.joint_state(id).broken);

  crates.world.set_joint(id, HingeJoint{{.range = {-1, 3}}});
  EXPECT_EQ(std::get<HingeJoint>(crates.world.joint(id).kind).angle.range.upper, 3);
  expect_error([&] { crates.world.set_joint(id, SliderJoint{}); },
               {"World::set_joint: kind", "SliderJoint", "expected HingeJoint"});
}

// A light link between what holds it and a heavy load, which swing.
struct HeavyPendulum {
  explicit HeavyPendulum(JointSolver solver) : world({.settings = {.joint_solver = solver}}) {
    const BodyId beam = world.add_body(static_box({0, 0, 0.5}, {0.5, 0.5, 0.5}));
    bodies = {world.add_body({.shape = Box{{0.2, 0.02, 0.02}}, .position = {0.2, 0, 0}, .density = 100}),
              world.add_body({.shape = Sphere{0.2}, .position = {0.4, 0, -0.2}, .density = 8000})};
    joints = {
        world.add_joint(
            {.first = beam, .second = bodies[0], .frame_first = {{0, 0, -0.5}}, .frame_second = {{-0.2, 0, 0}}}),
        world.add_joint(
            {.first = bodies[0], .second = bodies[1], .frame_first = {{0.2, 0, 0}}, .frame_second = {{0, 0, 0.2}}})};
    for (const BodyId body : bodies) start.push_back(world.pose(body));
  }
  void put_back() {
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      world.set_pose(bodies[i], start[i]);
      world.set_velocity(bodies[i], Vector3::Zero(), Vector3::Zero());
    }
  }
  std::vector<Vector3> path() {
    std::vector<Vector3> places;
    for (int i = 0; i < 20; ++i) {
      world.step(dt);
      for (const BodyId body : bodies) places.push_back(world.pose(body).position);
    }
    return places;
  }

  World world;
  std::vector<BodyId> bodies;
  std::vector<JointId> joints;
  std::vector<Pose> start;
};

TEST(JointWorld, AJointThatWasDisabledForgetsWhatItDid) {
  for (const JointSolver solver : {JointSolver::Iterative, JointSolver::Direct}) {
    SCOPED_TRACE(static_cast<int>(solver));
    HeavyPendulum pendulum(solver);
    const std::vector<Vector3> expected = pendulum.path();
    for (const JointId joint : pendulum.joints) pendulum.world.set_joint_enabled(joint, false);
    pendulum.put_back();
    for (const JointId joint : pendulum.joints) pendulum.world.set_joint_enabled(joint, true);
    EXPECT_EQ(pendulum.path(), expected);
  }
}

TEST(JointWorld, JointsGoWithEitherBody) {
  for (const bool first : {true, false}) {
    Crates crates;
    const JointId one = crates.add(crates.a, crates.b);
    const JointId two = crates.add(crates.b, crates.a);
    const JointId other = crates.add(crates.b, crates.c);
    crates.world.remove_body(first ? crates.a : crates.c);
    EXPECT_EQ(crates.world.contains(one), !first);
    EXPECT_EQ(crates.world.contains(two), !first);
    EXPECT_EQ(crates.world.contains(other), first);
    EXPECT_EQ(crates.world.joint_count(), first ? 1u : 2u);
    EXPECT_NO_THROW(run(crates.world, 3));
    // Earlier users of the same indices must leave no trace.
    const BodyId again = crates.world.add_body(box({0, 3, 0}));
    EXPECT_NO_THROW(crates.add(again, crates.b));
    EXPECT_EQ(crates.world.step(dt).counts.joints, first ? 2 : 3);
  }
}

TEST(JointWorld, WhatKeepsAPairApartIsCounted) {
  Crates crates;
  const JointId one = crates.add(crates.a, crates.b, false, FixedJoint{});
  const JointId two = crates.add(crates.b, crates.a, false, FixedJoint{});
  const JointId lenient = crates.add(crates.b, crates.a, true, FixedJoint{});
  EXPECT_EQ(crates.contacts(), 0);
  crates.world.remove_joint(one);
  EXPECT_EQ(crates.contacts(), 0) << "the other is left";
  crates.world.set_joint_enabled(two, false);
  EXPECT_EQ(crates.contacts(), 1) << "disabled, it does nothing";
  crates.world.set_joint_enabled(two, false);
  crates.world.set_joint_enabled(two, true);
  EXPECT_EQ(crates.contacts(), 0);
  crates.world.remove_joint(lenient);
  EXPECT_EQ(crates.contacts(), 0);
  crates.world.remove_joint(two);
  EXPECT_EQ(crates.contacts(), 1);
}

TEST(JointWorld, UsersAndJointsDoNotUndoEachOther) {
  Crates crates;
  crates.world.set_collision_enabled(crates.a, crates.b, false);
  const JointId joint = crates.add(crates.a, crates.b, false, FixedJoint{});
  crates.world.set_collision_enabled(crates.b, crates.a, true);
  EXPECT_EQ(crates.contacts(), 0) << "the joint keeps them apart";
  crates.world.set_collision_enabled(crates.a, crates.b, false);
  crates.world.remove_joint(joint);
  EXPECT_EQ(crates.contacts(), 0) << "the user does";
  crates.world.set_collision_enabled(crates.a, crates.b, true);
  EXPECT_EQ(crates.contacts(), 1);
}

TEST(JointWorld, RemovedBodysPairsAreForgotten) {
  Crates crates;
  crates.add(crates.a, crates.b);
  crates.world.remove_body(crates.b);
  const BodyId again = crates.world.add_body(box({0.9, 0, 0}));
  ASSERT_EQ(again.index, crates.b.index);
  EXPECT_EQ(crates.contacts(), 1);
}

// It leaves no trace in the motion of others, and is told of as one that holds nothing.
TEST(JointWorld, AJointBetweenBodiesThatAreNotDynamicIsIdle) {
  for (const JointSolver solver : {JointSolver::Iterative, JointSolver::Direct}) {
    const auto moved = [&](bool joined) {
      World world({.settings = {.joint_solver = solver}});
      const BodyId post = world.add_body(static_box({0, 0, 0}, {0.5, 0.5, 0.5}));
      const BodyId cart = world.add_body({.type = BodyType::Kinematic, .position = {3, 0, 0}, .velocity = {1, 0, 0}});
      const BodyId load = world.add_body(box({3, 0, -2}));
      world.add_joint({.first = cart, .second = load, .frame_second = {{0, 0, 2}}});
      JointId idle;
      if (joined) {
        const JointAxis driven{
            .range = {0, 1}, .spring = JointSpring{}, .motor = JointMotor{.speed = 1, .max_force = 9}};
        idle = world.add_joint({.kind = SliderJoint{driven}, .first = post, .second = cart, .break_force = 1e-3});
      }
      StepReport report;
      for (int i = 0; i < 60; ++i) {
        report = world.step(dt);
        EXPECT_TRUE(world.joint_events().empty());
      }
      EXPECT_EQ(report.counts.joints, 1);
      if (joined) {
        const JointState state = world.joint_state(idle);
        EXPECT_TRUE(state.force.isZero(0) && state.torque.isZero(0));
        EXPECT_NEAR(state.position[0], 4, 1e-9);
        EXPECT_EQ(state.motor[0], 0);
      }
      return Eigen::Matrix3Xd(world.positions());
    };
    EXPECT_EQ(moved(true), moved(false));
  }
}

// Coordinates of each kind, from poses and velocities alone.
TEST(JointWorld, StateTellsOfNamedCoordinates) {
  Crates crates;
  const auto state = [&](const JointKind& kind) {
    const JointId id = crates.world.add_joint({.kind = kind, .first = crates.a, .second = crates.c});
    const JointState read = crates.world.joint_state(id);
    crates.world.remove_joint(id);
    return read;
  };
  // The second is 5 m along x, turned by 0.3 about x, and moves along x and spins about it.
  const Quaternion turn(Eigen::AngleAxisd(0.3, Vector3::UnitX()));
  crates.world.set_pose(crates.c, {{5, 0.5, 0.25}, turn});
  crates.world.set_velocity(crates.c, {2, 0, 0}, {3, 0, 0});
  const JointState hinge = state(HingeJoint{});
  EXPECT_NEAR(hinge.position[0], 0.3, 1e-12);
  EXPECT_NEAR(hinge.speed[0], 3, 1e-12);
  EXPECT_EQ(hinge.position[1], 0);
  const JointState slider = state(SliderJoint{});
  EXPECT_NEAR(slider.position[0], 5, 1e-12);
  EXPECT_NEAR(slider.speed[0], 2, 1e-12);
  const JointState rod = state(DistanceJoint{});
  EXPECT_NEAR(rod.position[0], Vector3(5, 0.5, 0.25).norm(), 1e-12);
  EXPECT_NEAR(rod.speed[0], 10 / Vector3(5, 0.5, 0.25).norm(), 1e-12);
  const JointState cross = state(UniversalJoint{});
  EXPECT_NEAR(cross.position[0], 0.3, 1e-12);
  EXPECT_NEAR(cross.position[1], 0, 1e-12);
  const JointState cone = state(ConeTwistJoint{});
  EXPECT_NEAR(cone.position[0], 0, 1e-12);
  EXPECT_NEAR(cone.position[1], 0.3, 1e-12);
  EXPECT_NEAR(cone.speed[1], 3, 1e-12);
  const JointState six = state(SixDofJoint{});
  const double expected[] = {5, 0.5, 0.25, 2 * std::sin(0.15), 0, 0};
  const double speeds[] = {2, 0, 0, 3 * std::cos(0.15), 0, 0};
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(six.position[i], expected[i], 1e-12) << i;
    EXPECT_NEAR(six.speed[i], speeds[i], 1e-12) << i;
  }
  EXPECT_NEAR(state(GearJoint{.ratio = 2}).speed[0], 6, 1e-12);
  EXPECT_NEAR(state(GearJoint{.ratio = 2, .rack = true}).speed[0], 4, 1e-12);
  EXPECT_NEAR(state(WheelJoint{}).position[0], 0.25, 1e-12);
}

// An angle is known but for full turns.
TEST(JointWorld, AnglesStartWithTheTurnNearestToTheirRange) {
  Crates crates;
  crates.world.set_pose(crates.c, {{5, 0, 0}, Quaternion(Eigen::AngleAxisd(-3, Vector3::UnitX()))});
  const double turn = 2 * std::numbers::pi;
  const auto angle = [&](const JointRange& range) {
    const JointId id =
        crates.world.add_joint({.kind = HingeJoint{{.range = range}}, .first = crates.a, .second = crates.c});
    const double position = crates.world.joint_state(id).position[0];
    crates.world.set_joint(id, HingeJoint{});
    EXPECT_NEAR(crates.world.joint_state(id).position[0], -3, 1e-12) << "nobody counts";
    crates.world.set_joint(id, HingeJoint{{.range = range}});
    EXPECT_EQ(crates.world.joint_state(id).position[0], position);
    crates.world.remove_joint(id);
    return position;
  };
  EXPECT_NEAR(angle({-3.5, 0}), -3, 1e-12);
  EXPECT_NEAR(angle({3, 3.5}), -3 + turn, 1e-12);
  EXPECT_NEAR(angle({0.5, unlimited}), -3 + turn, 1e-12);
  EXPECT_NEAR(angle({8, 9}), -3 + 2 * turn, 1e-12);
  EXPECT_NEAR(angle({-1, 1}), -3, 1e-12) << "outside, and nearer to the lower end";
}

TEST(JointWorld, AnglesGoToTheTurnNearestToWhatIsSaid) {
  Crates crates;
  const double turn = 2 * std::numbers::pi;
  const JointId joint = crates.add(crates.a, crates.c, false, HingeJoint{});
  const auto angle = [&] { return crates.world.joint_state(joint).position[0]; };
  crates.world.count_turns_from(joint, turn);
  EXPECT_EQ(angle(), 0) << "nobody counts";
  crates.world.set_joint(joint, HingeJoint{{.range = {-20, 20}}});
  for (const double expected : {turn, -2 * turn, 0.0}) {
    crates.world.count_turns_from(joint, expected + 1);
    EXPECT_NEAR(angle(), expected, 1e-4);
    crates.world.step(dt);
    EXPECT_NEAR(angle(), expected, 1e-4) << "the step goes on from there";
  }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  expect_error([&] { crates.world.count_turns_from(joint, 0, 1); }, {"coordinate is 1", "1 that a HingeJoint has"});
  expect_error([&] { crates.world.count_turns_from(joint, nan); }, {"angle is nan"});
}

// A body made around its corner: its centre of mass is not where its frame is.
TEST(JointWorld, FramesAreThoseOfTheBodiesNotOfTheirMass) {
  World world({.gravity = Vector3::Zero()});
  const Compound corner{.children = {{.shape = Box{}, .position = {2, 0, 0}}}};
  const BodyId a = world.add_body({.shape = corner});
  const BodyId b = world.add_body({.shape = corner, .position = {0, 0, 3}});
  ASSERT_GT((world.centre_of_mass(a) - world.pose(a).position).norm(), 1);
  const JointDef rod{
      .kind = DistanceJoint{}, .first = a, .second = b, .frame_first = {{0, 0, 1}, Quaternion::Identity()}};
  EXPECT_NEAR(world.joint_state(world.add_joint(rod)).position[0], 2, 1e-12);
}

TEST(JointWorld, HashSeesAllOfAJoint) {
  const auto hash_with = [](const JointDef& change, bool enabled = true) {
    Crates crates;
    JointDef def = change;
    def.first = crates.a;
    def.second = crates.c;
    const JointId id = crates.world.add_joint(def);
    crates.world.set_joint_enabled(id, enabled);
    return crates.world.state_hash();
  };
  const auto hinge = [](const JointAxis& axis) { return JointDef{.kind = HingeJoint{axis}}; };
  std::vector<JointDef> defs = {
      hinge({}),
      hinge({.range = {.lower = -1}}),
      hinge({.range = {.upper = 1}}),
      hinge({.spring = JointSpring{}}),
      hinge({.spring = JointSpring{.hertz = 2}}),
      hinge({.spring = JointSpring{.damping_ratio = 2}}),
      hinge({.spring = JointSpring{.rest = 1e-300}}),
      hinge({.motor = JointMotor{0, 1}}),
      hinge({.motor = JointMotor{1e-300, 1}}),
      hinge({.motor = JointMotor{0, 2}}),
      {.kind = BallJoint{}},
      {.kind = GearJoint{}},
      {.kind = GearJoint{.ratio = 2}},
      {.kind = GearJoint{.rack = true}},
      {.frame_first = {{1e-300, 0, 0}, Quaternion::Identity()}},
      {.frame_second = {{1e-300, 0, 0}, Quaternion::Identity()}},
      {.frame_first = {{0, 0, 0}, Quaternion(1, 1e-100, 0, 0)}},
      {.frame_second = {{0, 0, 0}, Quaternion(1, 1e-100, 0, 0)}},
      {.collide = true},
      {.break_force = 1},
      {.break_torque = 1},
  };
  std::set<std::uint64_t> hashes;
  for (const JointDef& def : defs) hashes.insert(hash_with(def));
  EXPECT_EQ(hashes.size(), defs.size());
  hashes.insert(hash_with(JointDef{}, false));
  EXPECT_EQ(hashes.size(), defs.size() + 1);
}

TEST(JointWorld, HashSeesWhichIdComesNext) {
  const auto hash_after = [](int joints) {
    Crates crates;
    std::vector<JointId> ids;
    for (int i = 0; i < joints; ++i) ids.push_back(crates.add(crates.a, crates.c));
    for (const JointId id : ids) crates.world.remove_joint(id);
    return crates.world.state_hash();
  };
  const std::set<std::uint64_t> hashes = {hash_after(0), hash_after(1), hash_after(2)};
  EXPECT_EQ(hashes.size(), 3u);
}

// Restitution that is set later acts as if the joint had been made with it.
TEST(JointWorld, RestitutionThatIsSetLaterBounces) {
  const auto speed_back = [](double at_first, double later) {
    World world({.gravity = Vector3::Zero()});
    const BodyId rail = world.add_body({.type = BodyType::Static, .shape = Box{{0.1, 0.1, 0.1}}});
    const BodyId cart =
        world.add_body({.shape = Box{{0.1, 0.1, 0.1}}, .position = {0.01, 0, 0}, .velocity = {3, 0, 0}});
    JointAxis axis{.range = {.lower = -1, .upper = 1, .restitution = at_first}};
    const JointId slider = world.add_joint({.kind = SliderJoint{axis}, .first = rail, .second = cart});
    axis.range.restitution = later;
    world.set_joint_axis(slider, axis);
    Snapshot snapshot;
    world.save(snapshot);
    World other({.gravity = Vector3::Zero()});
    other.restore(snapshot);
    for (int i = 0; i < 30; ++i) {
      world.step(1.0 / 60);
      other.step(1.0 / 60);
      EXPECT_EQ(world.state_hash(), other.state_hash()) << i;
    }
    return -world.velocity(cart).x();
  };
  EXPECT_NEAR(speed_back(0, 0.8), 2.4, 0.05);
  EXPECT_NEAR(speed_back(0.8, 0.8), 2.4, 0.05);
  EXPECT_LT(speed_back(0.8, 0), 0.2);
}

}  // namespace
}  // namespace atl::test
