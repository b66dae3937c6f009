#include <array>

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

}  // namespace

Settings read_settings(const Reader& in) {
  in.only_keys({"substeps",
                "iterations",
                "relax_iterations",
                "tolerance",
                "friction",
                "warm_starting",
                "stabilisation",
                "correction",
                "slop",
                "contact_hertz",
                "contact_damping_ratio",
                "contact_push_speed",
                "restitution_threshold",
                "contact_solver",
                "joint_solver",
                "joint_hertz",
                "joint_damping_ratio",
                "sleeping",
                "sleep_speed",
                "time_to_sleep"});
  Settings settings;
  get(in, "substeps", settings.substeps, 1, 1024);
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
  if (in.find("contact_hertz")) get(in, "contact_hertz", settings.contact_hertz.emplace(), above(0));
  get(in, "contact_damping_ratio", settings.contact_damping_ratio, at_least(0));
  get(in, "contact_push_speed", settings.contact_push_speed, above(0));
  if (in.find("restitution_threshold")) {
    get(in, "restitution_threshold", settings.restitution_threshold.emplace(), at_least(0));
  }
  if (const auto solver = in.find("contact_solver")) settings.contact_solver = read_contact_solver(*solver);
  if (const auto solver = in.find("joint_solver")) settings.joint_solver = read_joint_solver(*solver);
  if (in.find("joint_hertz")) get(in, "joint_hertz", settings.joint_hertz.emplace(), above(0));
  get(in, "joint_damping_ratio", settings.joint_damping_ratio, at_least(0));
  get(in, "sleeping", settings.sleeping);
  get(in, "sleep_speed", settings.sleep_speed, at_least(0));
  get(in, "time_to_sleep", settings.time_to_sleep, at_least(0));
  return settings;
}

}  // namespace atl::scene
