// Compares an error target with the cheapest fixed number of substeps that meets it: the errors that it holds, measured
// by the audit in a run of their own, and its cost in CPU time of one thread.
//
//   atoll_target_table [SCENE[@STEPS] ...]   (default: the scenes below)

#include <atoll/atoll.h>
#include <atoll/error_meter.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <optional>
#include <string>
#include <vector>

namespace {

using namespace atl;

constexpr int audits = 40;       // of a run
constexpr int rounds = 3;        // of timing, of all settings in turn
constexpr double enough = 0.95;  // of states
constexpr double targets[] = {1e-2, 1e-3, 1e-4};

double cpu_seconds() {
  timespec time;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1, static_cast<std::size_t>(share * static_cast<double>(values.size())))];
}

// The worse of overlaps and gaps of joints, m, of a state.
double error_of(const Scene& scene, const World& world, const std::vector<BodyId>& ids) {
  const double overlap = measure_penetration(placed_shapes(scene, world, ids), may_touch(scene)).p99;
  const std::vector<BodyState> states = body_states(world, ids);
  std::vector<double> gaps;
  for (const PlacedJoint& joint : placed_joints(scene)) gaps.push_back(measure_joint_drift({&joint, 1}, states).max);
  return std::max(overlap, percentile(gaps, 0.99));
}

struct Run {
  Settings settings;
  double rest = 0;      // m, the worst state of the last quarter
  double reported = 1;  // of those that are not, those of which the world tells
  double substeps = 0;
  int last_change = 0;  // the step in which a body got another number of substeps for the last time
  std::vector<double> seconds = {};
  std::vector<double> errors = {};  // m, by state

  double share_within(double target) const {
    const auto within = std::count_if(errors.begin(), errors.end(), [=](double error) { return error <= target; });
    return static_cast<double>(within) / static_cast<double>(errors.size());
  }
};

void measure_errors(const Scene& scene, double target, Run& run) {
  World world({.gravity = scene.gravity, .threads = 2, .settings = run.settings});
  const std::vector<BodyId> ids = build_scene(scene, world);
  const int every = std::max(1, scene.steps / audits);
  int beyond = 0, reported = 0;
  std::int64_t before = 0;
  bool asks = false;  // whether the last state was beyond
  for (int step = 0; step < scene.steps; ++step) {
    apply_forces(scene, world, ids);
    const StepReport report = world.step(scene.dt);
    if (asks) reported += report.counts.missed_targets > 0;
    run.substeps += static_cast<double>(report.counts.body_substeps) / static_cast<double>(scene.steps);
    if (report.counts.body_substeps != before) run.last_change = step;
    before = report.counts.body_substeps;
    asks = false;
    if (step % every != every - 1) continue;
    const double error = error_of(scene, world, ids);
    run.errors.push_back(error);
    asks = error > target;
    beyond += asks;
    if (4 * step >= 3 * scene.steps) run.rest = std::max(run.rest, error);
  }
  if (asks) reported += world.step(scene.dt).counts.missed_targets > 0;
  if (beyond > 0) run.reported = static_cast<double>(reported) / beyond;
}

void measure_time(const Scene& scene, Run& run) {
  World world({.gravity = scene.gravity, .threads = 1, .settings = run.settings});
  const std::vector<BodyId> ids = build_scene(scene, world);
  double seconds = 0;
  for (int step = 0; step < scene.steps; ++step) {
    apply_forces(scene, world, ids);
    const double begin = cpu_seconds();
    world.step(scene.dt);
    seconds += cpu_seconds() - begin;
  }
  run.seconds.push_back(1e3 * seconds / scene.steps);
}

void print(const char* name, const Scene& scene, const Run& run, double target) {
  std::printf("  %-14s %8.3f ms/step  rest %8.4f mm  within %5.1f%%", name, percentile(run.seconds, 0.5),
              1e3 * run.rest, 100 * run.share_within(target));
  if (run.settings.target.is_set()) {
    std::printf("  reported %5.1f%%  substeps %5.1f  last change at %.1f s", 100 * run.reported,
                run.substeps / static_cast<double>(scene.bodies.size()), run.last_change * scene.dt);
  }
  std::printf("%s\n", run.rest <= target ? "" : "  (not held)");
}

