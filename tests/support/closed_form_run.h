#pragma once
/// Runs scenes with a closed form.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

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

}  // namespace atl::test
