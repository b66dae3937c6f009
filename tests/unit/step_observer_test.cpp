// When step observers are told, what they may do, and what becomes of one that throws.

#include <atoll/batch.h>
#include <atoll/forces.h>
#include <atoll/snapshot.h>
#include <gtest/gtest.h>

#include <functional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "support/bodies.h"
#include "support/expect_error.h"

namespace atl::test {
namespace {

World resting_box() {
  World world;
  world.add_body(ground());
  world.add_body(box({0, 0, 0.5}));
  return world;
}

TEST(StepObserver, IsToldOfEachStepAsItEndsUntilItHasEnough) {
  World world = resting_box();
  std::vector<double> lengths;
  std::vector<std::int64_t> contacts;
  world.add_step_observer([&](const World& of, const StepReport& report, double length) {
    EXPECT_EQ(&of, &world);
    EXPECT_EQ(of.contact_forces().size(), 4u);
    EXPECT_EQ(of.pair_forces().size(), 1u);
    lengths.push_back(length);
    contacts.push_back(report.counts.contacts);
    return lengths.size() < 3;
  });
  world.step(dt);
  world.step(dt / 2, [](Forces&) {});
  for (int i = 0; i < 5; ++i) world.step(dt);
  EXPECT_EQ(lengths, (std::vector<double>{dt, dt / 2, dt}));
  EXPECT_EQ(contacts, (std::vector<std::int64_t>{1, 1, 1}));
}

TEST(StepObserver, ChangesNoBitAndGoesWithAWorldThatIsMoved) {
  World seen = resting_box(), other = resting_box();
  int steps = 0;
  seen.add_step_observer([&](const World& world, const StepReport&, double) {
    (void)world.state_hash();
    return ++steps > 0;
  });
  World moved = std::move(seen);
  run(moved, 10);
  run(other, 10);
  EXPECT_EQ(steps, 10);
  EXPECT_EQ(moved.state_hash(), other.state_hash());
}

TEST(StepObserver, SeveralAreToldInOrderAndGoOneByOne) {
  World world = resting_box();
  std::vector<int> observed;
  for (int number = 1; number <= 3; ++number) {
    world.add_step_observer([&, number](const World&, const StepReport&, double) {
      observed.push_back(number);
      return number != 2;
    });
  }
  run(world, 2);
  EXPECT_EQ(observed, (std::vector<int>{1, 2, 3, 1, 3}));
}

TEST(StepObserver, OfAWorldOfABatchIsToldOfTheBatchsSteps) {
  Batch batch(load_scene("stack:height=2"), 3, 2);
  int steps = 0;
  batch.world(1).add_step_observer([&](const World&, const StepReport&, double) { return ++steps > 0; });
  batch.step(dt, 4);
  EXPECT_EQ(steps, 4);
}

TEST(StepObserver, WhatItThrowsGoesThroughAndItIsToldOfTheNextStep) {
  World world = resting_box();
  int first = 0, second = 0, third = 0;
  world.add_step_observer([&](const World&, const StepReport&, double) { return ++first < 1; });
  world.add_step_observer([&](const World&, const StepReport&, double) {
    if (++second == 1) throw std::runtime_error("no room");
    return true;
  });
  world.add_step_observer([&](const World&, const StepReport&, double) { return ++third > 0; });
  EXPECT_THROW(world.step(dt), std::runtime_error);
  world.step(dt);
  EXPECT_EQ(first, 1);
  EXPECT_EQ(second, 2);
  EXPECT_EQ(third, 1);
  World other = resting_box();
  run(other, 2);
  EXPECT_EQ(world.state_hash(), other.state_hash());
}

TEST(StepObserver, MayNotChangeTheWorld) {
  World world = resting_box();
  Snapshot snapshot;
  const std::vector<std::function<void()>> calls = {
      [&] { world.step(dt); },
      [&] { world.add_body({}); },
      [&] { world.set_gravity(Vector3::Zero()); },
      [&] { world.save(snapshot); },
      [&] { world.add_step_observer([](const World&, const StepReport&, double) { return true; }); },
  };
  std::size_t call = 0;
  world.add_step_observer([&](const World&, const StepReport&, double) {
    expect_error(calls[call], {"found a step under way", "a step observer"});
    return ++call < calls.size();
  });
  run(world, 10);
  EXPECT_EQ(call, calls.size());
  world.set_gravity(Vector3::Zero());
  expect_error([&] { world.add_step_observer({}); }, {"World::add_step_observer", "empty"});
}

}  // namespace
}  // namespace atl::test
