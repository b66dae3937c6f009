// Worlds side by side come to what each comes to by itself, whatever is beside it.

#include <atoll/batch.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
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

std::vector<std::uint64_t> alone(const Scene& scene, std::size_t number, int steps) {
  World world({.gravity = scene.gravity, .settings = scene.settings});
  const std::vector<BodyId> ids = build_scene(scene, world);
  vary(world, number);
  std::vector<std::uint64_t> hashes = {world.state_hash()};
  for (int i = 0; i < steps; ++i) {
    apply_forces(scene, world, ids);
    world.step(dt);
    hashes.push_back(world.state_hash());
  }
  return hashes;
}

class BatchOf : public testing::TestWithParam<const char*> {};

TEST_P(BatchOf, WorldsIsEachOfThemByItself) {
  const Scene scene = load_scene(GetParam());
  constexpr int steps = 24;
  constexpr std::size_t kinds = 5;
  std::vector<std::vector<std::uint64_t>> expected;
  for (std::size_t kind = 0; kind < kinds; ++kind) expected.push_back(alone(scene, kind, steps));
  for (const std::size_t size : {1, 7, 64}) {
    for (const int threads : {1, 2, 3}) {
      for (const std::size_t shift : {0, 3}) {  // other places for the same
        Batch batch(scene, size, threads);
        const auto kind_of = [&](std::size_t place) { return (place + shift) % kinds; };
        batch.for_each([&](World& world, std::size_t place) { vary(world, kind_of(place)); });
        int made = 0;
        for (const int count : {1, 0, 7, 16}) {
          batch.step(dt, count);
          made += count;
          const std::vector<std::uint64_t> hashes = batch.hashes();
          for (std::size_t place = 0; place < size; ++place) {
            ASSERT_EQ(hashes[place], expected[kind_of(place)][static_cast<std::size_t>(made)])
                << "world " << place << " of " << size << ", step " << made << ", threads " << threads;
          }
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, BatchOf,
                         testing::Values("pile:bodies=12", "ragdolls:count=1", "vehicle", "pushed-box",
                                         "rocks:bodies=10"));

TEST(Batch, ResetsSomeAndLeavesOthers) {
  const Scene scene = load_scene("pile:bodies=10");
  Batch batch(scene, 9, 2);
  batch.for_each([&](World& world, std::size_t place) { vary(world, place); });
  batch.keep_start();
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

TEST(Batch, DrivesAJointInEachWorld) {
  const Scene scene = load_scene("slider-crank");
  Batch batch(scene, 6, 2);
  std::vector<double> positions(6), speeds(6), wanted(6);
  std::iota(wanted.begin(), wanted.end(), 1.0);
  std::size_t motor = 0;
  while (!std::holds_alternative<HingeJoint>(scene.joints[motor].def.kind) ||
         !std::get<HingeJoint>(scene.joints[motor].def.kind).angle.motor) {
    ++motor;
  }
  batch.set_motor_speeds(motor, wanted);
  batch.step(dt, 2);
  batch.read_joint(motor, positions, speeds);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(speeds[i], wanted[i], 0.02 * wanted[i]);
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

TEST(Batch, ArraysChangeWorldsAsTheirOwnCallsDo) {
  const Scene scene = load_scene("pile:bodies=6");
  Batch batch(scene, 4, 2);
  const std::size_t body = batch.bodies().size() - 1;
  const std::vector<std::size_t> places = {3, 1};
  const std::vector<double> gravities = {0, 0, -3, 1, 0, -5}, masses = {2, 700}, frictions = {0.1, 0.9};
  set_gravities(batch, gravities, places);
  set_masses(batch, body, masses, places);
  set_frictions(batch, body, frictions, places);
  batch.step(dt, 30);
  const std::vector<std::uint64_t> hashes = batch.hashes();
  for (std::size_t place = 0; place < 4; ++place) {
    World world({.gravity = scene.gravity, .settings = scene.settings});
    const BodyId changed = build_scene(scene, world)[body];
    for (std::size_t i = 0; i < 2; ++i) {
      if (places[i] != place) continue;
      world.set_gravity(Vector3(gravities.data() + 3 * i));
      world.set_mass(changed, masses[i]);
      Material material = world.material(changed);
      material.friction = frictions[i];
      world.set_material(changed, material);
    }
    run(world, 30);
    EXPECT_EQ(hashes[place], world.state_hash()) << place;
  }
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
  expect_error([&] { set_masses(batch, 1000, few); }, {"set_masses: found body 1000"});
  expect_error([&] { set_frictions(batch, 0, few); }, {"set_frictions: found 5 numbers of frictions", "3"});
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
