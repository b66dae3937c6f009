#include "view/colour.h"

#include <algorithm>
#include <cmath>

namespace atl::view {

Colour body_colour(std::size_t number) {
  const double hue = std::fmod(static_cast<double>(number) * 137.508, 360.0) / 60;
  const auto channel = [hue](double peak) {
    const double apart = std::abs(std::remainder(hue - peak, 6.0));
    return 0.42 + 0.42 * std::clamp(2 - apart, 0.0, 1.0);
  };
  return {channel(0), channel(2), channel(4)};
}

Colour linear(const Colour& colour) {
  const auto channel = [](double c) { return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4); };
  return {channel(colour.r), channel(colour.g), channel(colour.b)};
}

}  // namespace atl::view
