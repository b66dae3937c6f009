#pragma once
/// Runs scenes with a closed form, and feeds their measures with given states.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "support/bodies.h"

namespace atl::test {

using Errors = std::map<std::string, double>;

inline Errors by_name(const std::vector<ErrorMeasure>& measures) {
  Errors errors;
  for (const ErrorMeasure& measure : measures) errors[measure.name] = measure.value;
  return errors;
}

inline std::vector<BodyState> starting_states(const Scene& scene) {
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
inline Errors errors_of(const Scene& scene, const Motion& motion, double dt) {
  const auto measure = scene.closed_form->measure();
  const double duration = scene.steps * scene.dt;
  for (int step = 1; step * dt < duration * (1 + 1e-12); ++step) {
    std::vector<BodyState> states = starting_states(scene);
    motion(step * dt, states);
    measure->observe(step * dt, states, {});
  }
  return by_name(measure->errors());
}

inline constexpr std::array sampling = {1.0 / 15, 1.0 / 60, 1.0 / 97, 1.0 / 960};  ///< s, steps

/// Atoll's own errors over a scene's whole duration, in steps of dt.
inline Errors run_closed_form(std::string_view text, const Settings& settings, double dt = 1.0 / 60) {
  const Scene scene = load_scene(text);
  Settings all = scene.settings;
  all.substeps = settings.substeps;
  all.friction = settings.friction;
  all.joint_solver = settings.joint_solver;
  World world({.gravity = scene.gravity, .settings = all});
  const std::vector<BodyId> ids = build_scene(scene, world);
  ErrorMeter meter(scene);
  const double duration = scene.steps * scene.dt;
  for (int step = 1; step * dt < duration * (1 + 1e-12); ++step) {
    apply_forces(scene, world, ids);
    world.step(dt);
    meter.observe(step * dt, body_states(world, ids),
                  meter.needs_loads() ? contact_loads(world, ids) : std::vector<ContactLoad>());
  }
  return by_name(meter.errors());
}

inline constexpr double exact = 1e-9;  ///< what counts as no error

/// A scene's exact motion has no error, however it is sampled.
inline void expect_exact(const Scene& scene, const Motion& motion, double tolerance = exact) {
  for (const double dt : sampling) {
    for (const auto& [name, error] : errors_of(scene, motion, dt)) {
      EXPECT_LT(error, tolerance) << scene.name << ", " << name << ", steps of " << dt << " s";
    }
  }
}

inline std::vector<std::string> closed_form_scenes() {
  std::vector<std::string> names;
  for (const BuiltinScene& builtin : builtin_scenes()) {
    if (load_scene(builtin.name + (builtin.name == "islands" ? ":count=1" : "")).closed_form)
      names.push_back(builtin.name);
  }
  return names;
}

}  // namespace atl::test
