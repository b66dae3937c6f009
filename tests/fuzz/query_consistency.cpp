#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "consistency.h"
#include "finding.h"

namespace atl::fuzz {
namespace {

// Queries don't find it.
bool is_out(const World& world, BodyId id) { return world.is_quarantined(id) || !world.is_enabled(id); }

// A world of one of the bodies, as it is.
World alone(const World& world, BodyId id) {
  World one;
  one.add_body(world.definition(id));
  return one;
}

template <typename Hit>
bool agree(const std::optional<Hit>& a, const std::optional<Hit>& b) {
  if (a.has_value() != b.has_value()) return false;
  return !a || (a->body == b->body && a->child == b->child && a->distance == b->distance && a->normal == b->normal);
}

// The nearest of the answers of worlds of one body each, to what ask(queries) asks.
template <typename Ask>
std::optional<double> nearest_alone(const World& world, const Ask& ask) {
  std::optional<double> nearest;
  for (const BodyId id : world.bodies()) {
    if (is_out(world, id)) continue;
    const World one = alone(world, id);
    const auto hit = ask(Queries(one));
    if (hit && (!nearest || hit->distance < *nearest)) nearest = hit->distance;
  }
  return nearest;
}

// Frames of bodies are told to the rounding of where their centres of mass are.
template <typename Hit>
void require_nearest(const std::optional<Hit>& hit, const std::optional<double>& alone, double tolerance,
                     const char* what) {
  require(hit.has_value() == alone.has_value(),
          std::string(what) + (hit ? " hits what" : " misses what") + " worlds of one body " + (hit ? "miss" : "hit"));
  require(!hit || std::abs(hit->distance - *alone) < tolerance,
          std::string(what) + " is at " + std::to_string(hit ? hit->distance : 0) + " m, in worlds of one body at " +
              std::to_string(alone.value_or(0)));
}

void check_overlaps(const World& world, const QueryShape& query, const std::vector<BodyId>& found) {
  if (!query.shape) return;
  const PlacedShape placed{.shape = std::visit([](const auto& solid) { return Shape(solid); }, *query.shape),
                           .pose = {query.position, query.orientation.normalized()}};
  for (const BodyId id : world.bodies()) {
    if (is_out(world, id)) continue;
    BodyDef def = world.definition(id);
    if (def.sensor || !keep_what_is_seen(def)) continue;
    // Meshes have no inside here, and in the audit a solid below a field is deep in it.
    if (std::holds_alternative<TriangleMesh>(def.shape) || std::holds_alternative<HeightField>(def.shape)) continue;
    const double depth = overlap(placed, {def.type, def.shape, world.pose(id)});
    const bool is_found = std::binary_search(found.begin(), found.end(), id);
    require(is_found || depth < 1e-6,
            "overlapping() misses body " + std::to_string(id.index) + ", which overlaps by " + std::to_string(depth));
    require(!is_found || depth > -1e-6, "overlapping() finds a body at a distance of " + std::to_string(-depth));
  }
}

bool all_solid(const World& world) {
  const std::vector<BodyId> bodies = world.bodies();
  return std::none_of(bodies.begin(), bodies.end(), [&](BodyId id) { return world.definition(id).sensor; });
}

template <typename Hits>
void require_finite_hits(const Hits& hits) {
  for (const auto& hit : hits) {
    require_finite(hit.distance, "a hit's distance");
    require(hit.distance >= 0, "a hit's distance is negative");
    require_finite(hit.normal, "a hit's normal");
  }
}

void check_rays(std::span<const World> worlds, const Ray& ray, bool has_normal_numbers) {
  const std::optional<RayHit> first = Queries(worlds.front()).cast_ray(ray);
  for (const World& world : worlds) {
    require(agree(Queries(world).cast_ray(ray), first), "cast_ray differs between worlds");
    require(Queries(world).is_blocked(ray) == first.has_value(), "is_blocked is at odds with cast_ray");
  }
  const std::vector<RayHit> all = Queries(worlds.front()).cast_ray_through(ray);
  require_finite_hits(all);
  require(agree(first, all.empty() ? std::nullopt : std::optional(all.front())),
          "cast_ray is at odds with cast_ray_through");
  if (!has_normal_numbers || !all_solid(worlds.front())) return;
  require_nearest(first, nearest_alone(worlds.front(), [&](const Queries& one) { return one.cast_ray(ray); }), 1e-6,
                  "cast_ray");
}

void check_casts(std::span<const World> worlds, const ShapeCast& cast, bool has_normal_numbers) {
  const std::optional<ShapeHit> first = Queries(worlds.front()).cast_shape(cast);
  for (const World& world : worlds) {
    require(agree(Queries(world).cast_shape(cast), first), "cast_shape differs between worlds");
  }
  const std::vector<ShapeHit> all = Queries(worlds.front()).cast_shape_through(cast);
  require_finite_hits(all);
  // Against what is 1e12 m long distances are known to meters, and what else is met at once decides whether it is
  // asked.
  const auto is_first = [&](const ShapeHit& hit) { return agree(first, std::optional(hit)); };
  require(has_normal_numbers
              ? agree(first, all.empty() ? std::nullopt : std::optional(all.front()))
              : first.has_value() == !all.empty() && (!first || std::any_of(all.begin(), all.end(), is_first)),
          "cast_shape is at odds with cast_shape_through");
  if (!has_normal_numbers || !all_solid(worlds.front())) return;
  require_nearest(first, nearest_alone(worlds.front(), [&](const Queries& one) { return one.cast_shape(cast); }), 1e-5,
                  "cast_shape");
}

void check_places(std::span<const World> worlds, const QueryShape& query, double reach, bool has_normal_numbers) {
  const std::vector<BodyId> found = Queries(worlds.front()).overlapping(query);
  const std::optional<ClosestPoint> closest = Queries(worlds.front()).closest_point(query, reach);
  for (const World& world : worlds) {
    require(Queries(world).overlapping(query) == found, "overlapping differs between worlds");
    require(agree(Queries(world).closest_point(query, reach), closest), "closest_point differs between worlds");
  }
  if (closest) {
    require_finite(closest->distance, "a closest point's distance");
    // Rounding may say of what is 1e30 m long that it is touched.
    const bool is_rounding = !has_normal_numbers && closest->distance == 0;
    require(is_rounding || (closest->distance <= 0) == !found.empty(), "closest_point is at odds with overlapping");
    require(closest->distance <= reach, "a closest point is out of reach");
    require_finite(closest->on_body, "a closest point");
    require_finite(closest->on_shape, "a closest point");
  }
  const std::vector<ClosestPoint> near = Queries(worlds.front()).nearby(query, reach);
  require(agree(closest, near.empty() ? std::nullopt : std::optional(near.front())),
          "closest_point is at odds with nearby");
  if (!has_normal_numbers || !all_solid(worlds.front())) return;
  check_overlaps(worlds.front(), query, found);
  require_nearest(closest,
                  nearest_alone(worlds.front(), [&](const Queries& one) { return one.closest_point(query, reach); }),
                  1e-5, "closest_point");
}

}  // namespace

void check_queries(std::span<const World> worlds, Definitions& definitions, Bytes& bytes) {
  const bool has_normal_numbers = definitions.has_normal_numbers();
  try {
    switch (bytes.below(3)) {
      case 0:
        return check_rays(worlds, definitions.ray(), has_normal_numbers);
      case 1:
        return check_casts(worlds, definitions.shape_cast(), has_normal_numbers);
      default: {
        const QueryShape query = definitions.query_shape();
        return check_places(worlds, query, definitions.number(0, 5), has_normal_numbers);
      }
    }
  } catch (const Error& error) {
    require(!has_normal_numbers, std::string("a query is refused: ") + error.what());
  }
}

namespace {

// A filter, and the same in words of definitions, as far as they have any.
struct Choice {
  std::vector<BodyId> ignored = {};
  QueryFilter filter = {};

