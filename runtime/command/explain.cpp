#include "explain.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iomanip>
#include <iostream>
#include <nlohmann/json.hpp>

#include "failure.h"
#include "figures.h"
#include "interrupt.h"
#include "names.h"
#include "progress.h"
#include "standard_streams.h"

namespace atl::command {
namespace {

// A feature over the steps of a run.
struct FeatureTally {
  const char* name = "";
  const char* unit = "";
  const char* why_run = "";       // as the last step that ran it says
  const char* why_left_out = "";  // likewise
  std::int64_t steps = 0;         // that ran it
  std::int64_t items = 0;         // of these steps, in all
  std::int64_t max = 0;           // in one step

  void add(const FeatureReport& feature) {
    name = feature.name;
    unit = feature.unit;
    (feature.run ? why_run : why_left_out) = feature.why;
    if (!feature.run) return;
    ++steps;
    items += feature.items;
    max = std::max(max, feature.items);
  }
  double mean() const { return steps == 0 ? 0 : static_cast<double>(items) / static_cast<double>(steps); }
};

struct Explanation {
  std::array<FeatureTally, feature_count> features;
  std::vector<MemoryUse> memory;
  std::int64_t steps = 0;
};

Explanation explanation_of(const Scene& scene, World& world) {
  Explanation found;
  const std::vector<BodyId> ids = build_scene(scene, world);
  Progress progress(scene.steps);
  while (found.steps < scene.steps) {
    apply_forces(scene, world, ids);
    const StepReport report = world.step(scene.dt);
    for (std::size_t i = 0; i < feature_count; ++i) found.features[i].add(report.features[i]);
    progress.update(static_cast<int>(++found.steps));
    if (interrupted()) break;
  }
  found.memory = world.memory();
  return found;
}

std::string words_of(const char* name) {
  std::string words = name;
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

constexpr int feature_width = 24;

void write_feature(std::ostream& out, const std::string& name, const std::string& text) {
  out << "  " << std::left << std::setw(feature_width) << name << text << "\n";
}

std::string extent_words(const FeatureTally& feature) {
  return std::string(feature.unit) + " a step: " + significant(feature.mean(), 4) + ", " + std::to_string(feature.max) +
         " at most";
}

void write_text(std::ostream& out, const Scene& scene, const Explanation& found) {
  const BodyCounts bodies = body_counts(scene);
  out << scene.name << ": " << bodies.dynamic << " dynamic, " << bodies.fixed << " static, " << bodies.kinematic
      << " kinematic bodies, " << (found.steps < scene.steps ? std::to_string(found.steps) + " of " : "")
      << plural(scene.steps, "step") << "\n";

  const auto section = [&](const char* title, const auto& belongs, const auto& text) {
    if (std::none_of(found.features.begin(), found.features.end(), belongs)) return;
    out << "\n" << title << "\n";
    for (const FeatureTally& feature : found.features) {
      if (belongs(feature)) write_feature(out, words_of(feature.name), text(feature));
    }
  };
  section(
      "needed in every step", [&](const FeatureTally& feature) { return feature.steps == found.steps; },
      [](const FeatureTally& feature) { return feature.why_run + std::string(" (") + extent_words(feature) + ")"; });
  section(
      "needed in some steps",
      [&](const FeatureTally& feature) { return feature.steps > 0 && feature.steps < found.steps; },
      [](const FeatureTally& feature) {
        return "in " + plural(feature.steps, "step") + ": " + feature.why_run + " (" + extent_words(feature) +
               "); else " + feature.why_left_out;
      });
  section(
      "left out", [](const FeatureTally& feature) { return feature.steps == 0; },
      [](const FeatureTally& feature) { return std::string(feature.why_left_out); });

  out << "\nmemory" << std::string(feature_width - 4, ' ') << std::right << std::setw(12) << "bytes"
      << "    for each\n";
  std::size_t all = 0;
  for (const MemoryUse& use : found.memory) {
    all += use.bytes;
    out << "  " << std::left << std::setw(feature_width) << words_of(use.name) << std::right << std::setw(12)
        << use.bytes;
    if (use.bytes > 0 && use.count > 0) {
      out << "    " << significant(static_cast<double>(use.bytes) / static_cast<double>(use.count), 4) << " of "
          << use.count << " " << use.unit;
    }
    out << "\n";
  }
  out << "  " << std::left << std::setw(feature_width) << "in all" << std::right << std::setw(12) << all << "\n";
}

void write_json(std::ostream& out, const Scene& scene, const Explanation& found) {
  using Json = nlohmann::ordered_json;
  Json features = Json::array(), memory = Json::array();
  for (const FeatureTally& feature : found.features) {
    features.push_back({{"name", feature.name},
                        {"steps", feature.steps},
                        {"items_mean", feature.mean()},
                        {"items_max", feature.max},
                        {"unit", feature.unit},
                        {"why_run", feature.why_run},
                        {"why_left_out", feature.why_left_out}});
  }
  for (const MemoryUse& use : found.memory) {
    memory.push_back({{"name", use.name}, {"bytes", use.bytes}, {"count", use.count}, {"unit", use.unit}});
  }
  const Json object = {{"scene", scene.name}, {"steps", found.steps}, {"features", features}, {"memory", memory}};
  out << object.dump(2, ' ', false, Json::error_handler_t::replace) << "\n";
}

}  // namespace

void add_explain_options(CLI::App& command, ExplainOptions& options) {
  command.footer(
      "Examples:\n"
      "  atoll explain hopper");
  add_scene_options(command, options.scene)->required();
  add_machine_options(command, options.threads, options.simd);
  add_format_option(command, options.format);
}

void explain(const ExplainOptions& options) {
  Scene scene = load(options.scene);
  scene.settings.simd = options.simd;
  Explanation found;
  try {
    World world({.gravity = scene.gravity, .threads = options.threads, .settings = scene.settings});
    found = explanation_of(scene, world);
  } catch (const Error& error) {
    throw Failure(Status::BadScene, error.what());
  }
  if (options.format == Format::Json) {
    write_json(std::cout, scene, found);
  } else {
    write_text(std::cout, scene, found);
  }
  finish_output();
  if (found.steps < scene.steps) {
    throw interruption(scene.name, found.steps, scene.steps);
  }
}

}  // namespace atl::command
