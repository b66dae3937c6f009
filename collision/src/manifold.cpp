#include <collision/manifold.h>

#include <limits>

namespace atl::collision {
namespace {

// Index of the point with the greatest score; the earliest of equals.
template <typename Score>
int best_point(int count, const Score& score) {
  int best = 0;
  double best_score = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < count; ++i) {
    const double s = score(i);
    if (s > best_score) {
      best = i;
      best_score = s;
    }
  }
  return best;
}

}  // namespace

void reduce_points(const Manifold::Point* points, int count, Manifold& manifold) {
  manifold.count = 0;
  const auto keep = [&](int i) { manifold.add(points[i].position, points[i].separation, points[i].id); };
  if (count <= max_points) {
    for (int i = 0; i < count; ++i) keep(i);
    return;
  }
  const auto at = [&](int i) -> const Vector3& { return points[i].position; };
  const int deepest = best_point(count, [&](int i) { return -points[i].separation; });
  const int farthest = best_point(count, [&](int i) { return (at(i) - at(deepest)).squaredNorm(); });
  const Vector3 line = at(farthest) - at(deepest);
  const auto side = [&](int i) { return line.cross(at(i) - at(deepest)).dot(manifold.normal); };
  const int left = best_point(count, side);
  const int right = best_point(count, [&](int i) { return -side(i); });
  keep(deepest);
  keep(farthest);
  // On a line, or in a corner, a side may have no point of its own.
  if (left != deepest && left != farthest) keep(left);
  if (right != deepest && right != farthest && right != left) keep(right);
}

}  // namespace atl::collision
