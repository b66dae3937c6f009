#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "curve.h"
#include "placed.h"

// The least translation that parts two solids, or minus their distance, is the least overlap over all directions. As a
// function of the direction the overlap bends sharply where a flat face, an edge or the side of a cylinder or cone
// looks that way, or the cone of a tapered capsule: face normals are tried one by one, and those of edges and sides
// searched along their curves. Elsewhere it is smooth, and what was found is improved by a search that only compares
// values, from some more starts as well. Every value is that of a real direction, so the result can only be too large.

namespace atl::audit {
namespace {

template <class Other>
class SmoothSearch {
 public:
  SmoothSearch(const Other& a, const Smooth& b, const Vector3& offset) : a_(a), b_(b), offset_(offset) {}

  double overlap(const Vector3& normal) const { return reach(a_, normal) + reach(b_, -normal) - normal.dot(offset_); }

  void offer(const Vector3& normal) {
    const double depth = overlap(normal);
    if (depth < min_.depth) min_ = {depth, normal};
  }

  /// Directions centre + cos(t) x + sin(t) y, t in [0, angle].
  void search_along(const Curve& curve) {
    constexpr double widest_step = 0.05;  // rad
    const int steps = std::max(4, static_cast<int>(std::ceil(curve.angle / widest_step)));
    const double step = curve.angle / steps;
    const auto value = [&](double t) { return overlap(curve.at(t).normalized()); };
    std::vector<double> values;
    for (int i = 0; i <= steps; ++i) values.push_back(value(step * i));
    for (int i = 0; i <= steps; ++i) {
      const int before = std::max(i - 1, 0);
      const int after = std::min(i + 1, steps);
      const auto at = [&](int k) { return values[static_cast<std::size_t>(k)]; };
      if (at(before) < at(i) || at(after) < at(i)) continue;
      offer(curve.at(step * i).normalized());
      offer(curve.at(golden_section(step * before, step * after, value)).normalized());
    }
  }
  void search_circle(const Vector3& axis, double along) {
    const Vector3 x = any_across(axis);
    const double across = std::sqrt(std::max(0.0, 1 - along * along));
    search_along({along * axis, across * x, across * axis.cross(x), 2 * std::numbers::pi});
  }

  /// Compares with directions around, ever closer ones, which turn so that a sharp bend hides from few.
  void improve(Vector3 normal) {
    constexpr double golden_angle = 2.399963229728653;
    constexpr int around = 8;
    constexpr double last_step = 1e-10;  // rad
    double best = overlap(normal);
    double turn = 0;
    for (double step = 0.3; step > last_step; turn += golden_angle) {
      const Vector3 x = any_across(normal);
      const Vector3 y = normal.cross(x);
      Vector3 next = normal;
      for (int i = 0; i < around; ++i) {
        const double angle = turn + 2 * std::numbers::pi * i / around;
        const Vector3 tried = (normal + step * (std::cos(angle) * x + std::sin(angle) * y)).normalized();
        const double depth = overlap(tried);
        if (!(depth < best)) continue;
        best = depth;
        next = tried;
      }
      step *= next == normal ? 0.6 : 1.2;
      normal = next;
    }
    offer(normal);
  }

  /// From what was found so far, and from directions all around.
  Penetration finish() {
    if (min_.depth < std::numeric_limits<double>::infinity()) improve(min_.normal);
    if (offset_.squaredNorm() > 0) improve(offset_.normalized());
    // Apart there is but one minimum.
    if (min_.depth <= 0) return min_;
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        for (int z = -1; z <= 1; ++z) {
          if (x != 0 || y != 0 || z != 0) improve(Vector3(x, y, z).normalized());
        }
      }
    }
    return min_;
  }

 private:
  const Other& a_;
  const Smooth& b_;
  Vector3 offset_;
  Penetration min_{std::numeric_limits<double>::infinity(), Vector3::UnitZ()};
};

// The direction in which one ball of a tapered capsule takes over from the other; `sign` is 1 out of a, -1 out of b.
template <class Other>
void search_cone(SmoothSearch<Other>& search, const Smooth& solid, double sign) {
  const double length = solid.half.norm();
  if (!(length > 0)) return;
  search.search_circle(solid.half / length, sign * (solid.radii[0] - solid.radii[1]) / (2 * length));
}

}  // namespace

Penetration penetration(const Polytope& a, const Smooth& b, const Vector3& offset) {
  SmoothSearch<Polytope> search(a, b, offset);
  for (const Vector3& normal : a.normals) search.offer(normal);
  for (const Polytope::Edge& edge : a.edges) search.search_along({Vector3::Zero(), edge.from, edge.toward, edge.angle});
  if (a.is_segment()) search.search_circle((a.vertices[1] - a.vertices[0]).normalized(), 0);
  search_cone(search, b, -1);
  return search.finish();
}

Penetration penetration(const Revolved& a, const Smooth& b, const Vector3& offset) {
  SmoothSearch<Revolved> search(a, b, offset);
  search.offer(-a.axis);
  if (!a.is_cone) search.offer(a.axis);
  search.search_circle(a.axis, a.side_sine());
  search_cone(search, b, -1);
  return search.finish();
}

Penetration penetration(const Smooth& a, const Smooth& b, const Vector3& offset) {
  SmoothSearch<Smooth> search(a, b, offset);
  search_cone(search, a, 1);
  search_cone(search, b, -1);
  return search.finish();
}

}  // namespace atl::audit
