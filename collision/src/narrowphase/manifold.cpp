#include <collision/narrowphase/manifold.h>
#include <jobs/assert.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace atl::collision {
namespace {

// Index of the first point whose score is as good as the greatest, but for a tolerance and a thousandth: of
// points that are equally good, rounding doesn't choose.
template <typename Score>
int best_point(int count, double tolerance, const Score& score) {
  ATL_ASSERT(count > 0 && count <= max_points_to_reduce, count);
  ATL_ASSERT(!(tolerance < 0), tolerance);
  std::array<double, max_points_to_reduce> scores;
  double max = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < count; ++i) {
    scores[static_cast<std::size_t>(i)] = score(i);
    max = std::max(max, scores[static_cast<std::size_t>(i)]);
  }
  const double min = max - tolerance - 1e-3 * std::max(max, 0.0);
  int best = 0;
  while (best + 1 < count && !(scores[static_cast<std::size_t>(best)] >= min)) ++best;
  return best;
}

}  // namespace

Manifold as_last(const Manifold& found) {
  ATL_ASSERT(found.count >= 0 && found.count <= max_points, found.count);
  Manifold last;
  last.axis = found.axis;
  last.known = found.count > 0;
  last.normal = found.normal;
  last.reference_is_second = found.reference_is_second;
  for (int i = 0; i < found.count; ++i) {
    last.middle += found.points[static_cast<std::size_t>(i)].position / found.count;
  }
  return last;
}

void reduce_points(const Manifold::Point* points, int count, Manifold& manifold) {
  ATL_ASSERT(count >= 0, count);
  manifold.count = 0;
  count = std::min(count, max_points_to_reduce);
  const auto keep = [&](int i) { manifold.add(points[i].position, points[i].separation, points[i].id); };
  if (count <= max_points) {
    for (int i = 0; i < count; ++i) keep(i);
    return;
  }
  const auto at = [&](int i) -> const Vector3& { return points[i].position; };
  const auto from = [&](int i, int origin) { return (at(i) - at(origin)).squaredNorm(); };
  double extent = 0;
  for (int i = 1; i < count; ++i) extent = std::max(extent, from(i, 0));
  double min = points[0].separation;
  for (int i = 1; i < count; ++i) min = std::min(min, points[i].separation);
  // The tolerance for depths is small, because a shape that rests tilted by a hair must rest on its lowest points.
  const int deepest = best_point(count, 1e-5 * std::sqrt(extent), [&](int i) { return min - points[i].separation; });
  const int farthest = best_point(count, 0, [&](int i) { return from(i, deepest); });
  const Vector3 line = at(farthest) - at(deepest);
  const auto side = [&](int i) { return line.cross(at(i) - at(deepest)).dot(manifold.normal); };
  const int left = best_point(count, 0, side);
  const int right = best_point(count, 0, [&](int i) { return -side(i); });
  keep(deepest);
  keep(farthest);
  // On a line, or in a corner, a side may have no point of its own.
  const bool has_left = left != deepest && left != farthest;
  const bool has_right = right != deepest && right != farthest && right != left;
  if (has_left) keep(left);
  if (has_right) keep(right);
  if (has_left == has_right) return;
  // Three so far: the fourth is the one farthest from them all.
  const int third = has_left ? left : right;
  const int fourth = best_point(count, 0, [&](int i) {
    return std::min({from(i, deepest), from(i, farthest), from(i, third)});
  });
  if (fourth != deepest && fourth != farthest && fourth != third) keep(fourth);
}

}  // namespace atl::collision
