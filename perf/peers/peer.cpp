#include "peer.h"

#include <figures.h>
#include <state_csv.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numeric>

#include "run.h"

namespace peer {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
  std::string scene;
  int steps = 0;  // 0: as many as the scene says
  double dt = 0;  // 0: the scene's
  std::uint64_t seed = 1;
  Setting setting;
  double time = 0;
  bool timed = false;
  bool errors = false;
  bool describe = false;
  std::string format = "text";
  std::string final_state;
};

Json describe(const Engine& engine) {
  Json settings = Json::array();
  for (const NamedSetting& setting : engine.settings) {
    settings.push_back({{"label", setting.label}, {"options", setting.options}, {"large", setting.large}});
  }
  return {{"engine", engine.name},
          {"version", engine.version},
          {"precision", engine.precision},
          {"settings", std::move(settings)}};
}

Json times_json(std::vector<double> ms) {
  std::sort(ms.begin(), ms.end());
  const std::size_t n = ms.size();
  const auto rank = static_cast<std::size_t>(std::ceil(0.99 * static_cast<double>(n)));
  return {{"mean", std::accumulate(ms.begin(), ms.end(), 0.0) / static_cast<double>(n)},
          {"median", (ms[(n - 1) / 2] + ms[n / 2]) / 2},
          {"p99", ms[rank - 1]},
          {"max", ms.back()}};
}

void add_outcome(Json& report, const Outcome& outcome) {
  Json errors = Json::object();
  for (const atl::ErrorMeasure& error : outcome.errors) errors[error.name] = error.value;
  report["errors"] = std::move(errors);
  report["fell"] = outcome.fell;
}

void add_times(Json& report, const TimedRuns& timed, const atl::Scene& scene) {
  const double steps = static_cast<double>(timed.runs) * scene.steps;
  report["cpu_s_per_simulated_s"] = timed.cpu / (steps * scene.dt);
  report["ms_per_step"] = {{"mean", 1e3 * timed.wall / steps}};
  report["runs"] = timed.runs;
}

// One line a value, objects flattened to dotted names.
void print_text(const Json& report) {
  const Json flat = report.flatten();
  for (const auto& [path, value] : flat.items()) {
    std::string name = path.substr(1);
    std::replace(name.begin(), name.end(), '/', '.');
    std::cout << std::left << std::setw(34) << name << (value.is_string() ? value.get<std::string>() : value.dump())
              << '\n';
  }
}

void write_final_state(const std::string& path, const atl::Scene& scene, const std::vector<atl::BodyState>& states) {
  atl::World world;
  const std::vector<atl::BodyId> ids = atl::build_scene(scene, world);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (world.type(ids[i]) == atl::BodyType::Static) continue;
    world.set_pose(ids[i], states[i].pose);
    world.set_velocity(ids[i], states[i].velocity, states[i].angular_velocity);
  }
  atl::command::BodyStates table;
  table.copy(world);
  std::ofstream file(path);
  table.write_csv(file, scene, ids);
  if (!file.flush()) throw std::runtime_error("cannot write " + path);
}

const char* found_beside(const atl::BodyDef& def) {
  if (!(def.locks == atl::MotionLocks())) return "motion locks";
  if (def.material.rolling_friction > 0) return "rolling friction";
  if (def.material.torsional_friction > 0) return "torsional friction";
  if (def.material.is_directed()) return "a direction of friction";
  if (def.material.friction_rule != atl::CombineRule::Default) return "a rule for friction";
  if (def.material.restitution_rule != atl::CombineRule::Default) return "a rule for restitution";
  if (!def.materials.empty()) return "materials of triangles";
  return def.surface_velocity.isZero(0) ? nullptr : "a surface velocity";
}

// No driver hands these on, and without them it would be another scene.
void check_bodies(const Engine& engine, const atl::Scene& scene) {
  for (const atl::SceneBody& body : scene.bodies) {
    if (const char* found = found_beside(body.def)) {
      throw atl::Error("the " + engine.name +
                       " driver knows no locks, and of a surface friction and restitution only: found " + found +
                       " on body \"" + body.name + "\"");
    }
  }
}

