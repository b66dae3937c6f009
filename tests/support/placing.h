#pragma once

#include <atoll/errors.h>

#include <numbers>
#include <random>

namespace atl::test {

inline PlacedShape place(const Shape& shape, const Vector3& position,
                         const Quaternion& orientation = Quaternion::Identity(), BodyType type = BodyType::Dynamic) {
  return {.type = type, .shape = shape, .pose = {.position = position, .orientation = orientation}};
}

inline Quaternion turn(double angle, const Vector3& axis) {
  return Quaternion(Eigen::AngleAxisd(angle, axis.normalized()));
}

/// The same numbers in every run.
class RandomPlaces {
 public:
  explicit RandomPlaces(unsigned seed = 12345) : engine_(seed) {}

  double between(double low, double high) { return std::uniform_real_distribution(low, high)(engine_); }
  Vector3 vector(double low, double high) { return {between(low, high), between(low, high), between(low, high)}; }
  Vector3 direction() {
    for (;;) {
      const Vector3 v = vector(-1, 1);
      if (v.norm() > 0.1 && v.norm() < 1) return v.normalized();
    }
  }
  Quaternion orientation() { return turn(between(0, 2 * std::numbers::pi), direction()); }

 private:
  std::mt19937 engine_;
};

}  // namespace atl::test
