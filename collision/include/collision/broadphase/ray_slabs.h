#pragma once

#include <collision/shapes/aabb.h>

#include <cmath>

namespace atl::collision {

/// A ray, or a box that is swept along one, prepared for tests against many boxes: the slab method (Kay and
/// Kajiya 1986) with every rounding to the safe side, so a box that the ray touches is never missed. At most
/// a few units in the last place of a double are added.
class RaySlabs {
 public:
  /// The points origin + t * direction, 0 <= t <= max_t; direction of any length, 0 as well (the origin
  /// alone); max_t may be infinite. `half_extents` (>= 0) are those of a swept box centred on the ray. With a
  /// number that is not finite, nothing is ever hit.
  RaySlabs(const Vector3& origin, const Vector3& direction, double max_t, const Vector3& half_extents) {
    valid_ = origin.allFinite() && direction.allFinite() && half_extents.allFinite() && max_t >= 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto axis = static_cast<Eigen::Index>(i);
      origin_[i] = origin[axis];
      half_[i] = half_extents[axis];
      // So slow a component that its inverse might overflow counts as none, with the slab as much thicker.
      across_[i] = std::abs(direction[axis]) < 1e-300;
      inverse_[i] = across_[i] ? 0 : 1 / direction[axis];
      if (across_[i] && direction[axis] != 0) half_[i] += std::abs(direction[axis]) * max_t;
    }
  }

  bool valid() const { return valid_; }

  /// True if the ray touches the box at a t of [0, max_t]. If so, t_enter is the least such t, rounded down. A box with
  /// a NaN is never touched.
  bool enter(const Aabb& box, double max_t, double& t_enter) const {
    double enter = 0;
    double leave = max_t;
    bool ordered = true;
    for (std::size_t i = 0; i < 3; ++i) {
      const double lower = rounded_up(half_[i] - static_cast<double>(box.lower[i])) + origin_[i];  // inside if >= 0
      const double upper = rounded_up(half_[i] + static_cast<double>(box.upper[i])) - origin_[i];  // inside if >= 0
      if (across_[i]) {
        ordered &= lower >= 0 && upper >= 0;
        continue;
      }
      const bool forward = inverse_[i] > 0;
      const double speed = std::abs(inverse_[i]);
      const double near = rounded_down(-(forward ? lower : upper) * speed);
      const double far = rounded_up((forward ? upper : lower) * speed);
      ordered &= near <= far;  // false for a NaN, which the next two lines would pass over
      enter = near > enter ? near : enter;
      leave = far < leave ? far : leave;
    }
    t_enter = enter;
    return ordered && enter <= leave;
  }

 private:
  // More than the rounding of the operations that made a value: one sum, or one sum, an inverse and a product.
  static constexpr double rounding = 0x1p-50;

  static double rounded_up(double value) { return value + rounding * std::abs(value); }
  static double rounded_down(double value) { return value - rounding * std::abs(value); }

  std::array<double, 3> origin_, half_, inverse_;
  std::array<bool, 3> across_;
  bool valid_;
};

}  // namespace atl::collision
