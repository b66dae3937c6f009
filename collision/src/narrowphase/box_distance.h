#pragma once

#include <collision/shapes/aabb.h>

#include <algorithm>

namespace atl::collision {

/// Square of the distance (m^2) of a box from bounds; 0 where they overlap.
inline double square_apart(const Aabb& box, const Bounds& bounds) {
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    const double apart = std::max({0.0, static_cast<double>(box.lower[i]) - bounds.upper[axis],
                                   bounds.lower[axis] - static_cast<double>(box.upper[i])});
    sum += apart * apart;
  }
  return sum;
}

}  // namespace atl::collision
