// Flush solids are one surface: what slides or rolls over their seams feels none of them, and what stands out of the
// surface stops it as before.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "support/bodies.h"

namespace atl::test {
namespace {

constexpr double length = 38;  // m, that bodies travel
constexpr double size = 0.2;   // m, half of theirs
const Quaternion lying(Eigen::AngleAxisd(M_PI / 2, Vector3::UnitX()));

Shape hull_of_box(const Vector3& half) {
  std::vector<Vector3> corners;
  for (int i = 0; i < 8; ++i) {
    corners.push_back(half.cwiseProduct(Vector3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)));
  }
  return ConvexHull{corners};
}

enum class Floor { Tiles, Narrow, Children, Hulls, Bricks, Belt, Meshes };

// Its surface is at z = 0, and the belt's runs along x.
void add_floor(World& world, Floor floor, double speed) {
  const Material material{.friction = floor == Floor::Belt ? 0.5 : 0};
  const auto add = [&](const Shape& shape, const Vector3& at) {
    BodyDef def{.type = BodyType::Static, .shape = shape, .position = at, .material = material};
    if (floor == Floor::Belt) def.surface_velocity = {speed, 0, 0};
    world.add_body(def);
  };
  const auto add_tiles = [&](const Vector3& half, int across, double stagger) {
    for (int i = 0; 2 * half.x() * i < length + 4; ++i) {
      for (int j = 0; j < across; ++j) {
        const double shift = j % 2 == 1 ? stagger : 0;
        add(Box{half}, {(2 * i + 1) * half.x() + shift - 1, (2 * j + 1 - across) * half.y(), -half.z()});
      }
    }
  };
  Compound compound;
  switch (floor) {
    case Floor::Tiles:
    case Floor::Belt:
      return add_tiles({0.5, 2, 0.25}, 1, 0);
    case Floor::Narrow:
      return add_tiles({0.25, 0.025, 0.25}, 16, 0);
    case Floor::Bricks:
      return add_tiles({0.25, 0.1, 0.25}, 6, 0.25);
    case Floor::Children:
      for (int i = 0; i < 42; ++i) compound.children.push_back({Box{{0.5, 2, 0.25}}, Vector3(i - 0.5, 0, -0.25)});
      return add(compound, Vector3::Zero());
    case Floor::Hulls:
      for (int i = 0; i < 42; ++i) add(hull_of_box({0.5, 2, 0.25}), {i - 0.5, 0, -0.25});
      return;
    case Floor::Meshes:
      for (int i = 0; i < 21; ++i) {
        const double x = 2 * i - 1;
        const std::vector<Vector3> corners = {{x, -2, 0}, {x + 2, -2, 0}, {x + 2, 2, 0}, {x, 2, 0}};
        const std::vector<TriangleMesh::Indices> halves = {{0, 1, 2}, {0, 2, 3}};
        add(TriangleMesh(corners, halves), Vector3::Zero());
      }
      return;
  }
}

struct Mover {
  std::string name;
  Shape shape;
  Quaternion orientation = Quaternion::Identity();
};

std::vector<Mover> movers() {
  return {{"ball", Sphere{size}},
          {"box", Box{{size, size, size}}},
          {"capsule", Capsule{size, size}, lying},
          {"ellipsoid", Ellipsoid{Vector3::Constant(size)}, lying},
          {"tapered capsule", TaperedCapsule{{size, size}, size}, lying},
          {"wheel", Cylinder{size, 0.1}, lying},
          {"hull", hull_of_box({size, 0.15, size})}};
}

class FlushFloor : public testing::TestWithParam<Floor> {};

TEST_P(FlushFloor, IsOneSurface) {
  for (const Mover& mover : movers()) {
    for (const double speed : {2.0, 5.0, 20.0, 30.0}) {
      // A box rocks on soft contacts, whose normals are those of its own faces here: 8e-4 of its speed.
      if (GetParam() == Floor::Hulls && speed < 5) continue;
      World world;
      add_floor(world, GetParam(), speed);
      const BodyId id = world.add_body({.shape = mover.shape,
                                        .position = {0.6, 0, size},
                                        .orientation = mover.orientation,
                                        .velocity = {speed, 0, 0},
                                        .material = {.friction = GetParam() == Floor::Belt ? 0.5 : 0}});
      double highest = 0, lowest = 1;
      for (int i = 0; i * dt < (length - 1) / speed; ++i) {
        world.step(dt);
        highest = std::max(highest, world.pose(id).position.z());
        lowest = std::min(lowest, world.pose(id).position.z());
      }
      EXPECT_NEAR(world.velocity(id).x(), speed, 1e-3) << mover.name << " " << speed;
      EXPECT_LT(highest, size + 5e-4) << mover.name << " " << speed;
      EXPECT_GT(lowest, size - 1e-3) << mover.name << " " << speed;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Floors, FlushFloor,
                         testing::Values(Floor::Tiles, Floor::Narrow, Floor::Children, Floor::Hulls, Floor::Bricks,
                                         Floor::Belt, Floor::Meshes));

// On a platform of tiles that moves sideways and up, one compound.
TEST(FlushSolids, AreOneSurfaceWhereTheyMove) {
  Compound tiles;
  for (int i = 0; i < 42; ++i) tiles.children.push_back({Box{{0.5, 20, 0.25}}, Vector3(i - 0.5, 0, -0.25)});
  for (const Mover& mover : movers()) {
    for (const double speed : {2.0, 5.0, 20.0, 30.0}) {
      World world;
      world.add_body(
          {.type = BodyType::Kinematic, .shape = tiles, .velocity = {0, 1, 0.5}, .material = {.friction = 0}});
      const BodyId id = world.add_body({.shape = mover.shape,
                                        .position = {0.6, 0, size},
                                        .orientation = mover.orientation,
                                        .velocity = {speed, 0, 0.5},
                                        .material = {.friction = 0}});
      for (int i = 1; i * dt < (length - 1) / speed; ++i) {
        world.step(dt);
        // In the first step, without a contact yet, it is stopped at a seam, from which the platform rises.
        const double sunk = size + 0.5 * i * dt - world.pose(id).position.z();
        EXPECT_LT(std::abs(sunk), i * dt * speed < 5 ? 6e-3 : 1e-3) << mover.name << " " << speed;
      }
      EXPECT_NEAR(world.velocity(id).x(), speed, 1e-3) << mover.name << " " << speed;
    }
  }
}

// A raft of tiles glides over narrow rails that are flush, so that its seams run over their edges.
TEST(FlushSolids, AreOneSurfaceWhereTheyGlide) {
  Compound tiles;
  for (int i = -5; i <= 5; ++i) tiles.children.push_back({Box{{0.15, 1, 0.05}}, Vector3(0.3 * i, 0, 0)});
  for (const double speed : {1.0, 5.0, 20.0}) {
    World world;
    for (int i = 0; i < 60; ++i) {
      world.add_body({.type = BodyType::Static,
                      .shape = Box{{0.1, 1.2, 0.1}},
                      .position = {0.7 * i, 0, -0.1},
                      .material = {.friction = 0}});
    }
    const BodyId id = world.add_body(
        {.shape = tiles, .position = {2, 0, 0.05}, .velocity = {speed, 0, 0}, .material = {.friction = 0}});
    for (int i = 0; i * dt < 36 / speed; ++i) {
      world.step(dt);
      ASSERT_NEAR(world.pose(id).position.z(), 0.05, 1e-3) << speed;
    }
    // It rocks as rails come and go beneath its ends: 1.3e-3 after 36 s.
    EXPECT_NEAR(world.velocity(id).x(), speed, 2e-3) << speed;
  }
}

// Whatever solves it, on any threads, and from a snapshot on.
TEST(FlushSolids, AreTheSameHoweverTheyAreStepped) {
  for (const ContactSolver solver : {ContactSolver::Auto, ContactSolver::Direct, ContactSolver::Iterative}) {
    std::vector<std::uint64_t> hashes;
    for (const int threads : {1, 2}) {
      for (const bool restores : {false, true}) {
        World world({.threads = threads, .settings = {.contact_solver = solver}});
        add_floor(world, Floor::Narrow, 5);
        std::vector<BodyId> ids;
        for (int i = 0; i < 3; ++i) {
          ids.push_back(world.add_body({.shape = Box{{size, size, size}},
                                        .position = {0.6 + i, 0.01 * i, size},
                                        .velocity = {5, 0, 0},
                                        .material = {.friction = 0}}));
        }
        for (int i = 0; i < 120; ++i) {
          world.step(dt);
          if (!restores || i != 60) continue;
          Snapshot saved;
          world.save(saved);
          world.step(dt);
          world.restore(saved);
        }
        for (const BodyId id : ids) EXPECT_NEAR(world.velocity(id).x(), 5, 1e-3);
        hashes.push_back(world.state_hash());
      }
    }
    for (const std::uint64_t hash : hashes) EXPECT_EQ(hash, hashes.front());
  }
}

// A step of a hundredth of a box's size stops the box, and so does a wall on the floor.
TEST(FlushSolids, StopWhatRunsAgainstAStepOrAWall) {
  for (const double height : {0.002, 0.02, 1.0}) {
    World world;
    add_floor(world, Floor::Tiles, 0);
    world.add_body({.type = BodyType::Static, .shape = Box{{0.5, 2, 1}}, .position = {4.5, 0, height - 1}});
    const BodyId id = world.add_body({.shape = Box{{size, size, size}},
                                      .position = {1, 0, size},
                                      .velocity = {0.5, 0, 0},
                                      .material = {.friction = 0}});
    double farthest = 0;
    for (int i = 0; i < 600; ++i) {
      world.step(dt);
      farthest = std::max(farthest, world.pose(id).position.x());
    }
    EXPECT_NEAR(farthest, 4 - size, 5e-3) << height;
    EXPECT_LT(world.velocity(id).x(), 0.01) << height;
  }
}

// A wedge on its edge, in the corner of a floor and a wall of triangles.
TEST(FlushSolids, StopAnEdgeAtTheFootOfAWall) {
  World world;
  add_floor(world, Floor::Meshes, 0);
  const std::vector<Vector3> corners = {{4, -2, 0}, {4, 2, 0}, {4, 2, 2}, {4, -2, 2}};
  const std::vector<TriangleMesh::Indices> halves = {{0, 2, 1}, {0, 3, 2}};
  world.add_body({.type = BodyType::Static, .shape = TriangleMesh(corners, halves), .material = {.friction = 0}});
  const std::vector<Vector3> wedge = {{0.3, -0.2, -0.1}, {0.3, 0.2, -0.1},  {-0.3, -0.2, -0.1},
                                      {-0.3, 0.2, -0.1}, {-0.3, -0.2, 0.2}, {-0.3, 0.2, 0.2}};
  const BodyId id = world.add_body(
      {.shape = ConvexHull{wedge}, .position = {3, 0, 0.1}, .velocity = {1, 0, 0}, .material = {.friction = 0}});
  double farthest = 0;
  for (int i = 0; i < 240; ++i) {
    world.step(dt);
    farthest = std::max(farthest, world.pose(id).position.x());
  }
  EXPECT_NEAR(farthest, 3.7, 0.05) << "it tips over its edge, and gets no farther";
}

// A plank that leans in the corner between floor and wall, and one that stands there, touch both.
// A ramp that stands on a floor: what rolls or slides onto it meets its face, as where two half-spaces cross, and not
// the edge at its foot.
TEST(FlushSolids, LeadOntoARampThatStandsOnThem) {
  const double slope = 0.2, radius = 0.1, speed = 5;
  const Vector3 normal(-std::sin(slope), 0, std::cos(slope));
  std::vector<Vector3> corners;
  for (const double y : {-3.0, 3.0}) {
    for (const Vector3& corner : {Vector3(0, y, 0), Vector3(10, y, 0), Vector3(10, y, 10 * std::tan(slope))}) {
      corners.push_back(corner);
    }
  }
  const auto energy_after = [&](const Shape& shape, const Shape& ramp, double start, int substeps,
                                ContactSolver solver) {
    Settings settings;
    settings.substeps = substeps;
    settings.contact_solver = solver;
    World world({.settings = settings});
    const bool rolls = std::holds_alternative<Sphere>(shape);
    const Material material{.friction = rolls ? 1.0 : 0.0};
    world.add_body({.type = BodyType::Static, .shape = HalfSpace{}, .material = material});
    world.add_body({.type = BodyType::Static, .shape = ramp, .material = material});
    const BodyId body = world.add_body({.shape = shape,
                                        .position = {start, 0.05, radius},
                                        .velocity = {speed, 0, 0},
                                        .angular_velocity = {0, rolls ? speed / radius : 0, 0},
                                        .material = material});
    run(world, 30);
    const Vector3 v = world.velocity(body);
    return v.squaredNorm() / (speed * speed) + 2 * g * (world.pose(body).position.z() - radius) / (speed * speed);
  };
  for (const Shape& shape : {Shape(Sphere{radius}), Shape(Box{Vector3::Constant(radius)})}) {
    for (const auto& [substeps, solver] :
         {std::pair(4, ContactSolver::Auto), std::pair(16, ContactSolver::Auto), std::pair(4, ContactSolver::Direct)}) {
      for (const double start : {-0.7, -0.721, -0.742, -0.763}) {
        const double right = energy_after(shape, HalfSpace{normal, 0}, start, substeps, solver);
        const double found = energy_after(shape, ConvexHull{corners}, start, substeps, solver);
        EXPECT_NEAR(found, right, 0.02) << shape.index() << " " << substeps << " " << start;
      }
    }
  }
}

TEST(FlushSolids, HoldWhatIsInTheirCorner) {
  for (const double tilt : {0.0, 0.02, 0.3}) {
    World world;
    add_floor(world, Floor::Tiles, 0);
    world.add_body({.type = BodyType::Static, .shape = Box{{0.5, 2, 2}}, .position = {4.5, 0, 2}});
    const double lean = std::sin(tilt) * 0.5 + std::cos(tilt) * 0.02;
    const BodyId id = world.add_body({.shape = Box{{0.02, 0.3, 0.5}},
                                      .position = {4 - lean, 0, 0.5 * std::cos(tilt) + 0.02 * std::sin(tilt)},
                                      .orientation = Quaternion(Eigen::AngleAxisd(tilt, Vector3::UnitY()))});
    for (int i = 0; i < 240; ++i) world.step(dt);
    const Vector3 at = world.pose(id).position;
    EXPECT_GT(at.z(), 0.015) << tilt;
    EXPECT_LT(at.x(), 4) << tilt;
  }
}

// On an edge over a seam, at any angle, and on the ridge of a roof.
TEST(FlushSolids, HoldWhatLandsOnTheirSeams) {
  for (const double tilt : {1e-4, 1e-3, 0.01, 0.03, 0.1, 0.5, M_PI / 4}) {
    World world;
    add_floor(world, Floor::Tiles, 0);
    const BodyId id =
        world.add_body({.shape = Box{{size, size, size}},
                        .position = {2, 0, 0.5},
                        .orientation = Quaternion(Eigen::AngleAxisd(tilt, Vector3(1, 1, 0).normalized()))});
    double lowest = 1;
    for (int i = 0; i < 240; ++i) {
      world.step(dt);
      lowest = std::min(lowest, world.pose(id).position.z());
    }
    EXPECT_GT(lowest, size - 5e-3) << tilt;
    EXPECT_LT(world.velocity(id).norm(), 0.02) << tilt;
  }
}

}  // namespace
}  // namespace atl::test
