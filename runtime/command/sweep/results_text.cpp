#include <iomanip>
#include <ostream>
#include <sstream>

#include "results.h"

namespace atl::command {

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
}

}  // namespace atl::command
