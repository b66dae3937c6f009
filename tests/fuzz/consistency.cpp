#include "consistency.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>
#include <string>
#include <variant>

#include "finding.h"

namespace atl::fuzz {
namespace {

void require_finite(double value, const char* what) {
  require(std::isfinite(value), std::string(what) + " is " + std::to_string(value));
}
template <typename Derived>
std::string text_of(const Eigen::DenseBase<Derived>& values) {
  std::ostringstream out;
  out.precision(17);
  out << values.derived().transpose();
  return out.str();
}
template <typename Derived>
void require_finite(const Eigen::DenseBase<Derived>& values, const char* what) {
  require(values.allFinite(), std::string(what) + " is " + text_of(values));
}

void check_body(const World& world, BodyId id) {
  require(world.contains(id), "a body of bodies() is not contained");
  const Pose pose = world.pose(id);
  require_finite(pose.position, "a position");
  require_finite(pose.orientation.coeffs(), "an orientation");
  require(std::abs(pose.orientation.norm() - 1) < 1e-6, "an orientation is no unit quaternion");
  require_finite(world.centre_of_mass(id), "a centre of mass");
  require_finite(world.velocity(id), "a velocity");
  require_finite(world.angular_velocity(id), "an angular velocity");
  require(world.mass(id) > 0, "a mass is not positive");
  if (world.type(id) != BodyType::Dynamic) return;
  const MotionLocks locks = world.definition(id).locks;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    require(!locks.linear[axis] || world.velocity(id)[i] == 0, "a body moves along an axis that is locked");
    require(!locks.angular[axis] || world.angular_velocity(id)[i] == 0, "a body turns about an axis that is locked");
  }
}

void check_joint(const World& world, JointId id) {
  require(world.contains(id), "a joint of joints() is not contained");
  const JointState state = world.joint_state(id);
  require_finite(state.force, "a joint's force");
  require_finite(state.torque, "a joint's torque");
  for (const double x : state.position) require_finite(x, "a joint's position");
  for (const double x : state.speed) require_finite(x, "a joint's speed");
  require(!(state.enabled && state.broken), "a joint is enabled and broken");
}

void check_contact_problem(const World& world) {
  const ContactProblem problem = world.contact_problem();
  if (problem.patches.empty()) return;
  const ResidualReport residual = measure_contact_residual(problem);
  require_finite(residual.absolute, "a contact residual");
}

}  // namespace

void check_world(const World& world) {
  const std::vector<BodyId> bodies = world.bodies();
  require(bodies.size() == world.body_count(), "body_count() is not that of bodies()");
  require(std::is_sorted(bodies.begin(), bodies.end()), "bodies() are out of order");
  for (const BodyId id : bodies) check_body(world, id);
  const std::vector<JointId> joints = world.joints();
  require(joints.size() == world.joint_count(), "joint_count() is not that of joints()");
  for (const JointId id : joints) check_joint(world, id);

  for (const ContactForce& force : world.contact_forces()) {
    require_finite(force.position, "a contact's position");
    require(std::abs(force.normal.norm() - 1) < 1e-5, "a contact's normal is no unit vector: " + text_of(force.normal));
    require_finite(force.friction, "a contact's friction");
    require_finite(force.normal_force, "a contact's force");
    require(force.normal_force >= 0, "a contact pulls");
    require_finite(force.separation, "a contact's separation");
    require(world.contains(force.a) && world.contains(force.b), "a contact force is on no body");
  }
  for (const PairForce& pair : world.pair_forces()) {
    require_finite(pair.force, "a pair's force");
    require(pair.normal_force >= 0 && pair.a < pair.b, "a pair of bodies is no pair, or pulls");
  }
  if (world.settings().contact_events) {
    for (const ContactEvent& event : world.contact_events()) {
      require_finite(event.point, "a contact event's point");
      require_finite(event.normal, "a contact event's normal");
      require_finite(event.normal_force, "a contact event's force");
    }
  }
  for (const JointEvent& event : world.joint_events()) {
    require_finite(event.force, "a joint event's force");
    require_finite(event.torque, "a joint event's torque");
  }
  for (const Quarantined& out : world.quarantined()) {
    require(world.contains(out.id) && world.is_quarantined(out.id), "quarantined() tells of a body that is not");
  }
  if (world.settings().keep_contact_problem) check_contact_problem(world);
  for (const MemoryUse& use : world.memory()) require(use.bytes < (std::size_t{1} << 40), "absurd memory");
}

void check_same_results(const World& a, const World& b) {
  require(a.sensor_events().size() == b.sensor_events().size(), "sensor events differ");
  require(a.joint_events().size() == b.joint_events().size(), "joint events differ");
  require(a.selected_solves().size() == b.selected_solves().size(), "selected solves differ");
  const std::span<const ContactForce> first = a.contact_forces(), second = b.contact_forces();
  require(std::equal(first.begin(), first.end(), second.begin(), second.end(),
                     [](const ContactForce& x, const ContactForce& y) {
                       return x.a == y.a && x.b == y.b && x.normal_force == y.normal_force &&
                              x.friction == y.friction && x.position == y.position && x.feature_id == y.feature_id;
                     }),
          "contact forces differ");
}

