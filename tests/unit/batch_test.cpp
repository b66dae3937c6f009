// Worlds side by side come to what each comes to by itself, whatever is beside it.

#include <atoll/batch.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <utility>
#include <vector>

#include "support/bodies.h"
#include "support/expect_error.h"

namespace atl::test {
namespace {

// Makes each world differ from the others.
void vary(World& world, std::size_t number) {
  const auto x = static_cast<double>(number);
  const std::vector<BodyId> bodies = world.bodies();
  for (const BodyId body : bodies) {
    if (world.type(body) != BodyType::Dynamic) continue;
    world.set_velocity(body, {0.1 * x, 0.03 * x, 0}, {0, 0.2 * x, 0.1});
    world.set_mass(body, 1 + 0.25 * x);
    world.set_material(body, {.friction = 0.2 + 0.05 * x});
  }
}

TEST(Batch, ResetsSomeAndLeavesOthers) {
  const Scene scene = load_scene("pile:bodies=10");
  Batch batch(scene, 9, 2);
  batch.for_each([&](World& world, std::size_t place) { vary(world, place); });
  batch.save_start();
  const std::vector<std::uint64_t> start = batch.hashes();
  batch.step(dt, 5);
  const std::vector<std::uint64_t> five = batch.hashes();
  batch.reset(std::vector<std::size_t>{2, 7});
  const std::vector<std::uint64_t> mixed = batch.hashes();
  for (std::size_t i = 0; i < 9; ++i) EXPECT_EQ(mixed[i], i == 2 || i == 7 ? start[i] : five[i]) << i;
  batch.step(dt, 5, std::vector<std::size_t>{7});
  EXPECT_EQ(batch.hashes()[7], five[7]);
  EXPECT_EQ(batch.hashes()[2], start[2]);
  batch.reset();
  EXPECT_EQ(batch.hashes(), start);
}

TEST(Batch, ArraysAreTheWorldsOwn) {
  const Scene scene = load_scene("ragdolls:count=1");
  Batch batch(scene, 4, 2);
  const std::size_t bodies = batch.bodies().size();
  batch.for_each([&](World& world, std::size_t place) { vary(world, place); });
  batch.step(dt, 3);
  for (const auto column : {Batch::Column::Positions, Batch::Column::Origins, Batch::Column::Orientations,
                            Batch::Column::Velocities, Batch::Column::AngularVelocities}) {
    const std::size_t rows = Batch::rows_of(column);
    std::vector<double> numbers(rows * bodies * 4);
    batch.read(column, numbers);
    for (std::size_t place = 0; place < 4; ++place) {
      const World& world = batch.world(place);
      for (std::size_t i = 0; i < bodies; ++i) {
        const BodyState state = world.state(batch.bodies()[i]);
        const Eigen::Map<const Eigen::VectorXd> found(numbers.data() + rows * (place * bodies + i),
                                                      static_cast<Eigen::Index>(rows));
        switch (column) {
          case Batch::Column::Positions:
            EXPECT_EQ(found, world.centre_of_mass(batch.bodies()[i]));
            break;
          case Batch::Column::Origins:
            EXPECT_EQ(found, state.pose.position);
            break;
          case Batch::Column::Orientations:
            EXPECT_EQ(found, Eigen::VectorXd(state.pose.orientation.coeffs()));
            break;
          case Batch::Column::Velocities:
            EXPECT_EQ(found, state.velocity);
            break;
          case Batch::Column::AngularVelocities:
            EXPECT_EQ(found, state.angular_velocity);
            break;
          default:
            FAIL() << "another column";
        }
      }
    }
  }
  // There and back.
  const std::vector<std::uint64_t> before = batch.hashes();
  std::vector<double> linear(3 * bodies * 4), angular(3 * bodies * 4);
  batch.read(Batch::Column::Velocities, linear);
  batch.read(Batch::Column::AngularVelocities, angular);
  batch.set_velocities(linear, angular);
  std::vector<double> again(3 * bodies * 4);
  batch.read(Batch::Column::Velocities, again);
  EXPECT_EQ(again, linear);
  const std::size_t last = 3;  // the last world
  std::vector<double> still(3 * bodies, 0.0);
  batch.set_velocities(still, still, {&last, 1});
  batch.read(Batch::Column::Velocities, again);
  EXPECT_TRUE(
      std::all_of(again.end() - static_cast<std::ptrdiff_t>(3 * bodies), again.end(), [](double x) { return x == 0; }));
  EXPECT_TRUE(std::equal(linear.begin(), linear.end() - static_cast<std::ptrdiff_t>(3 * bodies), again.begin()));
}

TEST(Batch, ColumnsOfJointsAreTheWorldsOwn) {
  Batch batch(load_scene("vehicle"), 3, 2);
  batch.for_each([&](World& world, std::size_t place) { vary(world, place); });
  batch.step(dt, 3);
  batch.world(1).remove_joint(batch.joints()[1]);
  const std::size_t joints = batch.joints().size();
  std::vector<double> positions(6 * joints * 3), speeds(6 * joints * 3);
  batch.read(Batch::Column::JointPositions, positions);
  batch.read(Batch::Column::JointSpeeds, speeds);
  double moved = 0;
  for (std::size_t i = 0; i < 3 * joints; ++i) {
    const World& world = batch.world(i / joints);
    const JointId joint = batch.joints()[i % joints];
    const JointState state = world.contains(joint) ? world.joint_state(joint) : JointState{};
    for (std::size_t k = 0; k < 6; ++k) {
      EXPECT_EQ(positions[6 * i + k], state.position[k]) << "joint " << i << ", coordinate " << k;
      EXPECT_EQ(speeds[6 * i + k], state.speed[k]) << "joint " << i << ", coordinate " << k;
      moved += std::abs(state.speed[k]);
    }
  }
  EXPECT_GT(moved, 1);
}

TEST(Batch, TellsWhatItCannotDo) {
  const Scene scene = load_scene("pile:bodies=4");
  expect_error([&] { Batch(scene, 0); }, {"Batch: worlds is 0"});
  expect_error([&] { Batch(scene, 2, -1); }, {"Batch: threads is -1"});
  Batch batch(scene, 3, 2);
  const std::vector<std::uint64_t> before = batch.hashes();
  expect_error([&] { batch.world(3); }, {"Batch::world: found place 3", "below 3"});
  expect_error([&] { batch.step(0); }, {"Batch::step: found dt"});
  expect_error([&] { batch.step(dt, -1); }, {"-1 steps"});
  expect_error([&] { batch.step(dt, 1, std::vector<std::size_t>{0, 3}); }, {"place 3"});
  expect_error([&] { batch.step(dt, 1, std::vector<std::size_t>{1, 1}); }, {"place 1 twice"});
  std::vector<double> few(5);
  expect_error([&] { batch.read(Batch::Column::Positions, few); }, {"Batch::read: found 5 numbers"});
  expect_error([&] { batch.set_velocities(few, few); }, {"Batch::set_velocities"});
  expect_error([&] { set_gravities(batch, few); }, {"set_gravities: found 5 numbers of gravities", "9"});
  expect_error([&] { set_masses(batch, 1000, few); }, {"set_numbers: found body 1000"});
  expect_error([&] { set_frictions(batch, 0, few); }, {"set_numbers: found 5 numbers of body", "3"});
  const std::size_t last = batch.bodies().size() - 1;
  expect_error([&] { set_masses(batch, last, std::vector<double>{1, -1, 1}); }, {"World::set_mass: mass", "-1"});
  batch.reset();
  expect_error([&] { batch.set_motor_speeds(0, few); }, {"Batch::set_motor_speeds: found joint 0"});
  EXPECT_EQ(batch.hashes(), before);
  // The first by place, after all were asked.
  std::vector<int> asked(3);
  EXPECT_THROW(batch.for_each([&](World&, std::size_t place) {
    asked[place] = 1;
    if (place > 0) throw std::out_of_range(std::to_string(place));
  }),
               std::out_of_range);
  EXPECT_EQ(asked, std::vector<int>({1, 1, 1}));
}

TEST(Batch, KeepsItsWorlds) {
  const Scene scene = load_scene("stack:height=2");
  Batch batch(scene, 3);
  expect_error([&] { World taken = std::move(batch.world(2)); }, {"World: a move of a world of a Batch"});
  World other({.gravity = scene.gravity});
  expect_error([&] { other = std::move(batch.world(1)); }, {"World: a move of a world of a Batch"});
  expect_error([&] { batch.world(0) = std::move(other); }, {"World: a move of a world of a Batch"});
  Batch untouched(scene, 3);
  untouched.step(dt);
  batch.step(dt);
  EXPECT_EQ(batch.hashes(), untouched.hashes());
  EXPECT_EQ(other.body_count(), 0u);
  // One by itself is moved as ever.
  World moved = std::move(other);
  EXPECT_EQ(moved.body_count(), 0u);
}

TEST(Batch, RefusesMoreWorldsThanThereIsMemoryFor) {
  expect_error([] { Batch(load_scene("stack:height=2"), 1'000'000'000'000'000'000); },
               {"Batch: 1000000000000000000 worlds need about", "of memory, of which", "are free"});
}

}  // namespace
}  // namespace atl::test
