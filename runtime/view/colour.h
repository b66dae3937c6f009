#pragma once

#include <cstddef>

namespace atl::view {

/// sRGB, in [0, 1].
struct Colour {
  double r = 0, g = 0, b = 0;
};

/// The colour of static bodies.
inline constexpr Colour static_colour = {0.66, 0.68, 0.71};

/// The colour of a moving body, by its number: neighbours get hues far apart.
Colour body_colour(std::size_t number);

/// The same in linear light (IEC 61966-2-1).
Colour linear(const Colour& colour);

}  // namespace atl::view
