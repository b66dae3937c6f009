#include <collision/queries/query.h>
#include <collision/shapes/aabb.h>
#include <jobs/assert.h>

#include <algorithm>

namespace atl::collision {
namespace {

// The order of colliders in all answers.
bool comes_before(const ColliderTable& colliders, std::uint32_t a, std::uint32_t b) {
  if (colliders.body[a] != colliders.body[b]) return colliders.body[a] < colliders.body[b];
  return colliders.child[a] < colliders.child[b];
}

bool cast_at(const QueryScene& scene, const Ray& ray, Sides sides, std::uint32_t collider, double max_t,
             ColliderRayHit& hit) {
  const Pose pose = scene.colliders.pose(collider, scene.poses);
  const Quaternion inverse = pose.orientation.conjugate();
  const Ray seen{inverse * (ray.origin - pose.position), inverse * ray.direction, max_t};
  // A plane that the ray all but runs along may be too far away for a number.
  if (!cast_ray(scene.colliders.shape[collider], seen, sides, hit.hit) || hit.hit.t == infinity) return false;
  hit.collider = collider;
  hit.hit.normal = pose.orientation * hit.hit.normal;
  hit.point = ray.origin + hit.hit.t * ray.direction;
  return true;
}

// Says how deep a ray starts in what it hit, and which way is out.
void find_depth(const QueryScene& scene, const Ray& ray, ColliderRayHit& hit) {
  if (!hit.hit.started_inside) return;
  const Pose start{ray.origin, Quaternion::Identity()}, at = scene.colliders.pose(hit.collider, scene.poses);
  Distance depth;
  if (!find_signed_distance(Shape::sphere(0), start, scene.colliders.shape[hit.collider], at, 0, depth)) return;
  hit.depth = -depth.distance;
  hit.hit.normal = -depth.normal;
}

// Says how deep a solid is in what it overlaps before any motion.
void find_depth(const QueryScene& scene, const Shape& solid, const Pose& pose, ColliderSweepHit& hit) {
  if (!hit.hit.started_overlapping) return;
  const Pose at = scene.colliders.pose(hit.collider, scene.poses);
  Distance depth;
  if (!find_signed_distance(solid, pose, scene.colliders.shape[hit.collider], at, 0, depth)) return;
  ATL_ASSERT(!(depth.distance > 0), hit.collider, depth.distance);
  hit.depth = -depth.distance;
  hit.hit.normal = depth.normal;
  hit.hit.point = depth.on_other;
}

// The order of hits. Of a body's children that something starts in, the one it is deepest in comes first, as that is
// how deep it is in the body.
template <typename Hit>
bool comes_before(const ColliderTable& colliders, const Hit& a, const Hit& b) {
  if (a.hit.t != b.hit.t) return a.hit.t < b.hit.t;
  const bool same_body = colliders.body[a.collider] == colliders.body[b.collider];
  if (same_body && a.depth != b.depth) return a.depth > b.depth;
  return comes_before(colliders, a.collider, b.collider);
}

template <typename Hit>
void sort_hits(const ColliderTable& colliders, std::vector<Hit>& hits) {
  std::sort(hits.begin(), hits.end(), [&](const Hit& a, const Hit& b) { return comes_before(colliders, a, b); });
}

// A solid's way through the broadphase: the box around it, and where that goes.
struct Cast {
  Motion motion;
  Vector3 middle;
  Vector3 half;
  SweepGoal goal;

