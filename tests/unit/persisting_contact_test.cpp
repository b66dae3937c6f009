// Contact events of what goes on touching: who is told of, what it carried over the whole step, and who asked.

#include <atoll/forces.h>
#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "support/bodies.h"
#include "support/expect_error.h"

namespace atl::test::persisting_contact_test {
namespace {

constexpr double weight = 2 * g;  // N

struct Pair {
  World world;
  BodyId ground, crate;
};

// A crate of 2 kg that has come to rest.
Pair resting(const std::optional<double>& asked_by_world, const std::optional<double>& asked_by_crate,
             Settings settings = {}) {
  settings.contact_events = true;
  settings.contact_event_force = asked_by_world;
  Pair pair{World({.settings = settings}), {}, {}};
  pair.ground = pair.world.add_body(ground());
  pair.crate = pair.world.add_body(
      {.shape = Box{{0.5, 0.5, 0.5}}, .position = {0, 0, 0.5}, .mass = 2, .contact_event_force = asked_by_crate});
  run(pair.world, 60);
  return pair;
}

TEST(PersistingContact, TellsWhatItCarriedInTheWholeStep) {
  for (const ContactSolver solver : {ContactSolver::Iterative, ContactSolver::Direct}) {
    Pair pair = resting(0, {}, {.contact_solver = solver});
    for (int law = 0; law < 2; ++law) {
      if (law != 0) pair.world.step(dt, [](Forces&) {});
      ASSERT_EQ(pair.world.contact_events().size(), 1u);
      const ContactEvent& event = pair.world.contact_events()[0];
      EXPECT_TRUE(event.persists && !event.began);
      EXPECT_EQ(event.a, pair.ground);
      EXPECT_EQ(event.b, pair.crate);
      EXPECT_NEAR(event.impulse, weight * dt, 1e-3 * weight * dt);
      EXPECT_NEAR(event.normal_force, weight, 1e-3 * weight);
      EXPECT_NEAR(event.normal.z(), 1, 1e-6);
    }
  }
}

TEST(PersistingContact, IsToldOfFromTheForceOnThatTheWorldOrABodyAsksFor) {
  const double below = 0.99 * weight, above = 1.01 * weight;
  const auto events_with = [](std::optional<double> by_world, std::optional<double> by_crate) {
    return resting(by_world, by_crate).world.contact_events().size();
  };
  EXPECT_EQ(events_with({}, {}), 0u);
  EXPECT_EQ(events_with(below, {}), 1u);
  EXPECT_EQ(events_with(above, {}), 0u);
  EXPECT_EQ(events_with({}, below), 1u);
  EXPECT_EQ(events_with({}, above), 0u);
  EXPECT_EQ(events_with(above, below), 1u);
  EXPECT_EQ(events_with(below, above), 1u);
}

TEST(PersistingContact, TellsOfABlowWhereBodiesTouchAlready) {
  Pair pair = resting(10 * weight, {});
  pair.world.apply_impulse(pair.crate, {0, 0, -6}, {0, 0, 0.5});
  pair.world.step(dt);
  ASSERT_EQ(pair.world.contact_events().size(), 1u);
  EXPECT_TRUE(pair.world.contact_events()[0].persists);
  EXPECT_NEAR(pair.world.contact_events()[0].impulse, 6 + weight * dt, 0.1);
  EXPECT_NEAR(pair.world.contact_events()[0].approach_speed, 3, 0.01);
}

TEST(PersistingContact, IsOverAsBodiesSleepOrPart) {
  Pair pair = resting(0, {}, {.sleeping = true});
  ASSERT_TRUE(pair.world.is_asleep(pair.crate));
  EXPECT_TRUE(pair.world.contact_events().empty());
  pair.world.wake(pair.crate);
  pair.world.step(dt);
  EXPECT_EQ(pair.world.contact_events().size(), 1u);
  pair.world.set_pose(pair.crate, {{0, 0, 9}, Quaternion::Identity()});
  pair.world.step(dt);
  ASSERT_EQ(pair.world.contact_events().size(), 1u);
  EXPECT_FALSE(pair.world.contact_events()[0].began || pair.world.contact_events()[0].persists);
}

TEST(PersistingContact, IsToldOfAfterARestoreToo) {
  Pair pair = resting({}, 1);
  Snapshot snapshot;
  pair.world.save(snapshot);
  World other;
  other.restore(snapshot);
  EXPECT_EQ(other.definition(pair.crate).contact_event_force, 1);
  for (World* world : {&pair.world, &other}) world->step(dt);
  ASSERT_EQ(other.contact_events().size(), 1u);
  EXPECT_EQ(other.contact_events()[0].impulse, pair.world.contact_events()[0].impulse);
}

TEST(PersistingContact, RefusesAForceThatIsNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double force : {-1.0, nan, 1e16}) {
    expect_error([&] { World({.settings = {.contact_event_force = force}}); }, {"Settings.contact_event_force"});
    World world;
    expect_error([&] { world.add_body({.contact_event_force = force}); }, {"BodyDef.contact_event_force"});
  }
}

// Bodies share what never changes of them, but only if they are alike.
TEST(PersistingContact, OfOneBodyIsNotThatOfTheNext) {
  World world;
  world.add_body({.contact_event_force = 1});
  EXPECT_FALSE(world.definition(world.add_body({})).contact_event_force.has_value());
  world.add_body({.sensor = true});
  EXPECT_FALSE(world.definition(world.add_body({})).sensor);
}

}  // namespace
}  // namespace atl::test::persisting_contact_test
