#include "checks/tradeoff/record.h"

#include <algorithm>
#include <cmath>

#include "checks/tradeoff/number_text.h"

namespace atl::tradeoff {

const char* name_of(Outcome outcome) {
  switch (outcome) {
    case Outcome::Done:
      return "done";
    case Outcome::Fell:
      return "fell";
    case Outcome::CameApart:
      return "came_apart";
    case Outcome::NonFinite:
      return "non_finite";
    case Outcome::Refused:
      return "refused";
    case Outcome::TooSlow:
      return "too_slow";
    case Outcome::Skipped:
      return "skipped";
    case Outcome::Failed:
      break;
  }
  return "failed";
}

double Samples::median() const {
  std::vector<double> sorted = values_;
  std::sort(sorted.begin(), sorted.end());
  const std::size_t n = sorted.size();
  return (sorted.at((n - 1) / 2) + sorted.at(n / 2)) / 2;
}

double Samples::min() const { return *std::min_element(values_.begin(), values_.end()); }
double Samples::max() const { return *std::max_element(values_.begin(), values_.end()); }

void Record::judge_joints() {
  const std::optional<double> gap = error("joint_gap_run_max");
  if (outcome != Outcome::Done || !gap || *gap <= max_joint_gap) return;
  outcome = Outcome::CameApart;
  why = "came apart: a joint opened by " + fixed(*gap, 1) + " m";
}

std::optional<double> Record::error(const std::string& name) const {
  for (const ErrorMeasure& measure : errors) {
    if (measure.name == name) return std::abs(measure.value);
  }
  return std::nullopt;
}

}  // namespace atl::tradeoff