  Cast(const Shape& solid, const Pose& pose, const Vector3& translation) : motion(Motion::along(pose, translation)) {
    const Bounds bounds = bounds_of(solid, pose.position, pose.orientation.toRotationMatrix());
    middle = 0.5 * (bounds.lower + bounds.upper);
    goal.tolerance = 1e-7 * solid.inner_radius + 1e-14 * (pose.position.norm() + translation.norm());
    const double rounding = 1e-14 * (bounds.lower.cwiseAbs().maxCoeff() + bounds.upper.cwiseAbs().maxCoeff());
    half = 0.5 * (bounds.upper - bounds.lower) + Vector3::Constant(goal.tolerance + rounding);
  }
};

}  // namespace

bool cast_ray(const QueryScene& scene, const Ray& ray, Sides sides, Accept accept, ColliderRayHit& first) {
  bool found = false;
  scene.broadphase.proxies().query_ray(ray.origin, ray.direction, ray.max_t, [&](std::uint32_t collider, double) {
    const double max_t = found ? first.hit.t : ray.max_t;
    ColliderRayHit fresh;
    if (!accept(collider) || !cast_at(scene, ray, sides, collider, max_t, fresh)) return max_t;
    find_depth(scene, ray, fresh);
    if (found && !comes_before(scene.colliders, fresh, first)) return max_t;
    first = fresh;
    found = true;
    return first.hit.t;
  });
  ATL_ASSERT(!found || (first.hit.t >= 0 && first.hit.t <= ray.max_t), first.collider, first.hit.t, ray.max_t);
  return found;
}

bool cast_ray_any(const QueryScene& scene, const Ray& ray, Sides sides, Accept accept, ColliderRayHit& any) {
  bool found = false;
  scene.broadphase.proxies().query_ray(ray.origin, ray.direction, ray.max_t, [&](std::uint32_t collider, double) {
    // Below 0 nothing more is visited within a tree, but the next one begins.
    if (found) return -1.0;
    found = accept(collider) && cast_at(scene, ray, sides, collider, ray.max_t, any);
    return found ? -1.0 : ray.max_t;
  });
  return found;
}

void cast_ray_all(const QueryScene& scene, const Ray& ray, Sides sides, Accept accept,
                  std::vector<ColliderRayHit>& hits) {
  hits.clear();
  scene.broadphase.proxies().query_ray(ray.origin, ray.direction, ray.max_t, [&](std::uint32_t collider, double) {
    ColliderRayHit fresh;
    if (accept(collider) && cast_at(scene, ray, sides, collider, ray.max_t, fresh)) {
      find_depth(scene, ray, fresh);
      hits.push_back(fresh);
    }
    return ray.max_t;
  });
  sort_hits(scene.colliders, hits);
}

bool cast_shape(const QueryScene& scene, const Shape& solid, const Pose& pose, const Vector3& translation,
                Accept accept, ColliderSweepHit& first) {
  const Cast cast(solid, pose, translation);
  // Among colliders met at the same time, the first in the colliders' order is reported. A time of impact may come out
  // too early by the tolerance, so the search goes on a little beyond the first hit.
  const double slack = 4 * cast.goal.tolerance / translation.norm();
  bool found = false;
  scene.broadphase.proxies().query_ray(
      cast.middle, translation, 1,
      [&](std::uint32_t collider, double) {
        const double limit = found ? std::min(1.0, first.hit.t + slack) : 1;
        ColliderSweepHit fresh{collider, {}};
        if (!accept(collider)) return limit;
        const Motion still = Motion::still(scene.colliders.pose(collider, scene.poses));
        const Shape& other = scene.colliders.shape[collider];
        if (!sweep(solid, cast.motion, other, still, cast.goal, limit, fresh.hit)) return limit;
        find_depth(scene, solid, pose, fresh);
        if (found && !comes_before(scene.colliders, fresh, first)) return limit;
        first = fresh;
        found = true;
        return std::min(1.0, first.hit.t + slack);
      },
      cast.half);
  ATL_ASSERT(!found || (first.hit.t >= 0 && first.hit.t <= 1), first.collider, first.hit.t);
  return found;
}

void cast_shape_all(const QueryScene& scene, const Shape& solid, const Pose& pose, const Vector3& translation,
                    Accept accept, std::vector<ColliderSweepHit>& hits) {
  hits.clear();
  const Cast cast(solid, pose, translation);
  scene.broadphase.proxies().query_ray(
      cast.middle, translation, 1,
      [&](std::uint32_t collider, double) {
        ColliderSweepHit fresh{collider, {}};
        if (!accept(collider)) return 1.0;
        const Motion still = Motion::still(scene.colliders.pose(collider, scene.poses));
        if (sweep(solid, cast.motion, scene.colliders.shape[collider], still, cast.goal, 1, fresh.hit)) {
          find_depth(scene, solid, pose, fresh);
          hits.push_back(fresh);
        }
        return 1.0;
      },
      cast.half);
  sort_hits(scene.colliders, hits);
}

void find_overlaps(const QueryScene& scene, const Shape& solid, const Pose& pose, Accept accept,
                   std::vector<std::uint32_t>& found) {
  found.clear();
  const Bounds bounds = bounds_of(solid, pose.position, pose.orientation.toRotationMatrix());
  scene.broadphase.proxies().query_box(Aabb::around(bounds.lower, bounds.upper), [&](std::uint32_t collider) {
    if (!accept(collider)) return;
    const Pose at = scene.colliders.pose(collider, scene.poses);
    if (overlaps(solid, pose, scene.colliders.shape[collider], at)) found.push_back(collider);
  });
  std::sort(found.begin(), found.end(),
            [&](std::uint32_t a, std::uint32_t b) { return comes_before(scene.colliders, a, b); });
}

void find_near(const QueryScene& scene, const Shape& solid, const Pose& pose, double limit, Accept accept,
               std::vector<ColliderDistance>& found) {
  found.clear();
  const Bounds bounds = bounds_of(solid, pose.position, pose.orientation.toRotationMatrix());
  const Vector3 margin = Vector3::Constant(limit);
  scene.broadphase.proxies().query_box(
      Aabb::around(bounds.lower - margin, bounds.upper + margin), [&](std::uint32_t collider) {
        if (!accept(collider)) return;
        const Pose at = scene.colliders.pose(collider, scene.poses);
        ColliderDistance fresh{collider, {}};
        if (find_signed_distance(solid, pose, scene.colliders.shape[collider], at, limit, fresh.distance)) {
          found.push_back(fresh);
        }
      });
  std::sort(found.begin(), found.end(), [&](const ColliderDistance& a, const ColliderDistance& b) {
    const double x = a.distance.distance, y = b.distance.distance;
    return x != y ? x < y : comes_before(scene.colliders, a.collider, b.collider);
  });
}

// The broadphase finds what overlaps a box, so the box grows until something is found within it. Each time four times
// as large: the last one, which finds it all, then costs most.
bool find_closest(const QueryScene& scene, const Shape& solid, const Pose& pose, double limit, Accept accept,
                  ColliderDistance& closest) {
  const Proxies& proxies = scene.broadphase.proxies();
  const Bounds bounds = bounds_of(solid, pose.position, pose.orientation.toRotationMatrix());
  const double min = 1e-3 * limit;
  // A point's first reach may come to nothing, of which there is no multiple.
  const auto farther = [limit](double reach) { return reach > 0 ? std::min(4 * reach, limit) : limit; };
  for (double reach = std::max(min, std::min(limit, solid.bounding_radius));; reach = farther(reach)) {
    bool found = false;
    const Vector3 margin = Vector3::Constant(reach);
    proxies.query_box(Aabb::around(bounds.lower - margin, bounds.upper + margin), [&](std::uint32_t collider) {
      if (!accept(collider)) return;
      const double within = found ? std::max(0.0, closest.distance.distance) : reach;
      if (!proxies.is_half_space(collider) &&
          square_apart(proxies.fat_box(collider), bounds) > within * within * (1 + 1e-12)) {
        return;
      }
      const Pose at = scene.colliders.pose(collider, scene.poses);
      ColliderDistance fresh{collider, {}};
      if (!find_signed_distance(solid, pose, scene.colliders.shape[collider], at, within, fresh.distance)) return;
      const double excess = fresh.distance.distance - closest.distance.distance;
      if (found && (excess > 0 || (excess == 0 && !comes_before(scene.colliders, collider, closest.collider)))) return;
      closest = fresh;
      found = true;
    });
    if (found) return true;
    if (!(reach < limit)) return false;
  }
}

}  // namespace atl::collision
