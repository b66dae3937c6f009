#include <algorithm>
#include <iomanip>
#include <numeric>
#include <ostream>

#include "checks/tradeoff/target_text.h"
#include "figures.h"
#include "interrupt.h"
#include "measure_words.h"
#include "names.h"
#include "report.h"
#include "state/hex.h"

namespace atl::command {
namespace {

constexpr int name_width = 26;
constexpr int number_width = 12;
constexpr int share_width = 9;

void write_name(std::ostream& out, const char* name) { out << "  " << std::left << std::setw(name_width) << name; }

void write_number(std::ostream& out, const std::string& number) {
  out << std::right << std::setw(number_width) << number;
}

std::string stabilisation_words(const Settings& s) {
  const std::string name = std::string("stabilisation ") + name_of(s.stabilisation);
  return s.stabilisation == Stabilisation::Soft ? name : name + " of " + significant(s.correction, 4) + " a substep";
}

// "300 steps", or "120 of 300 steps".
std::string steps_words(const Scene& scene, const RunResult& result) {
  return (result.interrupted ? std::to_string(result.steps) + " of " : "") + plural(scene.steps, "step");
}

void write_head(std::ostream& out, const Scene& scene, const World& world, const RunResult& result) {
  const BodyCounts bodies = body_counts(scene);
  const Settings& s = scene.settings;
  out << "scene     " << scene.name << "\n"
      << "bodies    " << bodies.dynamic << " dynamic, " << bodies.fixed << " static, " << bodies.kinematic
      << " kinematic\n"
      << "run       " << steps_words(scene, result) << " of " << significant(1000 * scene.dt, 4) << " ms, "
      << significant(result.steps * scene.dt, 4) << " s in all; " << plural(world.threads(), "thread") << ", "
      << name_of(world.simd()) << "\n"
      << (result.interrupted ? std::string("ended     by ") + interrupt_name() + ", ahead of its last step\n" : "")
      << "settings  " << (s.target.is_set() ? "substeps by target" : plural(s.substeps, "substep")) << ", "
      << plural(s.iterations, "iteration") << ", " << s.relax_iterations << " to relax, friction "
      << name_of(s.friction) << ", warm starting " << (s.warm_starting ? "on" : "off") << ", sleeping "
      << (s.sleeping ? "on" : "off") << ",\n          " << stabilisation_words(s)
      << (s.tolerance > 0 ? ", tolerance " + significant(s.tolerance, 4) + " m/s" : "")
      << (s.contact_solver == ContactSolver::Auto ? "" : std::string(", contacts ") + name_of(s.contact_solver))
      << (scene.joints.empty() ? "" : std::string(", joints ") + name_of(s.joint_solver)) << "\n";
  if (s.target.is_set()) {
    out << "target    " << tradeoff::target_words(s.target) << ", with " << s.target.min_substeps << " to "
        << s.target.max_substeps << " substeps an island\n";
  }
}

void write_times(std::ostream& out, const RunResult& result) {
  const StepTimes& times = result.step_times;
  out << "\n" << std::left << std::setw(name_width + 2) << "time a step, mean of the run";
  write_number(out, "ms");
  out << std::setw(share_width) << "%"
      << "\n";
  for (int i = 0; i < phase_count; ++i) {
    write_name(out, phase_name(static_cast<Phase>(i)));
    write_number(out, fixed(result.phase_ms[i], 4));
    out << std::setw(share_width) << fixed(times.mean > 0 ? 100 * result.phase_ms[i] / times.mean : 0, 1) << "\n";
  }
  write_name(out, "step");
  write_number(out, fixed(times.mean, 4));
  out << "    median " << fixed(times.median, 4) << ", p99 " << fixed(times.p99, 4) << ", max " << fixed(times.max, 4)
      << " in step " << times.longest << "\n";
}

// The features that go over all points once or more a substep.
bool sweeps_points(SolverPhase phase) { return phase == SolverPhase::Solve || phase == SolverPhase::Relax; }

void write_solver_times(std::ostream& out, const Scene& scene, const RunResult& result) {
  const double all = std::accumulate(result.solver_ms.begin(), result.solver_ms.end(), 0.0);
  // With a target each island has its own.
  const double substeps =
      scene.settings.target.is_set() ? result.target.mean_substeps() : static_cast<double>(scene.settings.substeps);
  const double points = result.points * substeps;
  out << "\n" << std::left << std::setw(name_width + 2) << "solver, all groups";
  write_number(out, "ms");
  out << std::setw(share_width) << "%"
      << "    ns a point and substep\n";
  for (std::size_t i = 0; i < solver_phase_count; ++i) {
    const auto phase = static_cast<SolverPhase>(i);
    write_name(out, solver_phase_name(phase));
    write_number(out, fixed(result.solver_ms[i], 4));
    out << std::setw(share_width) << fixed(all > 0 ? 100 * result.solver_ms[i] / all : 0, 1);
    if (sweeps_points(phase) && points > 0) out << "    " << fixed(1e6 * result.solver_ms[i] / points, 1);
    out << "\n";
  }
}

void write_counts(std::ostream& out, const StepCounts& counts) {
  constexpr int columns = 3, column_width = 17, value_width = 10;
  out << "\ncounts of the last step\n";
  int column = 0;
  for (const Count& count : named_counts(counts)) {
    out << "  " << std::left << std::setw(column_width) << count.name << std::right << std::setw(value_width)
        << count.value;
    column = (column + 1) % columns;
    out << (column == 0 ? "\n" : "  ");
  }
}

void write_features(std::ostream& out, const std::array<FeatureReport, feature_count>& features) {
  out << "\nfeatures of the last step\n";
  for (const FeatureReport& feature : features) {
    write_name(out, feature.name);
    out << (feature.run ? "run      " : "skipped  ") << feature.why;
    if (feature.run) out << " (" << feature.items << " " << feature.unit << ")";
    out << "\n";
  }
}

void write_solver_choices(std::ostream& out, const Scene& scene, const RunResult& result) {
  if (result.solver_choices.empty()) return;
  constexpr std::size_t max = 10;
  out << "\nislands that sweeps can't hold up, in the last step\n";
  for (std::size_t i = 0; i < std::min(max, result.solver_choices.size()); ++i) {
    const SolverChoice& island = result.solver_choices[i].island;
    out << "  of " << body_words(scene, result.solver_choices[i].body) << ", "
        << plural(static_cast<std::int64_t>(island.bodies), "dynamic body", "dynamic bodies") << ", "
        << plural(static_cast<std::int64_t>(island.contacts), "contact") << ": " << island.why << "; "
        << (island.direct          ? "solved at once"
            : *island.why_not != 0 ? "swept"
                                   : "solved in finer substeps");
    if (*island.why_not != 0) out << ", not at once: " << island.why_not;
    if (scene.settings.profile) out << ", " << fixed(island.ms, 4) << " ms";
    out << "\n";
  }
  if (result.solver_choices.size() > max) out << "  and " << result.solver_choices.size() - max << " more\n";
}

// In mm and mm/s, which targets are about.
std::string target_value(double value, TargetError error) {
  const std::string unit = unit_of(error);
  return unit.empty() ? significant(value, 3) : significant(1000 * value, 3) + " m" + unit;
}

std::string words_of(TargetError error) { return error == TargetError::JointGap ? "joint gap" : name_of(error); }

void write_target(std::ostream& out, const Scene& scene, const RunResult& result) {
  const ErrorTarget& target = scene.settings.target;
  if (!target.is_set()) return;
  constexpr std::size_t max = 5;
  const TargetTally& tally = result.target;
  out << "\nsubsteps for the target\n  a body of an island got " << significant(tally.mean_substeps(), 3)
      << " a step in the mean, and " << tally.max_substeps << " at most;\n  "
      << (tally.missed_steps == 0
              ? "all islands were held in all steps"
              : plural(tally.missed_steps, "step") + " of " + std::to_string(result.steps) +
                    " ended with an island not held, " + std::to_string(tally.missed_targets) + " islands in all")
      << "\n";
  if (!result.missed_targets.empty()) out << "  not held in the last step\n";
  for (std::size_t i = 0; i < std::min(max, result.missed_targets.size()); ++i) {
    const MissedTarget& island = result.missed_targets[i].island;
    out << "    of " << body_words(scene, result.missed_targets[i].body) << ", "
        << plural(static_cast<std::int64_t>(island.bodies), "dynamic body", "dynamic bodies") << ", "
        << plural(static_cast<std::int64_t>(island.contacts), "contact") << ", "
        << plural(static_cast<std::int64_t>(island.joints), "joint") << ": " << words_of(island.error) << " "
        << target_value(island.measured, island.error) << ", target "
        << target_value(limit_of(target, island.error), island.error) << ", in " << plural(island.substeps, "substep")
        << ": " << island.why << "\n";
  }
  if (result.missed_targets.size() > max) out << "    and " << result.missed_targets.size() - max << " more\n";
}

void write_errors(std::ostream& out, const Scene& scene, const RunResult& result) {
  constexpr int unit_width = 5;
  out << "\nerrors\n";
  for (const ErrorMeasure& error : result.errors) {
    write_name(out, error.name.c_str());
    write_number(out, significant(error.value, 4));
    const std::string words = describe_measure(error.name, scene);
    if (!error.unit.empty() || !words.empty()) out << " ";
    if (words.empty()) {
      out << error.unit << "\n";
    } else {
      out << std::left << std::setw(unit_width) << error.unit << words << "\n";
    }
  }
}

// Writes the result of a run in a sentence.
void write_summary(std::ostream& out, const Scene& scene, const RunResult& result) {
  const double simulated = result.steps * scene.dt;
  const double wall = 1e-3 * result.step_times.mean * result.steps;
  out << "\n"
      << plural(body_counts(scene).dynamic, "body", "bodies") << " moved for " << significant(simulated, 3)
      << " s of simulated time in " << significant(wall, 3) << " s";
  if (wall > 0) {
    out << ": " << plain(result.steps / wall, 3) << " steps/s, " << plain(simulated / wall, 3) << " times real time";
  }
  out << "\n";
}

void write_next(std::ostream& out, const Scene& scene) {
  out << "next\n";
  if (!scene.settings.profile)
    out << "  atoll run ... --profile     what the solver does, all counts, which features ran and why\n";
  if (!scene.settings.keep_contact_problem)
    out << "  atoll run ... --errors      errors over all steps, not only as it ends\n";
  out << "  atoll sweep ... --out DIR   error against run time over many settings, as a page\n";
}

void write_lost(std::ostream& out, const Scene& scene, const RunResult& result) {
  if (result.lost.empty()) return;
  out << "\nbodies lost\n";
  for (const LostBody& lost : result.lost) out << "  " << lost_words(scene, lost) << "\n";
}

}  // namespace

void write_text(std::ostream& out, const Scene& scene, const World& world, const RunResult& result) {
  write_head(out, scene, world, result);
  if (scene.settings.profile) {
    write_counts(out, result.last.counts);
    write_features(out, result.last.features);
    write_solver_times(out, scene, result);
  }
  write_solver_choices(out, scene, result);
  write_target(out, scene, result);
  write_times(out, result);
  write_errors(out, scene, result);
  write_lost(out, scene, result);
  write_summary(out, scene, result);
  write_next(out, scene);
  out << "\nhash      " << hash_text(result.hash) << "\n";
}

}  // namespace atl::command