// A hard scene surrounded by many boxes that are easy to solve.
Scene among_boxes(const char* name, const char* hard, ContactSolver solver) {
  Scene scene = load_scene(hard);
  scene.name = name;
  scene.steps = 300;
  scene.settings.contact_solver = solver;
  for (int i = 0; i < 1000; ++i) {
    BodyDef box;
    box.shape = Box{{0.5, 0.5, 0.5}};
    box.position = {40.0 + 1.5 * (i % 32), 1.5 * (i / 32), 0.5};
    scene.bodies.push_back({.def = box});
  }
  return scene;
}

Scene scene_of(const std::string& name) {
  if (name == "tower_among_boxes") return among_boxes("tower_among_boxes", "stack:height=100", ContactSolver::Auto);
  if (name == "swept_tower_among_boxes") {
    return among_boxes("swept_tower_among_boxes", "stack:height=100", ContactSolver::Iterative);
  }
  if (name == "wall_among_boxes") return among_boxes("wall_among_boxes", "wall:base=20", ContactSolver::Auto);
  return load_scene(name);
}

void compare(const Scene& scene) {
  std::printf("%s: %zu bodies, %d steps\n", scene.name.c_str(), scene.bodies.size(), scene.steps);
  std::vector<Run> fixed;
  for (const int substeps : {1, 2, 4, 8, 16, 32, 64, 128}) {
    Run run{.settings = scene.settings};
    run.settings.substeps = substeps;
    measure_errors(scene, targets[0], run);
    fixed.push_back(run);
    if (run.rest <= targets[2]) break;
  }
  for (const double target : targets) {
    Run held{.settings = scene.settings};
    held.settings.target.penetration = held.settings.target.joint_gap = target;
    measure_errors(scene, target, held);
    // Up to three candidates for the cheapest run, from those that meet the target in motion too if there are any, else
    // from all that meet it at rest.
    std::vector<Run> candidates;
    for (const double share : {enough, 0.0}) {
      for (const Run& run : fixed) {
        if (candidates.size() < 3 && run.rest <= target && run.share_within(target) >= share) candidates.push_back(run);
      }
      if (!candidates.empty()) break;
    }
    for (int round = 0; round < rounds; ++round) {
      measure_time(scene, held);
      for (Run& run : candidates) measure_time(scene, run);
    }
    std::printf(" %g mm\n", 1e3 * target);
    const auto time = [](const Run& run) { return percentile(run.seconds, 0.5); };
    const auto best = std::min_element(candidates.begin(), candidates.end(),
                                       [&](const Run& a, const Run& b) { return time(a) < time(b); });
    if (best == candidates.end()) {
      std::printf("  no fixed number up to 128 holds it at rest\n");
    } else {
      print(("fixed " + std::to_string(best->settings.substeps)).c_str(), scene, *best, target);
    }
    print("target", scene, held, target);
    if (best != candidates.end()) std::printf("  time ratio %.2f\n", time(held) / time(*best));
    std::fflush(stdout);
  }
}

}  // namespace

int main(int count, char** words) {
  std::vector<std::string> names(words + 1, words + count);
  if (names.empty()) {
    for (const BuiltinScene& scene : builtin_scenes()) {
      if (load_scene(scene.name).closed_form) names.push_back(scene.name);
    }
    for (const char* name : {"pyramid3d@300", "wall@300", "islands@200", "pile:bodies=2000@500", "hopper@300",
                             "rocks:bodies=2000@500", "joint-grid@300", "chain@300", "ragdolls@400",
                             "tower_among_boxes", "swept_tower_among_boxes", "wall_among_boxes"}) {
      names.emplace_back(name);
    }
  }
  for (const std::string& name : names) {
    const std::size_t at = name.find('@');
    Scene scene = scene_of(name.substr(0, at));
    if (at != std::string::npos) scene.steps = std::stoi(name.substr(at + 1));
    compare(scene);
  }
}
