#include <iomanip>
#include <ostream>
#include <sstream>

#include "results.h"

namespace atl::command {

using namespace tradeoff;

void write_results_text(std::ostream& out, const SweepResults& results) {
  out << std::setprecision(3);
  for (const SceneReport& report : results.scenes) {
    out << report.plan.scene.name << "\n";
    if (report.comparisons.empty() || report.records.empty()) {
      out << "  no errors were measured\n";
      continue;
    }
    const Comparison& comparison = report.comparisons.front();
    const Record& own = report.records.front();
    const std::string unit = unit_of(comparison.measure, report.records);
    if (const auto error = own.error(comparison.measure); error && own.outcome == Outcome::Done) {
      out << "  " << comparison.measure << " " << *error << (unit.empty() ? "" : " ") << unit;
      if (own.cpu.count() > 0) out << " at " << own.cpu.median() << " s of CPU time a simulated second";
      out << "\n";
    }
    out << "  " << comparison.verdict.text << "\n";
  }
  for (const Frontier& frontier : results.frontiers) {
    out << "the most " << frontier.ladder.name << "\n";
    for (const Reach& reach : frontier.reaches) {
      out << "  " << std::left << std::setw(8) << reach.engine << std::right << std::setw(3) << reach.substeps
          << (reach.substeps == 1 ? " substep   " : " substeps  ");
      if (reach.rung) {
        out << *reach.rung << ", " << reach.ms_per_step << " ms a step\n";
      } else {
        out << "less than " << frontier.ladder.rungs.front() << "\n";
      }
    }
  }
}

}  // namespace atl::command
