#include "gauss_seidel.h"

#include <algorithm>
#include <cmath>

namespace atl::reference {
namespace {

// One patch against the velocities as they stand.
class PatchSolve {
 public:
  PatchSolve(const ContactRows& rows, const PatchRows& patch, Eigen::VectorXd& velocities, Eigen::VectorXd& impulses)
      : rows_(rows), patch_(patch), velocities_(velocities), impulses_(impulses) {}

  void run() {
    double sum = 0;
    for (int i = 0; i < patch_.points; ++i) {
      const double old = impulse(i);
      change(i, std::max(0.0, old - speed(i) / response(i, i)) - old);
      sum += impulse(i);
    }
    if (patch_.slides) slide(patch_.friction * sum);
    if (patch_.twists) {
      const int i = patch_.points + 2;
      const double bound = patch_.friction * sum;
      change(i, std::clamp(impulse(i) - speed(i) / response(i, i), -bound, bound) - impulse(i));
    }
  }

 private:
  double& impulse(int i) { return impulses_[patch_.first_row + i]; }

  double speed(int i) const {
    double u = rows_.offset[patch_.first_row + i];
    for (std::size_t side = 0; side < 2; ++side) {
      if (patch_.body[side] == PatchRows::none) continue;
      u += patch_.j[side].row(i).dot(velocities_.segment<6>(6 * patch_.body[side]));
    }
    return u;
  }

  double response(int i, int k) const {
    double w = 0;
    for (std::size_t side = 0; side < 2; ++side) w += patch_.j[side].row(i).dot(patch_.apply[side].col(k));
    return w;
  }

  void change(int i, double by) {
    if (by == 0) return;
    impulse(i) += by;
    for (std::size_t side = 0; side < 2; ++side) {
      if (patch_.body[side] == PatchRows::none) continue;
      velocities_.segment<6>(6 * patch_.body[side]) += by * patch_.apply[side].col(i);
    }
  }

  // A step against the slip as long as the stiffer direction bears, and back onto the disc.
  void slide(double bound) {
    const int i = patch_.points, k = i + 1;
    const double a = response(i, i), b = response(i, k), c = response(k, k);
    const double stiffest = (a + c) / 2 + std::hypot((a - c) / 2, b);
    const double x = impulse(i) - speed(i) / stiffest;
    const double y = impulse(k) - speed(k) / stiffest;
    const double length = std::hypot(x, y);
    const double scale = length > bound ? bound / length : 1;
    change(i, scale * x - impulse(i));
    change(k, scale * y - impulse(k));
  }

  const ContactRows& rows_;
  const PatchRows& patch_;
  Eigen::VectorXd& velocities_;
  Eigen::VectorXd& impulses_;
};

}  // namespace

void sweep_gauss_seidel(const ContactRows& rows, Eigen::VectorXd& impulses, int sweeps) {
  Eigen::VectorXd velocities = rows.velocities(impulses);
  for (int i = 0; i < sweeps; ++i) {
    for (const PatchRows& patch : rows.patches) PatchSolve(rows, patch, velocities, impulses).run();
  }
}

}  // namespace atl::reference
