#include "scene_options.h"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "checks/tradeoff/target_text.h"
#include "failure.h"
#include "names.h"
#include "option_checks.h"

namespace atl::command {
namespace {

void apply_target(const SceneOptions& options, ErrorTarget& target) {
  if (options.target) {
    const ErrorTarget before = target;
    target = *options.target;
    target.min_substeps = before.min_substeps;
    target.max_substeps = before.max_substeps;
  }
  if (!options.max_substeps) return;
  if (!target.is_set()) {
    throw Failure(Status::Usage, "--max-substeps: found no target, expected --target or a scene that has one");
  }
  target.max_substeps = *options.max_substeps;
  target.min_substeps = std::min(target.min_substeps, target.max_substeps);
}

void apply(const SceneOptions& options, Scene& scene) {
  const auto override_by = [](const auto& option, auto& value) {
    if (option) value = *option;
  };
  override_by(options.steps, scene.steps);
  override_by(options.dt, scene.dt);
  override_by(options.substeps, scene.settings.substeps);
  apply_target(options, scene.settings.target);
  override_by(options.iterations, scene.settings.iterations);
  override_by(options.relax_iterations, scene.settings.relax_iterations);
  override_by(options.friction, scene.settings.friction);
  override_by(options.stabilisation, scene.settings.stabilisation);
  override_by(options.correction, scene.settings.correction);
  override_by(options.slop, scene.settings.slop);
  override_by(options.tolerance, scene.settings.tolerance);
  override_by(options.contact_solver, scene.settings.contact_solver);
  override_by(options.joint_solver, scene.settings.joint_solver);
  if (options.joint_hertz) scene.settings.joint_hertz = options.joint_hertz;
  if (options.no_warm_start) scene.settings.warm_starting = false;
  if (options.sleeping) scene.settings.sleeping = true;
}

}  // namespace

CLI::Option* add_scene_options(CLI::App& command, SceneOptions& options) {
  CLI::Option* scene = command.add_option("SCENE", options.text,
                                          "scene file, or a built-in scene such as wall:base=100 (see atoll scenes)");

  const char* content = "Scene";
  command.add_option("--steps", options.steps, "steps to simulate (default: the scene's)")
      ->check(integer_in(1, max_steps))
      ->group(content);
  command.add_option("--dt", options.dt, "s of simulated time a step, as 1/60 or 0.01 (default: the scene's)")
      ->transform(seconds_a_step())
      ->group(content);
  command.add_option("--seed", options.seed, "seed of a scene's random content (default: 1)")
      ->check(seed_number())
      ->group(content);

  command
      .add_flag("--allow-outside", options.allow_outside,
                "let the scene file name mesh files outside its folder: for files that you trust")
      ->group(content);

  const char* solver = "Solver (default: the scene's settings)";
  command.add_option("--substeps", options.substeps, "substeps a step; error falls with their square")
      ->check(integer_in(1, 1024))
      ->group(solver);
  command
      .add_option_function<std::string>(
          "--target", [&options](const std::string& text) { tradeoff::read_target(text, options.target.emplace()); },
          "each island gets the fewest substeps that hold its errors below this: 1mm, of penetrations and gaps of "
          "joints; or a list as penetration=1mm,joint_gap=0.1mm,residual=0.01,motion=1mm/s; or off")
      ->check(error_target())
      ->type_name("ERROR")
      ->group(solver);
  command.add_option("--max-substeps", options.max_substeps, "with a target: the most that an island may get")
      ->check(integer_in(1, 1024))
      ->group(solver);
  command.add_option("--iterations", options.iterations, "sweeps over the contacts and joints a substep")
      ->check(integer_in(1, 1024))
      ->group(solver);
  command.add_option("--relax-iterations", options.relax_iterations, "sweeps without position bias a substep")
      ->check(integer_in(0, 1024))
      ->group(solver);
  add_choice(command, "--friction", {"cone", "pyramid"}, "friction model", [&options](const std::string& name) {
    options.friction = friction_named(name);
  })->group(solver);
  command
      .add_option("--tolerance", options.tolerance,
                  "m/s; sweeps of an island end with one that changes no speed at a contact or joint by more; 0: never")
      ->check(number_not_below_zero())
      ->group(solver);
  add_choice(command, "--stabilisation", {"soft", "baumgarte", "split_impulse"}, "how contacts get bodies apart",
             [&options](const std::string& name) { options.stabilisation = stabilisation_named(name); })
      ->group(solver);
  command
      .add_option("--correction", options.correction,
                  "of the overlap that baumgarte and split_impulse remove a substep")
      ->check(number_above_zero(1))
      ->group(solver);
  command.add_option("--slop", options.slop, "m of overlap that these leave alone")
      ->check(number_not_below_zero())
      ->group(solver);
  add_choice(command, "--contact-solver", {"auto", "iterative", "direct"},
             "how contacts are solved: by sweeps, or at once; auto: at once or in finer substeps where sweeps can't "
             "hold the load",
             [&options](const std::string& name) { options.contact_solver = contact_solver_named(name); })
      ->group(solver);
  add_choice(
      command, "--joint-solver", {"auto", "iterative", "direct"},
      "how joints are solved: one by one, or at once; auto: at once if anchored, in long chains or of unequal masses",
      [&options](const std::string& name) { options.joint_solver = joint_solver_named(name); })
      ->group(solver);
  command
      .add_option("--joint-hertz", options.joint_hertz,
                  "Hz; stiffness of iterative joints, up to 0.28 of the substep rate, which is the default")
      ->check(number_above_zero())
      ->group(solver);
  command.add_flag("--no-warm-start", options.no_warm_start, "start every step from zero impulses")->group(solver);
  command.add_flag("--sleeping", options.sleeping, "let islands at rest fall asleep")->group(solver);
  return scene;
}

Scene load(const SceneOptions& options) {
  Scene scene =
      load_scene(options.text, options.seed, options.allow_outside ? MeshFiles::Anywhere : MeshFiles::BelowScene);
  apply(options, scene);
  return scene;
}

}  // namespace atl::command
