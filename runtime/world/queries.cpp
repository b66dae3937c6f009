// Checks questions, hands them to the collision layer, and names bodies in its answers.

#include <atoll/error.h>
#include <atoll/queries.h>
#include <collision/queries/query.h>

#include <algorithm>
#include <sstream>
#include <string>

#include "world/body_definition.h"
#include "world/refuse.h"
#include "world/unit_of.h"
#include "world/world_impl.h"

namespace atl {

/// The parts of a world that queries read.
struct QueryAccess {
  const collision::ColliderTable& colliders;
  const solver::BodyTable& bodies;
  const BodyRecords& records;
  const collision::Broadphase& broadphase;
  const ContactChoices& choices;
  jobs::Arena& arena;

  static QueryAccess of(const World& world) {
    World::Impl& impl = *world.impl_;
    impl.step_guard.check("Queries");
    Stores& stores = impl.stores;
    impl.step_guard.change([&] { impl.query_gate.open(stores.broadphase, impl.arena); });
    return {stores.colliders, stores.bodies, stores.records, stores.broadphase, stores.choices, impl.arena};
  }

  collision::QueryScene scene() const {
    return {colliders, {bodies.positions.data(), bodies.orientations.data()}, broadphase};
  }
  const CollisionFilter& filter(std::uint32_t collider) const {
    const std::uint32_t body = colliders.body[collider];
    const CheckedCollider& part = records.constants[body]->colliders[colliders.child[collider]];
    return part.filter ? *part.filter : records.filter[body];
  }
  BodyId id(std::uint32_t collider) const {
    const std::uint32_t body = colliders.body[collider];
    return {body, records.generation[body]};
  }
};

namespace {

using collision::infinity;
// Few enough that a batch of a few hundred is shared evenly, many enough that handing out costs nothing.
constexpr std::size_t batch_grain = 32;

class Filter {
 public:
  Filter(const QueryAccess& access, const QueryFilter& filter) : access_(access), filter_(filter) {
    for (const BodyId id : filter.ignore) {
      if (id.index < access.records.generation.size() && access.records.generation[id.index] == id.generation) {
        ignored_.push_back(id.index);
      }
    }
    std::sort(ignored_.begin(), ignored_.end());
    if (!filter.as) return;
    const auto [index, generation] = *filter.as;
    const BodyRecords& records = access.records;
    if (index >= records.alive.size() || !records.alive[index] || records.generation[index] != generation) {
      refuse_stale("Queries: QueryFilter.as", *filter.as);
    }
  }

  bool operator()(std::uint32_t collider) const {
    const std::uint32_t body = access_.colliders.body[collider];
    const CollisionFilter& other = access_.filter(collider);
    if (filter_.as) {
      if (!may_touch(filter_.as->index, collider)) return false;
    } else if ((filter_.mask & other.category) == 0 || (other.mask & filter_.category) == 0) {
      return false;
    }
    if (access_.records.sensor[body] && !filter_.sensors) return false;
    if (!wanted(access_.records.type[body])) return false;
    if (std::binary_search(ignored_.begin(), ignored_.end(), body)) return false;
    // A body that a step left without a place is nowhere.
    if (!access_.bodies.position(body).allFinite()) return false;
    return !filter_.predicate || filter_.predicate(access_.id(collider), access_.colliders.child[collider]);
  }

 private:
  // True if any shape of the body may touch the collider.
  bool may_touch(std::uint32_t body, std::uint32_t collider) const {
    bool any = false;
    if (access_.colliders.body[collider] == body) return any;
    access_.colliders.for_each_of(body, [&](std::uint32_t own) {
      any |= access_.broadphase.proxies().contains(own) && access_.broadphase.filters().allowed(own, collider) &&
             !access_.choices.is_refused(collision::Pair::of(own, collider));
    });
    return any;
  }

