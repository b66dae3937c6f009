#pragma once

#include <collision/broadphase/broadphase.h>
#include <collision/continuous/sweep.h>
#include <collision/narrowphase/distance.h>
#include <collision/queries/ray.h>
#include <collision/shapes/collider_table.h>
#include <collision/shapes/function_ref.h>

#include <cstdint>
#include <vector>

namespace atl::collision {

// Questions to all colliders of a world at once. Every function is const and safe from several threads as long as
// nobody changes the scene. Answers don't depend on the broadphase's history: of equal hits the one of the lower
// body, then child, comes first.

/// The colliders of a world and their poses. Fat boxes in the broadphase must contain the colliders.
struct QueryScene {
  const ColliderTable& colliders;
  PoseView poses;  ///< of bodies
  const Broadphase& broadphase;
};

/// Says whether a collider counts.
using Accept = FunctionRef<bool(std::uint32_t collider)>;

struct ColliderRayHit {
  std::uint32_t collider = 0;
  RayHit hit;                       ///< normal in the world's frame: of a ray that starts inside, the way out
  double depth = 0;                 ///< m, along that
  Vector3 point = Vector3::Zero();  ///< m
};

/// The first collider that a ray meets; false if there is none.
bool cast_ray(const QueryScene& scene, const Ray& ray, Sides sides, Accept accept, ColliderRayHit& first);
/// Any of the colliders that a ray meets, which may depend on the broadphase's history; whether there is one doesn't.
bool cast_ray_any(const QueryScene& scene, const Ray& ray, Sides sides, Accept accept, ColliderRayHit& any);
/// Finds all hits, in order; of a surface the first hit alone. Replaces the contents of `hits`.
void cast_ray_all(const QueryScene& scene, const Ray& ray, Sides sides, Accept accept,
                  std::vector<ColliderRayHit>& hits);

struct ColliderSweepHit {
  std::uint32_t collider = 0;
  SweepHit hit;      ///< the cast shape is the first, the collider the second
  double depth = 0;  ///< m, along the normal, of two that overlap at the start
};

/// The first collider that a bounded convex solid meets on its way from a pose along a translation (m), without
/// turning: exact to 1e-7 of its inner radius. One that it overlaps at the start is met at t = 0, unless it is a
/// surface that the solid moves away from.
bool cast_shape(const QueryScene& scene, const Shape& solid, const Pose& pose, const Vector3& translation,
                Accept accept, ColliderSweepHit& first);
/// Finds all hits, in order.
void cast_shape_all(const QueryScene& scene, const Shape& solid, const Pose& pose, const Vector3& translation,
                    Accept accept, std::vector<ColliderSweepHit>& hits);

/// The colliders that touch or overlap a bounded convex solid at a pose, in order.
void find_overlaps(const QueryScene& scene, const Shape& solid, const Pose& pose, Accept accept,
                   std::vector<std::uint32_t>& found);

struct ColliderDistance {
  std::uint32_t collider = 0;
  Distance distance;
};

/// The colliders no farther than `limit` (m, finite, >= 0) from a bounded convex solid, the closest first, and by
/// signed distances: the deepest before all.
void find_near(const QueryScene& scene, const Shape& solid, const Pose& pose, double limit, Accept accept,
               std::vector<ColliderDistance>& found);

/// The first of these for a solid or a point (a sphere of radius 0).
bool find_closest(const QueryScene& scene, const Shape& solid, const Pose& pose, double limit, Accept accept,
                  ColliderDistance& closest);

}  // namespace atl::collision
