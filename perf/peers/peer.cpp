#include "peer.h"

#include <figures.h>
#include <state_csv.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numeric>

namespace peer {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
  std::string scene;
  int steps = 0;  // 0: as many as the scene says
  std::uint64_t seed = 1;
  std::string format = "text";
  std::string final_state;
};

// The scene as Atoll has it. Gives the masses, and takes the engine's last state to be measured.
struct Mirror {
  explicit Mirror(const atl::Scene& scene) : ids(atl::build_scene(scene, world)) {}

  std::vector<double> masses() const {
    std::vector<double> masses;
    for (const atl::BodyId id : ids) masses.push_back(world.mass(id));
    return masses;
  }

  void copy(const std::vector<BodyState>& state) {
    for (std::size_t i = 0; i < ids.size(); ++i) {
      if (world.type(ids[i]) != atl::BodyType::Dynamic) continue;
      world.set_pose(ids[i], state[i].pose);
      world.set_velocity(ids[i], state[i].velocity, state[i].angular_velocity);
    }
  }

  atl::World world;
  std::vector<atl::BodyId> ids;
};

std::vector<double> time_steps(Simulation& simulation, const atl::Scene& scene) {
  using Clock = std::chrono::steady_clock;
  std::vector<double> ms;
  for (int i = 0; i < scene.steps; ++i) {
    const Clock::time_point start = Clock::now();
    simulation.step(scene.dt);
    ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
  }
  return ms;
}

bool is_finite(const BodyState& body) {
  return body.pose.position.allFinite() && body.pose.orientation.coeffs().allFinite() && body.velocity.allFinite() &&
         body.angular_velocity.allFinite();
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

Json errors_json(const atl::Scene& scene, const Mirror& mirror) {
  const std::vector<atl::PlacedShape> shapes = atl::placed_shapes(scene, mirror.world, mirror.ids);
  atl::command::RunResult result;
  result.penetration = atl::measure_penetration(shapes);
  if (scene.starts_at_rest) {
    const double g = scene.gravity.norm();
    const atl::Vector3 up = g > 0 ? atl::Vector3(-scene.gravity / g) : atl::Vector3(0, 0, 1);
    result.rest = atl::measure_rest(atl::placed_shapes(scene), shapes, up);
  }
  Json errors = Json::object();
  for (const atl::command::ErrorMeasure& error : atl::command::named_errors(result)) errors[error.name] = error.value;
  return errors;
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

void write_final_state(const std::string& path, const atl::Scene& scene, const Mirror& mirror) {
  atl::command::BodyStates states;
  states.copy(mirror.world);
  std::ofstream file(path);
  states.write_csv(file, scene, mirror.ids);
  if (!file.flush()) throw std::runtime_error("cannot write " + path);
}

int simulate(const Engine& engine, const Options& options) {
  atl::Scene scene = atl::load_scene(options.scene, options.seed);
  if (options.steps > 0) scene.steps = options.steps;
  Mirror mirror(scene);
  const std::unique_ptr<Simulation> simulation = engine.load(scene, mirror.masses());
  const std::vector<double> ms = time_steps(*simulation, scene);

  const std::vector<BodyState> state = simulation->state();
  const auto broken = std::find_if_not(state.begin(), state.end(), is_finite);
  if (broken != state.end()) {
    std::cerr << engine.name << ": body " << broken - state.begin() << " is not finite after the run\n";
    return 4;
  }
  mirror.copy(state);
  if (!options.final_state.empty()) write_final_state(options.final_state, scene, mirror);
  const Json report = {{"engine", engine.name},
                       {"version", engine.version},
                       {"setting", engine.setting},
                       {"scene", scene.name},
                       {"bodies", atl::command::body_counts(scene).dynamic},
                       {"steps", scene.steps},
                       {"dt", scene.dt},
                       {"threads", 1},
                       {"ms_per_step", times_json(ms)},
                       {"errors", errors_json(scene, mirror)}};
  if (options.format == "json") {
    std::cout << report.dump(2) << '\n';
  } else {
    print_text(report);
  }
  return 0;
}

}  // namespace

int run(const Engine& engine, int argc, char** argv) {
  Options options;
  CLI::App app("Simulates an Atoll scene in " + engine.name + " " + engine.version + " (" + engine.setting + ").");
  app.add_option("SCENE", options.scene, "scene file or built-in scene")->required();
  app.add_option("--steps", options.steps, "steps to simulate (default: the scene's)")->check(CLI::Range(1, 1'000'000));
  app.add_option("--seed", options.seed, "seed of a scene's random content")->capture_default_str();
  app.add_option("--format", options.format, "text or json")
      ->check(CLI::IsMember({"text", "json"}))
      ->capture_default_str();
  app.add_option("--final-state", options.final_state, "write pose and velocity of every body to this CSV file");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }

  try {
    return simulate(engine, options);
  } catch (const atl::Error& error) {
    std::cerr << engine.name << ": " << error.what() << '\n';
    return 3;
  } catch (const std::exception& error) {
    std::cerr << engine.name << ": " << error.what() << '\n';
    return 2;
  }
}

}  // namespace peer
