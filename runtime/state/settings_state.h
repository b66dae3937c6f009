#pragma once
/// Settings for archives (state_archive.h): all that shape the result. The instruction set, a profile, what is kept for
/// diagnosis and whether anything is left out do not, and stay what they are.

#include <atoll/settings.h>

#include "state/joint_state.h"

namespace atl {

template <typename Archive, typename AnyTarget>
void visit_target(Archive& archive, AnyTarget& target) {
  if (Archive::hashes && !target.is_set()) return;
  for (auto* error : {&target.penetration, &target.joint_gap, &target.residual, &target.motion}) {
    visit_optional(archive, *error, [&](auto& value) { archive.value(value); });
  }
  archive.value(target.min_substeps);
  archive.value(target.max_substeps);
}

template <typename Archive, typename AnySettings>
void visit_settings(Archive& archive, AnySettings& s) {
  archive.value(s.substeps);
  archive.value(s.iterations);
  archive.value(s.relax_iterations);
  archive.value(s.tolerance);
  archive.value(s.friction);
  archive.check(s.friction == FrictionModel::Cone || s.friction == FrictionModel::Pyramid, "no model of friction");
  archive.value(s.warm_starting);
  archive.value(s.stabilisation);
  archive.value(s.correction);
  archive.value(s.slop);
  const auto optional = [&archive](auto& number) {
    if constexpr (Archive::hashes) {
      archive.value(number.value_or(0));
      if (number == 0.0) archive.value(true);  // not as if it were left out
    } else {
      visit_optional(archive, number, [&](auto& value) { archive.value(value); });
    }
  };
  optional(s.contact_hertz);
  archive.value(s.contact_damping_ratio);
  archive.value(s.contact_push_speed);
  optional(s.restitution_threshold);
  archive.value(s.contact_solver);
  archive.value(s.joint_solver);
  optional(s.joint_hertz);
  archive.value(s.joint_damping_ratio);
  archive.value(s.sleeping);
  archive.value(s.sleep_speed);
  archive.value(s.time_to_sleep);
  archive.value(s.contact_events);
  if (!Archive::hashes || s.contact_event_force) optional(s.contact_event_force);
  visit_target(archive, s.target);
}

}  // namespace atl
