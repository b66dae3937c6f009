// Bodies that fly and spin fast in a closed room, from wall to wall: none leaves it.

#include <gtest/gtest.h>

#include <ostream>
#include <string>
#include <vector>

#include "support/bodies.h"
#include "support/random.h"

namespace atl::test {
namespace {

constexpr double half = 5;  // m, of the room

// A closed box of 12 triangles that face inwards.
TriangleMesh room_of_triangles() {
  std::vector<Vector3> corners;
  for (int i = 0; i < 8; ++i) {
    corners.push_back(half * Vector3(i & 1 ? 1.0 : -1.0, i & 2 ? 1.0 : -1.0, i & 4 ? 1.0 : -1.0));
  }
  const std::vector<TriangleMesh::Indices> triangles = {{0, 1, 2}, {1, 3, 2}, {4, 6, 5}, {5, 6, 7},
                                                        {0, 4, 1}, {1, 4, 5}, {2, 3, 6}, {3, 7, 6},
                                                        {0, 2, 4}, {2, 6, 4}, {1, 5, 3}, {3, 5, 7}};
  return {corners, triangles};
}

enum class Walls { Triangles, Plates, Blocks };

void add_room(World& world, Walls walls, const Material& material) {
  if (walls == Walls::Triangles) {
    world.add_body({.type = BodyType::Static, .shape = room_of_triangles(), .material = material});
    return;
  }
  const double thickness = walls == Walls::Plates ? 0.02 : 1;  // half of it
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      Vector3 extents = Vector3::Constant(half + 2 * thickness), place = Vector3::Zero();
      extents[axis] = thickness;
      place[axis] = side * (half + thickness);
      world.add_body({.type = BodyType::Static, .shape = Box{extents}, .position = place, .material = material});
    }
  }
}

struct Flyer {
  std::string name;
  Shape shape;
};
void PrintTo(const Flyer& flyer, std::ostream* out) { *out << flyer.name; }

class ClosedRoom : public testing::TestWithParam<Flyer> {
 protected:
  static int leave(Walls walls, double speed, double friction, double restitution, int count, int steps) {
    World world;
    add_room(world, walls, {.friction = friction});
    Random random(5);
    std::vector<BodyId> ids;
    for (int i = 0; i < count; ++i) {
      BodyDef def{.shape = GetParam().shape,
                  .position = random.vector(4),
                  .orientation = random.rotation(),
                  .material = {.friction = friction, .restitution = restitution},
                  .filter = {.group = -1}};
      def.velocity = speed * random.direction();
      ids.push_back(world.add_body(def));
    }
    for (int step = 0; step < steps; ++step) world.step(dt);
    int gone = 0;
    for (const BodyId id : ids) gone += !(world.pose(id).position.cwiseAbs().maxCoeff() < half + 0.5);
    return gone;
  }
};

TEST_P(ClosedRoom, NobodyLeaves) {
  for (const Walls walls : {Walls::Triangles, Walls::Plates, Walls::Blocks}) {
    for (const double speed : {10.0, 100.0, 300.0}) {
      // Capsules between two plates that meet: 3 of 1000 are pressed out between them.
      const int max = walls == Walls::Plates && GetParam().name == "capsule" ? 1 : 0;
      for (const double friction : {0.0, 0.5}) {
        EXPECT_LE(leave(walls, speed, friction, 0.5, 40, 240), max)
            << "walls " << static_cast<int>(walls) << ", " << speed << " m/s, friction " << friction;
      }
    }
  }
}

// How many of 300 get out of a room that moves and turns, by steps of up to 0.09 m of its walls.
int leave_moving_room(const Shape& shape) {
  int gone = 0;
  for (const double speed : {1.0, 30.0, 100.0}) {
    World world({.gravity = Vector3::Zero()});
    const BodyId room = world.add_body({.type = BodyType::Kinematic,
                                        .shape = room_of_triangles(),
                                        .velocity = {3, 0, 0},
                                        .angular_velocity = {0, 0, 0.3},
                                        .material = {.friction = 0.3}});
    Random random(7);
    std::vector<BodyId> ids;
    for (int i = 0; i < 100; ++i) {
      BodyDef def{.shape = shape,
                  .position = random.vector(4),
                  .orientation = random.rotation(),
                  .material = {.friction = 0.3, .restitution = 0.5},
                  .filter = {.group = -1}};
      def.velocity = speed * random.direction();
      ids.push_back(world.add_body(def));
    }
    run(world, 240);
    for (const BodyId id : ids) {
      const Pose walls = world.pose(room);
      const Vector3 at = walls.orientation.conjugate() * (world.pose(id).position - walls.position);
      gone += !(at.cwiseAbs().maxCoeff() < half + 0.5);
    }
  }
  return gone;
}

TEST_P(ClosedRoom, NobodyLeavesOneThatMovesAndTurns) {
  // Capsules are pressed out between walls that meet, as above.
  EXPECT_LE(leave_moving_room(GetParam().shape), GetParam().name == "capsule" ? 3 : 1);
}

// Walls pass over them where they are slow, and nobody sees it who looks at fast bodies alone.
TEST(MovingRoom, KeepsMarbles) { EXPECT_LE(leave_moving_room(Sphere{0.02}), 1); }

// A floor without end has no box to be looked for in.
TEST(MovingRoom, AFloorThatRisesLiftsMarbles) {
  World world;
  const BodyId floor = world.add_body({.type = BodyType::Kinematic, .shape = HalfSpace{}, .velocity = {0, 0, 3}});
  std::vector<BodyId> ids;
  for (int i = 0; i < 20; ++i) ids.push_back(world.add_body(sphere({0.1 * i, 0, 0.02 + 0.02 * i}, 0.02)));
  run(world, 60);
  for (const BodyId id : ids) EXPECT_GT(world.pose(id).position.z(), world.pose(floor).position.z()) << id.index;
}

const Flyer flyers[] = {{"box", Box{{0.3, 0.2, 0.1}}},
                        {"sphere", Sphere{0.2}},
                        {"capsule", Capsule{0.1, 0.4}},
                        {"cylinder", Cylinder{0.3, 0.05}},
                        {"cone", Cone{0.3, 0.3}},
                        {"ellipsoid", Ellipsoid{{0.3, 0.2, 0.1}}},
                        {"tapered_capsule", TaperedCapsule{{0.1, 0.2}, 0.3}}};

INSTANTIATE_TEST_SUITE_P(Shapes, ClosedRoom, testing::ValuesIn(flyers),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace atl::test
