#pragma once

#include <atoll/types.h>

#include <cmath>
#include <cstdint>

namespace atl::scene {

/// SplitMix64 (Steele, Lea and Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014).
/// The standard's distributions differ between libraries, so the ones here are our own, and use no
/// operation that IEEE 754 leaves open: the same seed gives the same scene everywhere.
class Random {
 public:
  /// Different streams of one seed are independent of each other.
  explicit Random(std::uint64_t seed, std::uint64_t stream = 0) : state_(seed) {
    state_ = next() ^ (stream * increment);
  }

  std::uint64_t next() {
    std::uint64_t z = state_ += increment;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }

  /// Uniform in [min, max), of 53 random bits.
  double uniform(double min, double max) { return min + (max - min) * (static_cast<double>(next() >> 11) * 0x1p-53); }

  /// Each component uniform in [-half, half). Drawn in the order x, y, z.
  Vector3 in_box(const Vector3& half) {
    const double x = uniform(-half.x(), half.x());
    const double y = uniform(-half.y(), half.y());
    const double z = uniform(-half.z(), half.z());
    return {x, y, z};
  }

  /// Uniform over all rotations: a point of the unit 3-sphere from two of the unit disc (Marsaglia,
  /// "Choosing a point from the surface of a sphere", 1972), which needs no sine that libm might round.
  Quaternion rotation() {
    const Disc a = in_disc(), b = in_disc();
    const double scale = std::sqrt((1 - a.square) / b.square);
    return {b.y * scale, a.x, a.y, b.x * scale};
  }

 private:
  static constexpr std::uint64_t increment = 0x9e3779b97f4a7c15u;

  struct Disc {
    double x, y, square;
  };
  Disc in_disc() {
    for (;;) {
      const double x = uniform(-1, 1);
      const double y = uniform(-1, 1);
      const double square = x * x + y * y;
      if (square > 0 && square < 1) return {x, y, square};
    }
  }

  std::uint64_t state_;
};

}  // namespace atl::scene
