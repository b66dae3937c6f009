#pragma once
/// Random test data, the same on every run and machine.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <random>

namespace atl::test {

class Random {
 public:
  explicit Random(std::uint32_t seed) : engine_(seed) {}

  /// In [lower, upper).
  double real(double lower, double upper) { return lower + (upper - lower) * (engine_() * 0x1p-32); }
  /// In [lower, upper), evenly over magnitudes; lower > 0.
  double magnitude(double lower, double upper) { return std::exp(real(std::log(lower), std::log(upper))); }
  /// In [0, count).
  std::uint32_t below(std::uint32_t count) { return engine_() % count; }
  bool chance(double probability) { return real(0, 1) < probability; }

  Eigen::Vector3d vector(double reach) {
    const double x = real(-reach, reach);
    const double y = real(-reach, reach);
    const double z = real(-reach, reach);
    return {x, y, z};
  }
  Eigen::Vector3d direction() {
    while (true) {
      const Eigen::Vector3d v = vector(1);
      if (v.squaredNorm() < 1 && v.squaredNorm() > 0.01) return v.normalized();
    }
  }
  Eigen::Quaternion<double, Eigen::DontAlign> rotation(double largest_angle = 3.14) {
    const double half = 0.5 * real(-largest_angle, largest_angle);
    const Eigen::Vector3d v = std::sin(half) * direction();
    return {std::cos(half), v.x(), v.y(), v.z()};
  }

 private:
  std::mt19937 engine_;
};

}  // namespace atl::test
