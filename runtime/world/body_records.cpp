#include "world/body_records.h"

#include <collision/narrowphase/surface_contacts.h>
#include <jobs/append.h>
#include <jobs/arrays.h>
#include <jobs/assert.h>

#include <algorithm>
#include <utility>

namespace atl {

solver::Mobility mobility_of(BodyType type) {
  switch (type) {
    case BodyType::Static:
      return solver::Mobility::Fixed;
    case BodyType::Kinematic:
      return solver::Mobility::Kinematic;
    case BodyType::Dynamic:
      break;
  }
  return solver::Mobility::Dynamic;
}

void BodyRecords::resize(std::size_t bodies) {
  ATL_ASSERT(bodies >= alive.size(), bodies, alive.size());
  jobs::append(generation, bodies, std::uint32_t{0});
  jobs::append(alive, bodies, std::uint8_t{0});
  jobs::append(type, bodies, BodyType::Static);
  jobs::append(dynamic, bodies, std::uint8_t{0});
  material.resize(bodies);
  centre.resize(bodies);
  jobs::append(continuous, bodies, std::uint8_t{0});
  jobs::append(sensor, bodies, std::uint8_t{0});
  filter.resize(bodies);
  jobs::append(user_data, bodies, std::uint64_t{0});
  jobs::append(constants, bodies);
}

namespace {

void forget_other(std::map<std::uint32_t, std::vector<std::uint32_t>>& pairs, std::uint32_t body, std::uint32_t other) {
  const auto found = pairs.find(body);
  if (found == pairs.end()) return;
  std::erase(found->second, other);
  if (found->second.empty()) pairs.erase(found);
}

}  // namespace

void BodyRecords::disable_pair(std::uint32_t first, std::uint32_t second) {
  ATL_ASSERT(first != second, first);
  for (const auto& [body, other] : {std::pair{first, second}, std::pair{second, first}}) {
    std::vector<std::uint32_t>& others = disabled_pairs[body];
    const auto place = std::lower_bound(others.begin(), others.end(), other);
    if (place == others.end() || *place != other) others.insert(place, other);
  }
}

void BodyRecords::enable_pair(std::uint32_t first, std::uint32_t second) {
  forget_other(disabled_pairs, first, second);
  forget_other(disabled_pairs, second, first);
}

void Contents::count(const solver::BodyTable& bodies, const BodyRecords& records, std::uint32_t body, int sign) {
  const auto add = [sign](std::size_t& counter, bool has) {
    if (has) counter += static_cast<std::size_t>(sign);
  };
  add(kinematic, bodies.mobility[body] == solver::Mobility::Kinematic);
  const BodyConstants& constants = *records.constants[body];
  bool rubs = false, bounces = false;
  for_each_material(constants, [&](const Material& material) {
    rubs |= max_friction(material) > 0;
    bounces |= material.restitution > 0;
  });
  add(with_friction, rubs);
  add(with_restitution, bounces);
  add(own_materials, has_own_materials(constants));
  add(sensors, constants.sensor);
  add(continuous_sensors, constants.sensor && constants.continuous);
  add(with_event_force, constants.contact_event_force.has_value());
  add(with_speed_limit, constants.max_speed || constants.max_angular_speed);
  add(gyroscopic, bodies.gyroscopic[body] != 0);
  const auto is_surface = [](const CheckedCollider& collider) { return collision::is_surface(collider.shape.kind); };
  add(surfaces, std::ranges::any_of(constants.colliders, is_surface));
  const bool fixed = bodies.mobility[body] == solver::Mobility::Fixed;
  add(moving_compounds, !fixed && constants.colliders.size() > 1);
  if (!fixed) return;
  for (const CheckedCollider& collider : constants.colliders) {
    add(fixed_colliders, true);
    add(fixed_with_edges, collider.shape.kind != collision::ShapeKind::HalfSpace);
  }
}

}  // namespace atl
