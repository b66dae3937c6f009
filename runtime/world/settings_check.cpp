#include "world/settings_check.h"

#include <atoll/error.h>

#include <sstream>

#include "world/refuse.h"
#include "world/simd_names.h"

namespace atl {
namespace {

void check_count(std::string_view field, int value, int min) {
  if (value < min || value > 1024) refuse(field, value, min == 0 ? "0 to 1024" : "1 to 1024");
}

void check_target(const Settings& settings, const ErrorTarget& target) {
  const auto check_error = [](const char* field, std::optional<double> error) {
    if (error) check_positive(field, *error);
  };
  check_error("Settings.target.penetration", target.penetration);
  check_error("Settings.target.joint_gap", target.joint_gap);
  check_error("Settings.target.residual", target.residual);
  check_error("Settings.target.motion", target.motion);
  check_count("Settings.target.min_substeps", target.min_substeps, 1);
  check_count("Settings.target.max_substeps", target.max_substeps, 1);
  if (target.max_substeps < target.min_substeps) {
    refuse("Settings.target.max_substeps", target.max_substeps,
           "min_substeps, " + std::to_string(target.min_substeps) + ", or more");
  }
  if (!target.is_set()) return;
  if (settings.stabilisation != Stabilisation::Soft) {
    throw Error("Settings.target is set with rigid stabilisation, whose overlap is its slop; expected Soft");
  }
  if (target.penetration && settings.contact_hertz) {
    throw Error("Settings.target.penetration is set, and contact_hertz, too; expected one of them");
  }
  if (target.joint_gap && settings.joint_hertz) {
    throw Error("Settings.target.joint_gap is set, and joint_hertz, too; expected one of them");
  }
}

}  // namespace

void check(const Settings& settings) {
  check_count("Settings.substeps", settings.substeps, 1);
  check_count("Settings.iterations", settings.iterations, 1);
  check_count("Settings.relax_iterations", settings.relax_iterations, 0);
  check_target(settings, settings.target);
  check_not_negative("Settings.tolerance", settings.tolerance);
  if (settings.stabilisation < Stabilisation::Soft || settings.stabilisation > Stabilisation::SplitImpulse) {
    refuse("Settings.stabilisation", static_cast<int>(settings.stabilisation), "a value of Stabilisation");
  }
  if (!(settings.correction > 0 && settings.correction <= 1)) {
    refuse("Settings.correction", settings.correction, "a number in (0, 1]");
  }
  check_not_negative("Settings.slop", settings.slop);
  if (settings.contact_hertz) check_positive("Settings.contact_hertz", *settings.contact_hertz);
  check_not_negative("Settings.contact_damping_ratio", settings.contact_damping_ratio);
  check_positive("Settings.contact_push_speed", settings.contact_push_speed);
  if (settings.restitution_threshold) {
    check_not_negative("Settings.restitution_threshold", *settings.restitution_threshold);
  }
  if (settings.contact_solver < ContactSolver::Auto || settings.contact_solver > ContactSolver::Direct) {
    refuse("Settings.contact_solver", static_cast<int>(settings.contact_solver), "a value of ContactSolver");
  }
  if (settings.joint_solver < JointSolver::Auto || settings.joint_solver > JointSolver::Direct) {
    refuse("Settings.joint_solver", static_cast<int>(settings.joint_solver), "a value of JointSolver");
  }
  if (settings.joint_hertz) check_positive("Settings.joint_hertz", *settings.joint_hertz);
  check_not_negative("Settings.joint_damping_ratio", settings.joint_damping_ratio);
  if (settings.contact_event_force) check_not_negative("Settings.contact_event_force", *settings.contact_event_force);
  check_not_negative("Settings.sleep_speed", settings.sleep_speed);
  check_not_negative("Settings.time_to_sleep", settings.time_to_sleep);
  kernels_for(settings.simd);
}

solver::SolverSettings solver_settings(const Settings& settings) {
  solver::SolverSettings s;
  s.substeps = settings.substeps;
  s.iterations = settings.iterations;
  s.relax_iterations = settings.relax_iterations;
  s.pyramid = settings.friction == FrictionModel::Pyramid;
  s.warm_starting = settings.warm_starting;
  s.tolerance = settings.tolerance;
  s.stabilisation = static_cast<solver::Stabilisation>(settings.stabilisation);
  s.correction = settings.correction;
  s.slop = settings.slop;
  s.profile = settings.profile;
  s.everything = settings.run_everything;
  s.direct_only = settings.contact_solver == ContactSolver::Direct;
  s.contact_hertz = settings.contact_hertz.value_or(0);
  s.contact_damping_ratio = settings.contact_damping_ratio;
  s.contact_push_speed = settings.contact_push_speed;
  s.restitution_threshold = settings.restitution_threshold.value_or(0);
  s.joint_method = static_cast<solver::JointMethod>(settings.joint_solver);
  s.joint_hertz = settings.joint_hertz.value_or(0);
  s.joint_damping_ratio = settings.joint_damping_ratio;
  return s;
}

solver::ErrorTarget error_target(const ErrorTarget& target) {
  constexpr double none = solver::ErrorTarget::none;
  return {.penetration = target.penetration.value_or(none),
          .joint_gap = target.joint_gap.value_or(none),
          .residual = target.residual.value_or(none),
          .motion = target.motion.value_or(none),
          .min_substeps = target.min_substeps,
          .max_substeps = target.max_substeps};
}

const solver::Kernels& kernels_for(Simd simd) {
  if (simd == Simd::Auto) return *solver::available_kernels().front();
  for (const auto& [set, name] : simd_names) {
    if (set != simd) continue;
    if (const solver::Kernels* kernels = solver::find_kernels(name)) return *kernels;
    std::ostringstream message;
    message << "Settings.simd is " << name << ", which this machine lacks; expected auto";
    for (const solver::Kernels* kernels : solver::available_kernels()) message << ", " << kernels->name;
    throw Error(message.str());
  }
  refuse("Settings.simd", static_cast<int>(simd), "a value of Simd");
}

Simd simd_of(const solver::Kernels& kernels) {
  for (const auto& [set, name] : simd_names) {
    if (std::string_view(kernels.name) == name) return set;
  }
  return Simd::Portable;
}

}  // namespace atl
