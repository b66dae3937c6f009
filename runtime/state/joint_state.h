#pragma once
/// A joint's definition, and what lasts of it from step to step, for archives (state_archive.h).

#include <atoll/joint.h>
#include <solver/constraints/joint.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <variant>

#include "state/filter_state.h"
#include "state/state_archive.h"
#include "world/joint_table.h"
#include "world/refuse.h"

namespace atl {

/// The parameters of a joint kind, beside its name.
template <typename Archive>
struct JointKindState {
  Archive& archive;

  template <typename Axis>
  void axis(Axis& axis) const {
    visit_all(archive, axis.range.lower, axis.range.upper, axis.range.restitution, axis.armature);
    // So hashes of worlds without it are what they were before there was any.
    if (!Archive::hashes || axis.friction != 0) archive.value(axis.friction);
    visit_optional(archive, axis.spring, [this](auto& spring) {
      visit_all(archive, spring.hertz, spring.damping_ratio, spring.rest, spring.stiffness, spring.damping);
    });
    visit_optional(archive, axis.motor, [this](auto& motor) {
      archive.value(motor.speed);
      if constexpr (Archive::reads) motor.max_force.emplace();
      archive.value(*motor.max_force);  // as checked
      visit_optional(archive, motor.servo,
                     [this](auto& servo) { visit_all(archive, servo.target, servo.stiffness, servo.damping); });
    });
  }

  template <typename Terms>
  void terms(Terms& terms) const {
    auto count = static_cast<std::uint8_t>(terms.size());
    archive.value(count);
    if constexpr (Archive::reads) {
      archive.check(count <= TendonJoint::max_terms, "a tendon of too many terms");
      terms.resize(count);
    }
    for (auto& term : terms) {
      visit_all(archive, term.joint, term.coordinate, term.polynomial);
    }
  }

  template <typename Kind>
  void operator()(Kind& kind) const {
    using Joint = std::remove_const_t<Kind>;
    if constexpr (std::is_same_v<Joint, BallJoint>) {
      archive.value(kind.friction);
      if (Archive::hashes && !kind.servo) return;
      visit_optional(archive, kind.servo, [this](auto& servo) {
        visit_all(archive, servo.target, servo.angular_velocity, servo.stiffness, servo.damping, servo.max_torque);
      });
    } else if constexpr (std::is_same_v<Joint, HingeJoint>) {
      axis(kind.angle);
    } else if constexpr (std::is_same_v<Joint, SliderJoint>) {
      axis(kind.offset);
    } else if constexpr (std::is_same_v<Joint, DistanceJoint>) {
      axis(kind.distance);
    } else if constexpr (std::is_same_v<Joint, UniversalJoint>) {
      axis(kind.first);
      axis(kind.second);
    } else if constexpr (std::is_same_v<Joint, ConeTwistJoint>) {
      archive.value(kind.swing_limit);
      axis(kind.twist);
      archive.value(kind.swing_friction);
    } else if constexpr (std::is_same_v<Joint, SixDofJoint>) {
      for (auto& each : kind.offset) axis(each);
      for (auto& each : kind.turn) axis(each);
      // So hashes of worlds without angles are what they were before there were any.
      if (!Archive::hashes || kind.turns != SixDofTurns::Vector) archive.value(kind.turns);
      archive.check(kind.turns <= SixDofTurns::AnglesXZY, "turns of no known sort");
    } else if constexpr (std::is_same_v<Joint, GearJoint>) {
      visit_all(archive, kind.ratio, kind.rack);
    } else if constexpr (std::is_same_v<Joint, WheelJoint>) {
      axis(kind.suspension);
      axis(kind.steering);
      axis(kind.spin);
    } else if constexpr (std::is_same_v<Joint, TendonJoint>) {
      terms(kind.terms);
      axis(kind.length);
    } else {
      static_assert(std::is_same_v<Joint, FixedJoint>);
    }
  }
};

template <std::size_t... numbers>
void set_kind(JointKind& kind, std::size_t number, std::index_sequence<numbers...>) {
  ((number == numbers ? static_cast<void>(kind.emplace<numbers>()) : static_cast<void>(0)), ...);
}

template <typename Archive, typename Kind>
void visit_kind(Archive& archive, Kind& kind) {
  auto number = static_cast<std::uint8_t>(kind.index());
  archive.value(number);
  if constexpr (Archive::reads) {
    archive.check(number < std::variant_size_v<JointKind>, "a joint of no known kind");
    set_kind(kind, number, std::make_index_sequence<std::variant_size_v<JointKind>>());
  }
  std::visit(JointKindState<Archive>{archive}, kind);
}

template <typename Archive, typename Def>
void visit_definition(Archive& archive, Def& def) {
  visit_kind(archive, def.kind);
  visit_all(archive, def.first, def.second, def.frame_first, def.frame_second, def.collide, def.break_force,
            def.break_torque);
  // Nothing follows from these.
  if constexpr (!Archive::hashes) {
    visit_text(archive, def.name);
    archive.value(def.user_data);
  }
}

/// The state of a joint that lasts from step to step, beside its definition.
template <typename Archive, typename Joint, typename Limits>
void visit_joint(Archive& archive, Joint& joint, Limits& limit_before) {
  visit_all(archive, joint.point_impulse, joint.tension, joint.force, joint.torque);
  archive.values(joint.impulse.data(), joint.rows);
  archive.values(joint.position.data(), joint.rows);
  archive.values(joint.limit.data(), joint.rows);
  archive.values(joint.motor_bound.data(), joint.rows);
  archive.values(joint.friction_bound.data(), joint.rows);
  archive.values(limit_before.data(), joint.rows);
  for (std::size_t i = 0; i < joint.terms; ++i) archive.value(joint.term[i].position);
  if constexpr (Archive::reads) {
    bool finite = joint.point_impulse.allFinite() && joint.tension.allFinite() && joint.force.allFinite() &&
                  joint.torque.allFinite();
    for (std::size_t row = 0; row < joint.rows; ++row) {
      finite &= std::isfinite(joint.impulse[row]) && std::isfinite(joint.position[row]);
      // The bodies' poses give each angle up to whole turns; the number of turns is state of its own, and is checked
      // for bounds.
      const double turned = finite ? solver::continued(joint.coordinate[row], 0, joint.position[row]) : 0;
      finite &= std::abs(turned) <= numbers.max;
    }
    for (std::size_t i = 0; i < joint.terms; ++i) finite &= std::abs(joint.term[i].position) <= numbers.max;
    archive.check_number(finite, "a joint whose state is not finite, or out of bounds");
  }
  for (std::size_t row = 0; row < joint.rows; ++row) {
    archive.check(joint.limit[row] >= -1 && joint.limit[row] <= 1, "a joint at a limit that there is not");
    for (const auto& bound : {joint.motor_bound, joint.friction_bound}) {
      archive.check(bound[row] >= -1 && bound[row] <= 1, "a motor or dry friction at no bound");
    }
  }
}

}  // namespace atl
