#include "continuous/moving_core.h"

#include <collision/narrowphase/box_axes.h>
#include <jobs/assert.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "narrowphase/point_distance.h"

namespace atl::collision {
namespace {

// Limit of distance queries. Fast pairs need 3 to 10; only a pair that turns fast and hardly moves reaches it.
constexpr int max_distances = 60;
constexpr int max_reaches = 16;

// exp(rotation / 2): by its series for a small part of the angle, then squared.
Quaternion quaternion_of(const Vector3& rotation) {
  Vector3 half = 0.5 * rotation;
  int squarings = 0;
  // An angle of 2^40 rad has no meaning any more.
  while (half.squaredNorm() > 0.01 && squarings < 40) {
    half *= 0.5;
    ++squarings;
  }
  const double x = half.squaredNorm();
  const double cosine = 1 - x / 2 * (1 - x / 12 * (1 - x / 30 * (1 - x / 56 * (1 - x / 90))));
  const double sine = 1 - x / 6 * (1 - x / 20 * (1 - x / 42 * (1 - x / 72 * (1 - x / 110))));
  Quaternion result(cosine, sine * half.x(), sine * half.y(), sine * half.z());
  for (; squarings > 0; --squarings) result = (result * result).normalized();
  return result.normalized();
}

// The inverse: axis times angle, in [0, pi]. The angle is halved until a series gives it, asin(x) / x up to x = 0.05.
Vector3 rotation_of(Quaternion turn) {
  if (turn.w() < 0) turn.coeffs() = -turn.coeffs();
  double doublings = 2;
  double x = turn.vec().squaredNorm();
  for (; x > 0.0025; x = turn.vec().squaredNorm()) {
    turn.w() += 1;
    turn.normalize();
    doublings *= 2;
  }
  const double series =
      1 + x * (1.0 / 6 + x * (3.0 / 40 + x * (15.0 / 336 + x * (105.0 / 3456 + x * (945.0 / 42240)))));
  return doublings * series * turn.vec();
}

// The gap between the two shapes at one time of the conservative advancement.
struct Gap {
  double separation;  // m, proven
  Vector3 normal;     // world
  Vector3 point;      // on the second, world
};

Gap gap_at(const MovingCore& first, const MovingCore& second, const Pose& pose_first, const Pose& pose_second,
           const Vector3& guess) {
  const Matrix3 turned = pose_first.orientation.toRotationMatrix();
  const Pose seen = relative(pose_first, pose_second);
  const Placement place{seen.position, seen.orientation.toRotationMatrix()};
  const double radii = first.core.radius + second.core.radius;
  Vector3 normal;
  Vector3 on_second;
  double separation = 0;
  if (first.core.kind == ConvexCore::Kind::Point && has_closest_point(second.core)) {
    on_second =
        place.position + place.rotation * closest_point(second.core, place.rotation.transpose() * -seen.position);
    const double distance = on_second.norm();
    normal = distance > 0 ? Vector3(on_second / distance) : Vector3::UnitZ();
    separation = distance - radii;
  } else {
    const GjkResult found = gjk_distance(first.core, second.core, place, turned.transpose() * guess);
    normal = found.lower_bound > 0 ? found.bound_normal : found.normal;
    on_second = found.on_second;
    separation = found.lower_bound - radii;
  }
  const Vector3 surface = on_second - second.core.radius * normal;
  return {separation, turned * normal, pose_first.position + turned * surface};
}

// The radius (m) of the core about an axis (unit vector, shape's frame) through a centre.
double radius_about(const ConvexCore& core, const Vector3& centre, const Vector3& axis) {
  const auto square_from = [&](const Vector3& point) {
    const Vector3 arm = point - centre;
    return (arm - arm.dot(axis) * axis).squaredNorm();
  };
  const auto from = [&](const Vector3& point) { return std::sqrt(square_from(point)); };
  const Vector3 end(0, 0, core.half_height);
  double farthest = 0;
  switch (core.kind) {
    case ConvexCore::Kind::Point:
      farthest = from(Vector3::Zero());
      break;
    case ConvexCore::Kind::Segment:
      farthest = std::max(from(end), from(-end));
      break;
    case ConvexCore::Kind::Cylinder:
      farthest = std::max(from(end), from(-end)) + core.core_radius;
      break;
    case ConvexCore::Kind::Cone:
      farthest = std::max(from(end), from(-end) + core.core_radius);
      break;
    case ConvexCore::Kind::Box:
      for (int corner = 0; corner < 8; ++corner) {
        const Vector3 side(corner & 1 ? -1 : 1, corner & 2 ? -1 : 1, corner & 4 ? -1 : 1);
        farthest = std::max(farthest, square_from(side.cwiseProduct(core.half_extents)));
      }
      farthest = std::sqrt(farthest);
      break;
    case ConvexCore::Kind::Ellipsoid: {
      // No farther than |a| across the axis, with half axes a, nor than the longest; less the radius, which is added.
      const double across =
          core.half_extents.cwiseProduct((Vector3::Ones() - axis.cwiseAbs2()).cwiseMax(0).cwiseSqrt()).norm();
      farthest = from(Vector3::Zero()) + std::min(across, core.half_extents.maxCoeff()) - core.radius;
      break;
    }
    case ConvexCore::Kind::TaperedCapsule:
      farthest = std::max(from(end) + core.top_radius, from(-end) + core.core_radius);
      break;
    case ConvexCore::Kind::Hull:
      for (const Vector3& vertex : core.hull->vertices) farthest = std::max(farthest, square_from(vertex));
      farthest = std::sqrt(farthest);
      break;
    case ConvexCore::Kind::Triangle:
      for (const Vector3& vertex : core.triangle) farthest = std::max(farthest, square_from(vertex));
      farthest = std::sqrt(farthest);
      break;
  }
  return farthest + core.radius;
}

// Does stay_parted() with the best separating axis of two boxes at the start, which costs less than their distance.
bool boxes_stay_parted(const MovingCore& first, const MovingCore& second, const SweepGoal& goal, double t_limit) {
  if (first.core.kind != ConvexCore::Kind::Box || second.core.kind != ConvexCore::Kind::Box) return false;
  BoxAxes axes;
  const Pose& start = first.motion.start;
  find_box_axes(first.core.half_extents, second.core.half_extents, relative(start, second.motion.start), axes);
  return stay_parted(first, second, goal, start.orientation * best_box_axis(axes, 0), t_limit);
}

}  // namespace

Motion Motion::between(const Pose& start, const Pose& end, const Vector3& centre) {
  Motion motion;
  motion.start = start;
  motion.centre = centre;
  motion.translation = end.position + end.orientation * centre - (start.position + start.orientation * centre);
  motion.rotation = rotation_of(end.orientation * start.orientation.conjugate());
  ATL_ASSERT(!(motion.rotation.norm() > 3.142), motion.rotation.norm());  // the shorter way
  return motion;
}

Pose Motion::at(double t) const {
  if (rotation.squaredNorm() == 0) return {start.position + t * translation, start.orientation};
  const Quaternion orientation = quaternion_of(t * rotation) * start.orientation;
  const Vector3 middle = start.position + start.orientation * centre + t * translation;
  return {middle - orientation * centre, orientation};
}

MovingCore::MovingCore(const ConvexCore& convex, const Motion& how) : core(convex), motion(how) {
  const double angle = motion.rotation.norm();
  if (angle == 0) return;
  const Vector3 axis = motion.start.orientation.conjugate() * (motion.rotation / angle);
  axis_radius = radius_about(core, motion.centre, axis);
}

double MovingCore::reach(const Pose& pose, const Vector3& direction) const {
  const Vector3 seen = pose.orientation.conjugate() * direction;
  return pose.position.dot(direction) + core.support(seen).dot(seen) + core.radius;
}

double parted_until(const MovingCore& first, const MovingCore& second, const SweepGoal& goal,
                    const Vector3& direction) {
  const double length = direction.norm();
  if (!(length > 0)) return 0;
  const Vector3 unit = direction / length;
  const double separation = -second.reach(second.motion.start, -unit) - first.reach(first.motion.start, unit);
  const double room = separation - (goal.separation + goal.tolerance);
  if (!(room > 0)) return 0;
  const double closing = first.advance_along(unit) + second.advance_along(-unit);
  return closing > 0 ? room / closing : std::numeric_limits<double>::infinity();
}

bool stay_parted(const MovingCore& first, const MovingCore& second, const SweepGoal& goal, const Vector3& direction,
                 double t_limit) {
  return parted_until(first, second, goal, direction) > t_limit;
}

Vector3 first_guess(const MovingCore& first, const MovingCore& second) {
  const Pose& pose = second.motion.start;
  Vector3 guess = pose.position - first.motion.start.position;
  if (second.core.kind == ConvexCore::Kind::Triangle) guess += pose.orientation * second.core.triangle[0];
  return guess;
}

bool advance(const MovingCore& first, const MovingCore& second, const SweepGoal& goal, double t_limit, SweepHit& hit) {
  ATL_ASSERT(goal.separation >= 0 && goal.tolerance > 0, goal.separation, goal.tolerance);
  ATL_ASSERT(t_limit >= 0 && t_limit <= 1, t_limit);
  const bool turning = first.turns() || second.turns();
  const double aim = goal.aim();
  const double near = goal.separation + goal.tolerance;
  Pose pose_first = first.motion.start;
  Pose pose_second = second.motion.start;
  Vector3 guess = first_guess(first, second);
  if (stay_parted(first, second, goal, guess, t_limit)) return false;
  if (boxes_stay_parted(first, second, goal, t_limit)) return false;
  double t = 0;
  SweepHit last;
  for (int i = 0; i < max_distances; ++i) {
    const Gap gap = gap_at(first, second, pose_first, pose_second, guess);
    if (!(gap.separation > 0) && i > 0) {
      // Below what the step before allowed for: rounding, or a distance that is proven to be no more. That the two are
      // apart until this time is proven all the same, and a time that said less would depend on the limit.
      hit = last;
      hit.t = t;
      return true;
    }
    last = {t, gap.normal, gap.point, std::max(0.0, gap.separation), SweepHit::no_triangle, false, true};
    if (!(gap.separation > 0)) {
      hit = last;
      hit.started_overlapping = true;
      return true;
    }
    const double closing = first.advance_along(gap.normal) + second.advance_along(-gap.normal);
    if (!(closing > 0)) return false;
    if (gap.separation <= near) {
      hit = last;
      return true;
    }
    double separation = gap.separation;
    for (int k = 0; k < max_reaches; ++k) {
      t += (separation - aim) / closing;
      if (!(t <= t_limit)) return false;
      pose_first = first.motion.at(t);
      pose_second = second.motion.at(t);
      if (!turning) break;
      // The same direction may part them still, for the price of two support points.
      separation = -second.reach(pose_second, -gap.normal) - first.reach(pose_first, gap.normal);
      if (separation <= near) break;
    }
    guess = gap.normal;
  }
  hit = last;
  hit.t = t;
  hit.converged = false;
  return true;
}

}  // namespace atl::collision
