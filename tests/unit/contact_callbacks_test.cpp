// Functions of the user's that say who may touch, and how: when they are asked, in which order, and what comes of it.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <tuple>
#include <utility>
#include <vector>

#include "support/bodies.h"
#include "support/expect_error.h"
#include "support/temporary_file.h"

namespace atl::test {
namespace {

using Asked = std::tuple<BodyId, BodyId, std::uint32_t, std::uint32_t>;

Asked asked(const ContactCandidate& of) { return {of.a, of.b, of.child_a, of.child_b}; }

// One crate falls through the table as its contact is switched off, and at about the step in which it is gone the other
// one's is. Who comes first, and so whose contact takes whose place in memory, must not matter.
TEST(ContactModifier, WhatIsSwitchedOffAsAnotherContactEndsFalls) {
  for (const bool first_falls : {true, false}) {
    const auto drop = [&](int from) {
      World world;
      world.add_body(static_box({0, 0, -0.1}, {9, 9, 0.1}));
      const BodyId a = world.add_body(box({-2, 0, 0.5}));
      const BodyId b = world.add_body(box({2, 0, 0.5}));
      const BodyId falls = first_falls ? a : b, stays = first_falls ? b : a;
      int step = 0;
      world.set_contact_modifier([&](ModifiableContact& contact) {
        contact.enabled = contact.b != falls && (contact.b != stays || step < from);
      });
      int gone = 0;
      for (; step < 120; ++step) {
        const StepReport report = world.step(dt);
        if (gone == 0 && report.counts.asked_contacts == 1) gone = step;
      }
      return std::pair(gone, world.pose(stays).position.z());
    };
    const auto [gone, height] = drop(1000);
    ASSERT_GT(gone, 10);
    EXPECT_NEAR(height, 0.5, 1e-3);
    for (int from = gone - 2; from <= gone + 2; ++from) {
      EXPECT_LT(drop(from).second, -1) << "switched off from step " << from << " on; the other one is gone at " << gone;
    }
  }
}

TEST(ContactFilter, TellsChildrenApart) {
  World world;
  world.add_body(ground());
  // The lower ball passes through the ground; the body comes to rest on the upper one.
  const BodyId body = world.add_body({.shape = Compound{{{.shape = Sphere{0.2}, .position = {0, 0, -0.5}},
                                                         {.shape = Sphere{0.2}, .position = {0, 0, 0.5}}}},
                                      .position = {0, 0, 2},
                                      .locks = MotionLocks{.angular = {true, true, true}}});
  world.set_contact_filter([&](const ContactCandidate& of) { return of.child_b == 1; });
  run(world, 180);
  EXPECT_NEAR(world.pose(body).position.z(), -0.3, 2e-3);
}

TEST(ContactFilter, IsAskedAgainWhereItsMindChanged) {
  World world({.settings = {.sleeping = true, .time_to_sleep = 0.1}});
  const BodyId shelf = world.add_body({.type = BodyType::Static, .shape = Box{{1, 1, 0.1}}, .position = {0, 0, 2}});
  world.add_body(ground());
  const BodyId crate = world.add_body(box({0, 0, 2.6}));
  bool holds = true;
  int questions = 0;
  world.set_contact_filter([&](const ContactCandidate& of) {
    ++questions;
    return of.a != shelf || holds;
  });
  run(world, 60);
  ASSERT_TRUE(world.is_asleep(crate));
  const std::uint64_t resting = world.state_hash();
  const int asked_so_far = questions;
  world.refilter(shelf);
  EXPECT_FALSE(world.is_asleep(crate));
  EXPECT_NE(world.state_hash(), resting) << "the next step depends on it";
  EXPECT_FALSE(world.contact_forces(crate).empty());
  world.step(dt);
  EXPECT_EQ(questions, asked_so_far + 1);
  double force = 0;
  for (const ContactForce& of : world.contact_forces(crate)) force += of.normal_force;
  EXPECT_NEAR(force, world.mass(crate) * g, 1e-3 * world.mass(crate) * g) << "it keeps its impulses";

  holds = false;
  run(world, 30);
  EXPECT_NEAR(world.pose(crate).position.z(), 2.6, 2e-3) << "nobody asked";
  world.refilter(crate);
  run(world, 15);
  EXPECT_LT(world.pose(crate).position.z(), 2.4);
  EXPECT_EQ(world.contact_forces(crate).size(), 0u);
  // Within the shelf it is let touch again, and is pushed out of it.
  holds = true;
  world.refilter(shelf);
  run(world, 10);
  EXPECT_FALSE(world.contact_forces(crate).empty());
  // Without a filter nothing is refused once it is asked for.
  holds = false;
  world.refilter(shelf);
  world.step(dt);
  EXPECT_TRUE(world.contact_forces(crate).empty());
  world.set_contact_filter({});
  world.step(dt);
  EXPECT_TRUE(world.contact_forces(crate).empty()) << "what was refused stays so";
  world.refilter(shelf);
  world.step(dt);
  EXPECT_FALSE(world.contact_forces(crate).empty());
  world.remove_body(shelf);
  EXPECT_THROW(world.refilter(shelf), Error);
}

TEST(ContactFilter, WhatItSaidIsForgottenWithTheBounds) {
  World world({.gravity = Vector3::Zero()});
  const BodyId wall = world.add_body({.type = BodyType::Static, .shape = Box{{0.1, 1, 1}}});
  const BodyId ball = world.add_body(sphere({-1, 0, 0}, 0.2));
  int questions = 0;
  world.set_contact_filter([&](const ContactCandidate&) { return ++questions, false; });
  world.set_velocity(ball, {2, 0, 0}, Vector3::Zero());
  run(world, 120);
  EXPECT_NEAR(world.pose(ball).position.x(), 3, 1e-9);
  EXPECT_EQ(questions, 1) << "it passed through without another question";
  world.set_velocity(ball, {-2, 0, 0}, Vector3::Zero());
  run(world, 120);
  EXPECT_EQ(questions, 2);
  world.set_shape(ball, Sphere{0.25});
  world.set_pose(ball, {{0.2, 0, 0}});
  world.step(dt);
  EXPECT_EQ(questions, 3) << "another shape is another pair";
  world.remove_body(ball);
  const BodyId other = world.add_body(sphere({0.2, 0, 0}, 0.2));
  EXPECT_EQ(other.index, ball.index);
  world.step(dt);
  EXPECT_EQ(questions, 4);
  world.remove_body(wall);
  run(world, 3);
}

TEST(ContactFilter, ContinuousCollisionAndQueriesGoByIt) {
  for (const bool lets_pass : {false, true}) {
    for (const int threads : {1, 2}) {
      World world({.gravity = Vector3::Zero(), .threads = threads});
      const BodyId wall = world.add_body({.type = BodyType::Static, .shape = Box{{0.01, 5, 5}}});
      BodyDef def = sphere({-30, 0, 0}, 0.05);
      def.velocity = {1000, 0, 0};
      def.continuous = true;
      const BodyId bullet = world.add_body(def);
      std::vector<Asked> questions;
      world.set_contact_filter([&](const ContactCandidate& of) {
        questions.push_back(asked(of));
        return !lets_pass;
      });
      run(world, 4);
      EXPECT_EQ(world.pose(bullet).position.x() > 1, lets_pass) << world.pose(bullet).position.x();
      ASSERT_FALSE(questions.empty());
      EXPECT_EQ(questions.front(), Asked(wall, bullet, 0, 0));
    }
  }
  World world({.gravity = Vector3::Zero()});
  const BodyId near = world.add_body({.type = BodyType::Static, .shape = Box{{0.1, 1, 1}}, .position = {0.5, 0, 0}});
  const BodyId far = world.add_body({.type = BodyType::Static, .shape = Box{{0.1, 1, 1}}, .position = {3, 0, 0}});
  const BodyId ball = world.add_body(sphere({0, 0, 0}, 0.4));
  const BodyId pet = world.add_body(sphere({1.5, 0, 0}, 0.2));
  world.set_collision_enabled(ball, pet, false);
  const Queries queries(world);
  const Ray ray{.origin = Vector3::Zero(), .direction = {1, 0, 0}};
  EXPECT_EQ(queries.cast_ray(ray)->body, ball);
  EXPECT_EQ(queries.cast_ray(ray, {.as = ball})->body, near);
  world.step(dt);
  world.set_contact_filter([&](const ContactCandidate& of) { return of.a != near && of.b != near; });
  world.step(dt);
  EXPECT_EQ(queries.cast_ray(ray, {.as = ball})->body, near) << "they were near before there was a filter";
  world.refilter(ball);
  world.step(dt);
  EXPECT_EQ(queries.cast_ray(ray, {.as = ball})->body, far);
  EXPECT_EQ(queries.cast_ray(ray, {.ignore = std::span(&ball, 1)})->body, near);
  world.remove_body(ball);
  EXPECT_THROW(queries.cast_ray(ray, {.as = ball}), Error);
}

// Lets through what comes from below.
void one_way(ModifiableContact& contact, BodyId platform) {
  if (contact.a != platform && contact.b != platform) return;
  const double up = contact.a == platform ? contact.normal.z() : -contact.normal.z();
  const BodyId other = contact.a == platform ? contact.b : contact.a;
  const bool comes_from_above = up > 0.7 && contact.world.velocity(other).z() < 0.01;
  const double below = contact.world.pose(other).position.z() - contact.world.pose(platform).position.z();
  if (!comes_from_above || below < 0.5) contact.enabled = false;
}

TEST(ContactModifier, MakesAPlatformThatHoldsFromAboveAndLetsThroughFromBelow) {
  for (const ContactSolver solver : {ContactSolver::Auto, ContactSolver::Direct, ContactSolver::Iterative}) {
    for (const double speed : {9.0, 60.0}) {
      World world({.settings = {.contact_solver = solver, .sleeping = true, .contact_events = true}});
      // The platform comes after the box or before it, so that the normal points either way.
      BodyDef jumper = box({0, 0, 0.5});
      jumper.velocity = {0, 0, speed};
      const BodyId first = world.add_body(jumper);
      const BodyId platform =
          world.add_body({.type = BodyType::Static, .shape = Box{{2, 2, 0.1}}, .position = {0, 0, 2}});
      jumper.position.x() = 1.2;
      const BodyId second = world.add_body(jumper);
      world.set_contact_modifier([&](ModifiableContact& contact) { one_way(contact, platform); });
      double highest = 0;
      int events = 0;
      for (int i = 0; i < 1200; ++i) {
        world.step(dt);
        highest = std::max(highest, world.pose(first).position.z());
        for (const ContactEvent& event : world.contact_events()) events += event.began;
      }
      const double free = 0.5 + speed * speed / (2 * g);
      EXPECT_NEAR(highest, free, 0.02 * free) << "nothing slowed it on its way up";
      for (const BodyId id : {first, second}) {
        EXPECT_NEAR(world.pose(id).position.z(), 2.6, 5e-3);
        EXPECT_TRUE(world.is_asleep(id));
      }
      EXPECT_EQ(events, 2) << "what is switched off touches nobody";
    }
  }
}

// Distance until friction has stopped a block: v^2 / (2 mu g), with mu where it lies.
TEST(ContactModifier, MakesSlipperySpots) {
  constexpr double speed = 3, slippery = 0.15, plain = 0.6;
  for (const ContactSolver solver : {ContactSolver::Auto, ContactSolver::Direct, ContactSolver::Iterative}) {
    World world({.settings = {.contact_solver = solver}});
    world.add_body({.type = BodyType::Static, .shape = HalfSpace{}, .material = {.friction = plain}});
    const auto block = [&](double y) {
      BodyDef def{.shape = Box{{0.5, 0.5, 0.1}}, .position = {0, y, 0.1}, .velocity = {speed, 0, 0}};
      def.material.friction = plain;
      return world.add_body(def);
    };
    const BodyId on_ice = block(0), beside = block(5);
    world.set_contact_modifier([&](ModifiableContact& contact) {
      EXPECT_NEAR(contact.friction, plain, 1e-6) << "each step begins with what materials say";
      const bool iced = std::all_of(contact.points.begin(), contact.points.end(),
                                    [](const ModifiablePoint& point) { return point.position.y() < 1; });
      if (iced) contact.friction = slippery;
    });
    run(world, 240);
    const auto distance = [&](double mu) { return speed * speed / (2 * mu * g); };
    EXPECT_NEAR(world.pose(on_ice).position.x(), distance(slippery), 0.02 * distance(slippery));
    EXPECT_NEAR(world.pose(beside).position.x(), distance(plain), 0.03 * distance(plain));
    // Frictionless materials can be made to rub, and back.
    world.set_contact_modifier({});
    world.set_velocity(on_ice, {speed, 0, 0}, Vector3::Zero());
    const double x = world.pose(on_ice).position.x();
    run(world, 120);
    EXPECT_NEAR(world.pose(on_ice).position.x() - x, distance(plain), 0.03 * distance(plain));
  }
}

TEST(ContactModifier, MakesConveyorPatchesInEitherOrderOfBodies) {
  for (const ContactSolver solver : {ContactSolver::Auto, ContactSolver::Direct, ContactSolver::Iterative}) {
    World world({.settings = {.contact_solver = solver, .sleeping = true}});
    const BodyId early = world.add_body(box({0, 0, 0.5}));
    const BodyId floor = world.add_body(ground());
    const BodyId late = world.add_body(box({0, 3, 0.5}));
    const BodyId beside = world.add_body(box({-3, 0, 0.5}));
    world.set_contact_modifier([&](ModifiableContact& contact) {
      if (contact.points[0].position.x() > -1) contact.run_surface(floor, {1, 0, 5});
    });
    run(world, 180);
    for (const BodyId id : {early, late}) {
      EXPECT_NEAR(world.velocity(id).x(), 1, 1e-3);
      EXPECT_NEAR(world.velocity(id).z(), 0, 1e-3) << "what is along the normal is void";
      // It is taken up to speed by friction 0.6: t = v / (mu g), half of which is lost.
      EXPECT_NEAR(world.pose(id).position.x(), 3 - 1 / (2 * 0.6 * g), 0.05);
    }
    EXPECT_TRUE(world.is_asleep(beside));
    world.set_contact_modifier({});
    run(world, 60);
    EXPECT_NEAR(world.velocity(early).norm(), 0, 1e-3);
  }
}

TEST(ContactModifier, ChangesHowMuchBounces) {
  World world({.settings = {.substeps = 8}});
  const BodyId floor = world.add_body(ground());
  const BodyId ball = world.add_body(sphere({0, 0, 2.1}, 0.1));
  const BodyId dull = world.add_body(sphere({2, 0, 2.1}, 0.1));
  world.set_contact_modifier([&](ModifiableContact& contact) {
    EXPECT_EQ(contact.a, floor);
    if (contact.b == ball) contact.restitution = 0.8;
  });
  double highest = 0, highest_dull = 0;
  for (int i = 0; i < 110; ++i) {
    world.step(dt);
    if (i > 50) highest = std::max(highest, world.pose(ball).position.z() - 0.1);
    if (i > 50) highest_dull = std::max(highest_dull, world.pose(dull).position.z() - 0.1);
  }
  EXPECT_NEAR(highest, 2 * 0.8 * 0.8, 0.08);
  EXPECT_LT(highest_dull, 0.05);
}

// A block that is held up under one half alone tips over; under the inner points of both halves it stays.
TEST(ContactModifier, SwitchesPointsOff) {
  for (const ContactSolver solver : {ContactSolver::Auto, ContactSolver::Direct, ContactSolver::Iterative}) {
    World world({.settings = {.contact_solver = solver, .keep_contact_problem = true}});
    world.add_body(ground());
    const BodyId block = world.add_body({.shape = Box{{0.5, 0.5, 0.1}}, .position = {0, 0, 0.1}});
    world.set_contact_modifier([&](ModifiableContact& contact) {
      for (ModifiablePoint& point : contact.points) {
        if (point.position.x() < 0) point.enabled = false;
      }
    });
    world.step(dt);
    // Held at x = 0.5 m under its weight, a square plate turns at first by w' = m g r / (I + m r^2).
    const double inertia = (1.0 * 1.0 + 0.2 * 0.2) / 12 + 0.1 * 0.1;
    const double turn = g * 0.5 / (inertia + 0.25);
    EXPECT_NEAR(world.angular_velocity(block).y(), -turn * dt, 0.15 * turn * dt);
    for (const ContactForce& force : world.contact_forces()) EXPECT_GT(force.position.x(), 0.4);
    EXPECT_EQ(world.contact_forces().size(), 2u);
    ASSERT_EQ(world.contact_problem().patches.size(), 1u);
    EXPECT_EQ(world.contact_problem().patches[0].points.size(), 2u);
    world.set_contact_modifier({});
    run(world, 120);
    EXPECT_NEAR(world.pose(block).position.z(), 0.1, 2e-3);
  }
}

// A ball in a groove touches both of its sides, a mesh's, in manifolds of their own. Without the left one it rolls down
// along the right one.
TEST(ContactModifier, TellsTheSidesOfAMeshApart) {
  const std::vector<Vector3> vertices = {{0, -3, 0}, {0, 3, 0}, {3, -3, 3}, {3, 3, 3}, {-3, -3, 3}, {-3, 3, 3}};
  const std::vector<TriangleMesh::Indices> triangles = {{0, 2, 1}, {1, 2, 3}, {0, 1, 4}, {1, 5, 4}};
  for (const bool holds : {true, false}) {
    World world;
    const BodyId groove = world.add_body({.type = BodyType::Static, .shape = TriangleMesh(vertices, triangles)});
    const BodyId ball = world.add_body(sphere({0, 0, std::sqrt(0.5)}));
    std::uint32_t last = 0;
    world.set_contact_modifier([&](ModifiableContact& contact) {
      EXPECT_EQ(contact.a, groove);
      EXPECT_NEAR(std::abs(contact.normal.x()), std::sqrt(0.5), 0.01);
      last = std::max(last, contact.part);
      if (contact.normal.x() > 0) contact.enabled = holds;
    });
    run(world, 20);
    EXPECT_EQ(last, 1u);
    const Vector3 position = world.pose(ball).position;
    const double time = 20 * dt, rolled = 0.5 * (5.0 / 7 * g * std::sqrt(0.5)) * time * time;
    EXPECT_NEAR(position.x(), holds ? 0 : -rolled * std::sqrt(0.5), 0.005);
    EXPECT_NEAR(position.z() - position.x(), std::sqrt(0.5), 0.005);
  }
}

TEST(ContactModifier, WhatIsOffAgainstEachOtherNeitherWakesNorJoinsIslands) {
  World world({.settings = {.sleeping = true, .time_to_sleep = 0.1}});
  world.add_body(ground());
  const BodyId sleeper = world.add_body(box({0, 0, 0.5}));
  run(world, 60);
  ASSERT_TRUE(world.is_asleep(sleeper));
  BodyDef def = box({-1.2, 0, 0.5});
  def.velocity = {3, 0, 0};
  def.material.friction = 0;
  const BodyId slider = world.add_body(def);
  world.set_contact_modifier([&](ModifiableContact& contact) {
    if (contact.a == sleeper && contact.b == slider) contact.enabled = false;
  });
  run(world, 60);
  EXPECT_TRUE(world.is_asleep(sleeper));
  EXPECT_GT(world.pose(slider).position.x(), 1.5);
}

// Three boxes in a row fell asleep one by one. As they are on again, what is touched wakes its neighbour and that the
// next one, all in the same step: it is solved with them.
TEST(ContactModifier, WhatWasOffAsItFellAsleepWakesInARow) {
  World world({.settings = {.sleeping = true, .time_to_sleep = 0.1}});
  world.add_body(ground());
  std::vector<BodyId> row;
  for (const double x : {0.0, 0.999, 1.998}) row.push_back(world.add_body(box({x, 0, 0.5})));
  world.set_contact_modifier([&](ModifiableContact& contact) { contact.enabled = contact.a < row.front(); });
  run(world, 60);
  for (const BodyId id : row) ASSERT_TRUE(world.is_asleep(id));
  world.set_contact_modifier({});
  run(world, 10);
  for (const BodyId id : row) ASSERT_TRUE(world.is_asleep(id));
  BodyDef def = box({-1.2, 0, 0.5});
  def.velocity = {3, 0, 0};
  def.material.friction = 0;
  world.add_body(def);
  for (int step = 0; step < 10; ++step) {
    world.step(dt);
    for (const BodyId id : row) ASSERT_EQ(world.is_asleep(id), world.is_asleep(row.front())) << step;
  }
  EXPECT_FALSE(world.is_asleep(row.back()));
}

// Functions that change nothing leave the bits that there are without them.
TEST(ContactCallbacks, ThatChangeNothingLeaveAllAsItIs) {
  const auto hash_with = [](bool functions, int threads) {
    World world({.threads = threads, .settings = {.sleeping = true, .contact_events = true}});
    world.add_body(ground());
    for (int i = 0; i < 40; ++i) {
      const double z = 1 + 0.6 * i;
      BodyDef def = i % 2 == 0 ? box({0.3 * (i % 3), 0.2 * (i % 5), z}) : sphere({0.1 * (i % 4), 0, z});
      def.material.restitution = 0.2;
      world.add_body(def);
    }
    if (functions) {
      world.set_contact_filter([](const ContactCandidate&) { return true; });
      world.set_contact_modifier([](ModifiableContact&) {});
    }
    std::vector<std::uint64_t> trail;
    for (int i = 0; i < 150; ++i) {
      const StepReport report = world.step(dt);
      EXPECT_EQ(report.feature(Feature::ContactFilter).run, report.counts.filtered_pairs > 0);
      EXPECT_EQ(report.feature(Feature::ContactModifier).run, functions && report.counts.contacts > 0);
      trail.push_back(world.state_hash());
    }
    return trail;
  };
  EXPECT_EQ(hash_with(false, 1), hash_with(true, 1));
  EXPECT_EQ(hash_with(false, 1), hash_with(true, 2));
}

TEST(ContactCallbacks, ThatThrowLetTheStepEndFirst) {
  const auto world_with = [](bool throws) {
    World world;
    world.add_body(ground());
    world.add_body(box({0, 0, 0.5}));
    world.add_body(box({2, 0, 0.5}));
    if (throws) {
      world.set_contact_filter([](const ContactCandidate& of) -> bool {
        if (of.b.index == 1) throw std::runtime_error("no answer");
        ADD_FAILURE() << "nobody is asked after that";
        return false;
      });
      world.set_contact_modifier([](ModifiableContact&) { ADD_FAILURE() << "nobody is asked after that"; });
    }
    return world;
  };
  World plain = world_with(false), throwing = world_with(true);
  const TemporaryFile file(".throwing");
  throwing.record(file.path());
  plain.step(dt);
  EXPECT_THROW(throwing.step(dt), std::runtime_error);
  EXPECT_EQ(throwing.state_hash(), plain.state_hash());
  throwing.set_contact_filter({});
  throwing.set_contact_modifier([](ModifiableContact& contact) { contact.friction = -1; });
  plain.step(dt);
  expect_error([&] { throwing.step(dt); }, {"ContactModifier: contact.friction is -1", "not below 0"});
  EXPECT_EQ(throwing.state_hash(), plain.state_hash());
  throwing.set_contact_modifier([](ModifiableContact& contact) { contact.restitution = 1.5; });
  expect_error([&] { throwing.step(dt); }, {"restitution is 1.5", "from 0 to 1"});
  throwing.set_contact_modifier(
      [](ModifiableContact& contact) { contact.surface_velocity.x() = std::numeric_limits<double>::quiet_NaN(); });
  expect_error([&] { throwing.step(dt); }, {"surface_velocity", "finite"});
  throwing.set_contact_modifier([](ModifiableContact& contact) { contact.surface_velocity.x() = 2e6; });
  expect_error([&] { throwing.step(dt); }, {"surface_velocity is (2e+06, 0, 0)", "at most 1e+06"});
  throwing.set_contact_modifier({});
  throwing.step(dt);
  throwing.stop_recording();
  EXPECT_FALSE(replay(file.path()).divergence);
}

TEST(ContactCallbacks, MayNotChangeTheWorld) {
  World world;
  world.add_body(ground());
  const BodyId crate = world.add_body(box({0, 0, 0.5}));
  Snapshot snapshot;
  const std::vector<std::function<void()>> calls = {
      [&] { world.step(dt); },
      [&] {
        world.apply_force(crate, {1, 0, 0});
      },
      [&] { world.set_pose(crate, {}); },
      [&] { world.remove_body(crate); },
      [&] { world.add_body({}); },
      [&] {
        world.set_gravity({0, 0, 0});
      },
      [&] { world.save(snapshot); },
      [&] { world.set_contact_filter({}); },
      [&] { world.refilter(crate); },
  };
  for (const auto& change : calls) {
    world.set_contact_modifier([&](ModifiableContact&) { change(); });
    expect_error([&] { world.step(dt); }, {"found a step under way", "a contact modifier"});
    expect_error([&] { world.step(dt, [&](Forces&) { change(); }); }, {"found a step under way", "a force law"});
  }
  world.set_contact_modifier({});
  world.set_contact_filter([&](const ContactCandidate&) { return world.wake(crate), true; });
  world.refilter(crate);
  expect_error([&] { world.step(dt); }, {"World::wake", "a contact filter"});
  world.step(dt);
  EXPECT_TRUE(world.contains(crate));
}

// In each substep of a force law, what is recorded of it beside the law's forces.
TEST(ContactCallbacks, AreAskedInEachSubstepOfAForceLaw) {
  World world;
  world.add_body(ground());
  const BodyId crate = world.add_body(box({0, 0, 0.5}));
  int filtered = 0, modified = 0;
  world.set_contact_filter([&](const ContactCandidate&) { return ++filtered, true; });
  world.set_contact_modifier([&](ModifiableContact& contact) { ++modified, contact.friction = 0; });
  const TemporaryFile file(".forced");
  world.record(file.path());
  for (int i = 0; i < 30; ++i) world.step(dt, [&](Forces& forces) { forces.add(crate, {500, 0, 0}); });
  world.stop_recording();
  EXPECT_EQ(filtered, 1);
  EXPECT_EQ(modified, 30 * world.settings().substeps);
  const double speed = 500 / world.mass(crate) * 30 * dt;
  EXPECT_NEAR(world.velocity(crate).x(), speed, 0.02 * speed) << "nothing rubs";
  const ReplayResult result = replay(file.path(), {.threads = 2});
  EXPECT_FALSE(result.divergence);
  EXPECT_EQ(result.hash, world.state_hash());
}

// The sign of a zero would come back in what friction carries.
TEST(ContactModifier, MinusZeroIsZero) {
  const auto hash_with = [](double friction, bool of_material) {
    World world;
    world.add_body({.type = BodyType::Static, .shape = HalfSpace{}});
    world.add_body({.shape = Box{}, .position = {0, 0, 0.499}, .material = {.friction = of_material ? friction : 0.6}});
    if (!of_material) world.set_contact_modifier([=](ModifiableContact& contact) { contact.friction = friction; });
    world.set_velocity(world.bodies()[1], {1, 0.3, 0}, {0, 0.1, 0.2});
    for (int i = 0; i < 10; ++i) world.step(1.0 / 60);
    return world.state_hash();
  };
  for (const bool of_material : {false, true}) {
    EXPECT_EQ(hash_with(-0.0, of_material), hash_with(0, of_material)) << of_material;
    EXPECT_NE(hash_with(0.1, of_material), hash_with(0, of_material)) << of_material;
  }
}

}  // namespace
}  // namespace atl::test
