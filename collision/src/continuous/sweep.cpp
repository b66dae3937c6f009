#include <collision/continuous/sweep.h>
#include <collision/shapes/aabb.h>
#include <collision/shapes/height_field.h>
#include <collision/shapes/triangle_mesh.h>
#include <features/with_meshes.h>
#include <jobs/assert.h>

#include <algorithm>

#include "continuous/moving_core.h"

namespace atl::collision {
namespace {

constexpr int max_advances = 200;

Vector3 centre_at_start(const Motion& motion) {
  return motion.start.position + motion.start.orientation * motion.centre;
}

bool moves(const Motion& motion) { return motion.translation.squaredNorm() > 0 || motion.rotation.squaredNorm() > 0; }

// The largest distance (m) of a point of the solid from the centre of its motion.
double radius_about_centre(const Shape& solid, const Motion& motion) {
  return solid.bounding_radius + motion.centre.norm();
}

// An upper bound (m, in the whole time) of the way of the solid's points in the other's frame, in any direction.
double relative_path(const MovingCore& solid, double solid_radius, const Motion& other) {
  const Motion& motion = solid.motion;
  const Vector3 shift = motion.translation - other.translation;
  double path = shift.norm() + motion.rotation.norm() * solid.axis_radius;
  const double spin = other.rotation.norm();
  if (spin > 0) {
    const Vector3 apart = centre_at_start(motion) - centre_at_start(other);
    path += spin * (std::max(apart.norm(), (apart + shift).norm()) + solid_radius);
  }
  return path;
}

// Does advance() along the plane's normal. The normal of a plane that turns changes, so there motion in any direction
// counts.
bool sweep_to_plane(const Shape& solid, const MovingCore& moving, const Shape& plane, const Motion& plane_motion,
                    const SweepGoal& goal, double t_limit, SweepHit& hit) {
  const bool plane_turns = plane_motion.rotation.squaredNorm() > 0;
  const double any_closing =
      plane_turns ? relative_path(moving, radius_about_centre(solid, moving.motion), plane_motion) : 0;
  const double aim = goal.aim();
  double t = 0;
  for (int i = 0; i < max_advances; ++i) {
    const Pose pose = moving.motion.at(t);
    const Pose plane_pose = plane_motion.at(t);
    const Vector3 normal = plane_pose.orientation * plane.normal;
    const double level = normal.dot(plane_pose.position) + plane.offset;
    const double separation = -moving.reach(pose, -normal) - level;
    const double closing =
        plane_turns ? any_closing : moving.advance_along(-normal) + plane_motion.translation.dot(normal);
    const bool overlaps = i == 0 && !(separation > 0);
    if (!overlaps && !(closing > 0)) return false;
    if (overlaps || separation <= goal.separation + goal.tolerance || i + 1 == max_advances) {
      const Vector3 seen = pose.orientation.conjugate() * -normal;
      const Vector3 lowest = pose.position + pose.orientation * moving.core.support(seen);
      hit = {};
      hit.t = t;
      hit.normal = -normal;
      hit.point = lowest - (normal.dot(lowest) - level) * normal;
      hit.separation = std::max(0.0, separation);
      hit.started_overlapping = overlaps;
      hit.converged = overlaps || separation <= goal.separation + goal.tolerance;
      return true;
    }
    const double next = t + (separation - aim) / closing;
    if (!(next <= t_limit)) return false;
    t = next;
  }
  return false;
}

// Box around all places that the solid may get to up to t_limit, in the frame of the surface.
Aabb swept_box(const Shape& solid, const MovingCore& moving, const Motion& surface, double margin, double t_limit) {
  const Motion& motion = moving.motion;
  const auto grown = [&](const Vector3& lower, const Vector3& upper) {
    // More than the rounding of the poses, far from the origin.
    const double slack = margin + 1e-12 * (lower.cwiseAbs().maxCoeff() + upper.cwiseAbs().maxCoeff());
    return Aabb::around(lower - Vector3::Constant(slack), upper + Vector3::Constant(slack));
  };
  if (!moves(surface)) {
    // Between its ends a point that turns by an angle about an axis it is r away from gets off the line from one to the
    // other by r angle^2 / 8 at most, as linear interpolation does.
    const double angle = t_limit * motion.rotation.norm();
    const Vector3 bulge = Vector3::Constant(moving.axis_radius * angle * angle / 8);
    const Pose first = relative(surface.start, motion.start);
    const Pose last = relative(surface.start, motion.at(t_limit));
    const Bounds a = bounds_of(solid, first.position, first.orientation.toRotationMatrix());
    const Bounds b = bounds_of(solid, last.position, last.orientation.toRotationMatrix());
    return grown(a.lower.cwiseMin(b.lower) - bulge, a.upper.cwiseMax(b.upper) + bulge);
  }
  const Quaternion inverse = surface.start.orientation.conjugate();
  const Vector3 first = inverse * (centre_at_start(motion) - surface.start.position);
  double radius = radius_about_centre(solid, motion);
  radius += t_limit * relative_path(moving, radius, surface);
  return grown(first - Vector3::Constant(radius), first + Vector3::Constant(radius));
}

// Sweeps a solid to one triangle after the other, up to a limit.
class SurfaceSweep {
 public:
  SurfaceSweep(const MovingCore& solid, const Motion& surface, const SweepGoal& goal, double t_limit)
      : solid_(solid), surface_(surface), goal_(goal), t_limit_(t_limit) {
    const Quaternion inverse = surface.start.orientation.conjugate();
    centre_ = inverse * (centre_at_start(solid.motion) - surface.start.position);
    const Vector3 centre_shift = surface.rotation.cross(centre_at_start(solid.motion) - centre_at_start(surface));
    shift_ = inverse * (solid.motion.translation - surface.translation - centre_shift);
  }

