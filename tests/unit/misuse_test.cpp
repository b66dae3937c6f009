// Calls from another thread while a world steps are reported, in every build.

#include <atoll/atoll.h>
#include <atoll/contact_callbacks.h>
#include <atoll/queries.h>
#include <atoll/snapshot.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "support/bodies.h"

namespace atl::test {
namespace {

using Call = std::function<void(World&, BodyId)>;

struct NamedCall {
  const char* name;
  Call make;
};

const std::vector<NamedCall>& calls() {
  static const std::vector<NamedCall> all = {
      {"World::step", [](World& world, BodyId) { world.step(dt); }},
      {"World::add_body",
       [](World& world, BodyId) {
         world.add_body(sphere({0, 0, 9}));
       }},
      {"World::remove_body", [](World& world, BodyId id) { world.remove_body(id); }},
      {"World::set_pose", [](World& world, BodyId id) { world.set_pose(id, {}); }},
      {"World::apply_force",
       [](World& world, BodyId id) {
         world.apply_force(id, {1, 0, 0});
       }},
      {"World::set_gravity",
       [](World& world, BodyId) {
         world.set_gravity({0, 0, 1});
       }},
      {"World::set_settings", [](World& world, BodyId) { world.set_settings({}); }},
      {"World::save",
       [](World& world, BodyId) {
         Snapshot snapshot;
         world.save(snapshot);
       }},
      {"World::state_hash", [](World& world, BodyId) { world.state_hash(); }},
      {"World::contact_forces", [](World& world, BodyId) { world.contact_forces(); }},
      {"Queries",
       [](World& world, BodyId) {
         Queries(world).cast_ray({.origin = {0, 0, 9}});
       }},
  };
  return all;
}

std::string error_on_another_thread(World& world, BodyId id, const Call& make) {
  std::string error = "none";
  std::thread([&] {
    try {
      make(world, id);
    } catch (const Error& thrown) {
      error = thrown.what();
    }
  }).join();
  return error;
}

// A filter is called within a step, on the thread that steps.
TEST(Misuse, CallsFromAnotherThreadDuringAStepAreTold) {
  World world;
  world.add_body(ground());
  const BodyId ball = world.add_body(sphere({0, 0, 0.49}));
  std::vector<std::string> errors;
  world.set_contact_filter([&](const ContactCandidate&) {
    for (const NamedCall& call : calls()) errors.push_back(error_on_another_thread(world, ball, call.make));
    return true;
  });
  world.step(dt);
  ASSERT_EQ(errors.size(), calls().size());
  for (std::size_t i = 0; i < errors.size(); ++i) {
    EXPECT_EQ(errors[i],
              std::string(calls()[i].name) +
                  ": found a step under way on another thread; expected one thread at a time to use a world");
  }
}

TEST(Misuse, TheSameCallsAreFineOnceTheStepIsOver) {
  World world;
  world.add_body(ground());
  for (const NamedCall& call : calls()) {
    const BodyId ball = world.add_body(sphere({0, 0, 0.49}));
    world.step(dt);
    EXPECT_EQ(error_on_another_thread(world, ball, call.make), "none") << call.name;
  }
}

// An exception from a callback ends the step, and leaves nothing locked.
TEST(Misuse, AStepThatThrowsIsOver) {
  World world;
  world.add_body(ground());
  const BodyId ball = world.add_body(sphere({0, 0, 0.49}));
  world.set_contact_filter([](const ContactCandidate&) -> bool { throw Error("no"); });
  EXPECT_THROW(world.step(dt), Error);
  EXPECT_THROW(world.step(dt, [](Forces&) { throw Error("no"); }), Error);
  for (const NamedCall& call : calls()) {
    if (call.name == std::string("World::step")) continue;
    const BodyId other = world.add_body(sphere({4, 0, 0.49}));
    EXPECT_EQ(error_on_another_thread(world, other, call.make), "none") << call.name;
  }
  EXPECT_TRUE(world.contains(ball));
}

}  // namespace
}  // namespace atl::test
