#include "friction_cone.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace atl::audit {
namespace {

// The normal rows of z in falling order, and what R becomes where the next of them joins.
class SortedNormals {
 public:
  explicit SortedNormals(const PatchVector& z) : count_(z.points), sorted_(z.normal) {
    std::sort(sorted_.begin(), sorted_.begin() + static_cast<std::ptrdiff_t>(count_), std::greater<>());
    for (std::size_t i = 0; i < count_; ++i) {
      sums_[i] = (i > 0 ? sums_[i - 1] : 0) + sorted_[i];
      joins_[i] = i > 0 ? sums_[i - 1] - static_cast<double>(i) * sorted_[i] : 0;
    }
  }

  std::size_t count() const { return count_; }
  double largest() const { return sorted_[0]; }
  double join(std::size_t i) const { return joins_[i]; }

  // How many rows are above zero for a sum just above R.
  std::size_t active(double sum) const {
    std::size_t k = 1;
    while (k < count_ && joins_[k] <= sum) ++k;
    return k;
  }
  double sum_of_first(std::size_t k) const { return sums_[k - 1]; }

  // The l for which max(0, z_i + l) add up to R >= 0.
  double lift(double sum) const {
    const std::size_t k = active(sum);
    return (sum - sums_[k - 1]) / static_cast<double>(k);
  }

 private:
  std::size_t count_;
  std::array<double, 4> sorted_;
  std::array<double, 4> sums_ = {};
  std::array<double, 4> joins_ = {};
};

// R of the projection, for mu > 0 and a z outside of the polar cone.
double projected_sum(const SortedNormals& normals, double tangential, double twist, double friction) {
  const auto excess = [&](double sum) {
    return normals.lift(sum) - friction * (std::max(0.0, tangential - friction * sum) +  //
                                           std::max(0.0, twist - friction * sum));
  };
  double below = 0;  // the last breakpoint that is not past the zero
  const auto visit = [&](double breakpoint) {
    if (breakpoint > below && excess(breakpoint) <= 0) below = breakpoint;
  };
  for (std::size_t i = 1; i < normals.count(); ++i) visit(normals.join(i));
  visit(tangential / friction);
  visit(twist / friction);

  const std::size_t k = normals.active(below);
  double clamped = 0, rows = 0;
  for (const double length : {tangential, twist}) {
    if (length / friction <= below) continue;  // compared as above, so that rounding cannot tell another tale
    clamped += length;
    rows += 1;
  }
  const double n = static_cast<double>(k);
  return (normals.sum_of_first(k) + n * friction * clamped) / (1 + n * friction * friction * rows);
}

}  // namespace

double PatchVector::squared_norm() const {
  double sum = tangential.squaredNorm() + twist * twist;
  for (std::size_t i = 0; i < points; ++i) sum += normal[i] * normal[i];
  return sum;
}

PatchVector operator-(const PatchVector& a, const PatchVector& b) {
  PatchVector difference{.points = a.points, .tangential = a.tangential - b.tangential, .twist = a.twist - b.twist};
  for (std::size_t i = 0; i < a.points; ++i) difference.normal[i] = a.normal[i] - b.normal[i];
  return difference;
}

PatchVector project_on_cone(const PatchVector& z, double friction) {
  PatchVector nearest{.points = z.points};
  if (friction == 0) {
    for (std::size_t i = 0; i < z.points; ++i) nearest.normal[i] = std::max(0.0, z.normal[i]);
    return nearest;
  }
  const SortedNormals normals(z);
  const double tangential = z.tangential.norm();
  const double twist = std::abs(z.twist);
  if (normals.largest() + friction * (tangential + twist) <= 0) return nearest;  // the polar cone

  const double sum = projected_sum(normals, tangential, twist, friction);
  const double bound = friction * sum;
  const double lift = friction * (std::max(0.0, tangential - bound) + std::max(0.0, twist - bound));
  for (std::size_t i = 0; i < z.points; ++i) nearest.normal[i] = std::max(0.0, z.normal[i] + lift);
  nearest.tangential = tangential > bound ? Eigen::Vector2d(z.tangential * (bound / tangential)) : z.tangential;
  nearest.twist = std::clamp(z.twist, -bound, bound);
  return nearest;
}

}  // namespace atl::audit
