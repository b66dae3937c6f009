// The measures of the scenes with a closed form: the exact motion, computed in another way where there is one, has no
// error at any step length, and a wrong one has the error that it should. See closed_form_*_test.cpp for the motions
// with contacts and the tops.

#include <array>
#include <cmath>

#include "support/closed_form_run.h"

namespace atl::test {
namespace {

TEST(ClosedForm, SaysWhatItMeasures) {
  ASSERT_EQ(closed_form_scenes().size(), 23u);
  for (const std::string& name : closed_form_scenes()) {
    const Scene scene = load_scene(name);
    EXPECT_FALSE(scene.closed_form->metric.empty()) << name;
    EXPECT_FALSE(scene.closed_form->source.empty()) << name;
    EXPECT_EQ(scene.closed_form->needs_loads, name == "stack-forces") << name;
    const std::vector<ErrorMeasure> errors = scene.closed_form->measure()->errors();
    ASSERT_FALSE(errors.empty());
    EXPECT_EQ(errors.front().name, "analytic_error");
    EXPECT_EQ(errors.front().unit, "");
  }
}

TEST(ClosedForm, StandingStillIsWrong) {
  for (const std::string& name : closed_form_scenes()) {
    if (name == "hanging-chain" || name == "catenary") continue;  // which should
    const Scene scene = load_scene(name);
    // Coming to rest at the place of the start is as wrong as the whole path.
    const Errors errors = errors_of(
        scene,
        [](double, std::vector<BodyState>& states) {
          for (BodyState& state : states) state.velocity = state.angular_velocity = Vector3::Zero();
        },
        scene.dt);
    EXPECT_GT(errors.at("analytic_error"), 0.3) << name;
    EXPECT_LE(errors.at("analytic_error"), 4) << name;
  }
}

TEST(ClosedForm, EveryParameterHasAnUsableRange) {
  for (const BuiltinScene& builtin : builtin_scenes()) {
    if (builtin.name == "islands" || !load_scene(builtin.name).closed_form) continue;
    for (const SceneParameter& parameter : builtin.parameters) {
      for (const double value : {parameter.min, parameter.max}) {
        const Scene scene = load_scene(builtin.name + ":" + parameter.name + "=" + std::to_string(value));
        SCOPED_TRACE(scene.name);
        EXPECT_GT(scene.steps, 1);
        EXPECT_EQ(measure_penetration(placed_shapes(scene), may_touch(scene)).pairs, 0u);
        const auto measure = scene.closed_form->measure();
        const std::vector<BodyState> states = starting_states(scene);
        for (int step = 1; step <= 200; ++step) measure->observe(step * scene.steps / 200.0 * scene.dt, states, {});
        for (const ErrorMeasure& error : measure->errors()) {
          EXPECT_GE(error.value, 0) << error.name;
          EXPECT_LT(error.value, 1e3) << error.name;
        }
      }
    }
  }
}

TEST(ClosedForm, FarOffIsFinite) {
  for (const std::string& name : closed_form_scenes()) {
    const Scene scene = load_scene(name);
    for (const double huge : {1e30, -1e200}) {
      const Errors errors = errors_of(
          scene,
          [=](double, std::vector<BodyState>& states) {
            for (BodyState& state : states) {
              state.pose.position = state.velocity = state.angular_velocity = Vector3::Constant(huge);
            }
          },
          scene.dt);
      for (const auto& [part, error] : errors) {
        EXPECT_GE(error, 0) << name << ", " << part;
        EXPECT_LE(error, 1e3) << name << ", " << part;
      }
    }
  }
}

Motion parabolas(const Scene& scene) {
  return [gravity = scene.gravity](double t, std::vector<BodyState>& states) {
    for (BodyState& state : states) {
      state.pose.position += t * (state.velocity + t / 2 * gravity);
      state.velocity += t * gravity;
      // Half a turn's quaternion from sines and cosines.
      const double rate = state.angular_velocity.norm();
      const Vector3 axis = state.angular_velocity / rate;
      Quaternion turn;
      turn.w() = std::cos(rate * t / 2);
      turn.vec() = std::sin(rate * t / 2) * axis;
      state.pose.orientation = turn * state.pose.orientation;
    }
  };
}

TEST(ClosedForm, FreeFlight) {
  const Scene scene = load_scene("free-flight");
  expect_exact(scene, parabolas(scene), 1e-12);  // that is 1e-13 of a step of 1 ms, at a height of 20 m
  const Motion motion = parabolas(scene);
  // 1 mm to the side at the end of a path of 30 + 44.145 m; from the first step on it is 1/60 of it and more.
  const Errors drift = errors_of(
      scene,
      [&](double t, std::vector<BodyState>& states) {
        motion(t, states);
        states[3].pose.position.y() += 1e-3 * t * t;
      },
      scene.dt);
  EXPECT_NEAR(drift.at("position_error"), 9e-3 / (30 + 0.5 * g * 9), 1e-9);
  EXPECT_LT(drift.at("orientation_error"), 1e-13);
}

TEST(ClosedForm, StackForces) {
  const Scene scene = load_scene("stack-forces:height=3,ratio=4");
  const std::array<double, 3> carried = {6 * 1000 * g, 5 * 1000 * g, 4 * 1000 * g};
  const auto errors_with = [&](double swing, double bias) {
    const auto measure = scene.closed_form->measure();
    const std::vector<BodyState> states = starting_states(scene);
    for (int step = 1; step <= scene.steps; ++step) {
      const double sign = step % 2 == 0 ? 1 : -1;
      std::vector<ContactLoad> loads;
      for (std::size_t i = 0; i < 3; ++i) {
        const double factor = step * scene.dt < 2.4 ? 10 : 1 + bias + sign * swing;
        const Vector3 force(0, 0, factor * carried[i]);
        // Either body may come first.
        if (i == 1)
          loads.push_back({i + 1, i, -force});
        else
          loads.push_back({i, i + 1, force});
      }
      measure->observe(step * scene.dt, states, loads);
    }
    return by_name(measure->errors());
  };
  EXPECT_LT(errors_with(0, 0).at("analytic_error"), exact);
  EXPECT_LT(errors_with(0, 0).at("swing"), exact);
  EXPECT_NEAR(errors_with(0, 0.01).at("analytic_error"), 0.01, 1e-9);
  EXPECT_LT(errors_with(0.05, 0).at("analytic_error"), 5e-4) << "a swing averages out";
  EXPECT_NEAR(errors_with(0.05, 0).at("swing"), 0.05, 1e-9);
}

}  // namespace
}  // namespace atl::test