  bool wanted(BodyType type) const {
    switch (type) {
      case BodyType::Static:
        return filter_.static_bodies;
      case BodyType::Kinematic:
        return filter_.kinematic_bodies;
      case BodyType::Dynamic:
        break;
    }
    return filter_.dynamic_bodies;
  }

  const QueryAccess& access_;
  const QueryFilter& filter_;
  std::vector<std::uint32_t> ignored_;
};

void check_distance(const std::string& what, double value, bool may_be_infinite) {
  if (value >= 0 && (value < infinity || may_be_infinite)) return;
  std::ostringstream message;
  message << what << " is " << value << "; expected a number not below 0" << (may_be_infinite ? "" : ", finite");
  throw Error(message.str());
}

struct CheckedRay {
  collision::Ray ray;
  collision::Sides sides;
};

CheckedRay checked(const std::string& what, const Ray& ray) {
  check_number(what + ".origin", ray.origin);
  check_finite(what + ".direction", ray.direction);
  check_distance(what + ".max_distance", ray.max_distance, true);
  if (ray.direction.isZero(0)) throw Error(what + ".direction is zero; expected any other vector");
  return {{ray.origin, unit_of(ray.direction), ray.max_distance},
          ray.both_sides ? collision::Sides::Both : collision::Sides::Front};
}

collision::PlacedShape checked(const std::string& what, const ConvexShape* shape, const Vector3& position,
                               const Quaternion& orientation) {
  check_number(what + ".position", position);
  const collision::Pose pose{position, checked_orientation((what + ".orientation").c_str(), orientation)};
  if (shape == nullptr) return {collision::Shape::sphere(0), pose};
  // The hull, if it is one, belongs to the caller's shape, which outlives the call.
  const auto colliders_of = [&](const auto& one) { return checked_colliders((what + ".shape").c_str(), one); };
  return collision::centred(std::visit(colliders_of, *shape).front().shape, pose);
}

collision::PlacedShape checked(const std::string& what, const QueryShape& placed) {
  return checked(what, placed.shape ? &*placed.shape : nullptr, placed.position, placed.orientation);
}

collision::PlacedShape checked(const std::string& what, const ShapeCast& cast) {
  check_number(what + ".translation", cast.translation);
  return checked(what, &cast.shape, cast.position, cast.orientation);
}

std::optional<std::uint32_t> triangle_of(std::uint32_t number) {
  if (number == collision::RayHit::no_triangle) return std::nullopt;
  return number;
}

RayHit named(const QueryAccess& access, const collision::ColliderRayHit& found) {
  const collision::RayHit& hit = found.hit;
  return {access.id(found.collider),
          access.colliders.child[found.collider],
          hit.t,
          found.point,
          hit.normal,
          triangle_of(hit.triangle),
          hit.started_inside,
          found.depth};
}

ShapeHit named(const QueryAccess& access, const collision::ColliderSweepHit& found, double length) {
  const collision::SweepHit& hit = found.hit;
  return {access.id(found.collider),
          access.colliders.child[found.collider],
          hit.t * length,
          hit.point,
          -hit.normal,
          triangle_of(hit.triangle),
          hit.started_overlapping,
          found.depth};
}

std::optional<RayHit> first_hit(const QueryAccess& access, const CheckedRay& ray, const Filter& filter) {
  collision::ColliderRayHit found;
  if (!collision::cast_ray(access.scene(), ray.ray, ray.sides, filter, found)) return std::nullopt;
  return named(access, found);
}

bool any_hit(const QueryAccess& access, const CheckedRay& ray, const Filter& filter) {
  collision::ColliderRayHit unused;
  return collision::cast_ray_any(access.scene(), ray.ray, ray.sides, filter, unused);
}

std::optional<ShapeHit> first_hit(const QueryAccess& access, const collision::PlacedShape& solid,
                                  const Vector3& translation, const Filter& filter) {
  collision::ColliderSweepHit found;
  if (!collision::cast_shape(access.scene(), solid.shape, solid.pose, translation, filter, found)) return std::nullopt;
  return named(access, found, translation.norm());
}

std::vector<BodyId> overlapped(const QueryAccess& access, const collision::PlacedShape& solid, const Filter& filter) {
  std::vector<std::uint32_t> found;
  collision::find_overlaps(access.scene(), solid.shape, solid.pose, filter, found);
  std::vector<BodyId> bodies;
  for (const std::uint32_t collider : found) {
    const BodyId id = access.id(collider);
    if (bodies.empty() || bodies.back() != id) bodies.push_back(id);
  }
  return bodies;
}

ClosestPoint named(const QueryAccess& access, const collision::ColliderDistance& found) {
  const collision::Distance& distance = found.distance;
  return {access.id(found.collider),
          access.colliders.child[found.collider],
          distance.distance,
          distance.on_other,
          distance.on_solid,
          -distance.normal,
          triangle_of(distance.triangle)};
}

std::optional<ClosestPoint> closest(const QueryAccess& access, const collision::PlacedShape& solid, double max_distance,
                                    const Filter& filter) {
  collision::ColliderDistance found;
  if (!collision::find_closest(access.scene(), solid.shape, solid.pose, max_distance, filter, found)) {
    return std::nullopt;
  }
  return named(access, found);
}

template <typename Named>
std::vector<Named> all_named(const QueryAccess& access, const auto& found, const auto&... more) {
  std::vector<Named> all;
  all.reserve(found.size());
  for (const auto& each : found) all.push_back(named(access, each, more...));
  return all;
}

std::string numbered(const char* what, std::size_t i) { return what + ("[" + std::to_string(i) + "]"); }

// Checks all questions, then answers them in parallel.
template <typename Answer, typename Question, typename Respond>
std::vector<Answer> answer_all(const QueryAccess& access, const char* what, std::span<const Question> questions,
                               const Respond& respond) {
  std::vector<decltype(checked(std::string(), questions[0]))> good;
  good.reserve(questions.size());
  for (std::size_t i = 0; i < questions.size(); ++i) good.push_back(checked(numbered(what, i), questions[i]));
  std::vector<Answer> answers(questions.size());
  access.arena.parallel_for(questions.size(), batch_grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) answers[i] = respond(good[i], i);
  });
  return answers;
}

}  // namespace

