#pragma once

#include <collision/shapes/shape.h>

#include <algorithm>
#include <array>
#include <limits>

namespace atl::collision {

/// Axis-aligned box in single precision. One made from doubles is rounded outwards, so it always contains
/// what it was made from, however far from the origin.
struct Aabb {
  std::array<float, 3> lower;
  std::array<float, 3> upper;

  static Aabb empty() {
    constexpr float inf = std::numeric_limits<float>::infinity();
    return {{inf, inf, inf}, {-inf, -inf, -inf}};
  }

  /// The smallest float box around [lower, upper].
  static Aabb around(const Vector3& lower, const Vector3& upper);

  bool overlaps(const Aabb& other) const { return ordered(lower, other.upper) && ordered(other.lower, upper); }

  bool contains(const Aabb& other) const { return ordered(lower, other.lower) && ordered(other.upper, upper); }

  Aabb joined(const Aabb& other) const {
    Aabb result;
    for (std::size_t i = 0; i < 3; ++i) {
      result.lower[i] = std::min(lower[i], other.lower[i]);
      result.upper[i] = std::max(upper[i], other.upper[i]);
    }
    return result;
  }

  /// This box, or if any of its numbers is NaN, one of NaNs only, that overlaps nothing in any test.
  Aabb known_or_nan() const {
    bool known = true;
    for (std::size_t i = 0; i < 3; ++i) known &= lower[i] == lower[i] && upper[i] == upper[i];
    constexpr float nan = std::numeric_limits<float>::quiet_NaN();
    return known ? *this : Aabb{{nan, nan, nan}, {nan, nan, nan}};
  }

  /// Half the surface area.
  float half_area() const {
    const float x = upper[0] - lower[0];
    const float y = upper[1] - lower[1];
    const float z = upper[2] - lower[2];
    return x * y + y * z + z * x;
  }

  friend bool operator==(const Aabb&, const Aabb&) = default;

 private:
  // a <= b in each component; summed, so that the comparisons cost no branches.
  static bool ordered(const std::array<float, 3>& a, const std::array<float, 3>& b) {
    return int{a[0] <= b[0]} + int{a[1] <= b[1]} + int{a[2] <= b[2]} == 3;
  }
};

/// Tight bounds of a bounded shape (not a half-space) at a pose, as lower and upper corner in double.
struct Bounds {
  Vector3 lower;
  Vector3 upper;
};
Bounds bounds_of(const Shape& shape, const Vector3& position, const Matrix3& rotation);
/// The same of a box between two corners.
Bounds bounds_of_box(const Vector3& lower, const Vector3& upper, const Vector3& position, const Matrix3& rotation);

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
