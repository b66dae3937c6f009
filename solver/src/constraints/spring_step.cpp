#include <jobs/assert.h>
#include <solver/constraints/spring_step.h>
#include <solver/integrate/trigonometry.h>

#include <algorithm>
#include <cmath>

namespace atl::solver {

// The exact map of a step of x'' + decay x' + omega^2 x = 0 has the eigenvalues exp(-a h) and exp(-b h), with a and b
// the roots of s^2 - decay s + omega^2. The map u1 = (1 - d) u - p x, x1 = x + h u1 has the same eigenvalues if d = 1 -
// exp(-(a + b) h) and p h = (1 - exp(-a h)) (1 - exp(-b h)).
SpringStep SpringStep::of(double omega, double decay, double h, double max_closed) {
  ATL_ASSERT(h > 0, h);
  ATL_ASSERT(!(omega < 0) && !(decay < 0), omega, decay);
  const double phase = omega * h;
  const double half = std::max(0.5 * decay * h, std::sqrt(std::max(phase * phase - max_phase * max_phase, 0.0)));
  const double lost = -exponential_less_one(-2 * half);  // d
  double hold = 0;
  if (half >= phase) {
    const double root = std::sqrt((half - phase) * (half + phase));
    const double fast = half + root;
    const double slow = fast > 0 ? phase * phase / fast : 0;
    // (1 - exp(-x)) / x
    const auto part = [](double x) { return x > 0 ? -exponential_less_one(-x) / x : 1; };
    hold = 1 / (part(fast) * part(slow)) - 1;
  } else {
    const double angle = std::sqrt((phase - half) * (phase + half));
    const double left = 1 + exponential_less_one(-half);
    const double sine = sine_cosine(0.5 * angle).sine;
    hold = phase * phase / ((1 - left) * (1 - left) + 4 * left * sine * sine) - 1;
  }
  const double keep = hold - lost * (1 + hold);
  return {std::max(hold, phase * phase / max_closed - 1), keep, omega * phase};
}

}  // namespace atl::solver