Json simulate(const Engine& engine, const Options& options) {
  atl::Scene scene = atl::load_scene(options.scene, options.seed);
  check_bodies(engine, scene);
  if (options.steps > 0) scene.steps = options.steps;
  if (options.dt > 0) scene.dt = options.dt;
  const Setting& setting = options.setting;
  Json report = {
      {"engine", engine.name},
      {"version", engine.version},
      {"precision", engine.precision},
      {"setting", {{"substeps", setting.substeps}, {"iterations", setting.iterations}, {"variant", setting.variant}}},
      {"scene", scene.name},
      {"bodies", atl::command::body_counts(scene).dynamic},
      {"steps", scene.steps},
      {"dt", scene.dt},
      {"threads", 1}};
  if (options.errors) {
    add_outcome(report, run_observed(engine, scene, setting));
  } else if (options.timed) {
    add_times(report, run_timed(engine, scene, setting, options.time), scene);
  } else {
    const SteppedRun run = run_stepped(engine, scene, setting);
    if (!options.final_state.empty()) write_final_state(options.final_state, scene, run.states);
    report["ms_per_step"] = times_json(run.ms);
    add_outcome(report, run.outcome);
  }
  return report;
}

void add_options(CLI::App& app, const Engine& engine, Options& options) {
  auto* describe = app.add_flag("--describe", options.describe, "print the engine and the settings worth a sweep");
  auto* scene = app.add_option("SCENE", options.scene, "scene file or built-in scene");
  scene->excludes(describe);
  app.add_option("--steps", options.steps, "steps to simulate (default: the scene's)")->check(CLI::Range(1, 1'000'000));
  app.add_option("--dt", options.dt, "length of a step, s (default: the scene's)")->check(CLI::Range(1e-9, 1.0));
  app.add_option("--seed", options.seed, "seed of a scene's random content")->capture_default_str();
  app.add_option("--substeps", options.setting.substeps, "engine steps in a step, each of dt / substeps")
      ->check(CLI::Range(1, 100'000))
      ->capture_default_str();
  app.add_option("--iterations", options.setting.iterations, "iterations of the engine's solver")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  app.add_option("--variant", options.setting.variant, "how the engine solves")
      ->check(CLI::IsMember(engine.variants))
      ->capture_default_str();
  auto* time = app.add_option("--time", options.time, "time whole runs until they took this much CPU time, s");
  time->check(CLI::Range(0.0, 1e6));
  auto* errors = app.add_flag("--errors", options.errors, "measure errors over all steps; no times");
  errors->excludes(time);
  app.add_option("--format", options.format, "text or json")
      ->check(CLI::IsMember({"text", "json"}))
      ->capture_default_str();
  app.add_option("--final-state", options.final_state, "write pose and velocity of every body to this CSV file")
      ->excludes(time)
      ->excludes(errors);
  app.callback([&options, scene, describe, time] {
    options.timed = time->count() > 0;
    if (scene->count() + describe->count() == 0) throw CLI::RequiredError("SCENE");
  });
}

}  // namespace

int run(const Engine& engine, int argc, char** argv) {
  Options options;
  options.setting = {.iterations = engine.iterations, .variant = engine.variants.front()};
  CLI::App app("Simulates an Atoll scene in " + engine.name + " " + engine.version + " (" + engine.precision +
               " precision, one thread).");
  add_options(app, engine, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }

  int status = 2;
  try {
    const Json report = options.describe ? describe(engine) : simulate(engine, options);
    if (options.describe || options.format == "json") {
      std::cout << report.dump(2) << '\n';
    } else {
      print_text(report);
    }
    return 0;
  } catch (const NonFinite& error) {
    status = 4;
    std::cerr << engine.name << ": " << error.what() << '\n';
  } catch (const atl::Error& error) {
    status = 3;
    std::cerr << engine.name << ": " << error.what() << '\n';
  } catch (const std::exception& error) {
    std::cerr << engine.name << ": " << error.what() << '\n';
  }
  return status;
}

}  // namespace peer