  bool accepts(const World& world, BodyId id, std::uint32_t child) const {
    const BodyDef def = world.definition(id);
    CollisionFilter own = def.filter;
    if (const auto* compound = std::get_if<Compound>(&def.shape)) {
      own = compound->children.at(child).filter.value_or(own);
    }
    const bool is_wanted = def.type == BodyType::Static      ? filter.static_bodies
                           : def.type == BodyType::Kinematic ? filter.kinematic_bodies
                                                             : filter.dynamic_bodies;
    return is_wanted && (filter.sensors || !def.sensor) && (filter.mask & own.category) != 0 &&
           (own.mask & filter.category) != 0 && std::ranges::find(ignored, id) == ignored.end() &&
           (!filter.predicate || filter.predicate(id, child));
  }
};

void choose(Choice& choice, const World& world, Bytes& bytes) {
  QueryFilter& filter = choice.filter;
  if (bytes.flag()) filter.category = bytes.bits<std::uint8_t>();
  if (bytes.flag()) filter.mask = bytes.bits<std::uint8_t>();
  filter.static_bodies = !bytes.one_in(3);
  filter.kinematic_bodies = !bytes.one_in(3);
  filter.dynamic_bodies = !bytes.one_in(3);
  filter.sensors = bytes.flag();
  const std::vector<BodyId> bodies = world.bodies();
  for (std::uint32_t left = bytes.below(4); left > 0 && !bodies.empty(); --left) {
    choice.ignored.push_back(bodies[bytes.below(bodies.size())]);
  }
  choice.ignored.push_back({.index = 1u << 30, .generation = 7});  // of no body: does no harm
  filter.ignore = choice.ignored;
  if (bytes.flag()) filter.predicate = [](BodyId id, std::uint32_t child) { return (id.index + child) % 3 != 0; };
}

template <typename Hit>
bool agree(const std::vector<Hit>& a, const std::vector<Hit>& b) {
  return std::ranges::equal(
      a, b, [](const Hit& x, const Hit& y) { return agree(std::optional<Hit>(x), std::optional<Hit>(y)); });
}

// Whatever the filters of both, a body that asks for what it may touch finds neither itself nor sensors.
void check_what_touches(const World& world, const Ray& ray, Bytes& bytes) {
  const std::vector<BodyId> bodies = world.bodies();
  if (bodies.empty()) return;
  const BodyId as = bodies[bytes.below(bodies.size())];
  for (const RayHit& hit : Queries(world).cast_ray_through(ray, {.sensors = true, .as = as})) {
    require(hit.body != as && !world.definition(hit.body).sensor, "a body may touch itself, or a sensor");
  }
  const BodyId stale = {.index = as.index, .generation = as.generation + 1};
  require_refused("a query as a body that is not there", [&] { Queries(world).is_blocked(ray, {.as = stale}); });
}

void check_filtered(const World& world, const Ray& ray, Bytes& bytes) {
  Choice choice;
  choose(choice, world, bytes);
  std::vector<RayHit> expected = Queries(world).cast_ray_through(ray, {.sensors = true});
  std::erase_if(expected, [&](const RayHit& hit) { return !choice.accepts(world, hit.body, hit.child); });
  require(agree(Queries(world).cast_ray_through(ray, choice.filter), expected), "a filter lets other hits through");
  check_what_touches(world, ray, bytes);
}

// Requires a batch to be answered like single questions. Batches of some dozens are shared among threads.
template <typename Question, typename AskAll, typename Ask, typename Agree>
void check_batch(const std::vector<Question>& some, std::size_t count, const AskAll& ask_all, const Ask& ask,
                 const Agree& agree) {
  std::vector<Question> questions;
  for (std::size_t i = 0; i < count; ++i) questions.push_back(some[i % some.size()]);
  const auto answers = ask_all(questions);
  require(answers.size() == count, "a batch has another number of answers than questions");
  for (std::size_t i = 0; i < count; ++i)
    require(agree(answers[i], ask(questions[i])), "a batch is answered otherwise");
}

void check_batches(const World& world, Definitions& definitions, Bytes& bytes) {
  const Queries queries(world);
  Choice choice;
  choose(choice, world, bytes);
  const QueryFilter& filter = choice.filter;
  const std::size_t count = bytes.one_in(4) ? 70 : bytes.below(4);
  const auto same = [](const auto& a, const auto& b) { return agree(a, b); };
  const auto equal = [](const auto& a, const auto& b) { return a == b; };
  const std::vector<Ray> rays = {definitions.ray(), definitions.ray()};
  check_batch(
      rays, count, [&](const auto& all) { return queries.cast_rays(all, filter); },
      [&](const Ray& ray) { return queries.cast_ray(ray, filter); }, same);
  check_batch(
      rays, count, [&](const auto& all) { return queries.are_blocked(all, filter); },
      [&](const Ray& ray) { return std::uint8_t{queries.is_blocked(ray, filter)}; }, equal);
  check_batch(
      std::vector{definitions.shape_cast()}, count % 40,
      [&](const auto& all) { return queries.cast_shapes(all, filter); },
      [&](const ShapeCast& cast) { return queries.cast_shape(cast, filter); }, same);
  const std::vector<QueryShape> shapes = {definitions.query_shape()};
  check_batch(
      shapes, count % 40, [&](const auto& all) { return queries.overlapping(all, filter); },
      [&](const QueryShape& shape) { return queries.overlapping(shape, filter); }, equal);
  const double reach = definitions.number(0, 5);
  check_batch(
      shapes, count % 40, [&](const auto& all) { return queries.closest_points(all, reach, filter); },
      [&](const QueryShape& shape) { return queries.closest_point(shape, reach, filter); }, same);
}

}  // namespace

bool keep_what_is_seen(BodyDef& def) {
  const auto is_seen = [](const CollisionFilter& filter) { return filter.mask != 0 && filter.category != 0; };
  auto* const compound = std::get_if<Compound>(&def.shape);
  if (compound == nullptr) return is_seen(def.filter);
  std::erase_if(compound->children,
                [&](const CompoundChild& child) { return !is_seen(child.filter.value_or(def.filter)); });
  return !compound->children.empty();
}

void check_filtered_queries(std::span<const World> worlds, Definitions& definitions, Bytes& bytes) {
  try {
    if (bytes.flag()) return check_filtered(worlds.back(), definitions.ray(), bytes);
    check_batches(worlds.back(), definitions, bytes);
  } catch (const Error& error) {
    require(!definitions.has_normal_numbers(), std::string("a query is refused: ") + error.what());
  }
}

}  // namespace atl::fuzz
