#pragma once

namespace atl::solver {

struct SineCosine {
  double sine;
  double cosine;
};

/// Sine and cosine to within 3 units in the last place for |angle| < 1e5 rad, by operations that IEEE 754
/// defines to the bit: the C library's differ between versions.
SineCosine sine_cosine(double angle);

}  // namespace atl::solver
