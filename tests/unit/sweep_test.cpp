// Times of impact against closed forms, and fast thin things against thin walls.

#include <collision/continuous/sweep.h>
#include <collision/narrowphase/distance.h>
#include <collision/shapes/height_field.h>
#include <collision/shapes/hull.h>
#include <collision/shapes/shape.h>
#include <collision/shapes/triangle_mesh.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "support/random.h"
#include "surface_points.h"

namespace atl::collision {
namespace {

using test::Random;

const Quaternion unturned = Quaternion::Identity();
constexpr double dt = 1.0 / 60;

double distance_at(const Shape& first, const Motion& a, const Shape& second, const Motion& b, double t) {
  return closest_points(first, second, relative(a.at(t), b.at(t))).distance;
}

Motion random_motion(const Vector3& from, double speed, double spin, const Shape& shape, Random& random) {
  Motion motion;
  motion.centre = random.vector(0.3 * shape.bounding_radius);
  motion.start = {from, random.rotation()};
  motion.translation = -speed * from.normalized() + random.vector(0.3 * speed);
  motion.rotation = random.real(0, spin) * random.direction();
  return motion;
}

TEST(Motion, TurnsAboutItsCentreAtConstantSpeed) {
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    Motion motion;
    motion.centre = random.vector(1);
    motion.start = {random.vector(10), random.rotation()};
    motion.translation = random.vector(5);
    const double angle = random.magnitude(1e-8, 100);
    const Vector3 axis = random.direction();
    motion.rotation = angle * axis;
    const double t = random.real(0, 1);
    const Pose pose = motion.at(t);
    const Vector3 centre = motion.start.position + motion.start.orientation * motion.centre + t * motion.translation;
    EXPECT_LT((pose.position + pose.orientation * motion.centre - centre).norm(), 1e-13 * (1 + centre.norm()));
    const Eigen::Quaterniond expected(Eigen::AngleAxisd(t * angle, axis) *
                                      Eigen::Quaterniond(motion.start.orientation));
    EXPECT_LT(expected.angularDistance(Eigen::Quaterniond(pose.orientation)), 1e-7);
    EXPECT_LT((expected.toRotationMatrix() - pose.orientation.toRotationMatrix()).norm(), 1e-14 * (10 + angle));
  }
}

TEST(Motion, BetweenPosesEndsAtTheLast) {
  Random random(2);
  for (int i = 0; i < 1000; ++i) {
    const Pose start{random.vector(10), random.rotation()};
    const Pose end{random.vector(10), random.rotation()};
    const Motion motion = Motion::between(start, end, random.vector(1));
    EXPECT_LT((motion.at(1).position - end.position).norm(), 1e-13);
    EXPECT_LT((motion.at(1).orientation.toRotationMatrix() - end.orientation.toRotationMatrix()).norm(), 1e-13);
    EXPECT_LE(motion.rotation.norm(), std::numbers::pi + 1e-12);
  }
}

// Two balls: |p + t v| = r1 + r2 + goal is a quadratic.
TEST(Sweep, BallsMeetWhenTheQuadraticSays) {
  Random random(3);
  int hits = 0;
  for (int i = 0; i < 5000; ++i) {
    const double r1 = random.magnitude(0.01, 1);
    const double r2 = random.magnitude(0.01, 1);
    const SweepGoal goal{random.chance(0.5) ? 0 : 0.1 * r1, 1e-9};
    const double reach = r1 + r2 + goal.separation;
    const Vector3 apart = random.magnitude(1.01, 20) * reach * random.direction();
    const Motion first = random_motion(apart, random.real(0, 40) * reach, 3, Shape::sphere(r1), random);
    Motion second = Motion::still({Vector3::Zero(), random.rotation()});
    second.translation = random.vector(3);
    // The spin about a point off the first's middle moves it: only pure translation has this closed form.
    Motion straight = first;
    straight.centre = Vector3::Zero();
    const Vector3 v = straight.translation - second.translation;
    const double a = v.squaredNorm();
    const double b = v.dot(apart);
    const double square = b * b - a * (apart.squaredNorm() - reach * reach);
    if (std::abs(square) < 1e-6 * b * b) continue;
    const double expected = square < 0 || b > 0 ? 2 : (-b - std::sqrt(square)) / a;
    if (std::abs(expected - 1) < 1e-6) continue;
    SweepHit hit;
    const bool found = sweep(Shape::sphere(r1), straight, Shape::sphere(r2), second, goal, 1, hit);
    ASSERT_EQ(found, expected < 1);
    if (!found) continue;
    ++hits;
    EXPECT_LE(hit.t, expected);
    const Vector3 place = apart + expected * v;
    // The sweep stops at the tolerance, which is this much of the way at this angle of approach.
    const double closing = -v.dot(place.normalized());
    EXPECT_GT(hit.t, expected - 2 * goal.tolerance / closing);
    EXPECT_LT((hit.normal + place.normalized()).norm(), 1e-4);
    EXPECT_TRUE(hit.converged);
    EXPECT_FALSE(hit.started_overlapping);
  }
  EXPECT_GT(hits, 1000);
}

// A stick (box) whose end turns down onto a plate: touches when half_length * sin(angle) = height.
TEST(Sweep, TurningStickTouchesWhenItsSineSays) {
  const double half = 1;
  const Shape stick = Shape::box({half, 0.01, 1e-6});
  const Shape plate = Shape::box({10, 10, 0.5});
  const Shape ground = Shape::half_space(Vector3::UnitZ(), 0);
  for (const double height : {0.1, 0.5, 0.9}) {
    for (const double angle : {1.5, 3.0, 20.0}) {
      Motion turning = Motion::still({Vector3(0, 0, height), unturned});
      turning.rotation = Vector3(0, angle, 0);
      const Motion below = Motion::still({Vector3(0, 0, -0.5), unturned});
      const double expected = std::asin(height / half) / angle;
      SweepHit hit;
      ASSERT_EQ(sweep(stick, turning, plate, below, {0, 1e-6}, 1, hit), expected < 1);
      if (expected >= 1) continue;
      EXPECT_NEAR(hit.t, expected, 1e-5);
      EXPECT_LE(hit.t, expected);
      EXPECT_LT((hit.normal + Vector3::UnitZ()).norm(), 1e-5);
      ASSERT_TRUE(sweep(stick, turning, ground, Motion::still({Vector3::Zero(), unturned}), {0, 1e-6}, 1, hit));
      EXPECT_NEAR(hit.t, expected, 1e-5);
      EXPECT_LT((hit.normal + Vector3::UnitZ()).norm(), 1e-12);
      EXPECT_NEAR(hit.point.z(), 0, 1e-12);
      EXPECT_NEAR(std::abs(hit.point.x()), std::cos(std::asin(height)), 1e-5);
    }
  }
}

// Up to the time found nothing comes nearer than the goal, and there it is just reached.
TEST(Sweep, SolidsStayApartUpToTheTimeFound) {
  Random random(4);
  const Hull hull = box_hull({0.3, 0.4, 0.5});
  const Shape shapes[] = {Shape::sphere(0.4),        Shape::capsule(0.1, 0.8), Shape::box({0.05, 0.3, 1}),
                          Shape::cylinder(0.5, 0.1), Shape::cone(0.4, 0.5),    Shape::convex_hull(hull)};
  int hits = 0;
  int misses = 0;
  int early = 0;  // while turning in a gap hardly wider than the goal
  for (int i = 0; i < 1500; ++i) {
    const Shape& first = shapes[i % 6];
    const Shape& second = shapes[(i / 6) % 6];
    const Motion a = random_motion(random.real(1.5, 4) * random.direction(), random.real(0, 6), 6, first, random);
    const Motion b = random_motion(0.1 * random.direction(), random.real(0, 1), 6, second, random);
    if (distance_at(first, a, second, b, 0) < 0.02) continue;
    const SweepGoal goal{random.chance(0.5) ? 0.01 : 0, 1e-6};
    SweepHit hit;
    const bool found = sweep(first, a, second, b, goal, 1, hit);
    const double end = found ? hit.t : 1;
    for (int k = 0; k <= 40; ++k) {
      EXPECT_GE(distance_at(first, a, second, b, end * k / 40), goal.separation - 1e-12);
    }
    if (!found) {
      ++misses;
      continue;
    }
    ++hits;
    if (!hit.converged) {
      ++early;
      continue;
    }
    EXPECT_NEAR(distance_at(first, a, second, b, hit.t), goal.separation, 1.01e-6);
    // The point is on the second, at that distance from the first, along the normal.
    const Pose pose = b.at(hit.t);
    const Vector3 seen = pose.orientation.conjugate() * (hit.point - pose.position);
    EXPECT_LT(closest_points(second, {seen, seen, seen}).distance, 1e-7);
    const Pose from = a.at(hit.t);
    const Vector3 near = from.orientation.conjugate() * (hit.point - hit.separation * hit.normal - from.position);
    EXPECT_LT(closest_points(first, {near, near, near}).distance, 1e-6);
  }
  EXPECT_GT(hits, 300);
  EXPECT_GT(misses, 300);
  EXPECT_LT(early, hits / 100);
}

// The wall is 2 cm thick, the step 3.3 m long: every phase of it, against a wall of every kind.
class Bullets : public testing::Test {
 protected:
  Bullets() {
    const std::vector<Vector3> corners{{0.01, -5, -5}, {0.01, 5, -5}, {0.01, 5, 5}, {0.01, -5, 5}};
    const std::vector<std::array<std::uint32_t, 3>> triangles{{0, 1, 2}, {0, 2, 3}};
    mesh_ = std::get<TriangleMesh>(build_triangle_mesh(corners, triangles));
    field_ = std::get<HeightField>(build_height_field(11, 11, 1, 1, std::vector<double>(121, 0.01)));
    hull_ = box_hull({0.01, 5, 5});
    const Quaternion upright(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3::UnitY()));
    walls_ = {{Shape::box({0.01, 5, 5}), {Vector3::Zero(), unturned}},
              {Shape::convex_hull(hull_), {Vector3::Zero(), unturned}},
              {Shape::half_space(Vector3::UnitX(), 0.01), {Vector3::Zero(), unturned}},
              {Shape::triangle_mesh(mesh_), {Vector3::Zero(), unturned}},
              {Shape::height_field(field_), {Vector3(0, -5, 5), upright}}};
  }

