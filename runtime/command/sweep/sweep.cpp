#include "sweep.h"

#include <atoll/world.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iostream>

#include "../failure.h"
#include "../interrupt.h"
#include "../names.h"
#include "../output_file.h"
#include "../progress.h"
#include "../simulation.h"
#include "../standard_streams.h"
#include "../view.h"
#include "checks/tradeoff/scene_sweep.h"
#include "results.h"
#include "view/film.h"

namespace atl::command {
namespace {

namespace fs = std::filesystem;
using namespace tradeoff;

// The files of a sweep, known to be writable before it starts.
struct SweepFiles {
  OutputFile json;
  OutputFile csv;
  OutputFile page;
};

SweepFiles check_sweep_files(const std::string& directory) {
  std::error_code error;
  fs::create_directories(directory, error);
  if (error) throw Failure(Status::Usage, "--out: cannot make the directory " + directory + ": " + error.message());
  const auto file = [&](const char* name) { return OutputFile("--out", (fs::path(directory) / name).string()); };
  return {file("results.json"), file("results.csv"), file("index.html")};
}

std::vector<std::string> scene_addresses(const SweepOptions& options) {
  std::vector<std::string> addresses;
  if (options.analytic) {
    for (const BuiltinScene& scene : builtin_scenes()) {
      if (load_scene(scene.name, options.grid.seed).closed_form) addresses.push_back(scene.name);
    }
  }
  addresses.insert(addresses.end(), options.scenes.begin(), options.scenes.end());
  if (addresses.empty() && !options.frontier) {
    throw Failure(Status::Usage, "found no scene, expected SCENE, --analytic or --frontier");
  }
  return addresses;
}

std::vector<PeerDriver> ask_drivers(const SweepOptions& options) {
  const double limit = options.peer_limit.value_or(options.grid.quick ? quick_peer_limit : peer_limit);
  try {
    return tradeoff::ask_drivers(options.peers, limit, interrupted);
  } catch (const DriverError& error) {
    throw Failure(Status::Usage, std::string("--peer: ") + error.what());
  }
}

std::vector<EngineVersion> engine_versions(const std::vector<PeerDriver>& drivers) {
  std::vector<EngineVersion> engines = {
      {"Atoll", ATOLL_VERSION, "double poses, single velocities, " + std::string(name_of(World().simd()))}};
  for (const PeerDriver& driver : drivers) {
    engines.push_back({driver.engine(), driver.version(), driver.precision()});
  }
  return engines;
}

// Logs a finished scene when there is no terminal to draw a bar on.
void log_scene(const SceneReport& report, double seconds) {
  if (::isatty(STDERR_FILENO) != 0) return;
  std::cerr << "atoll: " << report.plan.scene.name << ": " << report.records.size() << " settings in "
            << fixed(seconds, 1) << " s" << std::endl;
}

void sweep_scenes(std::vector<ScenePlan> plans, const std::vector<PeerDriver>& drivers, const RunPolicy& policy,
                  SweepResults& results) {
  using Clock = std::chrono::steady_clock;
  std::vector<std::int64_t> work;
  std::int64_t all_work = 0;
  for (const ScenePlan& plan : plans) {
    work.push_back(estimate_work(plan, drivers, policy));
    all_work += work.back();
  }
  Progress progress(all_work, "");
  std::int64_t before = 0;
  for (std::size_t i = 0; i < plans.size() && !interrupted(); ++i) {
    const Clock::time_point start = Clock::now();
    std::int64_t done = 0;
    const WorkDone work_done = [&](std::int64_t more) { progress.update(before + (done += more)); };
    results.scenes.push_back(sweep_scene(std::move(plans[i]), drivers, policy, results.seed, work_done));
    if (results.scenes.back().records.empty()) results.scenes.pop_back();  // interrupted
    if (interrupted()) break;
    before += work[i];
    log_scene(results.scenes.back(), std::chrono::duration<double>(Clock::now() - start).count());
  }
}

void find_frontiers(const std::vector<PeerDriver>& drivers, SweepResults& results) {
  // Climbs one after another: a rung that fails ends it, so how long all take isn't known.
  const std::vector<Ladder> ladders = stiff_ladders();
  Progress progress(static_cast<std::int64_t>(ladders.size()), "");
  for (const Ladder& ladder : ladders) {
    try {
      results.frontiers.push_back(climb(ladder, drivers, results.quick, interrupted));
    } catch (const Stopped&) {
      return;
    }
    progress.update(static_cast<std::int64_t>(results.frontiers.size()));
  }
}

// Plays scenes by their own settings, as they were timed.
void write_views(const std::string& directory, SweepResults& results) {
  for (std::size_t i = 0; i < results.scenes.size() && !interrupted(); ++i) {
    const Scene& scene = results.scenes[i].plan.scene;
    World world = command::make_world(scene, 1);
    const std::vector<BodyId> ids = build_scene(scene, world);
    view::Film film(
        {.name = scene.name,
         .related = {.text = "Error against run time", .address = "index.html#scene-" + std::to_string(i)}});
    (void)simulate(scene, world, ids, {.going = true, .watchers = {&film}});
    const std::string file = "view-" + std::to_string(i) + ".html";
    write_film(page_file("--views", (fs::path(directory) / file).string()), film);
    results.scenes[i].view = file;
  }
}

// Each for itself. What went wrong, or "".
std::string write_files(const SweepFiles& files, const SweepResults& results) {
  std::string failures;
  const auto write = [&](const OutputFile& file, const auto& content) {
    try {
      file.write(content);
    } catch (const Failure& failure) {
      failures += (failures.empty() ? "" : "; ") + std::string(failure.what());
    }
  };
  write(files.json, [&](std::ostream& out) { write_results_json(out, results); });
  write(files.csv, [&](std::ostream& out) { write_results_csv(out, results); });
  write(files.page, [&](std::ostream& out) { write_results_page(out, results, today()); });
  return failures;
}

}  // namespace

namespace {

void sweep_all(const SweepOptions& options) {
  std::vector<ScenePlan> plans;
  for (const std::string& address : scene_addresses(options)) plans.push_back(plan_scene(address, options.grid));
  const std::vector<PeerDriver> drivers = ask_drivers(options);
  const SweepFiles outputs = check_sweep_files(options.out);
  if (options.views) (void)page_file("--views", (fs::path(options.out) / "view-0.html").string());

  RunPolicy policy = RunPolicy::standard(options.grid.quick);
  policy.repeats = options.repeats.value_or(policy.repeats);
  policy.min_time = options.time.value_or(policy.min_time);
  policy.stop = interrupted;
  SweepResults results = {.surroundings = surroundings(),
                          .engines = engine_versions(drivers),
                          .quick = options.grid.quick,
                          .repeats = policy.repeats,
                          .time = policy.min_time,
                          .seed = options.grid.seed,
                          .scenes = {},
                          .frontiers = {}};
  const std::size_t scenes = plans.size();
  sweep_scenes(std::move(plans), drivers, policy, results);
  if (options.frontier) find_frontiers(drivers, results);
  results.interrupted = interrupted();
  const std::string done =
      "with " + std::to_string(results.scenes.size()) + " of " + plural(static_cast<std::int64_t>(scenes), "scene");
  if (results.interrupted && results.scenes.empty() && results.frontiers.empty()) {
    throw interruption("sweep", done + " run; nothing was written");
  }

  if (options.views) write_views(options.out, results);
  const std::string failures = write_files(outputs, results);
  write_results_text(std::cout, results);
  if (failures.empty())
    std::cout << "wrote " << (fs::path(options.out) / "index.html").string() << ", results.json and results.csv\n";
  finish_output();
  if (!failures.empty()) throw Failure(Status::Usage, failures);
  if (results.interrupted) throw interruption("sweep", done + ", all that was timed by then is in what was written");
}

}  // namespace

void sweep(const SweepOptions& options) {
  try {
    sweep_all(options);
  } catch (const DriverError& error) {
    throw Failure(Status::Usage, error.what());
  } catch (const OtherBits& error) {
    throw Failure(Status::CheckFailed, error.what());
  } catch (const Stopped&) {
    throw Interrupted{};
  }
}

}  // namespace atl::command
