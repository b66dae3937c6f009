// The errors of a run as ErrorMeter gathers them from states, of whatever engine.

#include <atoll/error_meter.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "support/bodies.h"
#include "support/expect_error.h"

namespace atl::test {
namespace {

std::optional<double> value_of(const ErrorMeter& meter, const std::string& name) {
  for (const ErrorMeasure& error : meter.errors()) {
    if (error.name == name) return error.value;
  }
  return std::nullopt;
}

std::vector<BodyState> starting_states(const Scene& scene) {
  World world({.gravity = scene.gravity});
  return body_states(world, build_scene(scene, world));
}

// The sum of all heights that it saw: tells which steps were observed.
class HeightSum : public ClosedFormMeasure {
 public:
  void observe(double, std::span<const BodyState> states, std::span<const ContactLoad> loads) override {
    sum_ += states.back().pose.position.z() + static_cast<double>(loads.size());
  }
  std::vector<ErrorMeasure> errors() const override { return {{"analytic_error", sum_}, {"a_part", 2 * sum_, "m"}}; }

 private:
  double sum_ = 0;
};

Scene two_boxes() {
  Scene scene;
  scene.starts_at_rest = true;
  scene.bodies = {{.def = ground()}, {.def = box({0, 0, 0.5})}, {.def = box({0, 0, 1.5})}};
  return scene;
}

TEST(ErrorMeter, GivesTheClosedFormFirstAndOfAllSteps) {
  Scene scene = two_boxes();
  scene.closed_form = ClosedForm{.metric = "sum", .measure = [] { return std::make_unique<HeightSum>(); }};
  const std::vector<BodyState> states = starting_states(scene);
  ErrorMeter meter(scene);
  meter.observe(1, states);
  meter.observe(2, states);
  const std::vector<ErrorMeasure> errors = meter.errors();
  ASSERT_GE(errors.size(), 2u);
  EXPECT_EQ(errors[0].name, "analytic_error");
  EXPECT_DOUBLE_EQ(errors[0].value, 3);
  EXPECT_EQ(errors[1].name, "a_part");
  EXPECT_FALSE(meter.needs_loads());

  ErrorMeter of_end(scene, ErrorMeter::Follow::End);
  of_end.observe(2, states);
  EXPECT_FALSE(value_of(of_end, "analytic_error"));
  EXPECT_TRUE(value_of(of_end, "penetration_max"));
}

TEST(ErrorMeter, MeasuresPenetrationAndRestOfTheLastState) {
  const Scene scene = two_boxes();
  std::vector<BodyState> states = starting_states(scene);
  ErrorMeter meter(scene);
  states[2].pose.position.z() -= 0.3;
  meter.observe(1, states);
  states[2].pose.position.z() += 0.2;
  meter.observe(2, states);
  EXPECT_NEAR(value_of(meter, "penetration_max").value(), 0.1, 1e-12);
  EXPECT_NEAR(value_of(meter, "sink_max").value(), 0.1, 1e-12);
  EXPECT_NEAR(value_of(meter, "sink_mean").value(), 0.05, 1e-12);
}

TEST(ErrorMeter, ComparesEnergyWithThatOfTheStart) {
  Scene scene = two_boxes();
  std::vector<BodyState> states = starting_states(scene);
  ErrorMeter meter(scene);
  // 1000 kg at 0.5 m and at 1.5 m: 2 m in all against gravity.
  states[2].velocity = {1, 0, 0};
  meter.observe(1, states);
  EXPECT_NEAR(value_of(meter, "energy_drift").value(), 0.5 / (2 * 9.81), 1e-12);
}

TEST(ErrorMeter, ComparesMomentumOnlyWhereNothingOutsideChangesIt) {
  Scene scene;
  scene.gravity = Vector3::Zero();
  scene.bodies = {{.def = sphere({0, 0, 0})}, {.def = sphere({3, 0, 0})}};
  scene.bodies[0].def.velocity = {2, 0, 0};
  std::vector<BodyState> states = starting_states(scene);
  states[1].velocity = {0, 0.5, 0};
  const auto drift = [&] {
    ErrorMeter meter(scene);
    meter.observe(1, states);
    return value_of(meter, "momentum_drift");
  };
  EXPECT_NEAR(drift().value(), 0.25, 1e-12);
  scene.bodies[1].force = {1, 0, 0};
  EXPECT_FALSE(drift());
  scene.bodies[1].force = Vector3::Zero();
  scene.gravity = {0, 0, -9.81};
  EXPECT_FALSE(drift());
}

TEST(ErrorMeter, TellsWhatFellFromWhatSank) {
  const Scene scene = two_boxes();
  const auto fell = [&](const Vector3& moved, double turned) {
    std::vector<BodyState> states = starting_states(scene);
    states[2].pose.position += moved;
    states[2].pose.orientation = Quaternion(Eigen::AngleAxisd(turned, Vector3::UnitX()));
    ErrorMeter meter(scene);
    meter.observe(1, states);
    return meter.fell();
  };
  EXPECT_FALSE(fell({0, 0, -0.7}, 0.2));
  EXPECT_FALSE(fell({0.9, 0, 0}, 0));
  EXPECT_TRUE(fell({1.1, 0, -1}, 0)) << "a cube of 1 m that is more than that away";
  EXPECT_TRUE(fell({0, 0, 0}, 0.4));
}

TEST(BodyMass, IsThatOfTheWorld) {
  const BodyDef def = box({1, 2, 3}, {0.5, 1, 1.5});
  World world;
  const MassProperties mass = body_mass(def);
  EXPECT_DOUBLE_EQ(mass.mass, world.mass(world.add_body(def)));
  EXPECT_LT((mass.inertia.diagonal() - box_inertia(mass.mass, {0.5, 1, 1.5})).norm(), 1e-9 * mass.mass);
  EXPECT_DOUBLE_EQ(mass.volume, 6);
  expect_error([] { body_mass(ground()); }, {"BodyDef.type", "Dynamic"});
}

TEST(SceneForces, ActInEveryStep) {
  Scene scene;
  scene.gravity = Vector3::Zero();
  scene.bodies = {{.def = sphere({0, 0, 0})}, {.def = sphere({3, 0, 0}), .force = {0, 2, 0}}};
  World world({.gravity = scene.gravity});
  const std::vector<BodyId> ids = build_scene(scene, world);
  for (int i = 0; i < 60; ++i) {
    apply_forces(scene, world, ids);
    world.step(dt);
  }
  EXPECT_NEAR(world.velocity(ids[1]).y(), 2 / world.mass(ids[1]), 1e-12);
  EXPECT_TRUE(world.velocity(ids[0]).isZero(0));
}

TEST(ContactLoads, AddUpThePointsOfEachPair) {
  const Scene scene = two_boxes();
  World world({.gravity = scene.gravity});
  const std::vector<BodyId> ids = build_scene(scene, world);
  run(world, 120);
  const std::vector<ContactLoad> loads = contact_loads(world, ids);
  ASSERT_EQ(loads.size(), 2u);
  EXPECT_EQ(loads[0].a, 0u);
  EXPECT_EQ(loads[0].b, 1u);
  EXPECT_NEAR(loads[0].force.z(), 2000 * g, 0.02 * 2000 * g);
  EXPECT_NEAR(loads[1].force.z(), 1000 * g, 0.02 * 1000 * g);
}

}  // namespace
}  // namespace atl::test
