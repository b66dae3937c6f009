#include <atoll/world.h>

#include <array>
#include <string>

#include "schema.h"

namespace atl::scene {
namespace {

Stabilisation read_stabilisation(const Reader& in) {
  constexpr std::array stabilisations = {Stabilisation::Soft, Stabilisation::Baumgarte, Stabilisation::SplitImpulse};
  return stabilisations[in.choice({"soft", "baumgarte", "split_impulse"})];
}

ContactSolver read_contact_solver(const Reader& in) {
  constexpr std::array solvers = {ContactSolver::Auto, ContactSolver::Iterative, ContactSolver::Direct};
  return solvers[in.choice({"auto", "iterative", "direct"})];
}

JointSolver read_joint_solver(const Reader& in) {
  constexpr std::array solvers = {JointSolver::Auto, JointSolver::Iterative, JointSolver::Direct};
  return solvers[in.choice({"auto", "iterative", "direct"})];
}

ErrorTarget read_target(const Reader& in) {
  in.only_keys({"penetration", "joint_gap", "residual", "motion", "min_substeps", "max_substeps"});
  ErrorTarget target;
  get(in, "penetration", target.penetration, above(0));
  get(in, "joint_gap", target.joint_gap, above(0));
  get(in, "residual", target.residual, above(0));
  get(in, "motion", target.motion, above(0));
  get(in, "min_substeps", target.min_substeps, 1, 1024);
  get(in, "max_substeps", target.max_substeps, 1, 1024);
  if (target.max_substeps < target.min_substeps) {
    in.fail_at("max_substeps", std::to_string(target.max_substeps) + (in.has("max_substeps") ? "" : ", the default,"),
               "min_substeps, " + std::to_string(target.min_substeps) + ", or more");
  }
  return target;
}

// Refuses what a world would refuse, but names the place in the file.
void check_target(const Reader& in, const Settings& settings) {
  const ErrorTarget& target = settings.target;
  if (!target.is_set()) return;
  if (settings.stabilisation != Stabilisation::Soft) {
    in.fail_at("target", "it with rigid stabilisation, whose overlap is its slop", "it with \"soft\" only");
  }
  const Reader its = *in.find("target");
  if (target.penetration && settings.contact_hertz) its.fail_at("penetration", "it and contact_hertz", "one of them");
  if (target.joint_gap && settings.joint_hertz) its.fail_at("joint_gap", "it and joint_hertz", "one of them");
}

}  // namespace

Settings read_settings(const Reader& in) {
  in.only_keys({"substeps",           "target",
                "iterations",         "relax_iterations",
                "tolerance",          "friction",
                "warm_starting",      "stabilisation",
                "correction",         "slop",
                "contact_hertz",      "contact_damping_ratio",
                "contact_push_speed", "restitution_threshold",
                "contact_solver",     "joint_solver",
                "joint_hertz",        "joint_damping_ratio",
                "sleeping",           "sleep_speed",
                "time_to_sleep"});
  Settings settings;
  get(in, "substeps", settings.substeps, 1, 1024);
  if (const auto target = in.find("target")) settings.target = read_target(*target);
  get(in, "iterations", settings.iterations, 1, 1024);
  get(in, "relax_iterations", settings.relax_iterations, 0, 1024);
  get(in, "tolerance", settings.tolerance, at_least(0));
  if (const auto friction = in.find("friction")) {
    settings.friction = friction->choice({"cone", "pyramid"}) == 0 ? FrictionModel::Cone : FrictionModel::Pyramid;
  }
  get(in, "warm_starting", settings.warm_starting);
  if (const auto stabilisation = in.find("stabilisation")) settings.stabilisation = read_stabilisation(*stabilisation);
  get(in, "correction", settings.correction, above_up_to(0, 1));
  get(in, "slop", settings.slop, at_least(0));
  get(in, "contact_hertz", settings.contact_hertz, above(0));
  get(in, "contact_damping_ratio", settings.contact_damping_ratio, at_least(0));
  get(in, "contact_push_speed", settings.contact_push_speed, above(0));
  get(in, "restitution_threshold", settings.restitution_threshold, at_least(0));
  if (const auto solver = in.find("contact_solver")) settings.contact_solver = read_contact_solver(*solver);
  if (const auto solver = in.find("joint_solver")) settings.joint_solver = read_joint_solver(*solver);
  get(in, "joint_hertz", settings.joint_hertz, above(0));
  get(in, "joint_damping_ratio", settings.joint_damping_ratio, at_least(0));
  get(in, "sleeping", settings.sleeping);
  get(in, "sleep_speed", settings.sleep_speed, at_least(0));
  get(in, "time_to_sleep", settings.time_to_sleep, at_least(0));
  check_target(in, settings);
  try {
    World({.settings = settings});  // which says with what sizes it can compute
  } catch (const Error& error) {
    in.complain(error.what());
  }
  return settings;
}

}  // namespace atl::scene
