// Height fields with holes, and heights that change under what lies on them.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "support/bodies.h"
#include "support/expect_error.h"
#include "support/random.h"

namespace atl::test::holes_test {
namespace {

const double hole = std::nan("");

// 21 x 21 samples, half a metre apart, about the origin. Holes where x, the place across, is above an edge.
BodyDef flat(double edge = 9) {
  std::vector<double> heights;
  for (int i = 0; i < 21 * 21; ++i) heights.push_back(0.5 * (i % 21) - 5 > edge ? hole : 0.0);
  return {.type = BodyType::Static, .shape = HeightField(21, 21, 0.5, 0.5, heights), .position = {-5, -5, 0}};
}

TEST(Holes, ABallFallsThroughFreely) {
  World world;
  const BodyId field = world.add_body(flat());
  world.set_heights(field, 9, 9, 3, std::vector(9, hole));
  const BodyId ball = world.add_body(sphere({0, 0, 1}, 0.25));
  run(world, 60);
  EXPECT_NEAR(world.pose(ball).position.z(), 1 - 0.5 * g, 1e-5);
  EXPECT_EQ(world.contact_forces().size(), 0u);
}

// A ball that rolls slowly over an edge turns about it, and leaves it where gravity no longer holds it there: at an
// angle whose cosine is 10 / 17 if it doesn't slip. Its speed there is sqrt(10 / 17 g r).
TEST(Holes, ABallRollsOverTheEdge) {
  World world;
  world.add_body(flat(0.25));
  const double radius = 0.2, speed = 0.05;
  BodyDef def = sphere({-0.05, 0.1, radius}, radius);
  def.velocity = {speed, 0, 0};
  def.angular_velocity = {0, speed / radius, 0};
  def.material.friction = 5;
  const BodyId ball = world.add_body(def);
  for (int i = 0; i < 1000 && world.pose(ball).position.z() > -radius; ++i) world.step(1.0 / 240);
  const double cosine = 10.0 / 17;
  EXPECT_NEAR(world.velocity(ball).x(), std::sqrt(cosine * g * radius) * cosine, 0.05);
  EXPECT_NEAR(world.velocity(ball).y(), 0, 0.02);
  EXPECT_LT(world.pose(ball).position.z(), -radius);
}

// Whatever asks of a field with holes hears what a mesh of its other triangles says.
TEST(Holes, QueriesAreThoseOfAMesh) {
  Random random(3);
  for (int round = 0; round < 20; ++round) {
    std::vector<double> heights;
    for (int i = 0; i < 7 * 6; ++i) heights.push_back(random.chance(0.2) ? hole : random.real(0, 1));
    std::vector<Vector3> vertices;
    for (int i = 0; i < 7 * 6; ++i) vertices.emplace_back(i % 7, i / 7, std::isnan(heights[i]) ? 0 : heights[i]);
    std::vector<TriangleMesh::Indices> triangles;
    for (std::uint32_t i = 0; i + 8 < 7 * 6; ++i) {
      if (i % 7 == 6) continue;
      for (const TriangleMesh::Indices& corners : {TriangleMesh::Indices{i, i + 1, i + 8}, {i, i + 8, i + 7}}) {
        const auto is_hole = [&](std::uint32_t corner) { return std::isnan(heights[corner]); };
        if (std::ranges::none_of(corners, is_hole)) triangles.push_back(corners);
      }
    }
    if (triangles.empty()) continue;
    World field, mesh;
    field.add_body({.type = BodyType::Static, .shape = HeightField(7, 6, 1, 1, heights)});
    mesh.add_body({.type = BodyType::Static, .shape = TriangleMesh(vertices, triangles)});
    const Queries in_field(field), in_mesh(mesh);
    for (int i = 0; i < 100; ++i) {
      const Vector3 from(random.real(-1, 7), random.real(-1, 6), random.real(1, 3));
      const Ray ray{from, random.vector(1) - Vector3(0, 0, 1), 20};
      const auto hit = in_field.cast_ray(ray), same_hit = in_mesh.cast_ray(ray);
      ASSERT_EQ(hit.has_value(), same_hit.has_value());
      if (hit) {
        ASSERT_NEAR(hit->distance, same_hit->distance, 1e-9);
      }
      const auto near = in_field.closest_point({.position = from}, 2),
                 other = in_mesh.closest_point({.position = from}, 2);
      ASSERT_EQ(near.has_value(), other.has_value());
      if (near) {
        ASSERT_NEAR(near->distance, other->distance, 1e-9);
      }
      const QueryShape box{Box{}, from - Vector3(0, 0, 1.5), random.rotation()};
      ASSERT_EQ(in_field.overlapping(box).size(), in_mesh.overlapping(box).size());
    }
  }
}

struct Dug {
  World world{{.settings = {.sleeping = true}}};
  BodyId field = world.add_body(flat());
  BodyId near = world.add_body(box({0.1, 0.05, 0.25}, Vector3::Constant(0.25)));
  BodyId far = world.add_body(box({3.1, 3.05, 0.25}, Vector3::Constant(0.25)));
};

TEST(SetHeights, WakesAndFindsAnewWhatIsNear) {
  Dug dug, as_it_was;
  for (Dug* world : {&dug, &as_it_was}) run(world->world, 120);
  ASSERT_TRUE(dug.world.is_asleep(dug.near));
  dug.world.set_heights(dug.field, 8, 8, 5, std::vector(25, -1.0));
  EXPECT_FALSE(dug.world.is_asleep(dug.near));
  EXPECT_TRUE(dug.world.is_asleep(dug.far));
  run(dug.world, 24);
  EXPECT_NEAR(dug.world.pose(dug.near).position.z(), 0.25 - 0.5 * g * 0.4 * 0.4, 1e-3) << "it falls freely";
  run(dug.world, 120);
  EXPECT_NEAR(dug.world.pose(dug.near).position.z(), -0.75, 2e-3) << "it lies on the new ground";
  EXPECT_EQ(dug.world.pose(dug.far).position, as_it_was.world.pose(as_it_was.far).position);
  dug.world.set_heights(dug.field, 8, 8, 5, std::vector(25, hole));
  run(dug.world, 60);
  EXPECT_LT(dug.world.pose(dug.near).position.z(), -4);
}

// Two awake crates: the one that the change doesn't reach moves on to the bit as if there had been none.
TEST(SetHeights, LeavesOtherContactsAsTheyAre) {
  Dug dug, as_it_was;
  for (Dug* world : {&dug, &as_it_was}) {
    world->world.set_velocity(world->far, {1.5, 0, 0}, {0, 0, 0.5});
    run(world->world, 5);
  }
  dug.world.set_heights(dug.field, 8, 8, 5, std::vector(25, 0.05));
  for (int i = 0; i < 30; ++i) {
    dug.world.step(dt);
    as_it_was.world.step(dt);
    ASSERT_EQ(dug.world.pose(dug.far).position, as_it_was.world.pose(as_it_was.far).position) << i;
  }
  EXPECT_NE(dug.world.pose(dug.near).position, as_it_was.world.pose(as_it_was.near).position);
}

TEST(SetHeights, IsTheFieldOfThoseHeights) {
  Dug dug;
  const HeightField shared = std::get<HeightField>(dug.world.definition(dug.field).shape);
  dug.world.set_heights(dug.field, 19, 20, 2, std::array{3.0, hole});
  const HeightField field = std::get<HeightField>(dug.world.definition(dug.field).shape);
  EXPECT_EQ(field.heights()[20 * 21 + 19], 3);
  EXPECT_TRUE(std::isnan(field.heights()[20 * 21 + 20]));
  EXPECT_EQ(std::ranges::count(field.heights(), 0.0), 21 * 21 - 2);
  EXPECT_EQ(shared.heights()[20 * 21 + 19], 0) << "others that have the shape keep it";
  EXPECT_NEAR(dug.world.bounds(dug.field).upper.z(), 3, 1e-12);
  // It begins to touch what its higher bounds now reach.
  const BodyId high = dug.world.add_body(sphere({4.5, 5, 3.2}, 0.25));
  dug.world.step(dt);
  EXPECT_GT(contact_force(dug.world, dug.field, high).z(), 0);
}

TEST(SetHeights, RefusesWhatDoesNotFit) {
  Dug dug;
  const std::vector two(2, 0.0);
  expect_error([&] { dug.world.set_heights(dug.near, 0, 0, 2, two); }, {"another shape", "expected a HeightField"});
  expect_error([&] { dug.world.set_heights(dug.field, 20, 0, 2, two); }, {"from column 20", "the field's 21 columns"});
  expect_error([&] { dug.world.set_heights(dug.field, 0, 20, 1, two); }, {"row 20", "21 rows"});
  expect_error([&] { dug.world.set_heights(dug.field, 0, 0, 3, two); }, {"2 heights in 3 columns", "whole rows"});
  expect_error([&] { dug.world.set_heights(dug.field, 0, 0, 0, two); }, {"0 columns"});
  expect_error([&] { dug.world.set_heights(dug.field, 0, 0, 2, std::array{0.0, 1 / 0.0}); }, {"a height of inf"});
}

}  // namespace
}  // namespace atl::test::holes_test
