// How friction and restitution of two materials come together, by what a crate and a ball do.

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "support/bodies.h"
#include "support/expect_error.h"

namespace atl::test::combine_rule_test {
namespace {

constexpr double a = 0.2, b = 0.45;

struct Rules {
  CombineRule first, second;
  double friction, restitution;
};

const std::vector<Rules> all = {
    {CombineRule::Default, CombineRule::Default, 0.3, b},
    {CombineRule::GeometricMean, CombineRule::Default, 0.3, 0.3},
    {CombineRule::Default, CombineRule::Average, 0.325, 0.325},
    {CombineRule::Min, CombineRule::Default, a, a},
    {CombineRule::Default, CombineRule::Max, b, b},
    {CombineRule::Multiply, CombineRule::Multiply, a* b, a* b},
    // The later of two rules, whoever asks for it.
    {CombineRule::Average, CombineRule::GeometricMean, 0.3, 0.3},
    {CombineRule::Min, CombineRule::Average, a, a},
    {CombineRule::Multiply, CombineRule::Min, a* b, a* b},
    {CombineRule::Max, CombineRule::Multiply, b, b},
};

// Coulomb's law: a crate that slides loses mu g.
TEST(CombineRule, GivesTheFrictionThatSlowsACrate) {
  for (const Rules& rules : all) {
    for (const ContactSolver solver : {ContactSolver::Iterative, ContactSolver::Direct}) {
      World world({.settings = {.contact_solver = solver}});
      BodyDef floor = ground(a);
      floor.material.friction_rule = rules.first;
      world.add_body(floor);
      BodyDef def = box({0, 0, 0.5});
      def.material = {.friction = b, .friction_rule = rules.second};
      def.velocity = {8, 0, 0};
      const BodyId crate = world.add_body(def);
      run(world, 20);
      const double before = world.velocity(crate).x();
      run(world, 10);
      EXPECT_NEAR((before - world.velocity(crate).x()) / (10 * dt), rules.friction * g, 0.02 * g);
    }
  }
}

// Newton's law.
TEST(CombineRule, GivesTheRestitutionOfABounce) {
  for (const Rules& rules : all) {
    World world({.gravity = Vector3::Zero()});
    BodyDef floor = ground();
    floor.material = {.restitution = a, .restitution_rule = rules.first};
    world.add_body(floor);
    BodyDef def = sphere({0, 0, 1});
    def.material = {.restitution = b, .restitution_rule = rules.second};
    def.velocity = {0, 0, -5};
    const BodyId ball = world.add_body(def);
    run(world, 30);
    EXPECT_NEAR(world.velocity(ball).z(), 5 * rules.restitution, 1e-3);
  }
}

TEST(CombineRule, FollowsAMaterialThatChangesAndARestore) {
  World world;
  world.add_body(ground(0.9));
  const BodyId crate = world.add_body(box({0, 0, 0.5}));
  run(world, 10);
  world.set_material(crate, {.friction = 0, .friction_rule = CombineRule::Max});
  Snapshot snapshot;
  world.save(snapshot);
  World other;
  other.restore(snapshot);
  EXPECT_EQ(other.material(crate), world.material(crate));
  for (World* of : {&world, &other}) {
    of->set_velocity(crate, {1, 0, 0}, Vector3::Zero());
    run(*of, 20);
    EXPECT_NEAR(of->velocity(crate).x(), 0, 1e-3);
  }
  EXPECT_EQ(other.state_hash(), world.state_hash());
  world.set_material(crate, {.friction = 0});
  world.set_velocity(crate, {1, 0, 0}, Vector3::Zero());
  run(world, 20);
  EXPECT_NEAR(world.velocity(crate).x(), 1, 1e-6);
}

TEST(CombineRule, ThatIsNoneIsRefused) {
  World world;
  expect_error([&] { world.add_body({.material = {.friction_rule = static_cast<CombineRule>(6)}}); },
               {"BodyDef.material.friction_rule is 6", "CombineRule"});
  expect_error([&] { world.add_body({.material = {.restitution_rule = static_cast<CombineRule>(9)}}); },
               {"BodyDef.material.restitution_rule is 9"});
}

}  // namespace
}  // namespace atl::test::combine_rule_test
