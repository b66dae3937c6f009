// Children of a compound that have materials and filters of their own.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace atl {
namespace {

constexpr double dt = 1.0 / 60;

Compound two_blocks(const CompoundChild& like) {
  Compound both;
  for (const double x : {-0.4, 0.4}) {
    both.children.push_back(like);
    both.children.back().position = {x, 0, 0};
  }
  return both;
}

TEST(CompoundChildren, ThatAllHaveOneMaterialAreABodyThatHasIt) {
  const Material slippery{.friction = 0.05, .restitution = 0.3, .rolling_friction = 0.01, .torsional_friction = 0.02};
  for (const ContactSolver solver : {ContactSolver::Auto, ContactSolver::Direct}) {
    for (const int threads : {1, 2}) {
      const auto run = [&](bool by_child) {
        World world({.threads = threads, .settings = {.contact_solver = solver}});
        world.add_body({.type = BodyType::Static,
                        .shape = HalfSpace{},
                        .orientation = Quaternion(Eigen::AngleAxisd(0.1, Vector3::UnitY())),
                        .material = {.friction = 0.05}});
        for (int i = 0; i < 10; ++i) {
          CompoundChild child{.shape = i % 2 == 0 ? ConvexShape(Box{{0.3, 0.3, 0.3}}) : ConvexShape(Sphere{0.3})};
          if (by_child) child.material = slippery;
          world.add_body({.shape = two_blocks(child),
                          .position = {0.3 * (i % 2), 0, 1 + 0.8 * i},
                          .material = by_child ? Material{} : slippery});
        }
        for (int i = 0; i < 120; ++i) world.step(dt);
        return world.state_hash();
      };
      EXPECT_EQ(run(true), run(false));
    }
  }
}

// On a slope that holds the one and not the other, at the friction of each child.
TEST(CompoundChildren, RubWithTheirOwnFriction) {
  constexpr double slope = 0.3;
  const Quaternion tilt(Eigen::AngleAxisd(slope, Vector3::UnitY()));
  const auto speed_with = [&](double left, double right, ContactSolver solver) {
    World world({.settings = {.contact_solver = solver}});
    world.add_body({.type = BodyType::Static, .shape = HalfSpace{}, .orientation = tilt, .material = {.friction = 1}});
    Compound skis{{{.shape = Box{{0.5, 0.1, 0.1}}, .position = {0, -0.4, -0.1}, .material = Material{.friction = left}},
                   {.shape = Box{{0.5, 0.1, 0.1}}, .position = {0, 0.4, -0.1}, .material = Material{.friction = right}},
                   {.shape = Box{{0.5, 0.5, 0.1}}, .position = {0, 0, 0.1}}}};
    const BodyId sled = world.add_body({.shape = skis,
                                        .position = tilt * Vector3(0, 0, 0.2),
                                        .orientation = tilt,
                                        .locks = MotionLocks{.angular = {true, true, true}}});
    for (int i = 0; i < 60; ++i) world.step(dt);
    return world.velocity(sled).norm();
  };
  for (const ContactSolver solver : {ContactSolver::Auto, ContactSolver::Iterative}) {
    const double g_along = 9.81 * std::sin(slope), g_across = 9.81 * std::cos(slope);
    EXPECT_NEAR(speed_with(0, 0, solver), g_along, 0.02 * g_along);
    // Friction is the root of the product with the ground's 1. How the skis share the load is open: nothing turns.
    const double held = g_along - 0.2 * g_across;
    EXPECT_NEAR(speed_with(0.04, 0.04, solver), held, 0.02 * g_along);
    EXPECT_GT(speed_with(0, 0.04, solver), held + 0.1);
    EXPECT_LT(speed_with(0, 0.04, solver), g_along - 0.1);
    EXPECT_LT(speed_with(1, 1, solver), 0.01);
  }
}

TEST(CompoundChildren, KeepTheirFiltersWhateverTheBodyGets) {
  constexpr CollisionFilter ghost{.mask = 0};
  World world;
  world.add_body({.type = BodyType::Static, .shape = HalfSpace{}});
  // The lower ball meets nothing, so the body comes to rest on the upper one, turned over or not: its locks keep it.
  const BodyId body =
      world.add_body({.shape = Compound{{{.shape = Sphere{0.2}, .position = {0, 0, -0.5}, .filter = ghost},
                                         {.shape = Sphere{0.2}, .position = {0, 0, 0.5}}}},
                      .position = {0, 0, 2},
                      .locks = MotionLocks{.angular = {true, true, true}}});
  const auto settle = [&](int steps) {
    for (int i = 0; i < steps; ++i) world.step(dt);
    return world.pose(body).position.z();
  };
  EXPECT_NEAR(settle(180), -0.3, 2e-3);
  Snapshot resting;
  world.save(resting);
  world.set_filter(body, {.category = 2});
  EXPECT_NEAR(settle(30), -0.3, 2e-3) << "the child keeps its own";
  world.set_filter(body, ghost);
  EXPECT_LT(settle(30), -0.5);
  world.restore(resting);
  EXPECT_NEAR(settle(30), -0.3, 2e-3);
  std::vector<BodyId> found = Queries(world).overlapping({.shape = Sphere{0.1}, .position = {0, 0, 0.2}}, {.mask = 1});
  EXPECT_EQ(found, std::vector{body});
}

TEST(CompoundChildren, MaterialsAreChecked) {
  World world;
  try {
    world.add_body({.shape = Compound{{{.shape = Box{}}, {.shape = Box{}, .material = Material{.friction = -1}}}}});
    ADD_FAILURE() << "it was taken";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(),
                 "BodyDef.shape: Compound.children[1].material.friction is -1; expected a finite number not below 0");
  }
}

