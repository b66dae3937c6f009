#include <collision/narrowphase/distance.h>

#include <algorithm>

#include "narrowphase/convex_core.h"
#include "narrowphase/gjk.h"
#include "narrowphase/point_distance.h"

namespace atl::collision {
namespace {

// Closest points of two segments through their middles (after Ericson, "Real-Time Collision Detection", 5.1.9):
// s * z, and middle + t * axis.
void segment_segment(double half_first, double half_second, const Vector3& middle, const Vector3& axis,
                     Vector3& on_first, Vector3& on_second) {
  const double cosine = axis.z();
  const double sine_square = axis.x() * axis.x() + axis.y() * axis.y();
  const double across = middle.x() * axis.x() + middle.y() * axis.y();
  // For parallel segments any s will do: the clamps that follow correct it.
  double s = sine_square > 1e-24 ? middle.z() - across * cosine / sine_square : 0;
  s = std::clamp(s, -half_first, half_first);
  const double t = std::clamp((s - middle.z()) * cosine - across, -half_second, half_second);
  s = std::clamp(middle.z() + t * cosine, -half_first, half_first);
  on_first = Vector3(0, 0, s);
  on_second = middle + t * axis;
}

// Adds the radii to cores at a distance along a unit normal.
ClosestPoints around_cores(double core_distance, const Vector3& on_first, const Vector3& on_second,
                           const Vector3& normal, double radius_first, double radius_second) {
  ClosestPoints result;
  result.distance = std::max(0.0, core_distance - radius_first - radius_second);
  result.on_first = on_first + radius_first * normal;
  result.on_second = on_second - radius_second * normal;
  result.normal = normal;
  return result;
}

ClosestPoints between_points(const Vector3& on_first, const Vector3& on_second, double radius_first,
                             double radius_second) {
  const Vector3 apart = on_second - on_first;
  const double distance = apart.norm();
  const Vector3 normal = distance > 0 ? Vector3(apart / distance) : Vector3::UnitZ();
  return around_cores(distance, on_first, on_second, normal, radius_first, radius_second);
}

ClosestPoints closest_points_of(const ConvexCore& first, const ConvexCore& second, const Placement& place) {
  using Kind = ConvexCore::Kind;
  if (second.kind == Kind::Point && has_closest_point(first)) {
    return between_points(closest_point(first, place.position), place.position, first.radius, second.radius);
  }
  if (first.kind == Kind::Point && has_closest_point(second)) {
    // The distance is taken from the difference in the second's own frame, which is zero for a point inside.
    const Vector3 seen = place.rotation.transpose() * -place.position;
    const Vector3 on_second = place.rotation * (closest_point(second, seen) - seen);
    return between_points(Vector3::Zero(), on_second, first.radius, second.radius);
  }
  if (first.kind == Kind::Segment && second.kind == Kind::Segment) {
    Vector3 on_first;
    Vector3 on_second;
    segment_segment(first.half_height, second.half_height, place.position, place.rotation.col(2), on_first, on_second);
    return between_points(on_first, on_second, first.radius, second.radius);
  }
  const Vector3 guess =
      second.kind == Kind::Triangle ? closest_point_of_triangle(second.triangle, Vector3::Zero()) : place.position;
  const GjkResult found = gjk_distance(first, second, place, guess);
  return around_cores(found.distance, found.on_first, found.on_second, found.normal, first.radius, second.radius);
}

}  // namespace

ClosestPoints closest_points(const Shape& first_shape, const Shape& second_shape, const Pose& second) {
  const Placement place{second.position, second.orientation.toRotationMatrix()};
  return closest_points_of(ConvexCore::of(first_shape), ConvexCore::of(second_shape), place);
}

ClosestPoints closest_points(const Shape& first_shape, const std::array<Vector3, 3>& triangle) {
  return closest_points_of(ConvexCore::of(first_shape), ConvexCore::of(triangle), {});
}

}  // namespace atl::collision
