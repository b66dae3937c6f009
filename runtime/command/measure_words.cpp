#include "measure_words.h"

#include <array>

namespace atl::command {
namespace {

struct Words {
  const char* name;
  const char* help;
};

constexpr std::array words = {
    Words{"joint_gap_run_mean", "how far what a joint locks together is apart, mean over the joints and all steps"},
    Words{"joint_gap_run_max", "how far what a joint locks together is apart, of any joint after any step"},
    Words{"joint_drift_max", "how far what a joint locks together is apart in the final state, at most"},
    Words{"joint_drift_rms", "the same, root of the mean square over the joints"},
    Words{"joint_angle_max", "angle between axes that a joint locks, in the final state, at most"},
    Words{"joint_excess_max",
          "how far an offset or a distance is beyond its joint's range in the final state, at most"},
    Words{"joint_angle_excess_max", "how far an angle is beyond its joint's range in the final state, at most"},
    Words{"penetration_max", "largest overlap of two shapes in the final state"},
    Words{"penetration_p99", "99th percentile of the overlaps in the final state"},
    Words{"penetration_mean", "mean overlap, over the pairs that overlap by more than 10 µm in the final state"},
    Words{"penetration_max_relative", "largest overlap over the smaller shape's bounding radius, in the final state"},
    Words{"sink_max", "how far a body ends below its ideal rest pose, at most"},
    Words{"sink_mean", "how far bodies end below their ideal rest poses, on average (its size, whatever the sign)"},
    Words{"drift_max", "how far a body ends beside its ideal rest pose, at most"},
    Words{"tilt_max", "by how much a body ends turned from its ideal rest pose, at most"},
    Words{"energy_drift",
          "change of mechanical energy over the run, relative to the start; an error only where impacts and friction "
          "take none"},
    Words{"momentum_drift", "change of linear momentum over the run, relative to the start"},
    Words{"contact_residual", "how far the impulses are from solving the last step's contact problem"},
    Words{"contact_residual_median",
          "how far the impulses are from solving the step's contact problem, median of the "
          "steps; told by Atoll alone"},
    Words{"contact_residual_max",
          "how far the impulses are from solving the step's contact problem, worst step; told "
          "by Atoll alone"},
};

}  // namespace

std::string describe_measure(const std::string& name, const Scene& scene) {
  if (name == "analytic_error" && scene.closed_form) return scene.closed_form->metric;
  for (const Words& entry : words) {
    if (entry.name == name) return entry.help;
  }
  return scene.closed_form ? "part of the comparison with the closed form" : "";
}

}  // namespace atl::command
