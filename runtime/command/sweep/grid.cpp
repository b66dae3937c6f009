#include "grid.h"

#include <algorithm>
#include <cmath>

#include "../figures.h"

namespace atl::command {
namespace {

using Values = std::vector<std::string>;

// What an axis is swept over where no option says so.
Values default_values(const Axis& axis, bool large, bool quick) {
  const std::string_view name = axis.name;
  if (name == "substeps") {
    if (quick) return {"1", "4", "16"};
    return large ? Values{"2", "4", "8", "16"} : Values{"1", "2", "4", "8", "16", "32"};
  }
  if (name == "iterations") {
    if (quick) return {"1", "4"};
    return large ? Values{"1", "2", "4"} : Values{"1", "2", "4", "8", "16"};
  }
  if (quick && large) return {};
  if (name == "dt") return large ? Values{"1/30", "1/60", "1/120"} : Values{"1/30", "1/60", "1/120", "1/240"};
  if (name == "friction") return {"cone", "pyramid"};
  if (name == "warm_start") return {"on", "off"};
  if (name == "relax_iterations") return {"0", "1", "2"};
  if (name == "stabilisation") return {"soft", "baumgarte", "split_impulse"};
  if (name == "tolerance") return quick ? Values{"0.001"} : Values{"0.01", "0.001", "0.0001"};
  if (name == "threads") return {"1", "2"};
  if (name == "simd") return available_simds();
  return {};
}

class Grid {
 public:
  explicit Grid(const Configuration& scenes_own) : scenes_own_(scenes_own), all_{scenes_own} {}

  void add(const Configuration& configuration) {
    const auto same = [&](const Configuration& other) { return same_place(configuration, other); };
    if (std::none_of(all_.begin(), all_.end(), same)) all_.push_back(configuration);
  }

  void add_plane(const Axis& first, const Values& first_values, const Axis& second, const Values& second_values,
                 const auto& keep) {
    for (const std::string& a : first_values) {
      for (const std::string& b : second_values) {
        Configuration configuration = scenes_own_;
        first.apply(a, configuration);
        second.apply(b, configuration);
        if (keep(configuration)) add(configuration);
      }
    }
  }

  void add_line(const Axis& axis, const Values& values, const Configuration& through) {
    for (const std::string& value : values) {
      Configuration configuration = through;
      axis.apply(value, configuration);
      add(configuration);
    }
  }

  std::vector<Configuration> take() { return std::move(all_); }

 private:
  Configuration scenes_own_;
  std::vector<Configuration> all_;
};

// With the most iterations of a list.
Configuration with_most(const Axis& iterations, const Values& values, const Configuration& scenes_own) {
  Configuration most = scenes_own;
  for (const std::string& value : values) {
    Configuration other = scenes_own;
    iterations.apply(value, other);
    if (other.settings.iterations > most.settings.iterations) most = other;
  }
  return most;
}

std::vector<Configuration> configurations(const Scene& scene, bool large, const SweepOptions& options) {
  const auto values = [&](const Axis& axis) {
    const auto given = options.lists.find(axis.name);
    return given != options.lists.end() ? given->second : default_values(axis, large, options.quick);
  };
  const Axis& substeps = find_axis("substeps");
  const Axis& iterations = find_axis("iterations");
  // Iterations on top of many substeps cost large scenes much and say little.
  const bool thin = large && !options.lists.contains("substeps") && !options.lists.contains("iterations");
  const int most_sweeps = options.quick ? 16 : 32;
  const Configuration scenes_own = {.settings = scene.settings, .dt = scene.dt, .threads = 1};
  const Axis& tolerance = find_axis("tolerance");
  const Configuration most_iterations = with_most(iterations, values(iterations), scenes_own);
  Grid grid(scenes_own);
  grid.add_plane(substeps, values(substeps), iterations, values(iterations), [&](const Configuration& c) {
    return !thin || c.settings.iterations == 1 || c.settings.substeps * c.settings.iterations <= most_sweeps;
  });
  for (const Axis& axis : axes()) {
    if (axis.name == substeps.name || axis.name == iterations.name) continue;
    // A tolerance can spare sweeps only where there are several.
    grid.add_line(axis, values(axis), axis.name == tolerance.name ? most_iterations : scenes_own);
  }
  return grid.take();
}

int steps_of_large(std::size_t bodies, int scenes_own, bool quick) {
  const double most_body_steps = quick ? 1e5 : 4e5;
  constexpr int least = 10;
  return std::min(scenes_own, std::max(least, static_cast<int>(most_body_steps / static_cast<double>(bodies))));
}

}  // namespace

int ScenePlan::steps(const Configuration& configuration) const {
  return std::max(1, static_cast<int>(std::lround(simulated_time() / configuration.dt)));
}

ScenePlan plan_scene(const std::string& address, const SweepOptions& options) {
  ScenePlan plan = {.address = address, .scene = load_scene(address, options.seed)};
  Scene& scene = plan.scene;
  const auto bodies = static_cast<std::size_t>(body_counts(scene).dynamic);
  plan.scene_steps = scene.steps;
  plan.large = bodies > most_bodies_of_small;
  if (options.steps) {
    scene.steps = *options.steps;
  } else if (plan.large) {
    scene.steps = steps_of_large(bodies, scene.steps, options.quick);
  }
  plan.configurations = configurations(scene, plan.large, options);
  return plan;
}

}  // namespace atl::command
