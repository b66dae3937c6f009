// Reports of a step.

#include <atoll/report.h>
#include <atoll/world.h>

#include <string>

#include "fields.h"
#include "parts.h"

namespace atl::python {
namespace {

void bind_counts(nb::module_& module) {
  nb::class_<StepCounts> counts(module, "StepCounts", "How many of what a step had to do with.");
  bind_result(counts, Field{"active_bodies", &StepCounts::active_bodies, "awake, or kinematic with a velocity"},
              Field{"active_contacts", &StepCounts::active_contacts, "of pairs with one of these"},
              Field{"aabb_updates", &StepCounts::aabb_updates, "of shapes that leave their fat bounds"},
              Field{"pairs", &StepCounts::pairs, "of bodies whose fat bounds overlap"},
              Field{"filtered_pairs", &StepCounts::filtered_pairs, "of which a contact filter was asked"},
              Field{"asked_contacts", &StepCounts::asked_contacts, "of which a contact modifier was asked"},
              Field{"contacts", &StepCounts::contacts, "pairs with at least one manifold point"},
              Field{"points", &StepCounts::points, "of these"}, Field{"joints", &StepCounts::joints, "on awake bodies"},
              Field{"direct_joints", &StepCounts::direct_joints, "of these, solved directly"},
              Field{"direct_islands", &StepCounts::direct_islands, "whose contacts are solved at once"},
              Field{"unsolved_islands", &StepCounts::unsolved_islands, "which that was tried for in vain"},
              Field{"refused_islands", &StepCounts::refused_islands, "which that was due for, and not tried"},
              Field{"missed_targets", &StepCounts::missed_targets, "with an error beyond its target"},
              Field{"body_substeps", &StepCounts::body_substeps, "with a target: substeps of islands, times bodies"},
              Field{"island_bodies", &StepCounts::island_bodies, "with a target: bodies of these islands"},
              Field{"max_substeps", &StepCounts::max_substeps, "with a target: that an island got"},
              Field{"refined_islands", &StepCounts::refined_islands, "that get more substeps"},
              Field{"newton_iterations", &StepCounts::newton_iterations, "of what is solved at once"},
              Field{"discarded_iterations", &StepCounts::discarded_iterations, "of these, in vain"},
              Field{"islands", &StepCounts::islands, "awake, with a contact or joint"},
              Field{"groups", &StepCounts::groups, "of islands, each one task"},
              Field{"colours", &StepCounts::colours, "of the group with the most"},
              Field{"recycled_manifolds", &StepCounts::recycled_manifolds, "that kept their features"},
              Field{"recomputed_manifolds", &StepCounts::recomputed_manifolds, "that the narrowphase looked at"},
              Field{"fcl_calls", &StepCounts::fcl_calls, "of these, by FCL"},
              Field{"fcl_repairs", &StepCounts::fcl_repairs, "answers of FCL that were replaced"},
              Field{"id_matches", &StepCounts::id_matches, "points that inherited an impulse"},
              Field{"id_misses", &StepCounts::id_misses, "points that did not"},
              Field{"sweeps", &StepCounts::sweeps, "over groups, substeps together"},
              Field{"asleep", &StepCounts::asleep, "bodies"},
              Field{"swept", &StepCounts::swept, "bodies that continuous collision looked at"},
              Field{"stopped", &StepCounts::stopped, "bodies that met something and were put back"});
}

void bind_missed_targets(nb::module_& module) {
  nb::enum_<TargetError>(module, "TargetError", "What Settings.target sets a limit to.")
      .value("PENETRATION", TargetError::Penetration, "m")
      .value("JOINT_GAP", TargetError::JointGap, "m")
      .value("RESIDUAL", TargetError::Residual, "Relative.")
      .value("MOTION", TargetError::Motion, "m/s");
  nb::class_<MissedTarget> island(
      module, "MissedTarget",
      "An error of an island beyond its target. Penetrations and gaps are those with which the step began.");
  bind_result(island, Field{"lowest", &MissedTarget::lowest, "of its bodies"},
              Field{"bodies", &MissedTarget::bodies, "how many"},
              Field{"contacts", &MissedTarget::contacts, "how many"},
              Field{"joints", &MissedTarget::joints, "how many"}, Field{"error", &MissedTarget::error, ""},
              Field{"measured", &MissedTarget::measured, "in the target's unit"},
              Field{"substeps", &MissedTarget::substeps, "that it got in this step"},
              Field{"why", &MissedTarget::why, "what keeps it beyond"});
}

}  // namespace

void bind_reports(nb::module_& module) {
  bind_counts(module);
  bind_missed_targets(module);
  nb::class_<FeatureReport> feature(module, "FeatureReport", "A feature of the step plan: whether it ran, and why.");
  bind_result(feature, Field{"name", &FeatureReport::name, ""}, Field{"run", &FeatureReport::run, ""},
              Field{"why", &FeatureReport::why, "or why not"}, Field{"items", &FeatureReport::items, "it was run on"},
              Field{"unit", &FeatureReport::unit, "of these"}, Field{"ms", &FeatureReport::ms, ""});

  nb::class_<StepReport>(module, "StepReport", "What one step did, and how long it took.")
      .def_ro("ms", &StepReport::ms, "wall time of the whole step")
      .def_ro("counts", &StepReport::counts)
      .def_prop_ro(
          "phase_ms",
          [](const StepReport& self) {
            nb::dict phases;
            for (int i = 0; i < phase_count; ++i) {
              phases[phase_name(static_cast<Phase>(i))] = self.phase_ms[static_cast<std::size_t>(i)];
            }
            return phases;
          },
          "by the name of the phase, in order", nb::sig("def phase_ms(self) -> dict[str, float]"))
      .def_prop_ro(
          "solver_ms",
          [](const StepReport& self) {
            nb::dict phases;
            for (std::size_t i = 0; i < solver_phase_count; ++i) {
              phases[solver_phase_name(static_cast<SolverPhase>(i))] = self.solver_ms[i];
            }
            return phases;
          },
          "with Settings.profile: by phase of the contact solver", nb::sig("def solver_ms(self) -> dict[str, float]"))
      .def_prop_ro(
          "features",
          [](const StepReport& self) {
            nb::dict features;
            for (const FeatureReport& feature : self.features) features[feature.name] = feature;
            return features;
          },
          "by name, in order", nb::sig("def features(self) -> dict[str, FeatureReport]"))
      .def_ro("quarantined", &StepReport::quarantined, "bodies that this step took out of the world")
      .def_ro("first_quarantined", &StepReport::first_quarantined, "their lowest index, or -1")
      .def("__repr__", [](const StepReport& self) {
        return "<StepReport of " + std::to_string(self.ms) + " ms, " + std::to_string(self.counts.contacts) +
               " contacts, " + std::to_string(self.counts.islands) + " islands>";
      });
}

}  // namespace atl::python
