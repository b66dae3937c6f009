#pragma once

#include <atoll/body.h>
#include <collision/pose.h>
#include <collision/shape.h>

#include <memory>
#include <vector>

namespace atl {

/// One convex solid, half-space or surface of a body.
struct CheckedCollider {
  collision::Shape shape;
  collision::Pose local;                 // in the body's frame
  std::shared_ptr<const void> geometry;  // what the shape points to, if anything
};

/// A definition that has passed all checks, in the terms of the layers below.
struct CheckedBody {
  std::vector<CheckedCollider> colliders;  // one for each child of a compound
  Vector3 centre = Vector3::Zero();        // of mass, body frame
  Vector3 position;                        // of the body frame
  Quaternion orientation;                  // unit
  double inverse_mass = 0;
  Matrix3 inertia = Matrix3::Zero();
  Matrix3 inverse_inertia = Matrix3::Zero();
  bool gyroscopic = false;
  // Of gyroscopic bodies: the axes, in the body's frame, in which the inertia is diagonal, and the moments about them.
  Quaternion principal_axes = Quaternion::Identity();
  Vector3 moments = Vector3::Zero();
};

/// Throws Error naming the field, the value and what was expected.
CheckedBody check(const BodyDef& def);

// For the calls that change a body later, and for queries. Each throws as check() does; `what` names the argument.
void check_finite(const char* what, const Vector3& value);
Quaternion checked_orientation(const char* what, const Quaternion& value);
/// What users call a kind that has no volume, and so no finite mass; null for solids.
const char* massless_name(collision::ShapeKind kind);

std::vector<CheckedCollider> checked_colliders(const char* what, const Shape& shape);

}  // namespace atl
