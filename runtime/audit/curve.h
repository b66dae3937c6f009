#pragma once
/// Least value of a function along an arc of a circle on the sphere of directions.

#include <atoll/types.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "revolved.h"

namespace atl::audit {

/// Directions centre + cos(t) * x + sin(t) * y for t in [0, angle], all of unit length.
struct Curve {
  Vector3 centre, x, y;
  double angle;  ///< rad, up to 2 pi

  Vector3 at(double t) const { return centre + std::cos(t) * x + std::sin(t) * y; }
};

/// Parameters at which a function along a curve may bend sharply: in [0, angle], in order, with both ends.
class Breaks {
 public:
  explicit Breaks(double angle) : angle_(angle) {
    add(0);
    parameters_[count_++] = angle;
  }

  void add(double t) {
    constexpr double turn = 2 * std::numbers::pi;
    t -= turn * std::floor(t / turn);
    if (t > angle_ || count_ >= parameters_.size()) return;
    std::size_t place = count_++;
    for (; place > 0 && parameters_[place - 1] > t; --place) parameters_[place] = parameters_[place - 1];
    parameters_[place] = t;
  }

  /// Adds the breaks of a solid's support along the curve: where the curve passes the directions of the solid's side,
  /// and where it comes nearest to the solid's axis. `sign` is -1 if the solid faces against the curve's directions.
  void add_all(const Revolved& solid, double sign, const Curve& curve) {
    const double along_x = solid.axis.dot(curve.x);
    const double along_y = solid.axis.dot(curve.y);
    const double size = std::hypot(along_x, along_y);
    if (size < 1e-14) return;
    const double middle = std::atan2(along_y, along_x);
    add(middle);
    add(middle + std::numbers::pi);
    const double nearest = std::abs(solid.axis.dot(curve.centre)) + size;
    if (nearest > near_axis) sharp_ = true;
    const double cosine = (sign * solid.side_sine() - solid.axis.dot(curve.centre)) / size;
    if (std::abs(cosine) > 1) return;
    add(middle + std::acos(cosine));
    add(middle - std::acos(cosine));
  }

  /// True if the curve comes so near a solid's axis that the support of its rim, although smooth, turns sharply there.
  bool sharp() const { return sharp_; }

  /// Calls visit(begin, end) for the pieces in between.
  template <class Visit>
  void visit_pieces(const Visit& visit) const {
    for (std::size_t i = 0; i + 1 < count_; ++i) {
      if (parameters_[i + 1] > parameters_[i]) visit(parameters_[i], parameters_[i + 1]);
    }
  }

 private:
  static constexpr double near_axis = 0.955;  // cosine of 0.3 rad

  double angle_;
  bool sharp_ = false;
  std::array<double, 12> parameters_ = {};  // in order
  std::size_t count_ = 0;
};

/// Golden-section search for a local minimum in [low, high], to 1e-11 rad.
template <class Value>
double golden_section(double low, double high, const Value& value) {
  constexpr double ratio = 0.6180339887498949;
  double left = high - ratio * (high - low);
  double right = low + ratio * (high - low);
  double at_left = value(left);
  double at_right = value(right);
  for (int i = 0; i < 60 && high - low > 1e-11; ++i) {
    if (at_left < at_right) {
      high = right;
      right = left;
      at_right = at_left;
      left = high - ratio * (high - low);
      at_left = value(left);
    } else {
      low = left;
      left = right;
      at_left = at_right;
      right = low + ratio * (high - low);
      at_right = value(right);
    }
  }
  return at_left < at_right ? left : right;
}

/// Hands to `offer` every parameter at which `value` may have a local minimum below limit(): the breaks and, in
/// between, what golden-section search makes of the local minima of samples. `bend` (m) bounds the slope, and a few
/// times it the second derivative where the curve isn't sharp.
template <class Value, class Limit, class Offer>
void minimise_along(Breaks breaks, double bend, const Value& value, const Limit& limit, const Offer& offer) {
  constexpr double widest_step = 0.14;  // 45 samples a turn; every smooth piece seen has at most three minima
  constexpr std::size_t max = 64;
  breaks.visit_pieces([&](double begin, double end) {
    const auto steps =
        std::clamp<std::size_t>(static_cast<std::size_t>(std::ceil((end - begin) / widest_step)), 2, max);
    const double step = (end - begin) / static_cast<double>(steps);
    std::array<double, max + 1> values;
    const auto at = [&](std::size_t i) { return i == steps ? end : begin + step * static_cast<double>(i); };
    for (std::size_t i = 0; i <= steps; ++i) values[i] = value(at(i));
    if (values[0] < limit()) offer(begin);
    if (values[steps] < limit()) offer(end);
    for (std::size_t i = 0; i <= steps; ++i) {
      if (i > 0 && values[i - 1] < values[i]) continue;
      if (i < steps && values[i + 1] < values[i]) continue;
      const double lower = bend * step * (breaks.sharp() ? 1 : 2 * step);  // by this much at most
      if (values[i] - lower > limit()) continue;
      const double t = golden_section(at(i > 0 ? i - 1 : 0), at(i < steps ? i + 1 : steps), value);
      if (value(t) < limit()) offer(t);
    }
  });
}

}  // namespace atl::audit