  void set_limit(double t) { t_limit_ = t; }

  bool meets(std::uint32_t number, const Triangle& triangle, SweepHit& hit) const {
    if (triangle.normal.dot(centre_ - triangle.vertices[0]) < 0) return false;
    const MovingCore moving(ConvexCore::of(triangle.vertices), surface_);
    if (stay_parted(solid_, moving, goal_, surface_.start.orientation * -triangle.normal, t_limit_)) return false;
    if (!advance(solid_, moving, goal_, t_limit_, hit)) return false;
    ATL_ASSERT(hit.t >= 0 && hit.t <= t_limit_, number, hit.t, t_limit_);
    if (const Parted parted = parted_by_planes(moving, triangle); hit.t < parted.until) {
      if (parted.until > t_limit_) return false;
      hit = {.t = parted.until, .normal = parted.across, .point = hit.point, .converged = false};
    }
    hit.triangle = number;
    return hit.t > 0 || triangle.normal.dot(shift_) < 0;
  }

 private:
  struct Parted {
    double until = 0;
    Vector3 across = Vector3::Zero();
  };

  // A distance to a triangle that is huge may come out as too small, even as none. What a plane keeps apart from it is
  // not met before that ends: its own plane, those across axes, by which triangles are looked up, and the one by which
  // advance() begins. Whatever the limit, as who is met first may not depend on that.
  Parted parted_by_planes(const MovingCore& moving, const Triangle& triangle) const {
    Parted longest;
    const SweepGoal goal = {goal_.separation, 2 * goal_.tolerance};  // not by rounding
    const auto look_along = [&](const Vector3& across) {
      const double until = parted_until(solid_, moving, goal, across);
      if (until > longest.until) longest = {until, across.normalized()};
    };
    const Quaternion& turned = surface_.start.orientation;
    look_along(turned * -triangle.normal);
    for (int axis = 0; axis < 3; ++axis) {
      look_along(turned * Vector3::Unit(axis));
      look_along(turned * -Vector3::Unit(axis));
    }
    look_along(first_guess(solid_, moving));
    return longest;
  }

  const MovingCore& solid_;
  const Motion& surface_;
  SweepGoal goal_;
  double t_limit_;
  Vector3 centre_;  // of the solid's motion at the start, surface's frame
  Vector3 shift_;   // its velocity there
};

}  // namespace

bool sweep(const Shape& solid, const Motion& solid_motion, const Shape& other, const Motion& other_motion,
           const SweepGoal& goal, double t_limit, SweepHit& hit) {
  if (is_surface(other.kind)) {
    ATL_ASSERT(is_convex_solid(solid.kind), static_cast<int>(solid.kind));
    bool found = false;
    sweep_each(solid, solid_motion, other, other_motion, goal, t_limit, [&](const SweepHit& fresh) {
      // The lowest triangle counts of those that are met at the same time.
      if (found && fresh.t == hit.t && fresh.triangle > hit.triangle) return hit.t;
      hit = fresh;
      found = true;
      return hit.t;
    });
    return found;
  }
  const MovingCore moving(ConvexCore::of(solid), solid_motion);
  if (other.kind == ShapeKind::HalfSpace) {
    return sweep_to_plane(solid, moving, other, other_motion, goal, t_limit, hit);
  }
  return advance(moving, MovingCore(ConvexCore::of(other), other_motion), goal, t_limit, hit);
}

void sweep_each(const Shape& solid, const Motion& solid_motion, const Shape& other, const Motion& other_motion,
                const SweepGoal& goal, double t_limit, FunctionRef<double(const SweepHit&)> visit) {
  SweepHit hit;
  if (!is_surface(other.kind)) {
    if (sweep(solid, solid_motion, other, other_motion, goal, t_limit, hit)) visit(hit);
    return;
  }
  if constexpr (!with_meshes) return;
  const MovingCore moving(ConvexCore::of(solid), solid_motion);
  SurfaceSweep surface(moving, other_motion, goal, t_limit);
  const auto test = [&](std::uint32_t number, const Triangle& triangle) {
    SweepHit fresh;
    if (surface.meets(number, triangle, fresh)) surface.set_limit(visit(fresh));
  };
  const Aabb box = swept_box(solid, moving, other_motion, goal.separation + goal.tolerance, t_limit);
  if (other.kind == ShapeKind::Mesh) {
    const TriangleMesh& mesh = *other.mesh;
    mesh.tree.query(box, [&](std::uint32_t number) { test(number, mesh.face(number)); });
  } else {
    const HeightField& field = *other.field;
    field.query(box, [&](std::uint32_t number) { test(number, field.face(number)); });
  }
}

}  // namespace atl::collision
