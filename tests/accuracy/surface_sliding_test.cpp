// Solids on surfaces of many triangles move as on the one plane that the triangles make up: nothing catches on an
// edge between them, and nothing hops.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "support/bodies.h"

namespace atl::test::surface_sliding_test {
namespace {

using Height = std::function<double(double, double)>;

// Two triangles a cell over [-reach, reach]^2, turned as a whole.
TriangleMesh grid(int cells, double reach, const Height& height, const Quaternion& turn = Quaternion::Identity()) {
  std::vector<Vector3> vertices;
  std::vector<TriangleMesh::Indices> triangles;
  for (int j = 0; j <= cells; ++j) {
    for (int i = 0; i <= cells; ++i) {
      const double x = reach * (2.0 * i / cells - 1);
      const double y = reach * (2.0 * j / cells - 1);
      vertices.push_back(turn * Vector3(x, y, height(x, y)));
    }
  }
  const auto row = static_cast<std::uint32_t>(cells + 1);
  for (std::uint32_t j = 0; j + 1 < row; ++j) {
    for (std::uint32_t i = 0; i + 1 < row; ++i) {
      const std::uint32_t a = j * row + i;
      triangles.push_back({a, a + 1, a + row + 1});
      triangles.push_back({a, a + row + 1, a + row});
    }
  }
  return {vertices, triangles};
}

double flat(double, double) { return 0; }

struct Ramp {
  Shape shape;
  double angle;
  double heading;  // of the body's velocity, from downhill, rad
  double friction;
  double start_speed;
};

// The body's velocity at every step, on the plane of a ramp that is `floor`.
std::vector<Vector3> descend(const Ramp& ramp, const Shape& floor) {
  World world;
  const Quaternion turn(Eigen::AngleAxisd(ramp.angle, Vector3::UnitY()));
  const Material material = {.friction = ramp.friction};
  world.add_body({.type = BodyType::Static, .shape = floor, .material = material});
  const Vector3 along(std::cos(ramp.heading), std::sin(ramp.heading), 0);
  const BodyId body = world.add_body({.shape = ramp.shape,
                                      .position = turn * Vector3(-6.03, 0.11, 0.5),
                                      .orientation = turn * Quaternion(Eigen::AngleAxisd(0.3, Vector3::UnitZ())),
                                      .velocity = turn * (ramp.start_speed * along),
                                      .material = material});
  std::vector<Vector3> velocities;
  for (int i = 0; i < 120; ++i) {
    world.step(dt);
    velocities.push_back(world.velocity(body));
  }
  return velocities;
}

TEST(SurfaceSliding, RampOfTrianglesIsAPlane) {
  const double angle = 0.35;
  const Quaternion turn(Eigen::AngleAxisd(angle, Vector3::UnitY()));
  const Shape mesh = grid(10, 10, flat, turn);
  const Shape plane = HalfSpace{.normal = turn * Vector3::UnitZ()};
  for (const bool is_box : {true, false}) {
    const Shape shape = is_box ? Shape(Box{{0.5, 0.4, 0.5}}) : Shape(Sphere{0.5});
    for (const double friction : {0.0, 0.3}) {
      for (const double heading : {0.0, 0.7, 2.3, -1.2}) {
        SCOPED_TRACE(std::string(is_box ? "box" : "sphere") + ", friction " + std::to_string(friction) + ", heading " +
                     std::to_string(heading));
        const Ramp ramp{shape, angle, heading, friction, 2};
        const std::vector<Vector3> on_mesh = descend(ramp, mesh);
        const std::vector<Vector3> on_plane = descend(ramp, plane);
        double worst = 0;
        for (std::size_t i = 0; i < on_mesh.size(); ++i) {
          worst = std::max(worst, (on_mesh[i] - on_plane[i]).norm() / std::max(1.0, on_plane[i].norm()));
        }
        EXPECT_LT(worst, 1e-3);
      }
    }
  }
}

struct Unrest {
  double vertical = 0;  ///< m/s, the greatest
  double turning = 0;   ///< rad/s
};

Unrest slide_over(const Shape& floor, double heading, double friction) {
  World world;
  const Material material = {.friction = friction};
  world.add_body({.type = BodyType::Static, .shape = floor, .material = material});
  const BodyId body = world.add_body({.shape = Box{{0.5, 0.4, 0.3}},
                                      .position = {0, 0, 0.3},
                                      .velocity = {4 * std::cos(heading), 4 * std::sin(heading), 0},
                                      .material = material});
  run(world, 20);  // it settles to where its weight is carried
  Unrest unrest;
  for (int i = 0; i < 80; ++i) {
    world.step(dt);
    unrest.vertical = std::max(unrest.vertical, std::abs(world.velocity(body).z()));
    unrest.turning = std::max(unrest.turning, world.angular_velocity(body).norm());
  }
  return unrest;
}

TEST(SurfaceSliding, NothingHopsOnAFlatMesh) {
  const Shape mesh = grid(40, 10, flat);
  for (const double heading : {0.0, 0.4, 0.7853981633974483, 1.9}) {
    for (const double friction : {0.0, 0.3}) {
      SCOPED_TRACE("heading " + std::to_string(heading) + ", friction " + std::to_string(friction));
      const Unrest on_mesh = slide_over(mesh, heading, friction);
      const Unrest on_plane = slide_over(HalfSpace{}, heading, friction);
      EXPECT_LT(on_mesh.vertical, on_plane.vertical + 1e-4);
      EXPECT_LT(on_mesh.turning, on_plane.turning + 2e-4);
    }
  }
}

Settings settings_of(int substeps, ContactSolver solver) {
  Settings settings;
  settings.substeps = substeps;
  settings.contact_solver = solver;
  return settings;
}

// A ball that rolls from level ground onto a slope keeps its turning about the line of the new contact, and nothing
// else: (5 cos a + 2) / 7 of its speed. That is how high it climbs. Solved directly it climbs 6% less, as between two
// half-spaces.
TEST(SurfaceSliding, ABallLosesAtACornerAsTheLawSays) {
  const double slope = 0.8, speed = 4, radius = 0.2, cell = 10;
  const double kept = speed * (5 * std::cos(slope) + 2) / 7, height = 0.7 * kept * kept / g;
  const double top = cell * std::tan(slope);
  const std::vector<Vector3> corners = {{-10, -5, 0}, {-10, 5, 0},     {0, -5, 0},
                                        {0, 5, 0},    {cell, -5, top}, {cell, 5, top}};
  const std::vector<TriangleMesh::Indices> halves = {{0, 2, 1}, {2, 3, 1}, {2, 4, 3}, {4, 5, 3}};
  const Shape mesh = TriangleMesh(corners, halves);
  const Shape field = HeightField(3, 2, cell, cell, std::vector<double>{0, 0, top, 0, 0, top});
  const Material rough{.friction = 1};
  struct Case {
    int substeps;
    ContactSolver solver;
    double tolerance;
  };
  for (const Case& at : {Case{4, ContactSolver::Auto, 0.015}, Case{16, ContactSolver::Auto, 0.002},
                         Case{16, ContactSolver::Direct, 0.07}}) {
    for (const bool is_mesh : {true, false}) {
      for (const double start : {-0.7, -0.72, -0.74, -0.75}) {
        World world({.settings = settings_of(at.substeps, at.solver)});
        const Vector3 corner = is_mesh ? Vector3::Zero() : Vector3(-cell, -0.5 * cell, 0);
        world.add_body(
            {.type = BodyType::Static, .shape = is_mesh ? mesh : field, .position = corner, .material = rough});
        const BodyId ball = world.add_body({.shape = Sphere{radius},
                                            .position = {start, 0.1, radius},
                                            .velocity = {speed, 0, 0},
                                            .angular_velocity = {0, speed / radius, 0},
                                            .material = rough});
        double max = 0;
        for (int i = 0; i < 60; ++i) {
          world.step(dt);
          max = std::max(max, world.pose(ball).position.z() - radius);
        }
        EXPECT_NEAR(max / height, 1, at.tolerance) << at.substeps << " " << is_mesh << " " << start;
      }
    }
  }
}

// Without friction or bounce, facets that rise against a ball take energy from it, and none gives any.
TEST(SurfaceSliding, FacetsGiveABallNoEnergy) {
  const double cell = 0.015, radius = 0.1, from = 0.1, speed = 0.3;
  const auto valley = [](double x, double) { return 1 - std::sqrt(1 - x * x); };
  const Shape mesh = grid(54, 27 * cell, valley);
  for (const int substeps : {4, 16}) {
    for (const ContactSolver solver : {ContactSolver::Auto, ContactSolver::Direct}) {
      World world({.settings = settings_of(substeps, solver)});
      const Material smooth{.friction = 0};
      world.add_body({.type = BodyType::Static, .shape = mesh, .material = smooth});
      const BodyId ball =
          world.add_body({.shape = Sphere{radius},
                          .position = {(1 - radius) * std::sin(from), 0.003, 1 - (1 - radius) * std::cos(from)},
                          .velocity = {-speed * std::cos(from), 0, -speed * std::sin(from)},
                          .material = smooth});
      const auto energy = [&] {
        return g * (world.pose(ball).position.z() - radius) + 0.5 * world.velocity(ball).squaredNorm();
      };
      const double start = energy();
      double max = 0;
      for (int i = 0; i < 600; ++i) {
        world.step(dt);
        max = std::max(max, energy());
      }
      EXPECT_LT(max, 1.005 * start) << substeps;
      EXPECT_LT(energy(), 0.95 * start) << substeps;
      if (solver == ContactSolver::Auto) {
        EXPECT_GT(energy(), 0.7 * start) << substeps;
      }
    }
  }
}

ConvexHull pebble() {
  std::vector<Vector3> points;
  for (int i = 0; i < 12; ++i) {
    const double turn = i * 2.399963;  // the golden angle spreads them over the sphere
    const double z = 1 - (2 * i + 1) / 12.0;
    const double r = std::sqrt(1 - z * z);
    points.emplace_back(0.5 * r * std::cos(turn), 0.5 * r * std::sin(turn), 0.35 * z);
  }
  return ConvexHull(points);
}

// After five seconds all energy of a drop from a hand's breadth is gone.
void expect_rest(const Shape& floor, const Shape& shape, const Vector3& position, const Quaternion& orientation,
                 const char* name) {
  World world;
  world.add_body({.type = BodyType::Static, .shape = floor});
  const BodyId body = world.add_body({.shape = shape, .position = position, .orientation = orientation});
  run(world, 300);
  const double energy =
      0.5 * world.velocity(body).squaredNorm() + 0.5 * 0.25 * world.angular_velocity(body).squaredNorm();
  EXPECT_LT(energy, 1e-8) << name;
  EXPECT_GT(world.pose(body).position.z(), 0) << name;
  EXPECT_LT((world.pose(body).position - position).head<2>().norm(), 1) << name;
}

TEST(SurfaceSliding, SolidsComeToRestOnFloors) {
  const Quaternion upright = Quaternion::Identity();
  const Quaternion lying(Eigen::AngleAxisd(1.5707963267948966, Vector3::UnitX()));
  const Quaternion tilted(Eigen::AngleAxisd(0.5, Vector3(1, 2, 3).normalized()));
  const Shape mesh = grid(16, 4, flat);
  expect_rest(mesh, pebble(), {0.1, 0.2, 0.6}, tilted, "hull on mesh");
  expect_rest(mesh, Box{{0.5, 0.4, 0.3}}, {0.1, 0.2, 0.6}, tilted, "box on mesh");
  const Shape field = HeightField(17, 17, 0.5, 0.5, std::vector<double>(289, 0.0));
  const Vector3 middle(4.1, 4.2, 0);
  expect_rest(field, Capsule{0.3, 0.4}, middle + Vector3(0, 0, 0.4), lying, "capsule");
  expect_rest(field, Cylinder{0.4, 0.5}, middle + Vector3(0, 0, 0.6), upright, "standing cylinder");
  expect_rest(field, Cylinder{0.4, 0.5}, middle + Vector3(0, 0, 0.5), lying, "lying cylinder");
  expect_rest(field, Cone{0.4, 0.5}, middle + Vector3(0, 0, 0.6), upright, "cone");
  expect_rest(field, Ellipsoid{{0.5, 0.4, 0.3}}, middle + Vector3(0, 0, 0.4), upright, "ellipsoid");
  expect_rest(field, TaperedCapsule{{0.3, 0.2}, 0.4}, middle + Vector3(0, 0, 0.4), lying, "tapered capsule");
}

TEST(SurfaceSliding, SolidsComeToRestOnRoughGround) {
  std::vector<double> heights;
  for (int i = 0; i < 33 * 33; ++i) heights.push_back(0.3 + 0.05 * std::sin(2.1 * i) + 0.02 * std::cos(0.7 * i));
  const Shape field = HeightField(33, 33, 0.25, 0.25, heights);
  const Quaternion tilted(Eigen::AngleAxisd(0.2, Vector3(1, 2, 3).normalized()));
  const Vector3 middle(4.1, 4.2, 1.2);
  expect_rest(field, pebble(), middle, tilted, "hull");
  expect_rest(field, Box{{0.5, 0.4, 0.3}}, middle, tilted, "box");
  expect_rest(field, Cylinder{0.4, 0.3}, middle, tilted, "cylinder");
}

}  // namespace
}  // namespace atl::test::surface_sliding_test
