#include "friction_cone.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>

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

// A frictional part of z, and its bound.
struct Part {
  double length;
  double friction;

  double excess(double sum) const { return friction * std::max(0.0, length - friction * sum); }
};

// R of the projection, for a z outside of the polar cone. Parts without friction are not among these.
double projected_sum(const SortedNormals& normals, std::span<const Part> parts) {
  const auto excess = [&](double sum) {
    double lift = normals.lift(sum);
    for (const Part& part : parts) lift -= part.excess(sum);
    return lift;
  };
  double below = 0;  // the last breakpoint that is not past the zero
  const auto visit = [&](double breakpoint) {
    if (breakpoint > below && excess(breakpoint) <= 0) below = breakpoint;
  };
  for (std::size_t i = 1; i < normals.count(); ++i) visit(normals.join(i));
  for (const Part& part : parts) visit(part.length / part.friction);

  const double n = static_cast<double>(normals.active(below));
  double clamped = normals.sum_of_first(normals.active(below));
  double rows = 1;
  for (const Part& part : parts) {
    if (part.length / part.friction <= below) continue;  // compared as above, so that rounding cannot tell another tale
    clamped += n * part.friction * part.length;
    rows += n * part.friction * part.friction;
  }
  return clamped / rows;
}

Eigen::Vector2d clamp(const Eigen::Vector2d& z, double bound) {
  const double length = z.norm();
  return length > bound ? Eigen::Vector2d(z * (bound / length)) : z;
}

}  // namespace

double PatchVector::squared_norm() const {
  double sum = tangential.squaredNorm() + torsional * torsional + rolling.squaredNorm();
  for (std::size_t i = 0; i < points; ++i) sum += normal[i] * normal[i];
  return sum;
}

PatchVector operator-(const PatchVector& a, const PatchVector& b) {
  PatchVector difference{.points = a.points,
                         .tangential = a.tangential - b.tangential,
                         .torsional = a.torsional - b.torsional,
                         .rolling = a.rolling - b.rolling};
  for (std::size_t i = 0; i < a.points; ++i) difference.normal[i] = a.normal[i] - b.normal[i];
  return difference;
}

PatchVector project_on_cone(const PatchVector& z, const FrictionBounds& friction) {
  PatchVector nearest{.points = z.points};
  std::array<Part, 3> all;
  std::size_t count = 0;
  const auto add = [&](double length, double bound) {
    if (bound > 0) all[count++] = {length, bound};
  };
  add(z.tangential.norm(), friction.tangential);
  add(std::abs(z.torsional), friction.torsional);
  add(z.rolling.norm(), friction.rolling);
  const std::span<const Part> parts(all.data(), count);

  const SortedNormals normals(z);
  double polar = normals.largest();
  for (const Part& part : parts) polar += part.excess(0);
  if (polar <= 0) return nearest;

  const double sum = projected_sum(normals, parts);
  double lift = 0;
  for (const Part& part : parts) lift += part.excess(sum);
  for (std::size_t i = 0; i < z.points; ++i) nearest.normal[i] = std::max(0.0, z.normal[i] + lift);
  nearest.tangential = clamp(z.tangential, friction.tangential * sum);
  nearest.torsional = std::clamp(z.torsional, -friction.torsional * sum, friction.torsional * sum);
  nearest.rolling = clamp(z.rolling, friction.rolling * sum);
  return nearest;
}

}  // namespace atl::audit
