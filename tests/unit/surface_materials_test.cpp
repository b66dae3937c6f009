// Materials of the triangles of meshes and of the cells of height fields.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "support/bodies.h"
#include "support/expect_error.h"

namespace atl::test::surface_materials_test {
namespace {

constexpr Material tar = {.friction = 0.5, .friction_rule = CombineRule::Min};
constexpr Material ice = {.friction = 0.05, .friction_rule = CombineRule::Min};
constexpr Material glass = {.friction = 0, .friction_rule = CombineRule::Min};

// 40 x 8 cells of half a metre from (-10, -2) on; cells from x = border on are of a number.
BodyDef floor(double border, const Material& there, bool as_mesh = false) {
  const std::vector<double> heights(41 * 9, 0.0);
  std::vector<std::uint8_t> cells;
  for (int i = 0; i < 40 * 8; ++i) cells.push_back(0.5 * (i % 40) - 10 >= border ? 1 : 0);
  BodyDef def = {.type = BodyType::Static, .position = {-10, -2, 0}, .material = tar, .materials = {there}};
  def.shape = HeightField(41, 9, 0.5, 0.5, heights, false, cells);
  if (!as_mesh) return def;
  std::vector<Vector3> vertices;
  std::vector<TriangleMesh::Indices> triangles;
  std::vector<std::uint8_t> numbers;
  for (int i = 0; i < 41 * 9; ++i) vertices.emplace_back(0.5 * (i % 41), 0.5 * (i / 41), 0);
  for (std::uint32_t cell = 0; cell < 40 * 8; ++cell) {
    const std::uint32_t a = cell / 40 * 41 + cell % 40;
    triangles.insert(triangles.end(), {{a, a + 1, a + 42}, {a, a + 42, a + 41}});
    numbers.insert(numbers.end(), 2, cells[cell]);
  }
  def.shape = TriangleMesh(vertices, triangles, 0, numbers);
  return def;
}

BodyDef slider(double x, double speed) {
  BodyDef def = box({x, 0.05, 0.25}, Vector3::Constant(0.25));
  def.velocity = {speed, 0, 0};
  def.material.friction = 5;
  return def;
}

double stops_after(const BodyDef& ground, double x, double speed) {
  World world;
  world.add_body(ground);
  const BodyId id = world.add_body(slider(x, speed));
  run(world, 360);
  return world.pose(id).position.x() - x;
}

class OnSurface : public testing::TestWithParam<bool> {};

// A box stops after v^2 / (2 mu g). One that comes from tar onto ice loses what it loses on tar, then the rest on ice.
// While it is astride, part of its weight rests on either: as if the border lay up to half a box aside.
TEST_P(OnSurface, ABoxSlidesFartherOnIce) {
  EXPECT_NEAR(stops_after(floor(20, ice, GetParam()), -5, 3), 9 / (2 * tar.friction * g), 0.02);
  EXPECT_NEAR(stops_after(floor(-20, ice, GetParam()), -5, 2), 4 / (2 * ice.friction * g), 0.03);
  const double on_tar = 5, square = 64 - 2 * tar.friction * g * on_tar;
  EXPECT_NEAR(stops_after(floor(0, ice, GetParam()), -on_tar, 8) - on_tar, square / (2 * ice.friction * g),
              0.25 * tar.friction / ice.friction);
}

// Without any friction on one side, so that the solver has other kernels for that.
TEST_P(OnSurface, FrictionComesAndGoes) {
  World world;
  world.add_body(floor(0, glass, GetParam()));
  const BodyId there = world.add_body(slider(3, 3)), back = world.add_body(slider(2, -3));
  run(world, 120);
  EXPECT_NEAR(world.velocity(there).x(), 3, 1e-3);
  EXPECT_NEAR(world.pose(back).position.x(), -9 / (2 * tar.friction * g), 0.25) << "it stops on the tar";
  EXPECT_NEAR(world.velocity(back).x(), 0, 1e-3);
}

INSTANTIATE_TEST_SUITE_P(All, OnSurface, testing::Bool(), [](const auto& of) { return of.param ? "Mesh" : "Field"; });

TEST(SurfaceMaterials, ABallBouncesWhereTheyBounce) {
  World world;
  world.add_body(floor(0, {.restitution = 0.8}));
  const BodyId dead = world.add_body(sphere({-2, 0, 1.25}, 0.25)), lively = world.add_body(sphere({2, 0, 1.25}, 0.25));
  double highest_dead = 0, highest_lively = 0;
  for (int i = 0; i < 60; ++i) {
    world.step(dt);
    if (i < 35) continue;
    highest_dead = std::max(highest_dead, world.pose(dead).position.z());
    highest_lively = std::max(highest_lively, world.pose(lively).position.z());
  }
  EXPECT_NEAR(highest_dead, 0.25, 0.01);
  EXPECT_NEAR(highest_lively, 0.25 + 0.64, 0.05);
}

TEST(SurfaceMaterials, ASceneFileHasThemAndHoles) {
  for (const bool as_mesh : {false, true}) {
    World world;
    world.add_body(floor(0, ice, as_mesh));
    world.add_body(slider(-1, 4));
    if (!as_mesh) world.set_heights(world.bodies()[0], 30, 7, 2, std::array{std::nan(""), 0.25});
    World again;
    build_scene(parse_scene(scene_text(scene_of(world)), "text"), again);
    const BodyDef def = again.definition(again.bodies()[0]);
    EXPECT_EQ(def.materials, std::vector{ice});
    run(world, 60);
    run(again, 60);
    EXPECT_NEAR(world.pose(world.bodies()[1]).position.x(), again.pose(again.bodies()[1]).position.x(), 1e-9);
    if (as_mesh) continue;
    EXPECT_TRUE(std::isnan(std::get<HeightField>(def.shape).heights()[7 * 41 + 30]));
    EXPECT_EQ(std::get<HeightField>(def.shape).materials()[39], 1);
  }
}

TEST(SurfaceMaterials, NumbersAreChecked) {
  World world;
  BodyDef def = floor(0, ice);
  def.materials.clear();
  expect_error([&] { world.add_body(def); }, {"BodyDef.shape", "material 1", "at most 0"});
  def.materials = {{.friction = -1}};
  expect_error([&] { world.add_body(def); }, {"BodyDef.materials[0].friction", "-1"});
  expect_error([&] { HeightField(2, 2, 1, 1, {0, 0, 0, 0}, false, {0, 1}); }, {"2 cells", "expected 1, or none"});
}

}  // namespace
}  // namespace atl::test::surface_materials_test
