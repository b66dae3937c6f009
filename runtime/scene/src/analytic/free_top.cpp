#include "free_top.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "quadrature.h"

namespace atl::scene {
namespace {

bool is_cyclic(const std::array<int, 3>& axes) { return (axes[0] + 1) % 3 == axes[1]; }

}  // namespace

// Arithmetic-geometric mean: Abramowitz and Stegun, "Handbook of Mathematical Functions", 16.4.
Jacobi jacobi(double argument, double modulus) {
  constexpr int max = 16;  // converges quadratically: 6 do for all but moduli next to 1
  std::array<double, max> a = {}, c = {};
  a[0] = 1;
  c[0] = modulus;
  double b = std::sqrt((1 - modulus) * (1 + modulus));
  int n = 0;
  while (n + 1 < max && std::abs(c[n]) > 1e-17 * a[n]) {
    a[n + 1] = (a[n] + b) / 2;
    c[n + 1] = (a[n] - b) / 2;
    b = std::sqrt(a[n] * b);
    ++n;
  }
  double phi = std::ldexp(a[n] * argument, n);
  for (; n > 0; --n) {
    phi = (phi + std::asin(std::clamp(c[n] / a[n] * std::sin(phi), -1.0, 1.0))) / 2;
  }
  const double sn = std::sin(phi), cn = std::cos(phi);
  // 1 - k^2 sn^2 as a sum of positive terms, which loses no digits next to k = 1.
  return {sn, cn, std::sqrt(cn * cn + (1 - modulus) * (1 + modulus) * sn * sn)};
}

FreeTop::FreeTop(const Vector3& moments, const Vector3& spin, const Quaternion& orientation) : moments_(moments) {
  const Vector3 momentum = moments.cwiseProduct(spin);
  momentum_ = momentum.norm();
  twice_energy_ = momentum.dot(spin);
  axes_ = {0, 1, 2};
  std::sort(axes_.begin(), axes_.end(), [&](int a, int b) { return moments[a] < moments[b]; });
  // Landau and Lifshitz's 1, 2, 3, or 3, 2, 1 where the momentum goes around the axis of the least moment.
  if (momentum_ * momentum_ < twice_energy_ * moments[axes_[1]]) std::swap(axes_[0], axes_[2]);

  const double i1 = moments[axes_[0]], i2 = moments[axes_[1]], i3 = moments[axes_[2]];
  const double square = momentum_ * momentum_;
  const double min = twice_energy_ * i3 - square, max = square - twice_energy_ * i1;
  amplitudes_ = {std::sqrt(std::max(0.0, min / (i1 * (i3 - i1)))), std::sqrt(std::max(0.0, min / (i2 * (i3 - i2)))),
                 std::sqrt(max / (i3 * (i3 - i1)))};
  rate_ = std::sqrt((i3 - i2) * max / (i1 * i2 * i3));
  modulus_ = std::sqrt(std::max(0.0, (i2 - i1) * min / ((i3 - i2) * max)));

  // Euler's equations, (I2 - I3) w2 w3 and so on, fix the product of the three signs; cn and sn come in both, dn in
  // one.
  const double sign = spin[axes_[2]] < 0 ? -1 : 1;
  amplitudes_[2] *= sign;
  amplitudes_[1] *= is_cyclic(axes_) == (i1 < i3) ? sign : -sign;
  if (amplitudes_[0] > 0) {
    argument_ = std::ellint_1(modulus_, std::atan2(spin[axes_[1]] / amplitudes_[1], spin[axes_[0]] / amplitudes_[0]));
  }
  typical_rate_ = momentum_ / moments.minCoeff();
  to_space_ = orientation.normalized() * Quaternion(relative_to_momentum(spin)).conjugate();
}

Vector3 FreeTop::spin(double time) const {
  const Jacobi at = jacobi(argument_ + rate_ * time, modulus_);
  Vector3 spin;
  spin[axes_[0]] = amplitudes_[0] * at.cn;
  spin[axes_[1]] = amplitudes_[1] * at.sn;
  spin[axes_[2]] = amplitudes_[2] * at.dn;
  return spin;
}

// Precession about the momentum of the axis that the momentum never points along: L (2 E - I w^2) / (L^2 - I^2 w^2).
double FreeTop::precession_rate(double time) const {
  const double moment = moments_[axes_[0]];
  const double rate = spin(time)[axes_[0]];
  return momentum_ * (twice_energy_ - moment * rate * rate) / (momentum_ * momentum_ - moment * moment * rate * rate);
}

// From the body to the frame with z along the angular momentum and x towards that axis.
Matrix3 FreeTop::relative_to_momentum(const Vector3& spin) const {
  const Vector3 z = moments_.cwiseProduct(spin).normalized();
  const Vector3 axis = Vector3::Unit(axes_[0]);
  const Vector3 x = (axis - axis.dot(z) * z).normalized();
  Matrix3 rotation;
  rotation.row(0) = x;
  rotation.row(1) = z.cross(x);
  rotation.row(2) = z;
  return rotation;
}

Quaternion FreeTop::orientation(double time) {
  const int parts = 1 + static_cast<int>(10 * typical_rate_ * (time - time_));
  angle_ += integrate([this](double at) { return precession_rate(at); }, time_, time, parts);
  time_ = time;
  return to_space_ * Quaternion(Eigen::AngleAxisd(angle_, Vector3::UnitZ())) *
         Quaternion(relative_to_momentum(spin(time)));
}

}  // namespace atl::scene
