#include "checks/tradeoff/grid.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>
#include <utility>

#include "checks/tradeoff/setting_names.h"
#include "scene_traits.h"

namespace atl::tradeoff {
namespace {

using Values = std::vector<std::string>;

Configuration own_configuration(const Scene& scene) {
  return {.settings = scene.settings, .dt = scene.dt, .threads = 1};
}

// Traits of a scene that decide which axes are worth a sweep.
struct Traits {
  bool large = false;
  bool quick = false;
  bool joints = false;
  bool contacts = true;       // bodies may touch
  bool targets = true;        // the settings leave it to a target how far contacts and joints give
  bool sweeps = true;         // there are contacts, or joints that are solved one by one
  Values joint_solvers = {};  // that do different things, the scene's own first

  Traits(const Scene& scene, bool is_large, bool is_quick)
      : large(is_large), quick(is_quick), joints(!scene.joints.empty()), contacts(!nothing_touches(scene)) {
    const Settings& own_settings = scene.settings;
    targets = (contacts || joints) && own_settings.stabilisation == Stabilisation::Soft &&
              !own_settings.contact_hertz && !own_settings.joint_hertz;
    if (!joints) return;
    std::vector<std::int64_t> at_once;
    joint_solvers = different_joint_solvers(scene, &at_once);
    sweeps = contacts || at_once.front() < static_cast<std::int64_t>(scene.joints.size());
  }
};

bool is_of_contacts(std::string_view axis) {
  return axis == "friction" || axis == "stabilisation" || axis == "tolerance";
}

// True for axes that matter only to contacts, or joints, that are swept one by one.
bool is_of_sweeps(std::string_view axis) {
  return axis == "iterations" || axis == "warm_start" || axis == "relax_iterations";
}

// All but what a scene's own, auto, stands for.
Values other_simds() {
  Values others = available_simds();
  std::erase(others, name_of(World().simd()));
  return others;
}

// Default values of an axis when no option gives any; none if the axis stays as the scene has it.
Values default_values(const Axis& axis, const Traits& scene) {
  const std::string_view name = axis.name;
  const bool large = scene.large, quick = scene.quick;
  if (!scene.contacts && is_of_contacts(name)) return {};
  if (!scene.sweeps && is_of_sweeps(name)) return {};
  if (name == "substeps") {
    if (quick) return {"1", "4", "16"};
    return large ? Values{"2", "4", "8", "16"} : Values{"1", "2", "4", "8", "16", "32"};
  }
  if (name == "iterations") {
    if (quick || scene.joints) return {"1", "4"};
    return large ? Values{"1", "2", "4"} : Values{"1", "2", "4", "8", "16"};
  }
  if (name == "joint_solver") return scene.joint_solvers;
  if (quick && large) return {};
  if (name == "target") {
    if (!scene.targets) return {};
    return quick ? Values{"0.001"} : large ? Values{"0.01", "0.001"} : Values{"0.01", "0.001", "0.0001"};
  }
  if (name == "dt") return large ? Values{"1/30", "1/60", "1/120"} : Values{"1/30", "1/60", "1/120", "1/240"};
  if (name == "friction") return {"cone", "pyramid"};
  if (name == "warm_start") return {"on", "off"};
  if (name == "relax_iterations") return {"0", "1", "2"};
  if (name == "stabilisation") return {"soft", "baumgarte", "split_impulse"};
  if (name == "tolerance") return quick || large ? Values{"0.001"} : Values{"0.01", "0.001", "0.0001"};
  if (name == "threads") return {"1", "2"};
  if (name == "simd") return other_simds();
  return {};
}

void check(const GridOptions& options) {
  for (const auto& [name, values] : options.lists) {
    const Axis& axis = find_axis(name);
    for (const std::string& value : values) {
      if (!axis.accepts(value)) throw Error(name + ": found \"" + value + "\", expected " + axis.expected);
    }
  }
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
  Configuration max = scenes_own;
  for (const std::string& value : values) {
    Configuration other = scenes_own;
    iterations.apply(value, other);
    if (other.settings.iterations > max.settings.iterations) max = other;
  }
  return max;
}

std::vector<Configuration> configurations(const Scene& scene, bool large, const GridOptions& options) {
  const Traits traits(scene, large, options.quick);
  const Configuration scenes_own = own_configuration(scene);
  const auto values = [&](const Axis& axis) {
    const auto given = options.lists.find(axis.name);
    return given != options.lists.end() ? given->second : default_values(axis, traits);
  };
  const Axis& substeps = find_axis("substeps");
  const Axis& iterations = find_axis("iterations");
  // Iterations on top of many substeps cost large scenes much and say little.
  const bool thin = large && !options.lists.contains("substeps") && !options.lists.contains("iterations");
  constexpr int max_sweeps = 16;
  const Axis& tolerance = find_axis("tolerance");
  const Configuration max_iterations = with_most(iterations, values(iterations), scenes_own);
  Grid grid(scenes_own);
  if (values(iterations).empty()) grid.add_line(substeps, values(substeps), scenes_own);
  grid.add_plane(substeps, values(substeps), iterations, values(iterations), [&](const Configuration& c) {
    return !thin || c.settings.iterations == 1 || c.settings.substeps * c.settings.iterations <= max_sweeps;
  });
  // A direct solver of joints takes what substeps are there, and an iterative one needs them.
  const Axis& joint_solver = find_axis("joint_solver");
  if (!large) {
    grid.add_plane(joint_solver, values(joint_solver), substeps, values(substeps),
                   [&](const Configuration& c) { return c.settings.joint_solver != scenes_own.settings.joint_solver; });
  }
  for (const Axis& axis : axes()) {
    if (axis.name == substeps.name || axis.name == iterations.name) continue;
    // A tolerance can spare sweeps only where there are several.
    grid.add_line(axis, values(axis), axis.name == tolerance.name ? max_iterations : scenes_own);
  }
  return grid.take();
}

// The first step from `min` on after which the bodies have landed, at the scene's own settings; `min` if they never
// do.
int steps_until_landed(const Scene& scene, int min) {
  World world({.gravity = scene.gravity, .settings = scene.settings});
  const std::vector<BodyId> ids = build_scene(scene, world);
  for (int step = 1; step <= scene.steps; ++step) {
    apply_forces(scene, world, ids);
    world.step(scene.dt);
    if (step >= min && touching_share(scene, world, ids) >= landed_share) return step;
  }
  return min;
}

int steps_of_large(const ScenePlan& plan, std::size_t bodies, bool quick) {
  const Scene& scene = plan.scene;
  const double max_body_steps = quick ? 1e5 : 3e5;
  constexpr int min = 10;
  const int few = std::max(min, static_cast<int>(max_body_steps / static_cast<double>(bodies)));
  if (few >= scene.steps) return scene.steps;
  return plan.chaotic() && !nothing_touches(scene) ? steps_until_landed(scene, few) : few;
}

}  // namespace

int ScenePlan::steps(const Configuration& configuration) const {
  return std::max(1, static_cast<int>(std::lround(simulated_time() / configuration.dt)));
}

double touching_share(const Scene& scene, const World& world, const std::vector<BodyId>& ids) {
  std::unordered_set<BodyId> touching;
  for (const ContactForce& contact : world.contact_forces()) {
    if (contact.normal_force > 0) touching.insert({contact.a, contact.b});
  }
  std::int64_t dynamic = 0, touched = 0;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (scene.bodies[i].def.type != BodyType::Dynamic) continue;
    ++dynamic;
    touched += touching.contains(ids[i]);
  }
  return dynamic > 0 ? static_cast<double>(touched) / static_cast<double>(dynamic) : 1;
}

std::size_t dynamic_bodies(const Scene& scene) {
  const auto dynamic = [](const SceneBody& body) { return body.def.type == BodyType::Dynamic; };
  return static_cast<std::size_t>(std::count_if(scene.bodies.begin(), scene.bodies.end(), dynamic));
}

ScenePlan plan_scene(const std::string& address, const GridOptions& options) {
  ScenePlan plan = plan_scene(load_scene(address, options.seed), options);
  plan.address = address;
  return plan;
}

ScenePlan plan_scene(Scene planned, const GridOptions& options) {
  check(options);
  ScenePlan plan = {.scene = std::move(planned)};
  Scene& scene = plan.scene;
  const std::size_t bodies = dynamic_bodies(scene);
  plan.scene_steps = scene.steps;
  plan.large = bodies > max_bodies_of_small;
  if (options.steps) {
    scene.steps = *options.steps;
  } else if (plan.large) {
    scene.steps = steps_of_large(plan, bodies, options.quick);
  }
  plan.configurations = configurations(scene, plan.large, options);
  return plan;
}

}  // namespace atl::tradeoff
