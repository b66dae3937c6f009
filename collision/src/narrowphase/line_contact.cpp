#include "narrowphase/line_contact.h"

#include <collision/narrowphase/feature_id.h>

#include <algorithm>
#include <cmath>

namespace atl::collision {
namespace {

constexpr double parallel_sine = 0.05;

struct LineParameters {
  double first, second;  // m, from the middles
};

// Closest points of two segments about their middles, along unit directions u and v; w leads from the first's
// middle to the second's (Ericson, "Real-Time Collision Detection", 2005, section 5.1.9).
LineParameters closest_on_segments(const Vector3& u, double half_u, const Vector3& v, double half_v, const Vector3& w) {
  const double b = u.dot(v);
  const double c = u.dot(w);
  const double f = v.dot(w);
  const double sine_squared = std::max(0.0, 1 - b * b);
  double s = 0;
  if (sine_squared > 1e-12) {
    s = std::clamp((c - b * f) / sine_squared, -half_u, half_u);
  } else {
    // Parallel: the middle of what they have in common.
    const double low = std::max(-half_u, c - half_v);
    const double high = std::min(half_u, c + half_v);
    s = std::clamp(0.5 * (low + high), -half_u, half_u);
  }
  const double t = std::clamp(b * s - f, -half_v, half_v);
  return {std::clamp(b * t + c, -half_u, half_u), t};
}

}  // namespace

bool line_points(const SurfaceLine& first, const SurfaceLine& second, const Vector3& normal, double margin,
                 Manifold& manifold) {
  Vector3 u = first.head - first.tail;
  const double length = u.norm();
  const Vector3 v = second.head - second.tail;
  if (!(length > 0) || !(u.cross(v).norm() < parallel_sine * length * v.norm())) return false;
  u /= length;
  const double tail = u.dot(second.tail - first.tail);
  const double head = u.dot(second.head - first.tail);
  const double slack = 1e-3 * std::min(length, std::abs(head - tail));
  if (std::min(tail, head) > length - slack || std::max(tail, head) < slack || !(slack > 0)) return false;
  const auto at = [&](double s) { return Vector3(second.tail + std::clamp((s - tail) / (head - tail), 0.0, 1.0) * v); };
  double from = tail < -slack || tail > length + slack ? std::clamp(tail, 0.0, length) : tail;
  double to = head < -slack || head > length + slack ? std::clamp(head, 0.0, length) : head;
  const auto aside = [&](double s) { return normal.cross(u).dot(at(s) - first.tail); };
  const double aside_from = aside(from);
  const double aside_to = aside(to);
  if (std::max(std::abs(aside_from), std::abs(aside_to)) > first.width) {
    const double slope = (aside_to - aside_from) / (to - from);
    const double middle = from - aside_from / slope;
    const double reach = std::abs(first.width / slope);
    const auto inside = [&](double s) { return std::clamp(s, middle - reach, middle + reach); };
    const double low = std::min(from, to);
    const double high = std::max(from, to);
    if (!(inside(low) <= high && inside(high) >= low) || !std::isfinite(middle)) return false;
    from = inside(from);
    to = inside(to);
    if (!(std::abs(to - from) > slack)) return false;
  }
  manifold.reference_is_second = false;
  manifold.normal = normal;
  int place = 1;
  for (const double s : {from, to}) {
    const Vector3 position = at(s);
    const double separation = normal.dot(position - (first.tail + s * u));
    const FeatureId id = feature_pair_id(first.kind, first.number, second.kind, second.number, place++);
    if (separation <= margin) manifold.add(position, separation, id);
  }
  return manifold.count > 0;
}

void collide_capsules(const Shape& first, const Shape& second, const Pose& pose, double margin, Manifold& manifold) {
  const Vector3 u = Vector3::UnitZ();
  const Vector3 v = pose.orientation * Vector3::UnitZ();
  if (!pose.position.allFinite() || !v.allFinite()) return;
  const LineParameters closest = closest_on_segments(u, first.half_height, v, second.half_height, pose.position);
  const Vector3 on_second = pose.position + closest.second * v;
  const Vector3 offset = on_second - closest.first * u;
  const double distance = offset.norm();
  const double radii = first.radius + second.radius;
  const double separation = distance - radii;
  if (!(separation <= margin)) return;

  Vector3 normal;
  if (distance > 1e-12 * radii) {
    normal = offset / distance;
  } else {
    // The segments cross, or lie in one another: out across both.
    const Vector3 cross = u.cross(v);
    normal = cross.norm() > 1e-6 ? Vector3(cross.normalized()) : v.unitOrthogonal();
  }
  const double height_first = first.half_height;
  const double height_second = second.half_height;
  const SurfaceLine line_first{first.radius * normal - height_first * u, first.radius * normal + height_first * u, 2,
                               0};
  const Vector3 middle = pose.position - second.radius * normal;
  const SurfaceLine line_second{middle - height_second * v, middle + height_second * v, 2, 0};
  // Beyond an end the normal leans, and there is but one point.
  const bool across = std::abs(normal.dot(u)) < parallel_sine && std::abs(normal.dot(v)) < parallel_sine;
  if (across && line_points(line_first, line_second, normal, margin, manifold)) return;
  manifold.reference_is_second = false;
  manifold.normal = normal;
  manifold.add(on_second - second.radius * normal, separation, single_point_id());
}

}  // namespace atl::collision
