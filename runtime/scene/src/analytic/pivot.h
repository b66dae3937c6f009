#pragma once

#include <atoll/types.h>

#include <cmath>

#include "quadrature.h"
#include "setting.h"

namespace atl::scene {

/// A block that turns about one of its lower edges: Housner, "The behavior of inverted pendulum structures during
/// earthquakes", Bulletin of the Seismological Society of America 53, 1963, without his small angles.
class Pivot {
 public:
  /// Half extents across the edge and upwards, m; a horizontal force through the centre, relative to the weight.
  Pivot(double half_width, double half_height, double push = 0)
      : slenderness_(angle_of(half_width, half_height)),
        rate_(std::sqrt(0.75 * standard_gravity / std::sqrt(half_width * half_width + half_height * half_height))),
        push_(push) {}

  /// Angle in rad between the diagonal and the vertical: at this tilt the block is balanced.
  double slenderness() const { return slenderness_; }
  double rate() const { return rate_; }  ///< 1/s: p^2 = m g R / I = 3 g / (4 R)

  /// Angular acceleration of the tilt towards the edge, rad/s^2.
  double acceleration(double tilt) const {
    const double arm = slenderness_ - tilt;
    return rate_ * rate_ * (push_ * std::cos(arm) - std::sin(arm));
  }

  /// Without push: the tilt at which a block of this tilt (>= 0) and rate (rad/s) comes to rest; at most that of
  /// balance.
  double peak(double tilt, double tilt_rate) const {
    const double level = std::cos(slenderness_ - tilt) + 0.5 * std::pow(tilt_rate / rate_, 2);
    return slenderness_ - std::acos(std::min(1.0, level));
  }

  /// Without push: how long it takes to fall from rest at a tilt to its base, s. Tilts p (1 - u^2) make the integrand
  /// of dt = d tilt / rate smooth.
  double quarter_period(double from) const {
    const auto time = [&](double u) {
      const double fallen = from * u * u;
      const double rise = 4 * std::sin(slenderness_ - from + fallen / 2) * std::sin(fallen / 2);
      return 2 * from * u / (rate_ * std::sqrt(rise));
    };
    return integrate(time, 0, 1, 64);
  }

 private:
  double slenderness_;
  double rate_;
  double push_;
};

/// The tilt of a block that starts at rest on its base, by the classical method of Runge and Kutta in steps of at most
/// 1 ms: its error is below 1e-10 rad.
class PivotMotion {
 public:
  explicit PivotMotion(const Pivot& pivot) : pivot_(pivot) {}

  /// At a time (s) not before that of the last call.
  double tilt(double time) {
    const int steps = static_cast<int>(std::ceil((time - time_) / 1e-3));
    const double h = steps > 0 ? (time - time_) / steps : 0;
    for (int i = 0; i < steps; ++i) step(h);
    time_ = time;
    return tilt_;
  }

 private:
  void step(double h) {
    const double v1 = rate_, a1 = pivot_.acceleration(tilt_);
    const double v2 = rate_ + h / 2 * a1, a2 = pivot_.acceleration(tilt_ + h / 2 * v1);
    const double v3 = rate_ + h / 2 * a2, a3 = pivot_.acceleration(tilt_ + h / 2 * v2);
    const double v4 = rate_ + h * a3, a4 = pivot_.acceleration(tilt_ + h * v3);
    tilt_ += h / 6 * (v1 + 2 * v2 + 2 * v3 + v4);
    rate_ += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }

  Pivot pivot_;
  double time_ = 0;
  double tilt_ = 0;
  double rate_ = 0;
};

/// Tilt of a body's z axis towards x, rad.
inline double tilt_towards_x(const BodyState& state) {
  const Vector3 up = state.pose.orientation * Vector3::UnitZ();
  return std::atan2(up.x(), up.z());
}

}  // namespace atl::scene
