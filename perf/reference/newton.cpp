#include "newton.h"

#include <algorithm>
#include <cmath>

namespace atl::reference {

using Vector7 = Eigen::Matrix<double, 7, 1>;
using Matrix7 = Eigen::Matrix<double, 7, 7>;

// F of one patch, and its derivatives by the patch's u and r.
struct NewtonSolver::Linearisation {
  Vector7 f = Vector7::Zero();
  Matrix7 by_u = Matrix7::Zero();
  Matrix7 by_r = Matrix7::Zero();
};

NewtonSolver::Linearisation NewtonSolver::linearise(const PatchRows& patch, const Eigen::VectorXd& impulses,
                                                    const Eigen::VectorXd& u_all) const {
  Linearisation l;
  const int n = patch.points;
  const double m = patch.mass;
  const auto r = impulses.segment(patch.first_row, patch.rows());
  const auto u = u_all.segment(patch.first_row, patch.rows());
  for (int i = 0; i < n; ++i) {
    if (r[i] - m * u[i] > 0) {
      l.f[i] = u[i];
      l.by_u(i, i) = 1;
    } else {
      l.f[i] = r[i] / m;
      l.by_r(i, i) = 1 / m;
    }
  }
  if (!patch.slides) return l;

  const double sum = r.head(n).sum();
  const double bound = patch.friction * std::max(0.0, sum);
  // Change of the bound per impulse at any of the points.
  const double opens = sum >= 0 ? patch.friction : 0;

  const Eigen::Vector2d z = r.segment<2>(n) - m * u.segment<2>(n);
  const double length = z.norm();
  if (length <= bound && bound > 0) {
    l.f.segment<2>(n) = u.segment<2>(n);
    l.by_u.block<2, 2>(n, n).setIdentity();
  } else {
    const Eigen::Vector2d along = length > 0 ? Eigen::Vector2d(z / length) : Eigen::Vector2d::Zero();
    const Eigen::Matrix2d turn =
        length > 0 ? Eigen::Matrix2d(bound / length * (Eigen::Matrix2d::Identity() - along * along.transpose()))
                   : Eigen::Matrix2d::Zero();
    l.f.segment<2>(n) = (r.segment<2>(n) - bound * along) / m;
    l.by_r.block<2, 2>(n, n) = (Eigen::Matrix2d::Identity() - turn) / m;
    l.by_u.block<2, 2>(n, n) = turn;
    for (int i = 0; i < n; ++i) l.by_r.block<2, 1>(n, i) = -opens / m * along;
  }
  if (!patch.twists) return l;

  const int t = n + 2;
  const double z_twist = r[t] - m * u[t];
  if (std::abs(z_twist) <= bound && bound > 0) {
    l.f[t] = u[t];
    l.by_u(t, t) = 1;
  } else {
    const double along = z_twist > 0 ? 1 : z_twist < 0 ? -1 : 0;
    l.f[t] = (r[t] - bound * along) / m;
    l.by_r(t, t) = 1 / m;
    for (int i = 0; i < n; ++i) l.by_r(t, i) = -opens / m * along;
  }
  return l;
}

NewtonSolver::NewtonSolver(const ContactRows& rows) : rows_(rows) {}

double NewtonSolver::error(const Eigen::VectorXd& impulses) const {
  const Eigen::VectorXd u = rows_.relative_velocities(rows_.velocities(impulses));
  double sum = 0;
  for (const PatchRows& patch : rows_.patches) sum += linearise(patch, impulses, u).f.squaredNorm();
  return std::sqrt(sum);
}

bool NewtonSolver::step(const Eigen::VectorXd& impulses, double proximal, Eigen::VectorXd& change) {
  const Eigen::VectorXd u = rows_.relative_velocities(rows_.velocities(impulses));
  const int bodies = static_cast<int>(rows_.free.size());
  const int size = bodies + rows_.rows;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(size);

  // dv - M^-1 J^T dr = 0 above, dF = -F below. Zeros are entered too, so that the pattern never changes.
  entries_.clear();
  for (int i = 0; i < bodies; ++i) entries_.emplace_back(i, i, 1);
  for (const PatchRows& patch : rows_.patches) {
    const Linearisation l = linearise(patch, impulses, u);
    const int n = patch.rows();
    const int at = bodies + patch.first_row;
    right.segment(at, n) = -l.f.head(n);
    for (std::size_t side = 0; side < 2; ++side) {
      if (patch.body[side] == PatchRows::none) continue;
      const int body = 6 * patch.body[side];
      const Eigen::Matrix<double, 7, 6> down = l.by_u * patch.j[side];
      for (int i = 0; i < n; ++i) {
        for (int k = 0; k < 6; ++k) {
          entries_.emplace_back(body + k, at + i, -patch.apply[side](k, i));
          entries_.emplace_back(at + i, body + k, down(i, k));
        }
      }
    }
    const Matrix7 direct = l.by_r + proximal / patch.mass * l.by_u;
    for (int i = 0; i < n; ++i) {
      for (int k = 0; k < n; ++k) entries_.emplace_back(at + i, at + k, direct(i, k));
    }
  }
  Eigen::SparseMatrix<double> matrix(size, size);
  matrix.setFromTriplets(entries_.begin(), entries_.end());
  if (!analysed_) {
    factors_.analyzePattern(matrix);
    analysed_ = true;
  }
  factors_.factorize(matrix);
  if (factors_.info() != Eigen::Success) return false;
  change = factors_.solve(right).tail(rows_.rows);
  return change.allFinite();
}

}  // namespace atl::reference
