// Friction and restitution between two materials, by what a crate and a ball do.

#include <gtest/gtest.h>

#include <cmath>

#include "support/bodies.h"
#include "support/expect_error.h"

namespace atl::test::material_pair_test {
namespace {

constexpr std::uint64_t ice = 7, steel = 3, rubber = 9;

// m/s^2: how a crate of a material slows down as it slides.
double slowed(World& world, std::uint64_t id, double y = 0) {
  BodyDef def = box({0, y, 0.5});
  def.material = {.friction = 0.3, .id = id};
  def.velocity = {8, 0, 0};
  const BodyId crate = world.add_body(def);
  run(world, 20);
  const double before = world.velocity(crate).x();
  run(world, 10);
  return (before - world.velocity(crate).x()) / (10 * dt);
}

TEST(MaterialPair, HasAFrictionOfItsOwn) {
  for (const ContactSolver solver : {ContactSolver::Iterative, ContactSolver::Direct}) {
    World world({.settings = {.contact_solver = solver}});
    world.set_material_pair({.first = steel, .second = ice, .friction = 0.05});
    world.set_material_pair({.first = ice, .second = rubber, .friction = 0.5});
    BodyDef floor = ground(0.3);
    floor.material.id = ice;
    world.add_body(floor);
    EXPECT_NEAR(slowed(world, steel), 0.05 * g, 0.01 * g);
    EXPECT_NEAR(slowed(world, rubber, 3), 0.5 * g, 0.01 * g);
    EXPECT_NEAR(slowed(world, ice, 6), 0.3 * g, 0.01 * g) << "of which nothing was said";
    EXPECT_NEAR(slowed(world, 0, 9), 0.3 * g, 0.01 * g) << "which is no material";
  }
}

TEST(MaterialPair, HasARestitutionOfItsOwn) {
  World world({.gravity = Vector3::Zero()});
  world.set_material_pair({.first = rubber, .second = rubber, .restitution = 0.75});
  BodyDef floor = ground();
  floor.material.id = rubber;
  world.add_body(floor);
  BodyDef def = sphere({0, 0, 1});
  def.material.id = rubber;
  def.velocity = {0, 0, -5};
  const BodyId ball = world.add_body(def);
  run(world, 30);
  EXPECT_NEAR(world.velocity(ball).z(), 5 * 0.75, 1e-3);
}

TEST(MaterialPair, WakesWhatRestsByItAndComesBackWithARestore) {
  World world({.gravity = {g / 4, 0, -g}, .settings = {.sleeping = true}});
  BodyDef floor = ground(0.3), def = box({0, 0, 0.5});
  floor.material.id = ice;
  def.material = {.friction = 0.3, .id = steel};
  world.add_body(floor);
  const BodyId crate = world.add_body(def);
  run(world, 120);
  ASSERT_TRUE(world.is_asleep(crate)) << "0.25 is less than 0.3";
  Snapshot rests, slides;
  world.save(rests);
  world.set_material_pair({.first = ice, .second = steel, .friction = 0.05});
  world.save(slides);
  run(world, 60);
  EXPECT_NEAR(world.velocity(crate).x(), g / 4 - 0.05 * g, 0.02 * g);
  const std::uint64_t hash = world.state_hash();

  World other;
  other.restore(slides);
  run(other, 60);
  EXPECT_EQ(other.state_hash(), hash);
  ASSERT_EQ(other.material_pairs().size(), 1u);
  EXPECT_EQ(other.material_pairs()[0], (MaterialPair{.first = steel, .second = ice, .friction = 0.05}));

  world.restore(rests);
  EXPECT_TRUE(world.material_pairs().empty());
  run(world, 60);
  EXPECT_TRUE(world.is_asleep(crate));

  other.set_material_pair({.first = steel, .second = ice});
  EXPECT_TRUE(other.material_pairs().empty());
  run(other, 240);
  EXPECT_LT(other.velocity(crate).norm(), 0.01) << "its friction is that of the materials again";
}

TEST(MaterialPair, IsInSceneFiles) {
  World world({.gravity = {g / 4, 0, -g}});
  BodyDef floor = ground(0.3);
  floor.material.id = ice;
  world.add_body(floor);
  world.set_material_pair({.first = ice, .second = steel, .friction = 0.05, .restitution = 0.5});
  const Scene scene = parse_scene(scene_text(scene_of(world)), "pairs");
  World built;
  build_scene(scene, built);
  ASSERT_EQ(built.material_pairs().size(), 1u);
  EXPECT_EQ(built.material_pairs()[0], world.material_pairs()[0]);
  expect_error(
      [&] { parse_scene(R"({"format": "atoll-scene", "version": 1, "material_pairs": [{"first": 1}]})", "s"); },
      {"/material_pairs/0", "second", "no material"});
}

TEST(MaterialPair, ThatIsNoneIsRefused) {
  World world;
  expect_error([&] { world.set_material_pair({.first = 1, .friction = 0.1}); }, {"MaterialPair", "id 0"});
  expect_error([&] { world.set_material_pair({.first = 1, .second = 2, .friction = -1}); },
               {"MaterialPair.friction is -1", "not below 0"});
  expect_error([&] { world.set_material_pair({.first = 1, .second = 2, .restitution = std::nan("")}); },
               {"MaterialPair.restitution is nan", "[0, 1]"});
  EXPECT_TRUE(world.material_pairs().empty());
}

}  // namespace
}  // namespace atl::test::material_pair_test
