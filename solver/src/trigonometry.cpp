#include <solver/trigonometry.h>

#include <cmath>

namespace atl::solver {

SineCosine sine_cosine(double angle) {
  // Reduction by multiples of pi/2 in three parts (Cody and Waite, 1980): the first two have 33 bits each, so
  // their products with any multiple below 2^20 are exact.
  constexpr double two_over_pi = 0.63661977236758134308;
  constexpr double half_pi_high = 1.57079632673412561417e+00;
  constexpr double half_pi_middle = 6.07710050630396597660e-11;
  constexpr double half_pi_low = 2.02226624879595063154e-21;
  const double multiple = std::nearbyint(angle * two_over_pi);
  const double r = ((angle - multiple * half_pi_high) - multiple * half_pi_middle) - multiple * half_pi_low;
  const double r2 = r * r;

  // Taylor's series; |r| <= pi/4, so the first terms left out are below 1e-18.
  double sine = 0;
  for (int n = 17; n >= 3; n -= 2) sine = (sine * r2 + 1) * (-1.0 / (n * (n - 1)));
  sine = r + r * (sine * r2);
  double cosine = 0;
  for (int n = 18; n >= 2; n -= 2) cosine = (cosine * r2 + 1) * (-1.0 / (n * (n - 1)));
  cosine = 1 + cosine * r2;

  switch (static_cast<long long>(multiple) & 3) {
    case 0:
      return {sine, cosine};
    case 1:
      return {cosine, -sine};
    case 2:
      return {-sine, -cosine};
    default:
      return {-cosine, sine};
  }
}

}  // namespace atl::solver
