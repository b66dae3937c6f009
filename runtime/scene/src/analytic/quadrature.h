#pragma once

#include <array>
#include <cmath>

namespace atl::scene {

/// Integral of a smooth function from a to b, by Gauss and Legendre's rule of five points on each of `parts` parts.
template <class Function>
double integrate(const Function& f, double a, double b, int parts) {
  const double inner = std::sqrt(5 - 2 * std::sqrt(10.0 / 7)) / 3;
  const double outer = std::sqrt(5 + 2 * std::sqrt(10.0 / 7)) / 3;
  const std::array<double, 5> nodes = {-outer, -inner, 0, inner, outer};
  const double inner_weight = (322 + 13 * std::sqrt(70.0)) / 900;
  const double outer_weight = (322 - 13 * std::sqrt(70.0)) / 900;
  const std::array<double, 5> weights = {outer_weight, inner_weight, 128.0 / 225, inner_weight, outer_weight};

  const double half = (b - a) / (2 * parts);
  double sum = 0;
  for (int part = 0; part < parts; ++part) {
    const double middle = a + (2 * part + 1) * half;
    for (std::size_t i = 0; i < nodes.size(); ++i) sum += weights[i] * f(middle + half * nodes[i]);
  }
  return sum * half;
}

}  // namespace atl::scene
