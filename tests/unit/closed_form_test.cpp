// The measures of the scenes with a closed form: a wrong motion has an error, and any is finite. That the right one has
// none is shown by worlds, in accuracy/analytic_scene_test.cpp and accuracy/analytic_joint_test.cpp.

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "support/closed_form_run.h"

namespace atl::test {
namespace {

std::vector<BodyState> starting_states(const Scene& scene) {
  std::vector<BodyState> states;
  for (const SceneBody& body : scene.bodies) {
    const BodyDef& def = body.def;
    states.push_back({{def.position, def.orientation.normalized()}, def.velocity, def.angular_velocity});
  }
  return states;
}

/// Changes the states from their start to those at a time in s.
using Motion = std::function<void(double time, std::vector<BodyState>& states)>;

/// Errors of a motion by the scene's measure, sampled in steps of dt (s) over the scene's duration.
Errors errors_of(const Scene& scene, const Motion& motion, double dt) {
  const auto measure = scene.closed_form->measure();
  const double duration = scene.steps * scene.dt;
  for (int step = 1; step * dt < duration * (1 + 1e-12); ++step) {
    std::vector<BodyState> states = starting_states(scene);
    motion(step * dt, states);
    measure->observe(step * dt, states, {});
  }
  return by_name(measure->errors());
}

std::vector<std::string> closed_form_scenes() {
  std::vector<std::string> names;
  for (const BuiltinScene& builtin : builtin_scenes()) {
    if (load_scene(builtin.name + (builtin.name == "islands" ? ":count=1" : "")).closed_form)
      names.push_back(builtin.name);
  }
  return names;
}

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
  EXPECT_LT(errors_with(0, 0).at("analytic_error"), 1e-9);
  EXPECT_LT(errors_with(0, 0).at("swing"), 1e-9);
  EXPECT_NEAR(errors_with(0, 0.01).at("analytic_error"), 0.01, 1e-9);
  EXPECT_LT(errors_with(0.05, 0).at("analytic_error"), 5e-4) << "a swing averages out";
  EXPECT_NEAR(errors_with(0.05, 0).at("swing"), 0.05, 1e-9);
}

}  // namespace
}  // namespace atl::test