  // From x > 0, through the wall within the step unless stopped.
  void expect_stopped(const Shape& bullet, const Motion& motion) {
    for (const auto& [wall, pose] : walls_) {
      SweepHit hit;
      ASSERT_TRUE(sweep(bullet, motion, wall, Motion::still(pose), {0.001, 1e-5}, 1, hit)) << int(wall.kind);
      EXPECT_FALSE(hit.started_overlapping);
      EXPECT_TRUE(hit.converged);
      // On this side, and as near as wanted.
      const Pose stopped = motion.at(hit.t);
      const Vector3 seen = stopped.orientation.conjugate() * -Vector3::UnitX();
      const double gap = stopped.position.x() - 0.01 - reach_along(bullet, seen);
      EXPECT_NEAR(gap, 0.001, 1.1e-5) << int(wall.kind);
      // At an edge between triangles the tolerance leaves the normal sqrt(2 * tolerance / radius) of a tilt.
      EXPECT_LT((hit.normal + Vector3::UnitX()).norm(), is_surface(wall.kind) ? 0.03 : 1e-6) << int(wall.kind);
    }
  }

  struct Wall {
    Shape shape;
    Pose pose;
  };
  TriangleMesh mesh_;
  HeightField field_;
  Hull hull_;
  std::vector<Wall> walls_;
};

