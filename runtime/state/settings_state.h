#pragma once
/// Settings for archives (state_archive.h): all that shape the result. The instruction set, a profile, what is kept for
/// diagnosis and whether anything is left out do not, and stay what they are.

#include <atoll/settings.h>

#include "state/joint_state.h"

namespace atl {

template <typename Archive, typename AnyTarget>
void visit_target(Archive& archive, AnyTarget& target) {
  if (Archive::hashes && !target.is_set()) return;
  visit_all(archive, target.penetration, target.joint_gap, target.residual, target.motion, target.min_substeps,
            target.max_substeps);
}

template <typename Archive, typename AnySettings>
void visit_settings(Archive& archive, AnySettings& s) {
  visit_all(archive, s.substeps, s.iterations, s.relax_iterations, s.tolerance, s.friction);
  archive.check(s.friction == FrictionModel::Cone || s.friction == FrictionModel::Pyramid, "no model of friction");
  visit_all(archive, s.warm_starting, s.stabilisation, s.correction, s.slop);
  const auto optional = [&archive](auto& number) {
    if constexpr (Archive::hashes) {
      archive.value(number.value_or(0));
      if (number == 0.0) archive.value(true);  // not as if it were left out
    } else {
      visit_value(archive, number);
    }
  };
  optional(s.contact_hertz);
  visit_all(archive, s.contact_damping_ratio, s.contact_push_speed);
  optional(s.restitution_threshold);
  visit_all(archive, s.contact_solver, s.joint_solver);
  optional(s.joint_hertz);
  visit_all(archive, s.joint_damping_ratio, s.sleeping, s.sleep_speed, s.time_to_sleep, s.contact_events);
  if (!Archive::hashes || s.contact_event_force) optional(s.contact_event_force);
  visit_target(archive, s.target);
}

}  // namespace atl
