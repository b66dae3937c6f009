// Settings and materials mean the same whichever solver an island gets: at the defaults that follows from how much its
// contacts carry, so columns of a few boxes more must not behave otherwise.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/bodies.h"
#include "support/random.h"

namespace atl::test {
namespace {

BodyDef belt(double speed) {
  BodyDef def = static_box({0, 0, -0.5}, {20, 20, 0.5});
  def.surface_velocity = {speed, 0, 0};
  return def;
}

// Returns how many steps an island was solved at once in.
std::int64_t run_direct(World& world, int steps) {
  std::int64_t direct = 0;
  for (int i = 0; i < steps; ++i) direct += world.step(dt).counts.direct_islands;
  return direct;
}

// A heavy body on a light one that hangs on joints is solved at once with them, but not if anything there has locks:
// those are kept to the last bit.
TEST(SolverChoice, LockedBodiesOnLoadedJointsStayLocked) {
  for (const bool locked : {false, true}) {
    World world;
    const BodyId wall = world.add_body(static_box({-1.2, 0, 1}, {0.2, 1, 0.2}));
    BodyDef plank = box({0, 0, 1}, {1, 0.5, 0.05});
    plank.mass = 1;
    const BodyId hanging = world.add_body(plank);
    JointDef hinge{.kind = HingeJoint{}, .first = wall, .second = hanging};
    hinge.frame_first = {{0.2, 0, 0}, Quaternion(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3::UnitZ()))};
    hinge.frame_second = {{-1, 0, 0}, hinge.frame_first.orientation};
    world.add_joint(hinge);
    BodyDef heavy = box({0.3, 0.1, 1.3}, {0.25, 0.25, 0.25});
    heavy.mass = 50;
    heavy.velocity = {0.5, 0, 0};
    if (locked) {
      heavy.locks.linear[1] = true;
      heavy.locks.angular = {true, false, true};
    }
    const BodyId load = world.add_body(heavy);
    std::int64_t direct = 0;
    for (int i = 0; i < 60; ++i) {
      direct += world.step(dt).counts.direct_islands;
      if (!locked) continue;
      ASSERT_EQ(world.velocity(load).y(), 0) << "step " << i;
      ASSERT_EQ(world.angular_velocity(load).x(), 0) << "step " << i;
      ASSERT_EQ(world.angular_velocity(load).z(), 0) << "step " << i;
    }
    EXPECT_EQ(direct > 0, !locked);
  }
}

// Nothing gives way between bodies that may not move, however they overlap: no impulse is told, and none is stored.
TEST(SolverChoice, LockedBodiesThatOverlapPushNothing) {
  for (const ContactSolver solver : {ContactSolver::Iterative, ContactSolver::Direct}) {
    Settings settings;
    settings.contact_solver = solver;
    for (unsigned seed = 0; seed < 200; ++seed) {
      Random random(seed);
      World world({.settings = settings});
      BodyDef held = sphere({0, 0, 2});
      held.locks.linear = {true, true, true};
      world.add_body(held);
      held.position += 0.95 * random.direction();
      held.mass = random.real(0.5, 3);
      const BodyId beside = world.add_body(held);
      world.step(dt);
      ASSERT_LT(world.contact_wrench(beside).force.norm(), 1) << "seed " << seed;
      ASSERT_EQ(world.pose(beside).position, held.position) << "seed " << seed;
    }
  }
}

TEST(SolverChoice, ABeltCarriesColumnsOfAnyHeight) {
  for (const int height : {1, 3, 5, 6, 7, 9}) {
    World world;
    world.add_body(belt(0.5));
    std::vector<BodyId> ids;
    for (int i = 0; i < height; ++i) {
      BodyDef def = box({0, 0, 0.5 + i});
      def.material.friction = i == 0 ? 0.6 : 2;  // none but the lowest slips
      ids.push_back(world.add_body(def));
    }
    const std::int64_t direct = run_direct(world, 120);
    if (height >= 6) {
      EXPECT_GT(direct, 100);
    }
    // It slips for v / (mu g), and tall columns lean as they are set in motion.
    for (const BodyId id : ids)
      EXPECT_NEAR(world.pose(id).position.x(), 1 - 0.5 * 0.5 * 0.5 / (0.6 * g), 0.06) << height;
  }
}

TEST(SolverChoice, ABeltCarriesFlatBoxesAndAHeavyCrateOnAPallet) {
  for (const bool pallet : {false, true}) {
    World world;
    world.add_body(belt(0.5));
    std::vector<BodyId> ids;
    for (int i = 0; i < (pallet ? 2 : 6); ++i) {
      BodyDef def = box({0, 0, 0.25 + 0.5 * i}, {0.5, 0.5, 0.25});
      def.material.friction = i == 0 ? 0.6 : 2;
      if (pallet) def.density = i == 0 ? 60 : 7800;
      ids.push_back(world.add_body(def));
    }
    EXPECT_GT(run_direct(world, 120), 100) << pallet;
    for (const BodyId id : ids) EXPECT_NEAR(world.pose(id).position.x(), 0.98, 0.015) << pallet;
  }
}

// Springs of 5 Hz, and of twice that on the ground: the four points of a face are as stiff as half of the box at a box,
// and as all of it on the ground.
TEST(SolverChoice, SoftContactsSagByWhatTheyCarry) {
  const auto square = [](double hertz) { return std::pow(2 * std::numbers::pi * hertz, 2); };
  const double expected = 3 * g / square(10) + (2 + 1) * 2 * g / square(5);
  for (const ContactSolver solver : {ContactSolver::Iterative, ContactSolver::Auto, ContactSolver::Direct}) {
    World world({.settings = {.contact_hertz = 5, .contact_solver = solver}});
    world.add_body(ground());
    const std::vector<BodyId> ids = add_stack(world, 3);
    run(world, 600);
    const double sag = 2.5 - world.pose(ids[2]).position.z();
    // A sweep a substep comes to a little less.
    EXPECT_NEAR(sag, expected, (solver == ContactSolver::Iterative ? 0.05 : 0.01) * expected);
  }
}

// Boxes that start one in another: all six contacts part by as much.
TEST(SolverChoice, OverlapIsPushedApartNoFasterThanIsAskedFor) {
  const auto rise = [](ContactSolver solver, double push_speed) {
    World world({.settings = {.contact_push_speed = push_speed, .contact_solver = solver}});
    world.add_body(ground());
    std::vector<BodyId> ids;
    for (int i = 0; i < 7; ++i) ids.push_back(world.add_body(box({0, 0, 0.5 + 0.9 * i})));
    run(world, 30);
    return world.pose(ids.back()).position.z() - 5.9;
  };
  for (const ContactSolver solver : {ContactSolver::Auto, ContactSolver::Direct}) {
    EXPECT_NEAR(rise(solver, 0.05), 6 * 0.05 * 0.5, 0.01);
    EXPECT_NEAR(rise(solver, 0.1), 6 * 0.1 * 0.5, 0.02);
    EXPECT_GT(rise(solver, 3), 0.4);
  }
}

// A column of slabs that moves as one, of which none but the lowest slips. Returns the lowest, which is as `foot` says.
BodyId add_slabs(World& world, int count, const BodyDef& foot) {
  BodyId lowest;
  for (int i = 0; i < count; ++i) {
    BodyDef slab = foot;
    slab.shape = Box{{0.5, 0.5, 0.05}};
    slab.position = {0, 0, 0.05 + 0.1 * i};
    if (i > 0) slab.material = {.friction = 2};
    const BodyId id = world.add_body(slab);
    if (i == 0) lowest = id;
  }
  return lowest;
}

// A column that slides at an angle to the pyramid's axes.
TEST(SolverChoice, ThePyramidBindsEachAxisByItself) {
  const auto slides_to = [](ContactSolver solver, FrictionModel friction) {
    World world({.settings = {.friction = friction, .contact_solver = solver}});
    world.add_body(ground(0.3));
    BodyDef foot;
    foot.material.friction = 0.3;
    foot.velocity = {2, 1, 0};
    const BodyId id = add_slabs(world, 8, foot);
    run(world, 120);
    return world.pose(id).position;
  };
  for (const FrictionModel friction : {FrictionModel::Cone, FrictionModel::Pyramid}) {
    const Vector3 swept = slides_to(ContactSolver::Iterative, friction);
    const Vector3 direct = slides_to(ContactSolver::Direct, friction);
    EXPECT_LT((direct - swept).norm(), 0.02 * swept.norm()) << direct.transpose() << "; swept " << swept.transpose();
    const Vector3 at_defaults = slides_to(ContactSolver::Auto, friction);
    EXPECT_LT((at_defaults - swept).norm(), 0.02 * swept.norm()) << at_defaults.transpose();
  }
}

// A heavy slab that coasts on rollers.
TEST(SolverChoice, RollingFrictionStopsASlabOnRollers) {
  const auto coasts_to = [](ContactSolver solver, double rolling_friction) {
    World world({.settings = {.contact_solver = solver}});
    world.add_body(ground());
    for (const double x : {-0.8, 0.0, 0.8}) {
      BodyDef roller{.shape = Cylinder{.radius = 0.1, .half_height = 0.5}, .position = {x, 0, 0.1}};
      roller.orientation = Quaternion(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3::UnitX()));
      roller.material.rolling_friction = rolling_friction;
      roller.velocity = {0.25, 0, 0};
      roller.angular_velocity = {0, 2.5, 0};
      world.add_body(roller);
    }
    BodyDef slab = box({0, 0, 0.25}, {1.5, 0.5, 0.05});
    slab.density = 8000;
    slab.velocity = {0.5, 0, 0};
    const BodyId id = world.add_body(slab);
    run(world, 120);
    return world.pose(id).position.x();
  };
  // It rolls over both ends of a diameter, which the slab passes twice as fast as the axle does.
  const double expected = 0.5 * 2 - 0.002 / 0.1 * g * 2;
  EXPECT_NEAR(coasts_to(ContactSolver::Iterative, 0.002), expected, 0.06 * expected);
  EXPECT_NEAR(coasts_to(ContactSolver::Direct, 0.002), expected, 0.02 * expected);
  EXPECT_NEAR(coasts_to(ContactSolver::Auto, 0.002), expected, 0.02 * expected);
  EXPECT_GT(coasts_to(ContactSolver::Direct, 0), 0.95);
}

// A column that spins on its foot.
TEST(SolverChoice, TorsionalFrictionStopsASpinningColumn) {
  const auto turned = [](ContactSolver solver, double torsional_friction) {
    World world({.settings = {.contact_solver = solver}});
    world.add_body(ground());
    BodyDef foot;
    foot.material.friction = 0.05;
    foot.material.torsional_friction = torsional_friction;
    foot.angular_velocity = {0, 0, 2};
    const BodyId id = add_slabs(world, 7, foot);
    run(world, 12);
    return world.angular_velocity(id).z();
  };
  for (const double torsional_friction : {0.0, 0.03}) {
    const double swept = turned(ContactSolver::Iterative, torsional_friction);
    EXPECT_NEAR(turned(ContactSolver::Direct, torsional_friction), swept, 0.02 * 2) << torsional_friction;
    EXPECT_NEAR(turned(ContactSolver::Auto, torsional_friction), swept, 0.02 * 2) << torsional_friction;
  }
  EXPECT_LT(turned(ContactSolver::Direct, 0.03), turned(ContactSolver::Direct, 0) - 0.2);
}

}  // namespace
}  // namespace atl::test
