// Bodies that are locked along or about axes move along and about the others as they should, and not at all along
// these.

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "support/bodies.h"

namespace atl::test::motion_locks_test {
namespace {

constexpr MotionLocks in_plane = MotionLocks::plane(Axis::Y);
constexpr MotionLocks no_turning = {.angular = {true, true, true}};

Quaternion about(const Vector3& axis, double angle) { return Quaternion(Eigen::AngleAxisd(angle, axis.normalized())); }

TEST(MotionLocks, PlaneIsAcrossItsAxis) {
  EXPECT_EQ(MotionLocks::plane(Axis::X), (MotionLocks{{true, false, false}, {false, true, true}}));
  EXPECT_EQ(MotionLocks::plane(Axis::Y), (MotionLocks{{false, true, false}, {true, false, true}}));
  EXPECT_EQ(MotionLocks::plane(Axis::Z), (MotionLocks{{false, false, true}, {true, true, false}}));
}

TEST(MotionLocks, DropWhatIsAskedForAlongThem) {
  World world({.gravity = {1, 2, 3}});
  BodyDef def = locked(box({1, 2, 3}), in_plane);
  def.velocity = {4, 5, 6};
  def.angular_velocity = {7, 8, 9};
  const BodyId id = world.add_body(def);
  EXPECT_EQ(world.velocity(id), Vector3(4, 0, 6));
  EXPECT_EQ(world.angular_velocity(id), Vector3(0, 8, 0));
  world.set_velocity(id, {-1, -2, -3}, {-4, -5, -6});
  EXPECT_EQ(world.velocity(id), Vector3(-1, 0, -3));
  EXPECT_EQ(world.angular_velocity(id), Vector3(0, -5, 0));
  world.set_velocity(id, {0, 0, 0}, {0, 0, 0});
  world.apply_impulse(id, {1000, 2000, 3000}, {1.1, 2.2, 3.3});
  EXPECT_TRUE(world.velocity(id).isApprox(Vector3(1, 0, 3))) << world.velocity(id).transpose();
  EXPECT_EQ(world.velocity(id).y(), 0);
  EXPECT_EQ(world.angular_velocity(id).x(), 0);
  EXPECT_EQ(world.angular_velocity(id).z(), 0);
  EXPECT_NEAR(world.angular_velocity(id).y(), (0.3 * 1000 - 0.1 * 3000) / (1000.0 / 6), 1e-9);
  const Quaternion turned = about({1, 2, 3}, 1);
  world.set_pose(id, {{7, 8, 9}, turned});
  EXPECT_EQ(world.pose(id).position, Vector3(7, 8, 9)) << "poses are free";
}

TEST(MotionLocks, FreeFlightIsAParabolaInThePlane) {
  World world;
  BodyDef plain = box({0, 0, 0});
  plain.velocity = {3, 0, 4};
  plain.angular_velocity = {0, 2, 0};
  BodyDef def = locked(plain, in_plane);
  def.velocity.y() = 5;
  def.angular_velocity = {1, 2, 3};
  const BodyId a = world.add_body(plain), b = world.add_body(def);
  world.set_collision_enabled(a, b, false);
  for (int i = 0; i < 120; ++i) {
    world.apply_force(a, {10, 0, 0}, {0, 20, 0});
    world.apply_force(b, {10, 1e7, 0}, {1e7, 20, -1e7});
    world.step(dt);
    ASSERT_EQ(world.pose(a).position, world.pose(b).position);
    ASSERT_LT(world.pose(a).orientation.angularDistance(world.pose(b).orientation), 1e-12);
    ASSERT_EQ(world.pose(b).position.y(), 0);
    ASSERT_EQ(world.angular_velocity(b).x(), 0);
    ASSERT_EQ(world.angular_velocity(b).z(), 0);
  }
}

// A body locked about one axis turns about the two others by the inverse of the inertia about these two.
TEST(MotionLocks, InertiaIsThatOfTheFreeAxes) {
  const Vector3 half(0.5, 0.3, 0.1);
  const Quaternion turned = about({1, 2, 3}, 0.8);
  const Matrix3 rotation = turned.toRotationMatrix();
  for (const bool touching : {false, true}) {  // in free flight, and in an island
    World world({.gravity = {0, 0, 0}});
    BodyDef def = locked(box({0, 0, 0}, half), {.angular = {true, false, false}});
    def.orientation = turned;
    const BodyId id = world.add_body(def);
    if (touching) {
      BodyDef other = sphere({0, 0, 0}, 1);
      other.material.friction = 0;
      other.position = rotation * Vector3(0, 0, 1.1);  // over the middle of a face
      world.add_body(other);
    }
    const double mass = world.mass(id);
    const Matrix3 inertia = rotation * box_inertia(mass, half).asDiagonal() * rotation.transpose();
    const Vector3 torque(5, 7, -3);
    const Eigen::Vector2d gained = dt * (inertia.bottomRightCorner<2, 2>().inverse() * torque.tail<2>());
    world.apply_force(id, {0, 0, 0}, torque);
    const StepReport report = world.step(dt);
    EXPECT_EQ(report.counts.contacts, touching ? 1 : 0);
    EXPECT_EQ(world.angular_velocity(id).x(), 0);
    EXPECT_LT((world.angular_velocity(id).tail<2>() - gained).norm(), (touching ? 1e-3 : 1e-12) * gained.norm());
  }
}

TEST(MotionLocks, PlanarBoxSlidesAsAFreeOneDoes) {
  World world;
  world.add_body(ground(0.4));
  BodyDef def = box({0, 0, 0.5});
  def.velocity = {4, 0, 0};
  def.material.friction = 0.4;
  const BodyId free = world.add_body(def);
  def.position.y() = 5;
  const BodyId planar = world.add_body(locked(def, in_plane));
  run(world, 120);
  const double path = 16 / (2 * 0.4 * g);
  EXPECT_NEAR(world.pose(free).position.x(), path, 2e-3 * path);
  EXPECT_NEAR(world.pose(planar).position.x(), path, 2e-3 * path);
  EXPECT_NEAR(world.pose(planar).position.z(), world.pose(free).position.z(), 1e-4);
  EXPECT_EQ(world.pose(planar).position.y(), 5);
}

TEST(MotionLocks, PlanarBlockTipsAsAFreeOneDoes) {
  World world({.settings = {.substeps = 8}});
  world.add_body(ground(2));
  const Vector3 half(0.25, 0.25, 0.75);
  BodyDef def = box({0, 0, 0.75}, half);
  def.material.friction = 2;
  const BodyId free = world.add_body(def);
  def.position.y() = 5;
  const BodyId planar = world.add_body(locked(def, in_plane));
  const double push = 1.5 * world.mass(free) * g * half.x() / half.z();
  for (int i = 0; i < 60; ++i) {
    for (const BodyId id : {free, planar}) world.apply_force(id, {push, 0, 0}, {0, 0, 0});
    world.step(dt);
    const double tilt = world.pose(free).orientation.angularDistance(Quaternion::Identity());
    if (tilt > 0.8) break;
    ASSERT_NEAR(world.pose(planar).orientation.angularDistance(Quaternion::Identity()), tilt, 4e-3) << "step " << i;
    ASSERT_LT((world.pose(planar).position - world.pose(free).position - Vector3(0, 5, 0)).norm(), 4e-3);
  }
  EXPECT_GT(world.pose(free).orientation.angularDistance(Quaternion::Identity()), 0.3) << "they tip";
  EXPECT_EQ(world.pose(planar).position.y(), 5);
}

TEST(MotionLocks, PlanarDiscRollsDownASlope) {
  World world({.gravity = Quaternion(Eigen::AngleAxisd(-0.3, Vector3::UnitY())) * Vector3(0, 0, -g)});
  world.add_body(ground(0.8));
  BodyDef def = sphere({0, 0, 0.5});
  def.material.friction = 0.8;
  const BodyId planar = world.add_body(locked(def, in_plane));
  run(world, 60);
  const double way = 0.5 * (5.0 / 7) * g * std::sin(0.3);
  EXPECT_NEAR(std::abs(world.pose(planar).position.x()), way, 5e-3 * way);
  EXPECT_NEAR(std::abs(world.angular_velocity(planar).y()), std::abs(world.velocity(planar).x()) / 0.5, 1e-3);
}

TEST(MotionLocks, RollingFrictionHoldsADiscBackInItsPlane) {
  World world;
  world.add_body(ground(1));
  BodyDef def = sphere({0, 0, 0.5});
  def.material = {.friction = 1, .rolling_friction = 0.05};
  def.velocity = {2, 0, 0};
  def.angular_velocity = {0, 4, 0};
  const BodyId free = world.add_body(def);
  def.position.y() = 5;
  const BodyId planar = world.add_body(locked(def, in_plane));
  run(world, 90);
  const double slowed = 2 - 1.5 * 0.05 * g / (1.4 * 0.5);
  EXPECT_NEAR(world.velocity(free).x(), slowed, 1e-2);
  EXPECT_NEAR(world.velocity(planar).x(), slowed, 1e-2);
}

TEST(MotionLocks, LockedRotationNeverTurns) {
  World world;
  world.add_body(ground());
  BodyDef def = box({0, 0, 1}, {0.2, 0.2, 1});
  def.orientation = about({0, 0, 1}, 0.3);
  const BodyId tall = world.add_body(locked(def, no_turning));
  const Quaternion start = world.pose(tall).orientation;
  BodyDef ball = sphere({-3, 0.1, 1.7}, 0.3);
  ball.velocity = {20, 0, 1};
  world.add_body(ball);
  for (int i = 0; i < 120; ++i) {
    world.apply_force(tall, {0, 0, 0}, {1e4, -1e4, 1e4});
    world.step(dt);
    ASSERT_EQ(world.angular_velocity(tall), Vector3::Zero());
  }
  EXPECT_LT(world.pose(tall).orientation.angularDistance(start), 1e-12);
  EXPECT_GT(world.pose(tall).position.x(), 0.1) << "it was hit";
  EXPECT_NEAR(world.pose(tall).position.z(), 1, 1e-3) << "and stands";
}

// A carriage on a rail that is hit at an angle.
TEST(MotionLocks, MomentumAlongTheFreeAxisIsConserved) {
  for (const double friction : {0.0, 0.7}) {
    World world({.gravity = {0, 0, 0}});
    BodyDef carriage = locked(box({0, 0, 0}), {.linear = {false, true, true}, .angular = {true, true, true}});
    carriage.orientation = about({0, 0, 1}, 0.4);
    carriage.material.friction = friction;
    const BodyId rail = world.add_body(carriage);
    BodyDef def = sphere({-3, -1, 0.1}, 0.4);
    def.velocity = {6, 2, 0};
    def.angular_velocity = {3, 2, 1};
    def.material = {.friction = friction, .restitution = 0.5};
    const BodyId ball = world.add_body(def);
    const std::vector<BodyId> both = {rail, ball};
    const double before = momentum(world, both).x();
    run(world, 120);
    EXPECT_GT(world.velocity(rail).x(), 0.5);
    EXPECT_NEAR(momentum(world, both).x(), before, 1e-5 * before);
    EXPECT_EQ(world.pose(rail).position.y(), 0);
    EXPECT_EQ(world.pose(rail).position.z(), 0);
    EXPECT_EQ(world.velocity(rail).y(), 0);
    EXPECT_EQ(world.velocity(rail).z(), 0);
  }
}

// Along its rail a carriage answers as its mass, across it as if fixed: a ball that comes straight across bounces back
// as fast as it came, and one that hits a wedge does what energy and momentum along the rail say.
TEST(MotionLocks, ImpactOnACarriageHasItsClosedForm) {
  World world({.gravity = {0, 0, 0}});
  BodyDef carriage = locked(sphere({0, 0, 0}), {.linear = {false, true, true}});
  carriage.material = {.friction = 0, .restitution = 1};
  const BodyId rail = world.add_body(carriage);
  const double angle = 0.7;  // of the line of centres
  const Vector3 normal(std::cos(angle), std::sin(angle), 0);
  BodyDef def = sphere(-2 * normal);
  def.velocity = 5 * normal;
  def.material = carriage.material;
  const BodyId ball = world.add_body(def);
  run(world, 60);
  const double m = world.mass(ball), mass = world.mass(rail);
  const double impulse = 2 * 5 / (1 / m + normal.x() * normal.x() / mass);
  EXPECT_NEAR(world.velocity(rail).x(), impulse * normal.x() / mass, 1e-3);
  EXPECT_LT((world.velocity(ball) - (5 - impulse / m) * normal).norm(), 1e-3);
}

TEST(MotionLocks, LockedInEveryWayItIsAsFixed) {
  World world;
  const BodyId shelf =
      world.add_body(locked(box({0, 0, 0}), {.linear = {true, true, true}, .angular = {true, true, true}}));
  const BodyId crate = world.add_body(box({0.1, 0, 1}));
  BodyDef ram = box({-3, 0, 0}, {0.3, 0.3, 0.3});
  ram.velocity = {30, 0, 0};
  world.add_body(ram);
  run(world, 240);
  EXPECT_EQ(world.pose(shelf).position, Vector3::Zero());
  EXPECT_EQ(world.velocity(shelf), Vector3::Zero());
  EXPECT_NEAR(world.pose(crate).position.z(), 1, 2e-3);
  EXPECT_NEAR(contact_force(world, shelf, crate).z(), world.mass(crate) * g, 0.01 * world.mass(crate) * g);
}

// A plank on an axle: locks hold its middle, and it turns about one axis.
TEST(MotionLocks, PlankOnAnAxleTurnsUnderItsLoad) {
  World world;
  const Vector3 half(2, 0.5, 0.1);
  const BodyId plank =
      world.add_body(locked(box({0, 0, 0}, half), {.linear = {true, true, true}, .angular = {true, false, true}}));
  BodyDef load = sphere({1.5, 0, 0.3}, 0.2);
  load.material.friction = 0;
  const BodyId ball = world.add_body(load);
  const double inertia = box_inertia(world.mass(plank), half).y();
  const double m = world.mass(ball), arm = 1.5;
  run(world, 6);
  const double rate = m * g * arm / (inertia + m * arm * arm) * 6 * dt;
  EXPECT_NEAR(world.angular_velocity(plank).y(), rate, 0.02 * rate);
  run(world, 300);
  EXPECT_EQ(world.pose(plank).position, Vector3::Zero());
  EXPECT_EQ(world.angular_velocity(plank).x(), 0);
  EXPECT_LT(std::abs(world.angular_velocity(plank).y()), 10) << "nothing throws it about";
}

// A wheel that is hit straight through its axle has nothing to answer with, and doesn't spin up.
TEST(MotionLocks, WheelHitThroughItsAxleStands) {
  World world({.gravity = {0, 0, 0}});
  const BodyId wheel =
      world.add_body(locked(sphere({0, 0, 0}), {.linear = {true, true, true}, .angular = {true, false, true}}));
  BodyDef def = box({-3, 0, 0});
  def.velocity = {10, 0, 0};
  const BodyId ram = world.add_body(def);
  run(world, 120);
  EXPECT_EQ(world.pose(wheel).position, Vector3::Zero());
  EXPECT_LT(world.angular_velocity(wheel).norm(), 1);
  EXPECT_TRUE(world.quarantined().empty());
  EXPECT_TRUE(world.pose(ram).position.allFinite());
}

// Boxes in all kinds of poses, some of which push others out of the plane. Heaps that come to lie otherwise tremble
// more or less: of a few the mean tells.
TEST(MotionLocks, PlanarPilesStayInTheirPlane) {
  constexpr int piles = 8;
  double fastest_of_all = 0;
  for (int pile = 0; pile < piles; ++pile) {
    World world;
    world.add_body(ground());
    std::vector<BodyId> ids;
    std::vector<Pose> starts;
    for (int i = 0; i < 30; ++i) {
      const double shift = 0.2 * std::sin(7.0 * i);
      BodyDef def = box({(1.1 + 0.02 * pile) * (i % 6) + 0.1 * (i / 6), shift, 1.2 + 1.3 * (i / 6)}, {0.5, 0.3, 0.4});
      def.orientation = about({std::sin(3.0 * i), std::cos(5.0 * i), 0.5}, 0.3 * i);
      ids.push_back(world.add_body(locked(def, in_plane)));
      starts.push_back(world.pose(ids.back()));
    }
    for (int i = 0; i < 600; ++i) {
      world.step(dt);
      for (std::size_t k = 0; k < ids.size(); ++k) {
        ASSERT_EQ(world.pose(ids[k]).position.y(), starts[k].position.y()) << "step " << i << ", body " << k;
        ASSERT_EQ(world.velocity(ids[k]).y(), 0);
        ASSERT_EQ(world.angular_velocity(ids[k]).x(), 0);
        ASSERT_EQ(world.angular_velocity(ids[k]).z(), 0);
      }
    }
    double fastest = 0;
    for (std::size_t k = 0; k < ids.size(); ++k) {
      const Quaternion turned = world.pose(ids[k]).orientation * starts[k].orientation.conjugate();
      EXPECT_LT(std::hypot(turned.x(), turned.z()), 1e-9);
      EXPECT_GT(world.pose(ids[k]).position.z(), 0.2) << "nothing sinks through the ground";
      fastest = std::max(fastest, world.velocity(ids[k]).norm());
    }
    fastest_of_all += fastest;
  }
  EXPECT_LT(fastest_of_all / piles, 0.1) << "piles come to rest";
}

TEST(MotionLocks, PlanarStackStands) {
  World world;
  world.add_body(ground());
  std::vector<BodyId> ids;
  for (int i = 0; i < 12; ++i) ids.push_back(world.add_body(locked(box({0, 0, i + 0.5}), in_plane)));
  run(world, 600);
  for (int i = 0; i < 12; ++i) {
    const Pose pose = world.pose(ids[static_cast<std::size_t>(i)]);
    EXPECT_EQ(pose.position.y(), 0);
    EXPECT_NEAR(pose.position.x(), 0, 1e-3);
    EXPECT_NEAR(pose.position.z(), i + 0.5, 0.03);
  }
  EXPECT_NEAR(contact_force(world, ids[0], ids[1]).z(), 11 * 1000 * g, 0.01 * 11 * 1000 * g);
}

// Balls beside the plane's middle meet as discs do, where they are cut.
TEST(MotionLocks, BallsOutOfThePlaneMeetWhereItCutsThem) {
  World world;
  BodyDef post = sphere({0, 0.6, 0}, 1);
  post.type = BodyType::Static;
  world.add_body(post);
  const BodyId ball = world.add_body(locked(sphere({0, 0, 1.9}, 1), in_plane));
  run(world, 120);
  EXPECT_NEAR(world.pose(ball).position.z(), std::sqrt(4 - 0.36), 2e-3) << "balanced on top";
  EXPECT_EQ(world.pose(ball).position.y(), 0);
}

// A contact that pushes only across the plane is ignored.
TEST(MotionLocks, WallsAcrossThePlaneHoldNothing) {
  World world;
  world.add_body(static_box({0, 1, 0}, {5, 0.5, 5}));
  BodyDef def = locked(box({0, 0.02, 0}), in_plane);  // 2 cm deep in it
  def.velocity = {1, 0, 0};
  const BodyId id = world.add_body(def);
  run(world, 60);
  EXPECT_NEAR(world.velocity(id).x(), 1, 1e-6);
  EXPECT_NEAR(world.velocity(id).z(), -g, 1e-3);
}

// The plane of a face turns with that, but what pushes on a planar body stays in its plane.
TEST(MotionLocks, FacesThatTurnPushNothingOutOfItsPlane) {
  for (const int substeps : {1, 4}) {
    World world({.gravity = Vector3::Zero(), .settings = {.substeps = substeps, .sleeping = false}});
    const BodyId plate = world.add_body({.shape = Box{{1, 1, 0.1}}, .angular_velocity = {2, 0.5, 0}, .density = 1000});
    const BodyId planar = world.add_body({.shape = Box{{0.2, 0.2, 0.2}},
                                          .position = {0.3, 0, 0.31},
                                          .velocity = {0, 0, -1},
                                          .locks = in_plane});
    for (int step = 0; step < 20; ++step) {
      world.step(dt);
      ASSERT_EQ(world.velocity(planar).y(), 0) << substeps << ' ' << step;
    }
    EXPECT_GT(world.velocity(plate).norm(), 0) << substeps;  // they have met
  }
}

TEST(MotionLocks, FastBodiesStopAtWallsWithoutLeavingTheirPlane) {
  World world;
  world.add_body(static_box({10, 0, 0}, {0.05, 5, 5}));
  BodyDef def = locked(sphere({0, 0.3, 0}, 0.1), in_plane);
  def.velocity = {500, 100, 0};
  const BodyId id = world.add_body(def);
  run(world, 10);
  EXPECT_LT(world.pose(id).position.x(), 10);
  EXPECT_EQ(world.pose(id).position.y(), 0.3);
}

TEST(MotionLocks, ContactResidualKnowsOfThem) {
  World world({.settings = {.iterations = 60, .keep_contact_problem = true}});
  world.add_body(ground());
  BodyDef def = box({0, 0, 0.5});
  def.orientation = about({0, 0, 1}, 0.2);
  def.velocity = {1, 0, 0};
  world.add_body(locked(def, {.linear = {false, true, false}}));
  def.position = {5, 1, 0.5};
  world.add_body(locked(def, in_plane));
  run(world, 5);
  EXPECT_LT(measure_contact_residual(world.contact_problem()).relative, 0.02);
}

TEST(MotionLocks, StaticAndKinematicBodiesHaveNone) {
  World world;
  BodyDef def = locked(box({0, 0, 0}), in_plane);
  def.type = BodyType::Kinematic;
  def.velocity = {0, 1, 0};
  const BodyId id = world.add_body(def);
  run(world, 60);
  EXPECT_NEAR(world.pose(id).position.y(), 1, 1e-9);
}

}  // namespace
}  // namespace atl::test::motion_locks_test
