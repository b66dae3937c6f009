#include <solver/integrate/trigonometry.h>

#include <array>
#include <cmath>
#include <cstddef>

namespace atl::solver {
namespace {

// (arctan(r) / r - 1) / r^2 for |r| <= tan(pi/12), by Taylor's series: the first term left out is below 2e-19 of
// arctan(r) / r. Even and odd terms are summed side by side, as each sum waits for itself.
double arctangent_series(double r2) {
  constexpr int terms = 16;
  constexpr auto coefficients = [] {
    std::array<double, terms> values = {};
    for (int n = 0; n < terms; ++n) values[static_cast<std::size_t>(n)] = (n % 2 == 0 ? -1.0 : 1.0) / (2 * n + 3);
    return values;
  }();
  const double r4 = r2 * r2;
  double even = coefficients[terms - 2], odd = coefficients[terms - 1];
  for (std::size_t n = terms - 2; n > 0; n -= 2) {
    even = even * r4 + coefficients[n - 2];
    odd = odd * r4 + coefficients[n - 1];
  }
  return even + odd * r2;
}

// The arctangent for t in [0, 1]. A t above tan(pi/12) is turned back by pi/6 (Cody and Waite, Software Manual for the
// Elementary Functions, 1980, chapter 11).
double arctangent_within_one(double t) {
  constexpr double tangent_of_twelfth = 0.26794919243112270647;
  constexpr double root_three = 1.73205080756887729353;
  constexpr double sixth_of_pi = 0.52359877559829887308, sixth_of_pi_low = -5.3604088322554746e-17;
  if (!(t > tangent_of_twelfth)) return t + t * (t * t * arctangent_series(t * t));
  // t root_three - 1, at less of a rounding.
  const double r = (((t * (root_three - 1) - 0.5) - 0.5) + t) / (t + root_three);
  return sixth_of_pi + (r + (sixth_of_pi_low + r * (r * r * arctangent_series(r * r))));
}

}  // namespace

SineCosine sine_cosine(double angle) {
  // Reduction by multiples of pi/2 in three parts (Cody and Waite, 1980): the first two have 33 bits each, so
  // their products with any multiple below 2^20 are exact.
  constexpr double two_over_pi = 0.63661977236758134308;
  constexpr double half_pi_high = 1.57079632673412561417e+00;
  constexpr double half_pi_middle = 6.07710050630396597660e-11;
  constexpr double half_pi_low = 2.02226624879595063154e-21;
  constexpr double quarter_pi = 0.78539816339744830962;
  // Beyond, a turn is less than the rounding of the angle; which turn it is would be up to how a machine converts
  // numbers.
  constexpr double max = 0x1p50;
  if (!(std::abs(angle) < max)) return {angle - angle, angle - angle + 1};
  // Most angles are small, and asking the C library to round takes a call.
  const double multiple = std::abs(angle) <= quarter_pi ? 0.0 : std::nearbyint(angle * two_over_pi);
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

double exponential_less_one(double x) {
  constexpr double all = -40;  // below, exp(x) is less than a rounding of 1
  constexpr double small = -0.25;
  if (!(x > all)) return x == x ? -1 : x;
  int halvings = 0;
  for (; x < small; x *= 0.5) ++halvings;
  // Taylor's series: the first term left out is below 1e-19 of x. Then exp(2 x) - 1 = (exp(x) - 1) (exp(x) + 1).
  double sum = 0;
  for (int n = 14; n >= 2; --n) sum = (sum + 1) * (x / n);
  double result = x + x * sum;
  for (; halvings > 0; --halvings) result *= 2 + result;
  return result;
}

double arctangent(double y, double x) {
  // Multiples of pi/2 in two parts each.
  constexpr double half_pi = 1.57079632679489661923, half_pi_low = 6.12323399573676588614e-17;
  const double across = std::abs(y), along = std::abs(x);
  const bool steep = across > along;
  // Equal ones may be zeros or infinities, whose quotient says nothing.
  const double equal = across == 0 ? 0 : 1;
  const double ratio = across == along ? equal : (steep ? along / across : across / along);

  double angle = arctangent_within_one(ratio);
  if (steep) angle = half_pi - (angle - half_pi_low);
  if (std::signbit(x)) angle = 2 * half_pi - (angle - 2 * half_pi_low);
  return std::copysign(angle, y);
}

}  // namespace atl::solver
