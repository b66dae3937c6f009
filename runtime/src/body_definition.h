#pragma once

#include <atoll/body.h>
#include <collision/shape.h>

namespace atl {

/// A definition that has passed all checks, in the terms of the layers below.
struct CheckedBody {
  collision::Shape shape;
  Vector3 position;
  Quaternion orientation;  // unit
  double inverse_mass = 0;
  Matrix3 inertia = Matrix3::Zero();
  Matrix3 inverse_inertia = Matrix3::Zero();
  bool gyroscopic = false;
};

/// Throws Error naming the field, the value and what was expected.
CheckedBody check(const BodyDef& def);

// For the calls that change a body later. Each throws as check() does; `what` names the argument.
void check_finite(const char* what, const Vector3& value);
Quaternion checked_orientation(const char* what, const Quaternion& value);

}  // namespace atl
