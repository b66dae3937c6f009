#include <collision/shapes/hull.h>
#include <jobs/hash.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "shapes/hull_build.h"
#include "shapes/text.h"

namespace atl::collision {
namespace {

// Neighbouring faces become one where the centre of one lies within this part of the extent of the other's
// plane. Corners of a flat polygon that were rounded to float lie up to 5e-8 from its plane, so the fourth
// corner of a quad up to 2e-7 from that of the other three, and the centre of the second triangle a third of that.
constexpr double merge_tolerance = 1e-7;
// Largest distance of an input point outside the hull, as part of the extent: a few times merge_tolerance, since errors
// add up along chains of merged faces.
constexpr double fit_tolerance = 1e-6;
// Thinner clouds, as part of the extent, count as flat.
constexpr double flat_tolerance = 1e-6;

// Distinct points, in order of first appearance.
std::vector<Vector3> distinct(std::span<const Vector3> points) {
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
    const Vector3& a = points[i];
    const Vector3& b = points[j];
    for (int axis = 0; axis < 3; ++axis) {
      if (a[axis] != b[axis]) return a[axis] < b[axis];
    }
    return i < j;
  });
  std::vector<std::size_t> first;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i == 0 || points[order[i]] != points[order[i - 1]]) first.push_back(order[i]);
  }
  std::sort(first.begin(), first.end());
  std::vector<Vector3> result;
  result.reserve(first.size());
  for (const std::size_t i : first) result.push_back(points[i]);
  return result;
}

template <typename Measure>
std::size_t farthest(std::span<const Vector3> points, const Measure& measure) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (measure(points[i]) > measure(points[best])) best = i;
  }
  return best;
}

// The largest distance of points from a plane through three that are far apart; the points' extent is 1.
double thickness(std::span<const Vector3> points) {
  const Vector3& a = points[farthest(points, [](const Vector3& p) { return p.squaredNorm(); })];
  const Vector3& b = points[farthest(points, [&](const Vector3& p) { return (p - a).squaredNorm(); })];
  const Vector3 along = (b - a).normalized();
  const auto across = [&](const Vector3& p) { return (p - a).cross(along).squaredNorm(); };
  const Vector3& c = points[farthest(points, across)];
  if (across(c) < flat_tolerance * flat_tolerance) return std::sqrt(across(c));
  const Vector3 normal = along.cross(c - a).normalized();
  const auto reach = [&](const Vector3& p) { return std::abs(normal.dot(p - a)); };
  return reach(points[farthest(points, reach)]);
}

std::vector<std::size_t> corners_of(const ConvexFacets& facets) {
  std::vector<std::size_t> used(facets.corners.begin(), facets.corners.end());
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  return used;
}

// The faces of a cloud of extent 1 that is not flat; a complaint where none are found. Faces of more corners than
// a hull may have are not checked. Merging with the usual tolerance fails where points lie so densely on a curved
// surface that faces merge all around it, so finer ones come next, then a coarser one for noise.
std::string find_hull(std::span<const Vector3> points, ConvexFacets& facets) {
  std::string complaint;
  Hull trial;
  for (const double tolerance : {merge_tolerance, 1e-9, 1e-12, 0.0, 1e-6}) {
    std::string problem = find_facets(points, tolerance, facets);
    if (problem.empty()) {
      if (corners_of(facets).size() > Hull::max_vertices) return {};
      if (assemble(points, facets, trial) && largest_excess(trial, points) <= fit_tolerance &&
          largest_dent(trial) <= fit_tolerance) {
        return {};
      }
      problem = "faces that do not close up";
    }
    if (complaint.empty()) complaint = problem;
  }
  return complaint;
}

template <typename T>
std::vector<T> gather(const std::vector<T>& all, const std::vector<std::size_t>& chosen) {
  std::vector<T> result;
  result.reserve(chosen.size());
  for (const std::size_t i : chosen) result.push_back(all[i]);
  return result;
}

// Faces are found for points moved to the origin and scaled to an extent of 1, which tolerances are parts of;
// the hull is made of the points as they are.
std::variant<Hull, std::string> hull_of(std::vector<Vector3> cloud, const Vector3& middle, double extent) {
  std::vector<Vector3> scaled;
  scaled.reserve(cloud.size());
  for (const Vector3& point : cloud) scaled.emplace_back((point - middle) / extent);
  const double thin = thickness(scaled);
  if (thin < flat_tolerance) {
    return text("found all points within ", thin * extent, " m of a plane, expected at least ", flat_tolerance,
                " of their extent of ", extent, " m");
  }
  ConvexFacets facets;
  std::string complaint = find_hull(scaled, facets);
  bool simplified = false;
  if (std::vector<std::size_t> used = corners_of(facets); complaint.empty() && used.size() > Hull::max_vertices) {
    cloud = gather(cloud, used);
    scaled = gather(scaled, used);
    used = choose_extreme_points(scaled);
    cloud = gather(cloud, used);
    scaled = gather(scaled, used);
    complaint = find_hull(scaled, facets);
    simplified = true;
  }
  Hull hull;
  if (complaint.empty() && !assemble(cloud, facets, hull)) complaint = "faces that do not close up";
  if (!complaint.empty()) return text("found no hull of ", cloud.size(), " points (", complaint, "), expected one");
  hull.simplified = simplified;
  hull.content = content_of(hull);
  return hull;
}

}  // namespace

std::uint64_t content_of(const Hull& hull) {
  jobs::Hash hash;
  for (const Vector3& vertex : hull.vertices) hash.add_all(vertex);
  for (const std::uint16_t vertex : hull.face_vertices) hash.add(std::uint64_t{vertex});
  return hash.value();
}

std::variant<Hull, std::string> build_hull(std::span<const Vector3> points) {
  Vector3 lower = Vector3::Constant(std::numeric_limits<double>::infinity());
  Vector3 upper = -lower;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3& p = points[i];
    if (!p.allFinite()) {
      return text("found point ", i, " at (", p.x(), ", ", p.y(), ", ", p.z(), "), expected finite coordinates");
    }
    lower = lower.cwiseMin(p);
    upper = upper.cwiseMax(p);
  }
  std::vector<Vector3> cloud = distinct(points);
  if (cloud.size() < 4) {
    return text("found ", cloud.size(), " distinct points, expected at least 4 that are not all in a plane");
  }
  // Beyond these limits products of six coordinates leave the range of double.
  const double extent = (upper - lower).maxCoeff();
  const double largest = std::max(upper.cwiseAbs().maxCoeff(), lower.cwiseAbs().maxCoeff());
  if (extent < 1e-30 || largest > 1e30) {
    return text("found points that extend over ", extent, " m up to ", largest,
                " m from the origin, expected 1e-30 to 1e30 m");
  }
  return hull_of(std::move(cloud), (lower + upper) / 2, extent);
}

}  // namespace atl::collision