// The children that pushed most, of both, and in the order of the bodies.
TEST(ContactEvents, NameChildren) {
  World world({.settings = {.contact_events = true}});
  const Compound stairs{
      {{.shape = Box{{1, 1, 0.5}}, .position = {-1, 0, 0}}, {.shape = Box{{1, 1, 1}}, .position = {1, 0, 0}}}};
  const BodyId low = world.add_body({.type = BodyType::Static, .shape = stairs});
  const Compound dumbbell{{{.shape = Sphere{0.1}, .position = {0, 0, 0.3}},
                           {.shape = Sphere{0.1}, .position = {0, 0.3, 0}},
                           {.shape = Sphere{0.1}, .position = {0, 0, -0.3}}}};
  const BodyId high = world.add_body({.shape = dumbbell, .position = {1, 0, 1.5}});
  for (int i = 0; i < 60; ++i) {
    world.step(dt);
    for (const ContactEvent& event : world.contact_events()) {
      EXPECT_EQ(event.a, low);
      EXPECT_EQ(event.b, high);
      EXPECT_EQ(event.child_a, 1u);
      EXPECT_EQ(event.child_b, 2u);
      return;
    }
  }
  ADD_FAILURE() << "it never landed";
}

// A table on two legs of which each stands on a step of its own.
TEST(ContactForces, NameChildren) {
  World world;
  const Compound stairs{
      {{.shape = Box{{1, 1, 0.5}}, .position = {-1, 0, 0}}, {.shape = Box{{1, 1, 1}}, .position = {1, 0, 0}}}};
  world.add_body({.type = BodyType::Static, .shape = stairs});
  const Compound table{{{.shape = Box{{1, 0.2, 0.1}}, .position = {0, 0, 1}},
                        {.shape = Box{{0.1, 0.2, 0.5}}, .position = {-0.9, 0, 0.5}},
                        {.shape = Box{{0.1, 0.2, 0.25}}, .position = {0.9, 0, 0.75}}}};
  world.add_body({.shape = table, .position = {0, 0, 0.5}});
  for (int i = 0; i < 60; ++i) world.step(dt);
  int by_leg[3] = {};
  for (const ContactForce& force : world.contact_forces()) {
    EXPECT_EQ(force.child_a, force.child_b - 1) << "of leg " << force.child_b;
    EXPECT_EQ(force.position.x() > 0, force.child_b == 2);
    ++by_leg[force.child_b];
  }
  EXPECT_EQ(by_leg[0], 0);
  EXPECT_EQ(by_leg[1], 4);
  EXPECT_EQ(by_leg[2], 4);
}

// A contact event reports the sum of the contact's forces.
TEST(ContactEvents, TellWhereAndHowHard) {
  World world({.settings = {.contact_events = true}});
  const BodyId floor = world.add_body({.type = BodyType::Static, .shape = Box{{5, 5, 0.5}}, .position = {0, 0, -0.5}});
  const BodyId crate = world.add_body({.shape = Box{{0.5, 0.4, 0.3}}, .position = {1, 2, 1}});
  int events = 0;
  for (int i = 0; i < 60; ++i) {
    const double falling = -world.velocity(crate).z();
    world.step(dt);
    for (const ContactEvent& event : world.contact_events()) {
      ++events;
      ASSERT_TRUE(event.began);
      EXPECT_NEAR(event.approach_speed, falling, 1e-6);
      // It stops: the rest is the weight over the step.
      const double weight = 9.81 * world.mass(crate) * dt;
      EXPECT_NEAR(event.impulse, world.mass(crate) * (falling + world.velocity(crate).z()) + weight, 1e-3 * weight);
      EXPECT_EQ(event.a, floor);
      EXPECT_EQ(event.b, crate);
      double force = 0;
      Vector3 moment = Vector3::Zero();
      for (const ContactForce& of : world.contact_forces(crate)) {
        force += of.normal_force;
        moment += of.normal_force * of.position;
      }
      EXPECT_NEAR(event.normal_force, force, 1e-9 * force);
      EXPECT_TRUE(event.normal.isApprox(Vector3::UnitZ(), 1e-6)) << event.normal.transpose();
      EXPECT_GT(force, 0);
      EXPECT_TRUE(event.point.isApprox(moment / force, 1e-9)) << event.point.transpose();
    }
  }
  EXPECT_EQ(events, 1);
  Settings off;
  world.set_settings(off);
  EXPECT_THROW(world.contact_events(), Error);
}

// Bodies share the data of their kind only if their children's own materials and filters are equal, too.
TEST(CompoundChildren, KeepTheirOwnBesideABodyThatIsOtherwiseAlike) {
  World world;
  const auto add = [&](double friction, std::uint32_t mask) {
    Compound compound;
    compound.children.push_back(
        {.shape = Box{}, .material = Material{.friction = friction}, .filter = CollisionFilter{.mask = mask}});
    compound.children.push_back({.shape = Sphere{0.2}, .position = {2, 0, 0}});
    return world.add_body({.shape = compound});
  };
  const auto first_child = [&](BodyId body) { return std::get<Compound>(world.definition(body).shape).children[0]; };
  const BodyId a = add(0.1, 1), b = add(0.9, 1), c = add(0.9, 2);
  EXPECT_EQ(first_child(a).material->friction, 0.1);
  EXPECT_EQ(first_child(b).material->friction, 0.9);
  EXPECT_EQ(first_child(b).filter->mask, 1u);
  EXPECT_EQ(first_child(c).filter->mask, 2u);
}

}  // namespace
}  // namespace atl
