#include <atoll/queries.h>

#include <algorithm>
#include <cmath>

#include "trials.h"

namespace atl::soak {
namespace {

constexpr double yard_half = 17;   // m
constexpr double rounding = 1e-6;  // m, of a distance in the yard
constexpr int rays = 16, shapes = 4;

Vector3 somewhere(Random& random) { return random.in_box({yard_half, yard_half, 3}) + Vector3(0, 0, 3); }

void require(bool holds, const char* what) {
  if (!holds) throw CheckFailed(what);
}

bool same(const std::optional<RayHit>& a, const std::optional<RayHit>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  return a->body == b->body && a->child == b->child && a->distance == b->distance && a->point == b->point &&
         a->normal == b->normal;
}

void check_ray(const Queries& queries, const Queries& others, const Ray& ray) {
  const std::optional<RayHit> first = queries.cast_ray(ray);
  require(same(first, others.cast_ray(ray)), "a ray meets something else in the second world");
  const std::vector<RayHit> all = queries.cast_ray_through(ray);
  require(first.has_value() == !all.empty() && (!first || first->distance == all.front().distance),
          "the first thing that a ray meets is not the first of all");
  require(queries.is_blocked(ray) == first.has_value(), "a ray that meets something is not blocked, or the reverse");
}

// m, below 0 where they overlap; nothing for shapes without a closed form here.
std::optional<double> gap_to_ball(const BodyDef& body, const Vector3& centre, double radius) {
  const Vector3 local = body.orientation.conjugate() * (centre - body.position);
  if (const auto* ball = std::get_if<Sphere>(&body.shape)) return local.norm() - ball->radius - radius;
  if (const auto* box = std::get_if<Box>(&body.shape)) {
    return (local.cwiseAbs() - box->half_extents).cwiseMax(0).norm() - radius;
  }
  return std::nullopt;
}

void check_overlaps(const World& world, const Queries& queries, const Queries& others, const Vector3& place,
                    double radius) {
  const QueryShape ball = {.shape = Sphere{radius}, .position = place};
  const std::vector<BodyId> found = queries.overlapping(ball);
  require(found == others.overlapping(ball), "overlaps are others in the second world");
  for (const BodyId id : world.bodies()) {
    const BodyDef body = world.definition(id);
    const std::optional<double> gap = body.sensor ? std::nullopt : gap_to_ball(body, place, radius);
    if (!gap || std::abs(*gap) < rounding) continue;
    require(std::binary_search(found.begin(), found.end(), id) == (*gap < 0),
            "an overlap with a ball or a box is not what its closed form says");
  }
  const auto closest = queries.closest_point(ball, 1);
  require(found.empty() || (closest && closest->distance <= 0), "what overlaps has a distance");
  require(!found.empty() || !closest || closest->distance > 0, "what has no distance doesn't overlap");
}

}  // namespace

void check_queries(Twin& twin, Random& random, SoakTally& tally) {
  const Queries queries(twin.world()), others(twin.second());
  for (int i = 0; i < rays; ++i) {
    check_ray(queries, others, {.origin = somewhere(random), .direction = random.rotation() * Vector3::UnitX()});
  }
  for (int i = 0; i < shapes; ++i) {
    const Vector3 place = somewhere(random);
    check_overlaps(twin.world(), queries, others, place, random.uniform(0.2, 2));
    const ShapeCast cast = {.shape = Box{{0.2, 0.3, 0.4}},
                            .position = place,
                            .orientation = random.rotation(),
                            .translation = random.in_box({5, 5, 5})};
    const std::optional<ShapeHit> hit = queries.cast_shape(cast), other = others.cast_shape(cast);
    require(hit.has_value() == other.has_value() &&
                (!hit || (hit->body == other->body && hit->distance == other->distance)),
            "a shape that is moved meets something else in the second world");
  }
  tally.queries += rays * 4 + shapes * 5;
}

}  // namespace atl::soak
