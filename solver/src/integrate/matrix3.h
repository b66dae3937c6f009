#pragma once

#include <solver/integrate/motion_locks.h>

// Products of 3 x 3 matrices, number by number. Eigen's go by pairs of numbers, and what is stored in pairs and loaded
// one by one, or the other way round, is waited for: with these a chain is solved in three quarters of the time.

namespace atl::solver {

inline Vector3 product(const Matrix3& m, const Vector3& v) {
  return {m(0, 0) * v[0] + m(0, 1) * v[1] + m(0, 2) * v[2], m(1, 0) * v[0] + m(1, 1) * v[1] + m(1, 2) * v[2],
          m(2, 0) * v[0] + m(2, 1) * v[1] + m(2, 2) * v[2]};
}

inline Matrix3 product(const Matrix3& a, const Matrix3& b) {
  Matrix3 m;
  for (int k = 0; k < 3; ++k) {
    for (int i = 0; i < 3; ++i) m(i, k) = a(i, 0) * b(0, k) + a(i, 1) * b(1, k) + a(i, 2) * b(2, k);
  }
  return m;
}

/// a b^T, which is symmetric.
inline Matrix3 symmetric_product(const Matrix3& a, const Matrix3& b) {
  Matrix3 m;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k <= i; ++k) m(i, k) = m(k, i) = a(i, 0) * b(k, 0) + a(i, 1) * b(k, 1) + a(i, 2) * b(k, 2);
  }
  return m;
}

inline Matrix3 symmetric_inverse(const Matrix3& m) {
  const double xx = m(1, 1) * m(2, 2) - m(2, 1) * m(2, 1);
  const double yx = m(2, 0) * m(2, 1) - m(1, 0) * m(2, 2);
  const double zx = m(1, 0) * m(2, 1) - m(2, 0) * m(1, 1);
  const double yy = m(0, 0) * m(2, 2) - m(2, 0) * m(2, 0);
  const double zy = m(1, 0) * m(2, 0) - m(0, 0) * m(2, 1);
  const double zz = m(0, 0) * m(1, 1) - m(1, 0) * m(1, 0);
  const double over = 1 / (m(0, 0) * xx + m(1, 0) * yx + m(2, 0) * zx);
  Matrix3 inverse;
  inverse(0, 0) = over * xx;
  inverse(1, 0) = inverse(0, 1) = over * yx;
  inverse(2, 0) = inverse(0, 2) = over * zx;
  inverse(1, 1) = over * yy;
  inverse(2, 1) = inverse(1, 2) = over * zy;
  inverse(2, 2) = over * zz;
  return inverse;
}

/// The same on the axes that a body may turn about, and zero on the others.
inline Matrix3 inverse_inertia_with(std::uint8_t locks, const Matrix3& inertia) {
  const unsigned locked = angular_locks(locks);
  return locked == 0 ? symmetric_inverse(inertia) : inverse_on_free_axes(locked, inertia);
}

/// to += scale * from.
inline void add_scaled(Matrix3& to, double scale, const Matrix3& from) {
  for (int k = 0; k < 3; ++k) {
    for (int i = 0; i < 3; ++i) to(i, k) += scale * from(i, k);
  }
}

/// [arm] times a matrix: the cross product with each column.
inline Matrix3 crossed(const Vector3& arm, const Matrix3& m) {
  Matrix3 result;
  for (int k = 0; k < 3; ++k) {
    result(0, k) = arm[1] * m(2, k) - arm[2] * m(1, k);
    result(1, k) = arm[2] * m(0, k) - arm[0] * m(2, k);
    result(2, k) = arm[0] * m(1, k) - arm[1] * m(0, k);
  }
  return result;
}

/// [arm] times the transpose of a matrix.
inline Matrix3 crossed_transpose(const Vector3& arm, const Matrix3& m) {
  Matrix3 result;
  for (int k = 0; k < 3; ++k) {
    result(0, k) = arm[1] * m(k, 2) - arm[2] * m(k, 1);
    result(1, k) = arm[2] * m(k, 0) - arm[0] * m(k, 2);
    result(2, k) = arm[0] * m(k, 1) - arm[1] * m(k, 0);
  }
  return result;
}

}  // namespace atl::solver