Queries::Queries(const World& world) : world_(&world) {}

std::optional<RayHit> Queries::cast_ray(const Ray& ray, const QueryFilter& filter) const {
  const QueryAccess access = QueryAccess::of(*world_);
  return first_hit(access, checked("Queries::cast_ray: ray", ray), Filter(access, filter));
}

std::vector<RayHit> Queries::cast_ray_through(const Ray& ray, const QueryFilter& filter) const {
  const QueryAccess access = QueryAccess::of(*world_);
  const CheckedRay good = checked("Queries::cast_ray_through: ray", ray);
  std::vector<collision::ColliderRayHit> found;
  const Filter accept(access, filter);
  collision::cast_ray_all(access.scene(), good.ray, good.sides, accept, found);
  return all_named<RayHit>(access, found);
}

bool Queries::is_blocked(const Ray& ray, const QueryFilter& filter) const {
  const QueryAccess access = QueryAccess::of(*world_);
  return any_hit(access, checked("Queries::is_blocked: ray", ray), Filter(access, filter));
}

std::optional<ShapeHit> Queries::cast_shape(const ShapeCast& cast, const QueryFilter& filter) const {
  const QueryAccess access = QueryAccess::of(*world_);
  return first_hit(access, checked("Queries::cast_shape: cast", cast), cast.translation, Filter(access, filter));
}

std::vector<ShapeHit> Queries::cast_shape_through(const ShapeCast& cast, const QueryFilter& filter) const {
  const QueryAccess access = QueryAccess::of(*world_);
  const collision::PlacedShape solid = checked("Queries::cast_shape_through: cast", cast);
  std::vector<collision::ColliderSweepHit> found;
  const Filter accept(access, filter);
  collision::cast_shape_all(access.scene(), solid.shape, solid.pose, cast.translation, accept, found);
  return all_named<ShapeHit>(access, found, cast.translation.norm());
}