void check_same_reports(const StepReport& a, const StepReport& b) {
  const auto require_same = [](auto x, auto y, const char* what) {
    require(x == y, std::string(what) + " of the reports differ: " + std::to_string(x) + " and " + std::to_string(y));
  };
  require_same(a.quarantined, b.quarantined, "quarantined");
  require_same(a.first_quarantined, b.first_quarantined, "first_quarantined");
  require_same(a.counts.contacts, b.counts.contacts, "contacts");
  require_same(a.counts.points, b.counts.points, "points");
  require_same(a.counts.joints, b.counts.joints, "joints");
  require_same(a.counts.islands, b.counts.islands, "islands");
  require_same(a.counts.direct_islands, b.counts.direct_islands, "direct_islands");
  require_same(a.counts.refined_islands, b.counts.refined_islands, "refined_islands");
  require_same(a.counts.unsolved_islands, b.counts.unsolved_islands, "unsolved_islands");
  require_same(a.counts.newton_iterations, b.counts.newton_iterations, "newton_iterations");
  require_same(a.counts.fcl_calls, b.counts.fcl_calls, "fcl_calls");
  require_same(a.counts.asleep, b.counts.asleep, "asleep");
  require_same(a.counts.swept, b.counts.swept, "swept");
  require_same(a.counts.stopped, b.counts.stopped, "stopped");
}

namespace {

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
    if (world.is_quarantined(id)) continue;
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

// Then no query finds it, or not all of it.
bool lets_nothing_touch(const BodyDef& def) {
  if (def.filter.mask == 0) return true;
  const Compound* const compound = std::get_if<Compound>(&def.shape);
  return compound != nullptr && std::any_of(compound->children.begin(), compound->children.end(),
                                            [](const auto& child) { return child.filter && child.filter->mask == 0; });
}

void check_overlaps(const World& world, const QueryShape& query, const std::vector<BodyId>& found) {
  if (!query.shape) return;
  const PlacedShape placed{.shape = std::visit([](const auto& solid) { return Shape(solid); }, *query.shape),
                           .pose = {query.position, query.orientation.normalized()}};
  for (const BodyId id : world.bodies()) {
    if (world.is_quarantined(id)) continue;
    const BodyDef def = world.definition(id);
    if (def.sensor || lets_nothing_touch(def)) continue;
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

void check_rays(std::span<const World> worlds, const Ray& ray, bool usual) {
  const std::optional<RayHit> first = Queries(worlds.front()).cast_ray(ray);
  for (const World& world : worlds) {
    require(agree(Queries(world).cast_ray(ray), first), "cast_ray differs between worlds");
    require(Queries(world).is_blocked(ray) == first.has_value(), "is_blocked is at odds with cast_ray");
  }
  const std::vector<RayHit> all = Queries(worlds.front()).cast_ray_through(ray);
  require_finite_hits(all);
  require(agree(first, all.empty() ? std::nullopt : std::optional(all.front())),
          "cast_ray is at odds with cast_ray_through");
  if (!usual || !all_solid(worlds.front())) return;
  require_nearest(first, nearest_alone(worlds.front(), [&](const Queries& one) { return one.cast_ray(ray); }), 1e-6,
                  "cast_ray");
}

void check_casts(std::span<const World> worlds, const ShapeCast& cast, bool usual) {
  const std::optional<ShapeHit> first = Queries(worlds.front()).cast_shape(cast);
  for (const World& world : worlds) {
    require(agree(Queries(world).cast_shape(cast), first), "cast_shape differs between worlds");
  }
  const std::vector<ShapeHit> all = Queries(worlds.front()).cast_shape_through(cast);
  require_finite_hits(all);
  // Against what is 1e12 m long distances are known to meters, and what else is met at once decides whether it is
  // asked.
  const auto is_first = [&](const ShapeHit& hit) { return agree(first, std::optional(hit)); };
  require(usual ? agree(first, all.empty() ? std::nullopt : std::optional(all.front()))
                : first.has_value() == !all.empty() && (!first || std::any_of(all.begin(), all.end(), is_first)),
          "cast_shape is at odds with cast_shape_through");
  if (!usual || !all_solid(worlds.front())) return;
  require_nearest(first, nearest_alone(worlds.front(), [&](const Queries& one) { return one.cast_shape(cast); }), 1e-5,
                  "cast_shape");
}

void check_places(std::span<const World> worlds, const QueryShape& query, double reach, bool usual) {
  const std::vector<BodyId> found = Queries(worlds.front()).overlapping(query);
  const std::optional<ClosestPoint> closest = Queries(worlds.front()).closest_point(query, reach);
  for (const World& world : worlds) {
    require(Queries(world).overlapping(query) == found, "overlapping differs between worlds");
    require(agree(Queries(world).closest_point(query, reach), closest), "closest_point differs between worlds");
  }
  if (closest) {
    require_finite(closest->distance, "a closest point's distance");
    require(closest->distance >= 0 && closest->distance <= reach, "a closest point is out of reach");
    require_finite(closest->on_body, "a closest point");
    require_finite(closest->on_shape, "a closest point");
  }
  if (!usual || !all_solid(worlds.front())) return;
  check_overlaps(worlds.front(), query, found);
  require_nearest(closest,
                  nearest_alone(worlds.front(), [&](const Queries& one) { return one.closest_point(query, reach); }),
                  1e-5, "closest_point");
}

}  // namespace

void check_queries(std::span<const World> worlds, Definitions& definitions, Bytes& bytes) {
  const bool usual = definitions.usual();
  try {
    switch (bytes.below(3)) {
      case 0:
        return check_rays(worlds, definitions.ray(), usual);
      case 1:
        return check_casts(worlds, definitions.shape_cast(), usual);
      default: {
        const QueryShape query = definitions.query_shape();
        return check_places(worlds, query, definitions.number(0, 5), usual);
      }
    }
  } catch (const Error& error) {
    require(!usual, std::string("a query is refused: ") + error.what());
  }
}

}  // namespace atl::fuzz