TEST_F(Bullets, SpinningStickNeverGoesThrough) {
  Random random(6);
  for (const Shape& stick :
       {Shape::box({0.25, 0.005, 0.005}), Shape::capsule(0.005, 0.245), Shape::cylinder(0.005, 0.25)}) {
    for (int i = 0; i < 1000; ++i) {
      const double phase = 0.27 + 2.75 * i / 1000;
      Motion motion = Motion::still({Vector3(phase, random.real(-1, 1), random.real(-1, 1)), random.rotation()});
      motion.translation = 200 * dt * Vector3(-1, random.real(-0.2, 0.2), random.real(-0.2, 0.2));
      motion.rotation = 100 * dt * random.direction();
      expect_stopped(stick, motion);
    }
  }
}

TEST_F(Bullets, SurfacesStopOnlyWhatComesFromTheFront) {
  const Shape ball = Shape::sphere(0.05);
  SweepHit hit;
  for (const auto& [wall, pose] : walls_) {
    if (!is_surface(wall.kind)) continue;
    // From behind; away, from a place that is nearer than the goal; and along, there.
    const Motion from_behind = Motion::along({Vector3(-1, 0, 0), unturned}, Vector3(3, 0, 0));
    EXPECT_FALSE(sweep(ball, from_behind, wall, Motion::still(pose), {0.001, 1e-5}, 1, hit));
    const Motion away = Motion::along({Vector3(0.0605, 0, 0), unturned}, Vector3(3, 0, 0));
    EXPECT_FALSE(sweep(ball, away, wall, Motion::still(pose), {0.001, 1e-5}, 1, hit));
    const Motion overlapping_away = Motion::along({Vector3(0.05, 0, 0), unturned}, Vector3(3, 0, 0));
    EXPECT_FALSE(sweep(ball, overlapping_away, wall, Motion::still(pose), {0.001, 1e-5}, 1, hit));
    const Motion into = Motion::along({Vector3(0.05, 0, 0), unturned}, Vector3(-3, 0, 0));
    ASSERT_TRUE(sweep(ball, into, wall, Motion::still(pose), {0.001, 1e-5}, 1, hit));
    EXPECT_TRUE(hit.started_overlapping);
    EXPECT_EQ(hit.t, 0);
  }
}

