#pragma once

namespace atl::solver {

struct SineCosine {
  double sine;
  double cosine;
};

/// Sine and cosine to within 3 units in the last place for |angle| < 1e5 rad, by operations that IEEE 754
/// defines to the bit: the C library's differ between versions. As of 0 from 2^50 on; NaN of what is not finite.
SineCosine sine_cosine(double angle);

/// The angle of (x, y) from the x axis, rad, in [-pi, pi], to within 4 units in the last place, by such operations
/// too. Signs of zeros and infinities count as in IEEE 754's atan2: with x = -0 or less, y = 0 gives pi and -0 gives
/// -pi, with x = 0 or more y itself; two infinities make a diagonal. NaN if either is.
double arctangent(double y, double x);

/// exp(x) - 1 for x <= 0, to within 4 units in the last place, by such operations too.
double exponential_less_one(double x);

}  // namespace atl::solver
