// Rollouts of a batch come to what calls of each world come to, and begin with all worlds or with none.

#include <atoll/rollout.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <numeric>
#include <string_view>
#include <vector>

#include "support/expect_error.h"

namespace atl::test {
namespace {

using Column = Batch::Column;

constexpr std::size_t steps = 4;
constexpr int count = 3;
constexpr double dt = 1.0 / 120;
const std::vector<Control> controls = {MotorSpeed{.joint = 0, .coordinate = 1}, ServoTarget{.joint = 1},
                                       BodyForce{.body = 3}, BodyTorque{.body = 3, .axis = Axis::Z}};
constexpr std::size_t width = 6;

// A slide with a motor and an arm with a servo upon it, and a box on the ground that a constant force pushes.
Scene arm_and_box() {
  const JointMotor servo = {.max_force = 40, .servo = JointServo{.stiffness = 100, .damping = 10}};
  SixDofJoint slide;
  for (JointAxis& axis : slide.offset) axis.range = {0, 0};
  for (JointAxis& axis : slide.turn) axis.range = {0, 0};
  slide.offset[1] = {.motor = JointMotor{.max_force = 300}};
  const CollisionFilter untouched = {.mask = 0};
  Scene scene;
  scene.bodies = {
      {.def = {.type = BodyType::Static, .shape = HalfSpace{}}},
      {.def = {.shape = Box{{0.1, 0.2, 0.1}}, .position = {0, 0, 1.2}, .mass = 2, .filter = untouched}},
      {.def = {.shape = Sphere{0.1}, .position = {0, 0, 0.6}, .mass = 1}},
      {.def = {.shape = Box{{0.2, 0.2, 0.2}}, .position = {0, 0.5, 0.2}, .mass = 3}, .force = {2, 0, 0}},
  };
  scene.joints = {
      {.def = {.kind = slide, .frame_first = {{0, 0, 1.2}}}, .first = 0, .second = 1},
      {.def = {.kind = HingeJoint{{.motor = servo}}, .frame_second = {{0, 0, 0.6}}}, .first = 1, .second = 2},
  };
  return scene;
}

// For so many worlds, each by its number, whatever the batch.
std::vector<double> values_for(std::size_t worlds) {
  std::vector<double> values(worlds * steps * width);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = std::sin(0.7 * static_cast<double>(i));
  for (std::size_t i = 2; i < values.size(); i += width) values[i] *= 30;
  return values;
}

// The state hashes after each control step, and what there is to be told of the last.
struct Alone {
  std::vector<std::uint64_t> hashes;
  std::vector<double> positions, joint_speeds;
};

Alone alone(const Scene& scene, const double* now) {
  World world({.gravity = scene.gravity, .settings = scene.settings});
  const std::vector<BodyId> bodies = build_scene(scene, world);
  Alone result;
  for (std::size_t step = 0; step < steps; ++step, now += width) {
    world.set_motor_speed(world.joints()[0], now[0], 1);
    world.set_servo_target(world.joints()[1], now[1]);
    for (int i = 0; i < count; ++i) {
      world.apply_force(bodies[3], {now[2], now[3], now[4]});
      world.apply_force(bodies[3], Vector3::Zero(), {0, 0, now[5]});
      apply_forces(scene, world, bodies);
      world.step(dt);
    }
    result.hashes.push_back(world.state_hash());
  }
  for (const BodyId body : bodies) {
    const Vector3 centre = world.centre_of_mass(body);
    result.positions.insert(result.positions.end(), centre.begin(), centre.end());
  }
  for (const JointId joint : world.joints()) {
    const JointState state = world.joint_state(joint);
    result.joint_speeds.insert(result.joint_speeds.end(), state.speed.begin(), state.speed.end());
  }
  return result;
}

void expect_last(const std::vector<double>& kept, std::size_t number, const std::vector<double>& expected) {
  const auto end = kept.begin() + static_cast<std::ptrdiff_t>((number + 1) * steps * expected.size());
  EXPECT_TRUE(std::equal(expected.begin(), expected.end(), end - static_cast<std::ptrdiff_t>(expected.size())))
      << "world " << number;
}

TEST(Rollout, IsTheCallsOfEachWorld) {
  const Scene scene = arm_and_box();
  const std::vector<double> all = values_for(64);
  std::vector<Alone> expected;
  for (std::size_t i = 0; i < 64; ++i) expected.push_back(alone(scene, all.data() + i * steps * width));
  ASSERT_NE(expected[0].hashes, expected[1].hashes);
  for (const std::size_t size : {1, 7, 64}) {
    for (const int threads : {1, 2, 3}) {
      Batch batch(scene, size, threads);
      // World i rolls out as the one of number size - 1 - i.
      std::vector<std::size_t> places(size);
      std::iota(places.rbegin(), places.rend(), 0);
      const std::vector<double> values(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(size * steps * width));
      for (int again = 0; again < 2; ++again) {
        const auto kept = roll_out(batch,
                                   {.controls = controls,
                                    .steps = steps,
                                    .count = count,
                                    .dt = dt,
                                    .keep = {Column::JointSpeeds, Column::Positions},
                                    .reset = again > 0},
                                   values, places);
        for (std::size_t i = 0; i < size; ++i) {
          ASSERT_EQ(batch.world(places[i]).state_hash(), expected[i].hashes.back())
              << "world " << i << " of " << size << ", threads " << threads;
          expect_last(kept[0], i, expected[i].joint_speeds);
          expect_last(kept[1], i, expected[i].positions);
        }
      }
    }
  }
}

TEST(Rollout, ChecksAllAheadOfTheFirstStep) {
  Batch batch(arm_and_box(), 3, 2);
  const Rollout good = {.controls = controls, .steps = steps, .count = count, .dt = dt};
  std::vector<double> values = values_for(3);
  roll_out(batch, good, values);
  std::vector<Snapshot> starts(3);
  for (std::size_t i = 0; i < 2; ++i) batch.world(i).save(starts[i]);
  const std::vector<std::uint64_t> before = batch.hashes();
  const auto expect = [&](const auto& change, std::initializer_list<std::string_view> words) {
    Rollout rollout = good;
    change(rollout);
    expect_error([&] { roll_out(batch, rollout, values); }, words);
    EXPECT_EQ(batch.hashes(), before);
  };
  expect([](Rollout& r) { r.dt = 0; }, {"Batch: found dt of 0"});
  expect([](Rollout& r) { r.count = 0; }, {"a count of 0", "1 or more"});
  expect([](Rollout& r) { r.steps = 5; }, {"found 72 values", "3 worlds x 5 control steps x 6 numbers = 90"});
  expect([](Rollout& r) { r.controls[0] = MotorSpeed{.joint = 2}; }, {"controls[0]", "of joint 2", "below 2"});
  expect([](Rollout& r) { r.controls[0] = MotorSpeed{}; }, {"controls[0]", "without a motor there in world 0"});
  expect([](Rollout& r) { r.controls[0] = ServoTarget{0, 1}; }, {"controls[0]", "without a servo there in world 0"});
  expect([](Rollout& r) { r.controls[2] = BodyForce{.body = 0}; }, {"controls[2]", "isn't dynamic in world 0"});
  expect([](Rollout& r) { r.controls[3] = BodyTorque{4, Axis::X}; }, {"torque on body 4", "below 4"});
  expect([&](Rollout& r) { r.start = std::span(starts).first(2); }, {"2 snapshots", "one for all, or 3"});
  expect(
      [&](Rollout& r) {
        r.start = starts;
        r.reset = true;
      },
      {"both reset and start"});
  // Worlds that have gone to their start by then come back.
  expect([&](Rollout& r) { r.start = starts; }, {"snapshot is empty"});
  expect(
      [](Rollout& r) {
        r.reset = true;
        r.controls[1] = ServoTarget{.joint = 1, .coordinate = 1};
      },
      {"without a servo there in world 0"});
  values[2 * steps * width + width + 5] = std::numeric_limits<double>::infinity();
  expect([](Rollout&) {}, {"inf at values[2][1][5], for controls[3], the torque on body 3", "a finite number"});
  values = values_for(3);
  values[1] = -2e15;
  expect([](Rollout&) {}, {"-2e+15 at values[0][0][1]", "1e15"});
}

}  // namespace
}  // namespace atl::test
