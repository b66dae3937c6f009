// Answers to queries against the geometry they tell of: what a ray meets is where it says and nothing is before it, a
// shape that is moved comes to touch and not further, what is nearest is as far as the audit says, and all is the same
// in a world that is placed elsewhere.

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "consistency.h"
#include "definitions.h"
#include "finding.h"
#include "target.h"

namespace {

using namespace atl;

constexpr double accuracy = 1e-5;  // m; shapes are of some decimetres

Shape solid_of(const ConvexShape& shape) {
  return std::visit([](const auto& solid) { return Shape(solid); }, shape);
}

// m: of what queries see of a body. Negative where they are apart, by as much if one of the two is round.
double overlap_of(const World& world, BodyId id, const ConvexShape& shape, const Pose& pose) {
  BodyDef def = world.definition(id);
  if (!fuzz::keep_what_is_seen(def)) return -std::numeric_limits<double>::infinity();
  return overlap({.shape = solid_of(shape), .pose = pose}, {def.type, def.shape, world.pose(id)});
}

bool is_surface(const World& world, BodyId id) {
  const Shape shape = world.definition(id).shape;
  return std::holds_alternative<TriangleMesh>(shape) || std::holds_alternative<HeightField>(shape);
}

bool is_round(const Shape& shape) {
  return std::holds_alternative<Sphere>(shape) || std::holds_alternative<Capsule>(shape) ||
         std::holds_alternative<HalfSpace>(shape);
}

// m, from a point or shape to the body, below 0 where they overlap.
double distance_of(const World& world, BodyId id, const QueryShape& shape) {
  const QueryFilter alone = {.predicate = [id](BodyId body, std::uint32_t) { return body == id; }};
  const auto closest = Queries(world).closest_point(shape, 100, alone);
  fuzz::require(closest.has_value(), "a body has no closest point within 100 m");
  return closest->distance;
}

std::vector<BodyDef> bodies_of(fuzz::Bytes& bytes, fuzz::Definitions& definitions) {
  std::vector<BodyDef> bodies;
  for (std::uint32_t left = 1 + bytes.below(4); left > 0; --left) {
    BodyDef def{.type = bytes.one_in(3) ? BodyType::Static : BodyType::Dynamic};
    def.shape = definitions.shape(def.type);
    def.position = definitions.vector(1.5);
    def.orientation = definitions.orientation();
    bodies.push_back(def);
  }
  return bodies;
}

World world_of(const std::vector<BodyDef>& bodies, const Pose& placed = {}) {
  World world;
  for (BodyDef def : bodies) {
    def.position = placed.position + placed.orientation * def.position;
    def.orientation = placed.orientation * def.orientation.normalized();
    world.add_body(def);
  }
  return world;
}

void check_ray(const World& world, const Ray& ray) {
  const std::optional<RayHit> hit = Queries(world).cast_ray(ray);
  if (!hit) return;
  const Vector3 direction = ray.direction.normalized();
  fuzz::require((ray.origin + hit->distance * direction - hit->point).norm() < accuracy, "a hit is not on its ray");
  fuzz::require(std::abs(hit->normal.norm() - 1) < 1e-6, "a hit's normal is no unit vector");
  fuzz::require(hit->distance <= ray.max_distance, "a hit is out of reach");
  const double off = distance_of(world, hit->body, {.position = hit->point});
  if (hit->started_inside) {
    fuzz::require(hit->distance == 0 && hit->depth >= 0, "a ray starts inside a body at a distance");
    fuzz::require(std::abs(hit->depth + off) < 1e-3, "a ray starts " + std::to_string(hit->depth) +
                                                         " m deep in a body, and closest_point says " +
                                                         std::to_string(-off));
    return;
  }
  fuzz::require(std::abs(off) < accuracy, "a hit is " + std::to_string(off) + " m off its body");
  fuzz::require(hit->normal.dot(direction) < 1e-6, "a ray meets a side that looks away from it");
  Ray shorter = ray;
  shorter.max_distance = std::max(0.0, hit->distance - accuracy);
  fuzz::require(hit->distance < accuracy || !Queries(world).is_blocked(shorter), "something is before the first hit");
}

void check_cast(const World& world, const ShapeCast& cast, double part) {
  const std::optional<ShapeHit> hit = Queries(world).cast_shape(cast);
  const double whole = cast.translation.norm();
  fuzz::require(!hit || hit->distance <= whole + accuracy, "a shape hits what is beyond its way");
  const auto at = [&](double distance) {
    return Pose{cast.position + distance * cast.translation.normalized(), cast.orientation.normalized()};
  };
  if (hit && hit->started_overlapping) {
    fuzz::require(hit->distance == 0 && hit->depth >= 0, "a shape starts in a body at a distance");
    return;
  }
  if (hit && !is_surface(world, hit->body)) {
    const Pose there = at(hit->distance);
    const double off = distance_of(world, hit->body, {cast.shape, there.position, there.orientation});
    fuzz::require(std::abs(off) < 1e-4, "a shape ends " + std::to_string(off) + " m from what it meets");
  }
  // Surfaces let through what comes from behind.
  for (const BodyId id : world.bodies()) {
    if (is_surface(world, id) || whole < accuracy) continue;
    const double depth = overlap_of(world, id, cast.shape, at(part * (hit ? hit->distance : whole)));
    fuzz::require(depth < accuracy, "a shape passes " + std::to_string(depth) + " m deep through a body");
  }
}

void check_near(const World& world, const QueryShape& query) {
  if (!query.shape) return;
  const Pose pose{query.position, query.orientation.normalized()};
  for (const ClosestPoint& near : Queries(world).nearby(query, 3)) {
    fuzz::require(std::abs(near.normal.norm() - 1) < 1e-6, "the normal at a closest point is no unit vector");
    if (is_surface(world, near.body)) continue;
    const Vector3 apart = near.on_shape - near.on_body;
    fuzz::require(near.distance < 0 || (apart - near.distance * near.normal).norm() < accuracy,
                  "closest points are not as far apart as they say");
    const BodyDef def = world.definition(near.body);
    if (std::holds_alternative<Compound>(def.shape)) continue;
    fuzz::require(
        near.distance < accuracy || std::abs(distance_of(world, near.body, {.position = near.on_body})) < accuracy,
        "a closest point is not on its body");
    const double depth = overlap_of(world, near.body, *query.shape, pose);
    const bool exact = depth > 0 || is_round(def.shape) || is_round(solid_of(*query.shape));
    // A tenth of the inner radius where a capsule's axis is deep in another solid.
    const double tolerance = depth > 0 ? 1e-3 + 0.1 * depth : accuracy;
    fuzz::require(exact ? std::abs(near.distance + depth) < tolerance : near.distance >= -depth - accuracy,
                  "a body is " + std::to_string(near.distance) + " m away, and overlaps by " + std::to_string(depth));
  }
}

void check_elsewhere(const World& world, const std::vector<BodyDef>& bodies, Ray ray, const Pose& placed) {
  const std::optional<RayHit> here = Queries(world).cast_ray(ray);
  ray.origin = placed.position + placed.orientation * ray.origin;
  ray.direction = placed.orientation * ray.direction;
  const World other = world_of(bodies, placed);
  const std::optional<RayHit> there = Queries(other).cast_ray(ray);
  // A ray that grazes a body may miss it in one of the two worlds, by rounding.
  if (!here || !there) return;
  fuzz::require(
      here->body != there->body || here->child != there->child || std::abs(here->distance - there->distance) < 1e-3,
      "a ray meets a body elsewhere in a world that is placed elsewhere");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  atl::fuzz::Bytes bytes({data, size});
  atl::fuzz::Definitions definitions(bytes, atl::fuzz::Numbers::Usual);
  const std::vector<BodyDef> bodies = bodies_of(bytes, definitions);
  const World world = world_of(bodies);
  for (int turn = 0; turn < 4; ++turn) {
    const Ray ray = definitions.ray();
    check_ray(world, ray);
    check_cast(world, definitions.shape_cast(), bytes.within(0, 1));
    check_near(world, definitions.query_shape());
    if (turn == 0)
      check_elsewhere(world, bodies, ray, {definitions.vector(100), definitions.orientation().normalized()});
  }
  return 0;
}
