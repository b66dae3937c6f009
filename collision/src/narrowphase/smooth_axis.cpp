#include "narrowphase/smooth_axis.h"

#include <collision/narrowphase/fcl_narrowphase.h>

#include <cmath>
#include <utility>

#include "narrowphase/convex_core.h"
#include "narrowphase/gjk.h"

namespace atl::collision {
namespace {

// Cores that are nearer than this part of their radii have no direction that rounding leaves.
constexpr double min_distance_share = 1e-3;

// The second moved by a way, seen by GJK.
struct CorePair {
  const SolidPair& pair;
  ConvexCore first, second;
  double radii;  // m, of both

  explicit CorePair(const SolidPair& solids)
      : pair(solids),
        first(ConvexCore::of(solids.first)),
        second(ConvexCore::of(solids.second)),
        radii(first.radius + second.radius) {}

  GjkResult distance(const Vector3& way, const Vector3& guess) const {
    return gjk_distance(first, second, {pair.position + way, pair.rotation}, guess);
  }
  bool parted(const GjkResult& found) const { return found.distance > min_distance_share * radii; }

  LocalAxis axis(const Vector3& normal, const Vector3& on_second) const {
    LocalAxis axis;
    axis.normal = normal;
    axis.separation = pair.separation_along(normal);
    axis.on_second = on_second - second.radius * normal;
    axis.confirmed = true;
    return axis;
  }
};

// Takes the normal of a flat face, or an axis of the shape, that parts the two better than a direction: where they
// overlap deeply, another side of a shape may be the nearer way out.
void try_sides(const SolidPair& pair, const Shape& shape, const Polytope& core, bool second, Vector3& normal) {
  double best = pair.separation_along(normal);
  const auto offer = [&](const Vector3& outward) {
    const Vector3 along = second ? Vector3(-(pair.rotation * outward)) : outward;
    const double separation = pair.separation_along(along);
    if (!(separation > best)) return;
    best = separation;
    normal = along;
  };
  for (int face = 0; face < core.face_count; ++face) offer(core.planes[face].normal);
  if (shape.kind == ShapeKind::Box || shape.kind == ShapeKind::Hull) return;
  for (int axis = 0; axis < 3; ++axis) {
    offer(Vector3::Unit(axis));
    offer(-Vector3::Unit(axis));
  }
}

// Steps to eight sides, ever smaller ones where none leads up.
void climb(const SolidPair& pair, Vector3& normal) {
  constexpr double diagonal = 0.70710678118654752;
  constexpr double first_step = 0.2, last_step = 1e-4, shrink = 0.5;  // rad
  constexpr int max_rounds = 60;
  double best = pair.separation_along(normal);
  double step = first_step;
  for (int round = 0; round < max_rounds && step > last_step; ++round) {
    const Vector3 u = normal.unitOrthogonal();
    const Vector3 v = normal.cross(u);
    const Vector3 before = normal;
    for (const auto& [x, y] : {std::pair{1.0, 0.0},
                               {0.0, 1.0},
                               {-1.0, 0.0},
                               {0.0, -1.0},
                               {diagonal, diagonal},
                               {-diagonal, diagonal},
                               {-diagonal, -diagonal},
                               {diagonal, -diagonal}}) {
      const Vector3 tried = (before + step * (x * u + y * v)).normalized();
      const double separation = pair.separation_along(tried);
      if (!(separation > best)) continue;
      best = separation;
      normal = tried;
    }
    if (normal == before) step *= shrink;
  }
}

// A core that is deep in another may have its nearest way out on any side.
void climb_from_all_around(const SolidPair& pair, Vector3& normal) {
  double best = pair.separation_along(normal);
  for (int corner = 0; corner < 8; ++corner) {
    Vector3 tried = Vector3(corner & 1 ? -1 : 1, corner & 2 ? -1 : 1, corner & 4 ? -1 : 1).normalized();
    climb(pair, tried);
    const double separation = pair.separation_along(tried);
    if (!(separation > best)) continue;
    best = separation;
    normal = tried;
  }
}

// The axis of cores that overlap.
LocalAxis deep_axis(const CorePair& cores, const Vector3& start) {
  const SolidPair& pair = cores.pair;
  // Each shortens what is left of an error to the depth's part of the radius of curvature and more: by half as deep as
  // that, to 1e-5.
  constexpr int max_rounds = 16;
  constexpr double still = 1 - 1e-14;
  Vector3 normal = start;
  LocalAxis best = cores.axis(normal, Vector3::Zero());
  best.on_second = pair.position + pair.rotation * support_point(pair.second, pair.rotation.transpose() * -normal);
  for (int round = 0; round < max_rounds; ++round) {
    const Vector3 way = -pair.separation_along(normal) * normal;
    const GjkResult found = cores.distance(way, normal);
    if (!cores.parted(found)) break;
    const bool stays = found.normal.dot(normal) > still;
    normal = found.normal;
    const LocalAxis axis = cores.axis(normal, found.on_second - way);
    if (axis.separation >= best.separation) best = axis;
    if (stays) break;
  }
  return best;
}

// The feature with which a box or a hull touches, by its vertex that reaches farthest.
Feature feature_along(const Shape& shape, const Polytope& core, const Vector3& outward) {
  const bool has_vertices = shape.kind == ShapeKind::Box || shape.kind == ShapeKind::Hull;
  return {Feature::Kind::Vertex, has_vertices ? core.support(outward) : 0};
}

}  // namespace

AxisSearch find_smooth_axis(const SolidPair& pair, double margin, const KnownAxis& known, Core& first, Core& second) {
  AxisSearch search;
  const CorePair cores(pair);
  const GjkResult found = cores.distance(Vector3::Zero(), known.exists ? known.normal : pair.position);
  search.by = known.exists ? Narrowphase::Kept : Narrowphase::ClosedForm;
  search.gap = found.lower_bound - cores.radii;
  if (search.gap > margin || !std::isfinite(found.distance)) return search;

  first.build(pair.first);
  second.build(pair.second);
  if (cores.parted(found)) {
    search.axis = cores.axis(found.normal, found.on_second);
  } else {
    Vector3 start = known.normal;
    if (!known.exists) {
      fcl_narrowphase::Axis asked;
      search.by = Narrowphase::Fcl;
      const bool touches =
          fcl_narrowphase::convex(pair.first, pair.second, pair.position, pair.rotation, margin, asked) &&
          asked.normal.squaredNorm() > 0.25 && asked.normal.allFinite();
      const double apart = pair.position.norm();
      start = touches ? asked.normal.normalized() : apart > 0 ? Vector3(pair.position / apart) : Vector3::UnitZ();
    }
    try_sides(pair, pair.first, first.polytope(), false, start);
    try_sides(pair, pair.second, second.polytope(), true, start);
    climb(pair, start);
    if (!known.exists) climb_from_all_around(pair, start);
    search.axis = deep_axis(cores, start);
  }
  LocalAxis& axis = search.axis;
  axis.first = feature_along(pair.first, first.polytope(), axis.normal);
  axis.second = feature_along(pair.second, second.polytope(), pair.rotation.transpose() * -axis.normal);
  search.gap = axis.separation;
  search.touches = axis.separation <= margin && axis.normal.allFinite();
  return search;
}

}  // namespace atl::collision