// The wall comes to the ball as the ball would to the wall.
TEST_F(Bullets, MovingWallsHitWhatStands) {
  const Shape ball = Shape::sphere(0.05);
  for (const auto& [wall, pose] : walls_) {
    SweepHit hit;
    const Motion rest = Motion::still({Vector3(2, 0.3, 0.2), unturned});
    ASSERT_TRUE(sweep(ball, rest, wall, Motion::along(pose, Vector3(3, 0, 0)), {0, 1e-7}, 1, hit)) << int(wall.kind);
    EXPECT_NEAR(hit.t, (2 - 0.05 - 0.01) / 3, 1e-7);
    // Swung about the origin by a right angle: reaches the ball where its front passes at an angle.
    Motion swing = Motion::still(pose);
    swing.centre = pose.orientation.conjugate() * -pose.position;
    swing.rotation = Vector3(0, 0, std::numbers::pi / 2);
    const Motion beside = Motion::still({Vector3(1, 2, 0), unturned});
    // The front meets the ball at (x, y) = (1, 2) when x cos(a) + y sin(a) = 0.06: never within a right angle, but
    // turning the other way.
    EXPECT_FALSE(sweep(ball, beside, wall, swing, {0, 1e-7}, 1, hit)) << int(wall.kind);
    swing.rotation = -swing.rotation;
    ASSERT_TRUE(sweep(ball, beside, wall, swing, {0, 1e-7}, 1, hit)) << int(wall.kind);
    const double expected = std::acos(0.06 / std::sqrt(5.0)) - std::atan2(2.0, 1.0);
    EXPECT_NEAR(hit.t, expected / (std::numbers::pi / 2), 1e-6) << int(wall.kind);
  }
}

// A time that is looked up to takes away what comes later and changes nothing else. Solids that all but touch, where
// distances of round ones are known to a part of the gap only.
TEST(Sweep, ALimitTakesAwayOnlyWhatComesAfter) {
  Random random(9);
  const Hull hull = box_hull({0.3, 0.4, 0.5});
  const Shape shapes[] = {Shape::sphere(0.4),        Shape::capsule(0.1, 0.8), Shape::box({0.05, 0.3, 1}),
                          Shape::cylinder(0.5, 0.1), Shape::cone(0.4, 0.5),    Shape::convex_hull(hull)};
  int hits = 0;
  for (int i = 0; i < 7200; ++i) {
    const Shape& first = shapes[i % 6];
    const Shape& second = shapes[(i / 6) % 6];
    const Motion b = Motion::still({random.vector(1), random.rotation()});
    Pose start{b.start.position + 3 * random.direction(), random.rotation()};
    const ClosestPoints apart = closest_points(first, second, relative(start, b.start));
    const Vector3 normal = start.orientation * apart.normal;
    start.position += (apart.distance - random.magnitude(1e-10, 1e-6)) * normal;
    Motion a = Motion::along(start, random.real(0.1, 5) * (normal + random.vector(0.5)));
    if (random.chance(0.3)) a.rotation = random.vector(3);
    const SweepGoal goal{0, random.magnitude(1e-8, 1e-7)};
    SweepHit hit;
    if (!sweep(first, a, second, b, goal, 1, hit)) continue;
    ++hits;
    for (const double limit : {0.0, 1e-12, 1e-9, 1e-7, 0.999 * hit.t, 1.001 * hit.t}) {
      SweepHit limited;
      ASSERT_EQ(sweep(first, a, second, b, goal, limit, limited), hit.t <= limit) << hit.t << " of " << limit;
      if (hit.t <= limit) {
        EXPECT_EQ(limited.t, hit.t);
      }
    }
  }
  EXPECT_GT(hits, 3000);
}

// Turning in a gap that is just wide enough takes many small steps; the answer stays safe.
TEST(Sweep, GrazingStaysSafe) {
  Random random(8);
  const Shape stick = Shape::capsule(0.01, 0.5);
  const Shape wall = Shape::box({0.1, 2, 2});
  for (int i = 0; i < 200; ++i) {
    Motion turning = Motion::still({Vector3(0.1 + 0.51 + random.magnitude(1e-8, 1e-3), 0, 0), random.rotation()});
    turning.rotation = Vector3(0, 20, 0);
    SweepHit hit;
    const Motion still = Motion::still({Vector3::Zero(), unturned});
    const bool found = sweep(stick, turning, wall, still, {0, 1e-7}, 1, hit);
    if (!found) continue;
    for (int k = 0; k <= 50; ++k) EXPECT_GT(distance_at(stick, turning, wall, still, hit.t * k / 50), 0);
  }
}

}  // namespace
}  // namespace atl::collision
