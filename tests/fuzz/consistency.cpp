#include "consistency.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "finding.h"

namespace atl::fuzz {
namespace {

// Requires queries for one body to agree with those for many bodies, and with its definition.
void check_both_ways(const World& world, BodyId id) {
  const BodyDef def = world.definition(id);
  const BodyState state = world.state(id);
  const Pose pose = world.pose(id);
  const auto i = static_cast<Eigen::Index>(id.index);
  require(state.pose.position == pose.position && state.pose.orientation.coeffs() == pose.orientation.coeffs() &&
              world.orientations().col(i) == pose.orientation.coeffs(),
          "a body is told to be in two places");
  require(world.positions().col(i) == world.centre_of_mass(id), "a centre of mass is told to be in two places");
  require(state.velocity == world.velocity(id) && world.velocities().col(i) == state.velocity &&
              state.angular_velocity == world.angular_velocity(id) &&
              world.angular_velocities().col(i) == state.angular_velocity,
          "a body is told to have two velocities");
  require(world.material(id) == def.material && world.user_data(id) == def.user_data && world.name(id) == def.name,
          "a body's definition is at odds with what is told of it");
  if (!def.name.empty()) {
    const std::optional<BodyId> named = world.find_body(def.name);
    require(named && world.contains(*named) && world.name(*named) == def.name, "a body isn't found by its name");
  }
  require(!world.is_asleep(id) || def.type == BodyType::Dynamic, "a body sleeps that is not dynamic");
  if (def.sensor) {
    const std::vector<BodyId> within = world.bodies_in(id);
    require(std::is_sorted(within.begin(), within.end()), "bodies in a sensor are out of order");
  } else {
    require_refused("bodies_in() of what is no sensor", [&] { world.bodies_in(id); });
  }
  if (def.type != BodyType::Dynamic) require_refused("the mass of what has none", [&] { body_mass(def); });
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
  check_both_ways(world, id);
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
  const std::string& name = world.joint(id).name;
  if (name.empty()) return;
  const std::optional<JointId> named = world.find_joint(name);
  require(named && world.contains(*named) && world.joint(*named).name == name, "a joint isn't found by its name");
}

// Each contact force must be listed for both of its bodies; without the setting, asking for events must be refused.
void check_contacts(const World& world, const std::vector<BodyId>& bodies) {
  std::size_t forces = 0;
  for (const BodyId id : bodies) forces += world.contact_forces(id).size();
  require(forces == 2 * world.contact_forces().size(), "contact forces of bodies are not those of the world");
  if (!world.settings().contact_events) {
    require_refused("contact_events() without the setting", [&] { world.contact_events(); });
  }
}

void check_hashes(const World& world, const std::vector<BodyId>& bodies) {
  const std::vector<BodyHash> hashes = world.body_hashes();
  for (const BodyId id : bodies) {
    require(world.body_hash(id) == hashes[id.index], "a body has another hash alone than among all");
  }
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
  const Eigen::Matrix3Xd origins = world.origins();
  for (const BodyId id : bodies) require(origins.col(id.index) == world.pose(id).position, "origins() are elsewhere");
  check_hashes(world, bodies);
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
  check_contacts(world, bodies);
  for (const PairForce& pair : world.pair_forces()) {
    require_finite(pair.force, "a pair's force");
    require(pair.normal_force >= 0 && pair.a < pair.b, "a pair of bodies is no pair, or pulls");
  }
  if (world.settings().contact_events) {
    for (const ContactEvent& event : world.contact_events()) {
      require_finite(event.point, "a contact event's point");
      require_finite(event.normal, "a contact event's normal");
      require_finite(event.normal_force, "a contact event's force");
      require(!(event.began && event.persists), "a contact begins and goes on");
      require(event.impulse >= 0 && std::isfinite(event.impulse), "a contact event's impulse is none");
    }
  }
  for (const JointEvent& event : world.joint_events()) {
    require_finite(event.force, "a joint event's force");
    require_finite(event.torque, "a joint event's torque");
  }
  for (const Quarantined& out : world.quarantined()) {
    require(world.contains(out.id) && world.is_quarantined(out.id), "quarantined() tells of a body that is not");
  }
  for (const MissedTarget& island : world.missed_targets()) {
    require(island.measured > 0 && island.substeps >= 1 && island.substeps <= 1024, "an island is unheld by no error");
    require(island.bodies > 0 && island.contacts + island.joints > 0, "an unheld island is none");
  }
  if (world.settings().keep_contact_problem) check_contact_problem(world);
  for (const MemoryUse& use : world.memory()) require(use.bytes < (std::size_t{1} << 40), "absurd memory");
}

namespace {

void check_hull(const ConvexHull& hull) {
  require(std::isfinite(hull.volume()) && hull.volume() > 0, "a hull has no volume");
  require_finite(hull.centre_of_mass(), "a hull's centre of mass");
  require(hull.vertices().size() >= 4 && hull.vertices().size() <= 255, "a hull has too few vertices, or too many");
  require(!hull.simplified(), "a hull of few points is simplified");
  // A closed surface without holes: Euler's formula, in which each edge is of two faces.
  std::size_t corners = 0;
  for (std::size_t i = 0; i < hull.face_count(); ++i) {
    const std::span<const std::uint16_t> face = hull.face(i);
    require(
        face.size() >= 3 && std::all_of(face.begin(), face.end(), [&](auto at) { return at < hull.vertices().size(); }),
        "a hull's face is none");
    corners += face.size();
  }
  require(corners % 2 == 0 && hull.vertices().size() + hull.face_count() == corners / 2 + 2, "a hull is not closed");
  require_refused("a face that a hull hasn't", [&] { hull.face(hull.face_count()); });
}

// Sides are joined by their vertices, and those left over by where these lie.
void check_mesh(const TriangleMesh& mesh) {
  const auto order = [](const Vector3& a, const Vector3& b) {
    return std::ranges::lexicographical_compare(std::span(a.data(), 3), std::span(b.data(), 3));
  };
  std::map<Vector3, std::uint32_t, decltype(order)> places(order);
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> by_index, by_place;
  const auto count = [](auto& edges, std::uint32_t from, std::uint32_t to) { ++edges[std::minmax(from, to)]; };
  const auto place = [&](std::uint32_t vertex) {
    return places.try_emplace(mesh.vertices()[vertex], vertex).first->second;
  };
  for (const TriangleMesh::Indices& corners : mesh.triangles()) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t from = corners[i], to = corners[(i + 1) % 3];
      count(by_index, from, to);
      count(by_place, place(from), place(to));
    }
  }
  const bool closed = std::ranges::all_of(by_index, [](const auto& edge) { return edge.second == 2; });
  require(mesh.closed() || !closed, "a closed mesh is open");
  const bool may_be = std::ranges::all_of(by_place, [](const auto& edge) { return edge.second % 2 == 0; });
  require(!mesh.closed() || may_be, "an open mesh is closed");
}

}  // namespace

