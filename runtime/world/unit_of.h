#pragma once

#include <cmath>

namespace atl {

/// A finite vector that is not zero, at length 1. It is scaled first only where the square of its length is no number
/// that a double holds, as that costs a rounding.
template <typename Vector>
typename Vector::PlainObject unit_of(const Vector& vector) {
  const double length = vector.norm();
  if (std::isfinite(length) && length > 0) return vector / length;
  // Eigen's stableNormalized() scales it back, to more than a double may hold.
  const typename Vector::PlainObject scaled = vector / vector.cwiseAbs().maxCoeff();
  return scaled / scaled.norm();
}

}  // namespace atl
