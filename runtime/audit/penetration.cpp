#include <algorithm>
#include <cstddef>
#include <utility>
#include <variant>
#include <vector>

#include "placed.h"

namespace atl {
namespace {

using audit::Placed;

/// Overlap up to this counts as touching.
constexpr double touching = 10e-6;

/// A bounded shape on its way through the sweep.
struct Entry {
  Vector3 low, high;  ///< world-frame bounds
  Placed shape;
  double bounding_radius;  ///< m
  bool dynamic;
  std::size_t place;  ///< among the shapes
};

Entry make_entry(const PlacedShape& from, std::size_t place) {
  Placed shape = audit::place(from);
  const Eigen::AlignedBox3d bounds = audit::bounds_of(shape);
  return {.low = bounds.min(),
          .high = bounds.max(),
          .shape = std::move(shape),
          .bounding_radius = audit::bounding_radius(from.shape),
          .dynamic = from.type == BodyType::Dynamic,
          .place = place};
}

/// The axis along which the centres have the largest variance.
int sweep_axis(const std::vector<Entry>& entries) {
  Vector3 mean = Vector3::Zero();
  for (const Entry& entry : entries) mean += (entry.low + entry.high) / 2;
  mean /= std::max<double>(1, static_cast<double>(entries.size()));
  Vector3 variance = Vector3::Zero();
  for (const Entry& entry : entries) variance += ((entry.low + entry.high) / 2 - mean).cwiseAbs2();
  int axis = 0;
  variance.maxCoeff(&axis);
  return axis;
}

/// Depths of the overlapping pairs, in a fixed order.
class Tally {
 public:
  void add(double depth, double smaller_radius) {
    if (depth <= touching) return;
    depths_.push_back(depth);
    max_relative_ = std::max(max_relative_, depth / smaller_radius);
  }

  PenetrationReport report() && {
    PenetrationReport report{.max_relative = max_relative_, .pairs = depths_.size()};
    if (depths_.empty()) return report;
    for (double depth : depths_) report.mean += depth;
    report.mean /= static_cast<double>(depths_.size());
    std::sort(depths_.begin(), depths_.end());
    report.max = depths_.back();
    const std::size_t rank = (depths_.size() * 99 + 99) / 100;  // nearest rank: ceil(0.99 n)
    report.p99 = depths_[rank - 1];
    return report;
  }

 private:
  std::vector<double> depths_;
  double max_relative_ = 0;
};

/// Sorts by the lower bound on the axis and hands every pair whose bounds overlap to `visit`.
template <class Visit>
void sweep(std::vector<Entry>& entries, const Visit& visit) {
  const int axis = sweep_axis(entries);
  std::stable_sort(entries.begin(), entries.end(),
                   [axis](const Entry& a, const Entry& b) { return a.low[axis] < b.low[axis]; });
  for (auto a = entries.begin(); a != entries.end(); ++a) {
    for (auto b = a + 1; b != entries.end() && b->low[axis] <= a->high[axis]; ++b) {
      if ((a->low.array() <= b->high.array()).all() && (b->low.array() <= a->high.array()).all()) visit(*a, *b);
    }
  }
}

}  // namespace

PenetrationReport measure_penetration(std::span<const PlacedShape> shapes, const MayTouch& may_touch) {
  struct Ground {
    Placed shape;
    std::size_t place;
  };
  std::vector<Entry> entries;
  std::vector<Ground> grounds;
  entries.reserve(shapes.size());
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    // Both are solid without bounds below.
    if (std::holds_alternative<HalfSpace>(shapes[i].shape) || std::holds_alternative<HeightField>(shapes[i].shape)) {
      grounds.push_back({audit::place(shapes[i]), i});
      continue;
    }
    Entry entry = make_entry(shapes[i], i);
    // A body that is not finite overlaps nothing and would break the sort; the step's report names it.
    if (entry.low.allFinite() && entry.high.allFinite()) entries.push_back(std::move(entry));
  }

  const auto counts = [&](std::size_t a, std::size_t b) { return !may_touch || may_touch(a, b); };
  Tally tally;
  for (const Entry& entry : entries) {
    if (!entry.dynamic) continue;
    for (const Ground& ground : grounds) {
      if (counts(entry.place, ground.place))
        tally.add(audit::overlap(entry.shape, ground.shape), entry.bounding_radius);
    }
  }
  sweep(entries, [&](const Entry& a, const Entry& b) {
    if ((!a.dynamic && !b.dynamic) || !counts(a.place, b.place)) return;
    tally.add(audit::overlap(a.shape, b.shape), std::min(a.bounding_radius, b.bounding_radius));
  });
  return std::move(tally).report();
}

}  // namespace atl
