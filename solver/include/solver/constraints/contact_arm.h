#pragma once

#include <collision/shapes/collider_table.h>
#include <solver/integrate/body_table.h>

#include <cstdint>

namespace atl::solver {

/// A contact's arm on a body that turns, in two parts, as the step begins: m, world frame. A round surface rolls: a
/// point below it, the pivot, goes with the body, and the contact stays where the surface meets the other body. An
/// ellipsoid's pivot is its centre of curvature along the way that the body's spin rolls the contact.
struct ContactArm {
  Vector3 pivot = Vector3::Zero();  ///< from the centre of mass
  Vector3 rim = Vector3::Zero();    ///< from the pivot to the contact; zero where the surface isn't round
  Vector3 axis = Vector3::Zero();   ///< unit, of a surface of revolution: the rim turns with it, but not about it. Zero
                                    ///< of balls' and ellipsoids' surfaces, whose rim doesn't turn at all.
};

/// The arm of a contact with a collider of a body. `anchor` is from the body's centre of mass to the contact, and
/// `outward` the unit normal that points away from the body.
ContactArm contact_arm(const BodyTable& bodies, std::uint32_t body, const collision::ColliderTable& colliders,
                       std::uint32_t collider, const Vector3& anchor, const Vector3& outward);

/// Tells shapes whose contacts have a rim.
bool is_round(collision::ShapeKind kind);

/// The arm that the body has taken along by a turn (rad) since the step began. The lowest point of a surface of
/// revolution is not moved by its spin, but the turn of its axis moves it along the rim.
Vector3 turned_arm(const ContactArm& arm, const Vector3& turn, const Vector3& normal);

/// rad, about the normal: how far that has turned the line along which a surface of revolution touches; else 0.
double line_turn(const ContactArm& arm, const Vector3& turn, const Vector3& normal);

/// m: what that changes along the normal, at a point that lies `off` from the contact.
double gained_along(const ContactArm& arm, const Vector3& off, const Quaternion& turn, const Vector3& normal);

/// Tells bodies that turn by enough in the step to take contacts on them along. Balls don't.
bool turns_in_step(const BodyTable& bodies, std::uint32_t body, double dt);

/// rad: a body's turn half way through the step, as its spin when that begins lets expect. Zero where contacts don't
/// move with it; of what turns far, and so may come to turn any way, less (tuning::known_turn).
Vector3 half_turn(const BodyTable& bodies, std::uint32_t body, double dt);

}  // namespace atl::solver