void check_shape(const Shape& shape) {
  const auto* const hull = std::get_if<ConvexHull>(&shape);
  const auto* const mesh = std::get_if<TriangleMesh>(&shape);
  if (hull != nullptr) check_hull(*hull);
  if (mesh != nullptr) check_mesh(*mesh);
  const bool is_solid =
      mesh == nullptr && !std::holds_alternative<HalfSpace>(shape) && !std::holds_alternative<HeightField>(shape);
  if (!is_solid) return require_refused("the mass of a surface", [&] { mass_properties(shape); });
  require(mass_properties(shape).mass > 0, "a solid has no mass");
}

void check_same_results(const World& a, const World& b) {
  require(a.sensor_events().size() == b.sensor_events().size(), "sensor events differ");
  require(std::ranges::equal(
              a.sleep_events(), b.sleep_events(),
              [](const SleepEvent& x, const SleepEvent& y) { return x.body == y.body && x.asleep == y.asleep; }),
          "sleep events differ");
  require(a.joint_events().size() == b.joint_events().size(), "joint events differ");
  require(a.solver_choices().size() == b.solver_choices().size(), "selected solves differ");
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
  require_same(a.counts.refused_islands, b.counts.refused_islands, "refused_islands");
  require_same(a.counts.discarded_iterations, b.counts.discarded_iterations, "discarded_iterations");
  require_same(a.counts.missed_targets, b.counts.missed_targets, "missed_targets");
  require_same(a.counts.body_substeps, b.counts.body_substeps, "body_substeps");
  require_same(a.counts.island_bodies, b.counts.island_bodies, "island_bodies");
  require_same(a.counts.max_substeps, b.counts.max_substeps, "max_substeps");
  require_same(a.counts.newton_iterations, b.counts.newton_iterations, "newton_iterations");
  require_same(a.counts.fcl_calls, b.counts.fcl_calls, "fcl_calls");
  require_same(a.counts.asleep, b.counts.asleep, "asleep");
  require_same(a.counts.swept, b.counts.swept, "swept");
  require_same(a.counts.stopped, b.counts.stopped, "stopped");
}

}  // namespace atl::fuzz
