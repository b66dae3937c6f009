#pragma once

#include <span>

#include "comparison.h"
#include "setting.h"

namespace atl::scene {

/// A plane through the y axis that goes down along x.
struct Slope {
  double angle;  ///< rad

  double sine() const { return sine_cosine(angle).sine; }
  double cosine() const { return sine_cosine(angle).cosine; }
  Vector3 normal() const { return {sine(), 0, cosine()}; }
  Vector3 down() const { return {cosine(), 0, -sine()}; }
  Quaternion orientation() const { return turned(angle, Vector3::UnitY()); }
};

/// A body that starts at rest and goes down a slope.
struct Descent {
  Vector3 start;
  double acceleration;  ///< m/s^2, downhill; 0 if it stays
};

/// Compares bodies 1, 2, ... with their descents: largest distance along the plane, relative to the way down without
/// friction over the duration (s); `held` and `moved` name the parts for those that stay and those that don't.
inline Compare compare_descents(const Slope& slope, const std::vector<Descent>& descents, double duration,
                                const std::string& held, const std::string& moved) {
  const double scale = 0.5 * standard_gravity * slope.sine() * duration * duration;
  return [=](double time, std::span<const BodyState> states, LargestErrors& errors) {
    for (std::size_t i = 0; i < descents.size(); ++i) {
      const Descent& descent = descents[i];
      const Vector3 expected = descent.start + 0.5 * descent.acceleration * time * time * slope.down();
      const Vector3 off = states[i + 1].pose.position - expected;
      const Vector3 along = off - off.dot(slope.normal()) * slope.normal();
      errors.raise_with_total(descent.acceleration == 0 ? held : moved, along.norm() / scale);
    }
  };
}

}  // namespace atl::scene
