/// A profile of the step: ns per manifold point and step, for each phase and, within solve_islands, for each phase of
/// the contact solver. Prints a Markdown table with one column a scene.

#include <atoll/atoll.h>
#include <collision/contacts/contact.h>
#include <solver/sweep/contact_block.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <map>
#include <string>
#include <vector>

namespace {

// Medians over the steps, ns per point.
struct Column {
  std::string scene;
  std::vector<double> phases = {};
  std::vector<double> solver_phases = {};
  double points = 0;
};

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Column measure(const std::string& name, const atl::Settings& settings, int threads, int warm_up, int steps) {
  const atl::Scene scene = atl::load_scene(name);
  atl::Settings profiled = settings;
  profiled.profile = true;
  atl::World world({.gravity = scene.gravity, .threads = threads, .settings = profiled});
  atl::build_scene(scene, world);
  for (int i = 0; i < warm_up; ++i) world.step(scene.dt);

  std::vector<std::vector<double>> phases(atl::phase_count), solver_phases(atl::solver_phase_count);
  std::vector<double> points;
  for (int i = 0; i < steps; ++i) {
    const atl::StepReport report = world.step(scene.dt);
    const double per_point = 1e6 / std::max<double>(1, static_cast<double>(report.counts.points));
    for (std::size_t k = 0; k < phases.size(); ++k) phases[k].push_back(per_point * report.phase_ms[k]);
    for (std::size_t k = 0; k < solver_phases.size(); ++k) solver_phases[k].push_back(per_point * report.solver_ms[k]);
    points.push_back(static_cast<double>(report.counts.points));
  }
  Column column{.scene = name, .points = median(points)};
  for (const auto& samples : phases) column.phases.push_back(median(samples));
  for (const auto& samples : solver_phases) column.solver_phases.push_back(median(samples));
  return column;
}

void print(const std::vector<Column>& columns) {
  const auto row = [&](const std::string& title, const char* format, const auto& value_of) {
    std::printf("| %s |", title.c_str());
    for (const Column& column : columns) {
      std::printf(" ");
      std::printf(format, value_of(column));
      std::printf(" |");
    }
    std::printf("\n");
  };
  std::printf("| ns per point and step |");
  for (const Column& column : columns) std::printf(" %s |", column.scene.c_str());
  std::printf("\n|---|");
  for (std::size_t i = 0; i < columns.size(); ++i) std::printf("--:|");
  std::printf("\n");
  for (std::size_t k = 0; k < atl::phase_count; ++k) {
    const auto phase = static_cast<atl::Phase>(k);
    row(atl::phase_name(phase), "%.1f", [&](const Column& column) { return column.phases[k]; });
    if (phase != atl::Phase::SolveIslands) continue;
    for (std::size_t s = 0; s < atl::solver_phase_count; ++s) {
      row(std::string("- ") + atl::solver_phase_name(static_cast<atl::SolverPhase>(s)), "%.1f",
          [&](const Column& column) { return column.solver_phases[s]; });
    }
  }
  row("points", "%.0f", [](const Column& column) { return column.points; });

  using atl::solver::block_lanes;
  std::printf("\nBytes a contact: %zu while it is solved, %zu kept as manifold, %zu kept as features.\n",
              sizeof(atl::solver::ContactBlock) / block_lanes, sizeof(atl::collision::ContactManifold),
              sizeof(atl::collision::Contact));
}

}  // namespace

int main(int argc, char** argv) try {
  std::vector<std::string> scenes = {"pyramid3d", "wall", "islands", "pile"};
  atl::Settings settings;
  const std::map<std::string, atl::Simd> sets = {{"auto", atl::Simd::Auto},
                                                 {"portable", atl::Simd::Portable},
                                                 {"sse4", atl::Simd::Sse4},
                                                 {"avx2", atl::Simd::Avx2},
                                                 {"avx512", atl::Simd::Avx512}};
  int threads = 1, warm_up = 100, steps = 100;
  CLI::App app("ns per contact point and step, by phase of the step and phase of the solver");
  app.add_option("SCENE", scenes, "scenes, as for atoll run");
  app.add_option("--substeps", settings.substeps)->check(CLI::Range(1, 1024))->capture_default_str();
  app.add_option("--threads", threads)->check(CLI::Range(1, 1024))->capture_default_str();
  app.add_option("--simd", settings.simd)->transform(CLI::CheckedTransformer(sets));
  app.add_option("--warm-up", warm_up, "steps before")->check(CLI::Range(0, 1000000))->capture_default_str();
  app.add_option("--steps", steps, "steps of which medians are taken")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);

  std::vector<Column> columns;
  for (const std::string& scene : scenes) columns.push_back(measure(scene, settings, threads, warm_up, steps));
  print(columns);
} catch (const std::exception& error) {
  std::fprintf(stderr, "atoll_phase_table: %s\n", error.what());
  return 2;
}
