// Queries over all vertices of a hull, in lanes. For hulls of up to a few dozen vertices, which are most, that is
// faster than to walk along edges.

#include <collision/shapes/hull.h>
#include <jobs/assert.h>

#include <algorithm>
#include <array>
#include <limits>

namespace atl::collision {
namespace {

using Lanes = Eigen::Array<double, Hull::lanes, 1>;

// Calls visit(i, reaches) with how far the vertices from the ith on reach along a direction, the sums as in dot().
template <typename Visit>
void visit_reaches(const Hull& hull, const Vector3& direction, const Visit& visit) {
  const std::size_t size = hull.columns.size() / 3;
  ATL_ASSERT(size % Hull::lanes == 0 && size >= hull.vertices.size(), size, hull.vertices.size());
  const double* x = hull.columns.data();
  const double* y = x + size;
  const double* z = y + size;
  for (std::size_t i = 0; i < size; i += Hull::lanes) {
    visit(i, Lanes((direction.x() * Eigen::Map<const Lanes>(x + i) + direction.y() * Eigen::Map<const Lanes>(y + i)) +
                   direction.z() * Eigen::Map<const Lanes>(z + i)));
  }
}

}  // namespace

void Hull::find_columns() {
  const std::size_t size = (vertices.size() + lanes - 1) / lanes * lanes;
  columns.clear();
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < size; ++i) columns.push_back(vertices[std::min(i, vertices.size() - 1)][axis]);
  }
  const std::size_t plane_lanes = (planes.size() + lanes - 1) / lanes * lanes;
  plane_columns.clear();
  for (Eigen::Index column = 0; column < 4; ++column) {
    for (std::size_t i = 0; i < plane_lanes; ++i) {
      const Plane& plane = planes[std::min(i, planes.size() - 1)];
      plane_columns.push_back(column < 3 ? plane.normal[column] : plane.offset);
    }
  }
  min_reach = std::numeric_limits<double>::infinity();
  for (const Plane& plane : planes) min_reach = std::min(min_reach, plane.offset);
  if (min_reach < 0) min_reach = -std::numeric_limits<double>::infinity();
}

double Hull::reach(const Vector3& direction) const {
  Lanes max = Lanes::Constant(-std::numeric_limits<double>::infinity());
  visit_reaches(*this, direction, [&](std::size_t, const Lanes& reaches) { max = max.max(reaches); });
  return max.maxCoeff();
}

std::size_t Hull::support(const Vector3& direction) const {
  std::array<double, max_vertices + lanes> reach;
  Lanes max = Lanes::Constant(-std::numeric_limits<double>::infinity());
  visit_reaches(*this, direction, [&](std::size_t i, const Lanes& reaches) {
    max = max.max(reaches);
    Eigen::Map<Lanes>(reach.data() + i) = reaches;
  });
  const double farthest = max.maxCoeff();
  std::size_t best = 0;
  while (best + 1 < vertices.size() && reach[best] != farthest) ++best;
  return best;
}

}  // namespace atl::collision
