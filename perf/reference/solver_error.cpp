// How far the solver's impulses are from solving the contact problem of a substep, and its velocities from those of a
// solution, over the solver's knobs. Discretisation plays no part in it.

#include <atoll/atoll.h>
#include <atoll/scene.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iomanip>
#include <iostream>
#include <string>
#include <vector>

#include "reference/reference_solver.h"

namespace {

struct Options {
  std::vector<std::string> scenes;
  int steps = 0;  // 0: as many as the scene says
  int from = 0;
  int samples = 10;
  std::uint64_t seed = 1;
  std::vector<int> substeps = {1, 4, 16};
  std::vector<int> iterations = {1, 4};
  std::vector<int> relax = {1, 4, 16};
};

struct Errors {
  std::vector<double> residual;
  std::vector<double> velocity;
  std::size_t patches = 0;  // most
  int unsolved = 0;         // by the reference
};

Errors measure(const atl::Scene& scene, const Options& options) {
  atl::World world({.gravity = scene.gravity, .settings = scene.settings});
  const std::vector<atl::BodyId> ids = atl::build_scene(scene, world);
  Errors errors;
  const int every = std::max(1, (scene.steps - options.from) / options.samples);
  for (int step = 1; step <= scene.steps; ++step) {
    atl::apply_forces(scene, world, ids);
    world.step(scene.dt);
    if (step <= options.from || (scene.steps - step) % every != 0) continue;
    const atl::ContactProblem problem = world.contact_problem();
    if (problem.patches.empty()) continue;
    const atl::reference::ReferenceSolution solution = atl::reference::solve_contact_problem(problem);
    errors.patches = std::max(errors.patches, problem.patches.size());
    errors.residual.push_back(atl::measure_contact_residual(problem).relative);
    if (solution.solved) {
      errors.velocity.push_back(atl::reference::velocity_error(problem, solution));
    } else {
      ++errors.unsolved;
    }
  }
  return errors;
}

void print_median_and_max(std::vector<double> values) {
  for (const double part : {0.5, 1.0}) {
    std::cout << std::setw(11);
    if (values.empty()) {
      std::cout << '-';
      continue;
    }
    std::sort(values.begin(), values.end());
    const auto last = static_cast<double>(values.size() - 1);
    std::cout << std::setprecision(3) << values[static_cast<std::size_t>(part * last)];
  }
}

void print_row(const atl::Scene& scene, const Errors& errors) {
  std::cout << std::left << std::setw(22) << scene.name << std::right << std::setw(9) << scene.settings.substeps
            << std::setw(11) << scene.settings.iterations << std::setw(6) << scene.settings.relax_iterations
            << std::setw(8) << errors.residual.size() << std::setw(8) << errors.patches;
  print_median_and_max(errors.residual);
  print_median_and_max(errors.velocity);
  std::cout << std::setw(9) << errors.unsolved << std::endl;
}

void run(const Options& options) {
  std::cout << "scene                  substeps iterations relax samples patches   residual        max   velocity"
               "        max unsolved\n";
  for (const std::string& text : options.scenes) {
    atl::Scene scene = atl::load_scene(text, options.seed);
    scene.name = text;
    if (options.steps > 0) scene.steps = options.steps;
    scene.settings.keep_contact_problem = true;
    for (const int substeps : options.substeps) {
      for (const int iterations : options.iterations) {
        for (const int relax : options.relax) {
          scene.settings.substeps = substeps;
          scene.settings.iterations = iterations;
          scene.settings.relax_iterations = relax;
          print_row(scene, measure(scene, options));
        }
      }
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app(
      "Measures the solver's error alone: of impulses by the residual of the contact problem of the last substep "
      "of a step, of velocities against an exact solution (energy norm, relative to what contacts change). "
      "Prints medians and maxima over the sampled steps.");
  app.add_option("SCENE", options.scenes, "scene files or built-in scenes")->required();
  app.add_option("--steps", options.steps, "steps to simulate (default: the scene's)")->check(CLI::Range(1, 1'000'000));
  app.add_option("--from", options.from, "steps before the first sample")->check(CLI::Range(0, 1'000'000));
  app.add_option("--samples", options.samples, "steps to measure, at equal distances")
      ->check(CLI::Range(1, 10'000))
      ->capture_default_str();
  app.add_option("--seed", options.seed, "seed of a scene's random content")->capture_default_str();
  const auto add_knob = [&](const char* name, std::vector<int>& values, int min) {
    app.add_option(name, values, "comma-separated values")
        ->delimiter(',')
        ->check(CLI::Range(min, 1024))
        ->capture_default_str();
  };
  add_knob("--substeps", options.substeps, 1);
  add_knob("--iterations", options.iterations, 1);
  add_knob("--relax", options.relax, 0);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    run(options);
  } catch (const atl::Error& error) {
    std::cerr << "atoll_solver_error: " << error.what() << '\n';
    return 3;
  }
  return 0;
}