std::vector<BodyId> Queries::overlapping(const QueryShape& shape, const QueryFilter& filter) const {
  const QueryAccess access = QueryAccess::of(*world_);
  return overlapped(access, checked("Queries::overlapping: shape", shape), Filter(access, filter));
}

std::optional<ClosestPoint> Queries::closest_point(const QueryShape& shape, double max_distance,
                                                   const QueryFilter& filter) const {
  const QueryAccess access = QueryAccess::of(*world_);
  check_distance("Queries::closest_point: max_distance", max_distance, false);
  return closest(access, checked("Queries::closest_point: shape", shape), max_distance, Filter(access, filter));
}

std::vector<ClosestPoint> Queries::nearby(const QueryShape& shape, double max_distance,
                                          const QueryFilter& filter) const {
  const QueryAccess access = QueryAccess::of(*world_);
  check_distance("Queries::nearby: max_distance", max_distance, false);
  const collision::PlacedShape solid = checked("Queries::nearby: shape", shape);
  std::vector<collision::ColliderDistance> found;
  const Filter accept(access, filter);
  collision::find_near(access.scene(), solid.shape, solid.pose, max_distance, accept, found);
  return all_named<ClosestPoint>(access, found);
}

std::vector<std::optional<RayHit>> Queries::cast_rays(std::span<const Ray> rays, const QueryFilter& filter) const {
  const QueryAccess access = QueryAccess::of(*world_);
  const Filter accept(access, filter);
  return answer_all<std::optional<RayHit>>(
      access, "Queries::cast_rays: rays", rays,
      [&](const CheckedRay& ray, std::size_t) { return first_hit(access, ray, accept); });
}

std::vector<std::uint8_t> Queries::are_blocked(std::span<const Ray> rays, const QueryFilter& filter) const {
  const QueryAccess access = QueryAccess::of(*world_);
  const Filter accept(access, filter);
  return answer_all<std::uint8_t>(
      access, "Queries::are_blocked: rays", rays,
      [&](const CheckedRay& ray, std::size_t) -> std::uint8_t { return any_hit(access, ray, accept); });
}

std::vector<std::optional<ShapeHit>> Queries::cast_shapes(std::span<const ShapeCast> casts,
                                                          const QueryFilter& filter) const {
  const QueryAccess access = QueryAccess::of(*world_);
  const Filter accept(access, filter);
  return answer_all<std::optional<ShapeHit>>(access, "Queries::cast_shapes: casts", casts,
                                             [&](const collision::PlacedShape& solid, std::size_t i) {
                                               return first_hit(access, solid, casts[i].translation, accept);
                                             });
}

std::vector<std::vector<BodyId>> Queries::overlapping(std::span<const QueryShape> shapes,
                                                      const QueryFilter& filter) const {
  const QueryAccess access = QueryAccess::of(*world_);
  const Filter accept(access, filter);
  return answer_all<std::vector<BodyId>>(
      access, "Queries::overlapping: shapes", shapes,
      [&](const collision::PlacedShape& solid, std::size_t) { return overlapped(access, solid, accept); });
}

std::vector<std::optional<ClosestPoint>> Queries::closest_points(std::span<const QueryShape> shapes,
                                                                 double max_distance, const QueryFilter& filter) const {
  const QueryAccess access = QueryAccess::of(*world_);
  check_distance("Queries::closest_points: max_distance", max_distance, false);
  const Filter accept(access, filter);
  return answer_all<std::optional<ClosestPoint>>(
      access, "Queries::closest_points: shapes", shapes,
      [&](const collision::PlacedShape& solid, std::size_t) { return closest(access, solid, max_distance, accept); });
}

}  // namespace atl
