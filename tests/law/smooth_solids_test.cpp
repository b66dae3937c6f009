// How ellipsoids and tapered capsules move: as spheres and capsules where they are such, and by closed forms of what
// rocks and rolls.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "support/bodies.h"
#include "support/min_turn.h"

namespace atl::test::smooth_solids_test {
namespace {

const Quaternion on_its_side(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3::UnitX()));

// A motion of which two shapes are to have the same course.
struct Course {
  std::string name;
  std::vector<BodyDef> fixed;
  std::vector<BodyDef> bodies;
};

std::vector<Course> courses(const Quaternion& lying) {
  const BodyDef plane = ground();
  const BodyDef slab = static_box({0, 0, -0.5}, {20, 20, 0.5});
  const std::vector<Vector3> corners = {{-20, -20, 0}, {20, -20, 0}, {20, 20, 0}, {-20, 20, 0}};
  const std::vector<TriangleMesh::Indices> halves = {{0, 1, 2}, {0, 2, 3}};
  const BodyDef mesh{.type = BodyType::Static, .shape = TriangleMesh(corners, halves)};
  const auto at = [&](const Vector3& place, const Vector3& velocity = Vector3::Zero()) {
    return BodyDef{.position = place, .orientation = lying, .velocity = velocity};
  };
  std::vector<Course> all;
  for (const auto& [name, floor] : {std::pair{"plane", plane}, {"slab", slab}, {"mesh", mesh}}) {
    all.push_back({std::string("drop on ") + name, {floor}, {at({0.3, 0.2, 1})}});
    all.push_back({std::string("roll on ") + name, {floor}, {at({0.3, 0.2, 0.3}, {0, 2, 0})}});
    all.push_back(
        {std::string("stack on ") + name, {floor}, {at({0.3, 0.2, 0.3}), at({0.3, 0.2, 0.9}), at({0.3, 0.2, 1.5})}});
  }
  return all;
}

void expect_same_course(const Course& course, const Shape& shape, const Shape& twin, double tolerance) {
  World world, other;
  std::vector<BodyId> ids;
  for (const BodyDef& def : course.fixed) {
    world.add_body(def);
    other.add_body(def);
  }
  for (BodyDef def : course.bodies) {
    def.shape = shape;
    ids.push_back(world.add_body(def));
    def.shape = twin;
    ASSERT_EQ(other.add_body(def), ids.back());
  }
  double off = 0;
  for (int step = 0; step < 180; ++step) {
    world.step(dt);
    other.step(dt);
    for (const BodyId id : ids) off = std::max(off, (world.pose(id).position - other.pose(id).position).norm());
  }
  EXPECT_LT(off, tolerance) << course.name;
}

TEST(SmoothSolids, MoveAsSpheresAndCapsulesWhereTheyAreSuch) {
  constexpr double tolerance = 3e-4;  // m, in 3 s; balls are the only ones that meet where they will touch
  for (const Course& course : courses(Quaternion::Identity())) {
    expect_same_course(course, Ellipsoid{Vector3::Constant(0.3)}, Sphere{0.3}, tolerance);
  }
  for (const Course& course : courses(on_its_side)) {
    expect_same_course(course, TaperedCapsule{{0.3, 0.3}, 0.4}, Capsule{0.3, 0.4}, tolerance);
  }
}

World plane_world(ContactSolver contacts) {
  World world({.settings = {.contact_solver = contacts, .sleeping = false}});
  world.add_body({.type = BodyType::Static, .shape = HalfSpace{}, .material = {.friction = 1}});
  return world;
}

TEST(SmoothSolids, BallLikeEllipsoidsRollOn) {
  for (const ContactSolver contacts : {ContactSolver::Iterative, ContactSolver::Direct}) {
    for (const double step : {1.0 / 60, 1.0 / 240}) {
      // The second rolls about the axis of a spheroid, the third is a ball.
      for (const Vector3& half_axes : {Vector3(0.3, 0.5, 0.5), Vector3(0.7, 0.5, 0.5), Vector3(0.5, 0.5, 0.5)}) {
        World world = plane_world(contacts);
        const BodyId body = world.add_body({.shape = Ellipsoid{half_axes},
                                            .position = {0, 0, 0.5},
                                            .velocity = {0, 2, 0},
                                            .angular_velocity = {-4, 0, 0},
                                            .material = {.friction = 1}});
        for (int i = 0; i < 5 / step; ++i) world.step(step);
        EXPECT_LT((world.velocity(body) - Vector3(0, 2, 0)).norm(), 2e-3) << half_axes.x() << ", dt " << step;
        EXPECT_LT((world.angular_velocity(body) - Vector3(-4, 0, 0)).norm(), 4e-3) << half_axes.x() << ", dt " << step;
        EXPECT_NEAR(world.pose(body).position.z(), 0.5, 2e-3) << half_axes.x() << ", dt " << step;
      }
    }
  }
}

double energy(const World& world, BodyId body, const Shape& shape) {
  const MassProperties solid = mass_properties(shape);
  const double density = world.mass(body) / solid.mass;
  const Vector3 spin = world.pose(body).orientation.conjugate() * world.angular_velocity(body);
  return 0.5 * world.mass(body) * world.velocity(body).squaredNorm() + 0.5 * density * spin.dot(solid.inertia * spin) +
         world.mass(body) * g * world.centre_of_mass(body).z();
}

struct Swings {
  int crossings = 0;
  double length = 0;  // s, of one
  double kept = 0;    // of the energy that was left after the second swing, after the last
};

// Rocks about x from a small lean on, at rest with its centre of mass at `low`.
Swings rock(ContactSolver contacts, double step, BodyDef def, const Shape& inertia, double low, double lean) {
  World world = plane_world(contacts);
  def.orientation = Quaternion(Eigen::AngleAxisd(lean, Vector3::UnitX()));
  def.material.friction = 1;
  const BodyId body = world.add_body(def);
  const double rest = world.mass(body) * g * low;
  constexpr int swings = 10, settled = 2;
  Swings found;
  double last = lean, from = 0, at_start = 0;
  for (int i = 1; found.crossings < 2 * swings + 1 && i < 40 / step; ++i) {
    world.step(step);
    const Vector3 up = world.pose(body).orientation * Vector3::UnitZ();
    const double now = std::atan2(-up.y(), up.z());
    if (now * last < 0) {
      const double time = step * (i - now / (now - last));
      if (found.crossings == 0) from = time;
      found.length = (time - from) / swings;
      if (found.crossings == 2 * settled) at_start = energy(world, body, inertia) - rest;
      ++found.crossings;
    }
    last = now;
  }
  EXPECT_EQ(found.crossings, 2 * swings + 1);
  found.kept = (energy(world, body, inertia) - rest) / at_start;
  return found;
}

// On its flat side, of the radius of curvature r = a^2 / c, a spheroid rocks with w^2 = m g (r - c) / (I + m c^2). It
// keeps as much of its energy as a ball of that radius with the same weight as low, whose contact always was exact.
TEST(SmoothSolids, SpheroidsRockAsFastAsTheyAreFlat) {
  for (const ContactSolver contacts : {ContactSolver::Iterative, ContactSolver::Direct}) {
    for (const double step : {1.0 / 60, 1.0 / 240}) {
      for (const double c : {0.35, 0.45}) {
        const double a = 0.5, lean = 0.05, radius = a * a / c;
        const Ellipsoid shape{{a, a, c}};
        const MassProperties solid = mass_properties(shape);
        const double height = std::hypot(a * std::sin(lean), c * std::cos(lean));
        const Swings swings = rock(contacts, step, {.shape = shape, .position = {0, 0, height}}, shape, c, lean);
        const BodyDef ball{.shape = Sphere{radius},
                           .position = {0, 0, radius},
                           .mass = solid.mass,
                           .inertia = solid.inertia,
                           .centre_of_mass = Vector3(0, 0, c - radius)};
        const Swings of_ball = rock(contacts, step, ball, shape, c, lean);
        const double inertia = (a * a + c * c) / 5;  // per kg
        const double w = std::sqrt(g * (radius - c) / (inertia + c * c));
        const std::string what = "c " + std::to_string(c) + ", dt " + std::to_string(step) + ", solver " +
                                 std::to_string(static_cast<int>(contacts));
        EXPECT_NEAR(2 * std::numbers::pi / swings.length / w, 1, 0.01) << what;
        EXPECT_NEAR(swings.length / of_ball.length, 1, 0.01) << what;
        EXPECT_GT(swings.kept, of_ball.kept - 0.02) << what;
        EXPECT_LT(swings.kept, 1.01) << what;
      }
    }
  }
}

// An egg that rolls about axes that aren't its own gains no energy, and by substeps loses little of it.
TEST(SmoothSolids, TriaxialEllipsoidsGainNoEnergy) {
  for (const ContactSolver contacts : {ContactSolver::Iterative, ContactSolver::Direct}) {
    for (const double step : {1.0 / 60, 1.0 / 240}) {
      World world = plane_world(contacts);
      const Ellipsoid shape{{0.5, 0.4, 0.3}};
      const Quaternion turn(Eigen::AngleAxisd(0.3, Vector3(1, 2, 0.5).normalized()));
      const double height = shape.half_axes.cwiseProduct(turn.conjugate() * Vector3::UnitZ()).norm();
      const BodyId body = world.add_body(
          {.shape = shape, .position = {0, 0, height}, .orientation = turn, .material = {.friction = 1}});
      const double rest = world.mass(body) * g * shape.half_axes.minCoeff();
      const double before = energy(world, body, shape) - rest;
      double max = 0;
      for (int i = 0; i < 10 / step; ++i) {
        world.step(step);
        max = std::max(max, energy(world, body, shape) - rest);
      }
      const std::string what = "dt " + std::to_string(step) + ", solver " + std::to_string(static_cast<int>(contacts));
      EXPECT_LT(max / before, 1.01) << what;
      if (contacts == ContactSolver::Iterative) {
        EXPECT_GT((energy(world, body, shape) - rest) / before, 0.8) << what;
      }
    }
  }
}

// The cone around a tapered capsule's balls rolls about its apex, which stays where it is. With half the angle at the
// apex, s, a spin w about the line of contact carries the axis around by w tan s.
TEST(SmoothSolids, TaperedCapsulesRollAboutTheirApex) {
  for (const ContactSolver contacts : {ContactSolver::Iterative, ContactSolver::Direct}) {
    for (const double step : {1.0 / 60, 1.0 / 240}) {
      World world = plane_world(contacts);
      const TaperedCapsule shape{{0.3, 0.1}, 0.4};
      const double s = std::asin(0.25), spin = 2;
      // From the apex, at the origin, the axis leads up along x by the angle s, to the larger ball first.
      const Vector3 axis(std::cos(s), 0, std::sin(s));
      const Vector3 middle = (0.2 / std::sin(s)) * axis;
      const Quaternion turn(min_turn(Vector3::UnitZ(), -axis));
      const Vector3 about(spin, 0, 0);
      const double centre = mass_properties(shape).centre.z();
      const BodyId body = world.add_body({.shape = shape,
                                          .position = middle,
                                          .orientation = turn,
                                          .velocity = about.cross(middle - centre * axis),
                                          .angular_velocity = about,
                                          .material = {.friction = 1}});
      // An eighth of the way around. Contacts along a line are where they were as the step began, so what turns about
      // the normal, here as a cone does, is sped up by the step times a rate: a quarter of it with a quarter of the
      // step.
      const double angle = std::numbers::pi / 4;
      const int steps = static_cast<int>(std::lround(angle / (spin * std::tan(s)) / step));
      double off = 0;
      for (int i = 0; i < steps; ++i) {
        world.step(step);
        const Pose pose = world.pose(body);
        off = std::max(off, (pose.position + pose.orientation * Vector3(0, 0, 0.8)).norm());
      }
      const std::string what = "dt " + std::to_string(step) + ", solver " + std::to_string(static_cast<int>(contacts));
      const Vector3 place = world.pose(body).position;
      EXPECT_LT(off, 3e-3) << what;
      EXPECT_NEAR(world.angular_velocity(body).norm(), spin, 6 * step * spin) << what;
      EXPECT_NEAR(place.head<2>().norm(), middle.x(), 2e-3) << what;
      EXPECT_NEAR(place.z(), middle.z(), 2e-3) << what;
      EXPECT_NEAR(std::atan2(-place.y(), place.x()), angle, 4 * step * angle) << what;
    }
  }
}

}  // namespace
}  // namespace atl::test::smooth_solids_test
