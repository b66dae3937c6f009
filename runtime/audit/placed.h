#pragma once
/// A PlacedShape resolved to world-frame doubles, the form in which the audit computes.

#include <atoll/errors.h>

#include <variant>

namespace atl::audit {

struct PlacedSphere {
  Vector3 centre;
  double radius;
};

struct PlacedBox {
  Vector3 centre;
  Matrix3 axes;  ///< columns: the box's axes in the world frame
  Vector3 half_extents;
};

/// Solid where normal . p <= offset.
struct PlacedHalfSpace {
  Vector3 normal;  ///< unit
  double offset;
};

using Placed = std::variant<PlacedSphere, PlacedBox, PlacedHalfSpace>;

Placed place(const PlacedShape& shape);

/// Signed overlap, defined as the public overlap() of errors.h.
double overlap(const Placed& a, const Placed& b);

/// The box-box case: all 15 axes of the separating-axis test.
double box_overlap(const PlacedBox& a, const PlacedBox& b);

}  // namespace atl::audit
