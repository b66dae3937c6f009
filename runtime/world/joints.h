#pragma once
/// Joints as they come, go and are changed from outside.

#include <atoll/joint.h>
#include <solver/constraints/joint.h>

#include <cstdint>

#include "world/stores.h"

namespace atl {

/// Throws Error if these bodies can't be joined.
void check_bodies(const Stores& world, const JointDef& def);

JointId add_joint(Stores& world, const JointDef& def);
void remove_joint(Stores& world, std::uint32_t joint);
void remove_joints_of(Stores& world, std::uint32_t body);
/// Called as a body goes into quarantine: everyone else sees its joints as removed.
void suspend_joints_of(Stores& world, std::uint32_t body);
void resume_joints_of(Stores& world, std::uint32_t body);

bool contains(const Stores& world, JointId id);
/// Throws Error that names `call` if no joint has the id.
std::uint32_t index_of(const Stores& world, JointId id, const char* call);

JointState joint_state(const Stores& world, std::uint32_t joint);
/// Throws Error, and changes nothing, if the definition is of another kind, between other bodies, or unusable.
void set_joint(Stores& world, std::uint32_t joint, const JointDef& definition);
/// Does as set_joint() with another speed or target of a coordinate's motor: the only thing that a controller changes,
/// in every step.
void drive(Stores& world, std::uint32_t joint, std::size_t coordinate, const JointMotor& motor);
/// After a body got another centre of mass, or type: its joints stay where they are in its frame.
void move_anchors(Stores& world, std::uint32_t body);
void set_joint_enabled(Stores& world, std::uint32_t joint, bool enabled);
/// Throws Error if the joint has no such coordinate.
void count_turns_from(Stores& world, std::uint32_t joint, double angle, std::size_t coordinate);

solver::JointFrames frames_of(const Stores& world, const solver::Joint& joint);
void wake_joined_by(Stores& world, std::uint32_t joint);
/// Wakes what joints connect a body to.
void wake_joined(Stores& world, std::uint32_t body);
/// The joint came, went, or acts otherwise from now on.
void joint_changed(Stores& world, std::uint32_t joint);
/// After the joint was disabled: it forgets what it did.
void release_joint(Stores& world, std::uint32_t joint);

/// The definition with unit orientations. Throws Error naming the field, the value and what was expected. What depends
/// on the bodies is not looked at.
JointDef checked(const JointDef& def);

/// Throws likewise; `what` names the argument.
void check(const char* what, const JointKind& kind);

/// "BallJoint", ...
const char* name_of(const JointKind& kind);

// Tendons: what of them follows from the joints of their terms.

/// A definition with the bodies of the first of its joints, if it is a tendon. Throws Error for terms that none can
/// have.
JointDef with_bodies(const Stores& world, JointDef def);

/// Tells a tendon which coordinates its terms are of; those that it had before, as `before`, keep their positions.
/// Throws Error as with_bodies() does.
void bind_tendon(const Stores& world, const JointKind& kind, const solver::Joint& before, solver::Joint& joint);

/// Finds where a tendon's coordinates are. Angles start with the turns that their joints count.
void find_length(const Stores& world, solver::Joint& tendon);
/// Once bodies have been put elsewhere.
void follow_length(const Stores& world, solver::Joint& tendon);

}  // namespace atl
