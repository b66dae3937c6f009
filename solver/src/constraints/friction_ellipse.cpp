#include <solver/constraints/friction_ellipse.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

namespace atl::solver {
namespace {

using Two = std::array<double, 2>;

Two turned(const Two& v, double cosine, double sine) {
  return {cosine * v[0] + sine * v[1], cosine * v[1] - sine * v[0]};
}

}  // namespace

bool FrictionEllipse::hold(const std::array<double, 3>& mass, double bound, Two& impulse) const {
  if (!(bound > 0)) {
    impulse = {0, 0};
    return true;
  }
  // With the shorter half axis stretched, the ellipse is a disc.
  const double c = cosine, s = sine, stretch = 1 / ratio;
  Two g = turned(impulse, c, s);
  g[1] *= stretch;
  const double length = std::sqrt(g[0] * g[0] + g[1] * g[1]);
  if (!(length > bound)) return false;
  const auto& [m11, m12, m22] = mass;
  const double a = c * c * m11 + 2 * c * s * m12 + s * s * m22;
  const double b = stretch * (c * s * (m22 - m11) + (c * c - s * s) * m12);
  const double d = stretch * stretch * (s * s * m11 - 2 * c * s * m12 + c * c * m22);
  // Newton's method for the t at which f = (1 + t m)^-1 g reaches the disc (More and Sorensen, "Computing a trust
  // region step", SIAM J. Sci. Stat. Comput. 4, 1983).
  double t = 0, reached = length;
  Two f = g;
  const auto solve = [&](const Two& v) -> Two {
    const double a1 = 1 + t * a, d1 = 1 + t * d, over = 1 / (a1 * d1 - t * b * t * b);
    return {over * (d1 * v[0] - t * b * v[1]), over * (a1 * v[1] - t * b * v[0])};
  };
  for (int i = 0; i < tuning::ellipse_rounds && reached > bound * (1 + 1e-12); ++i) {
    const Two by_mass = solve({a * f[0] + b * f[1], b * f[0] + d * f[1]});
    const double slope = f[0] * by_mass[0] + f[1] * by_mass[1];
    if (!(slope > 0)) break;
    t += std::max(0.0, (reached - bound) / bound * reached * reached / slope);
    f = solve(g);
    reached = std::sqrt(f[0] * f[0] + f[1] * f[1]);
  }
  const double scale = bound / reached;
  impulse = turned({scale * f[0], scale * ratio * f[1]}, c, -s);
  return true;
}

int FrictionEllipse::hold_in_rectangle(double bound, Two& impulse) const {
  const Two wanted = turned(impulse, cosine, sine);
  const Two held = {std::clamp(wanted[0], -bound, bound), std::clamp(wanted[1], -ratio * bound, ratio * bound)};
  impulse = turned(held, cosine, -sine);
  return (held[0] != wanted[0] ? 1 : 0) + (held[1] != wanted[1] ? 2 : 0);
}

}  // namespace atl::solver
