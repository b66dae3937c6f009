#pragma once
/// A world definition for archives (state_archive.h). Geometry is told by its content.

#include <solver/integrate/motion_locks.h>

#include <algorithm>
#include <map>
#include <memory>
#include <vector>

#include "state/filter_state.h"
#include "state/geometry_state.h"
#include "state/joint_state.h"
#include "state/world_definition.h"

namespace atl {

template <typename Archive, typename Shape>
void visit_shape(Archive& archive, Shape& shape) {
  archive.value(shape.kind);
  archive.check(shape.kind <= collision::ShapeKind::HeightField, "a shape of no known kind");
  visit_all(archive, shape.half_extents, shape.radius);
  if (shape.kind == collision::ShapeKind::TaperedCapsule) archive.value(shape.top_radius);
  visit_all(archive, shape.half_height, shape.normal, shape.offset, shape.bounding_radius, shape.inner_radius);
}

template <typename Archive, typename AnyMaterial>
void visit_material(Archive& archive, AnyMaterial& material) {
  visit_all(archive, material.friction, material.friction_across, material.friction_direction, material.restitution,
            material.rolling_friction, material.torsional_friction, material.friction_rule, material.restitution_rule,
            material.id);
}

template <typename Archive, typename Pair>
void visit_material_pair(Archive& archive, Pair& pair) {
  visit_all(archive, pair.first, pair.second, pair.friction, pair.friction_across, pair.restitution);
}

template <typename Archive, typename Constants>
void visit_constants(Archive& archive, Constants& body) {
  archive.value(body.type);
  archive.check(body.type >= BodyType::Static && body.type <= BodyType::Dynamic, "a body of no known type");
  visit_all(archive, body.continuous, body.sensor, body.notices_static, body.notices_sensors, body.contact_event_force);
  visit_material(archive, body.material);
  visit_each(archive, body.materials, 32, [&](auto& material) { visit_material(archive, material); });
  archive.value(body.locks);
  archive.check(body.locks <= (body.type == BodyType::Dynamic ? solver::all_locks : 0),
                "a body with locks that there are none of");
  visit_all(archive, body.may_sleep, body.max_speed, body.max_angular_speed, body.gravity_scale, body.linear_damping,
            body.angular_damping, body.centre, body.inverse_mass, body.inertia, body.inverse_inertia, body.gyroscopic,
            body.principal_axes, body.moments);
  auto count = static_cast<std::uint32_t>(body.colliders.size());
  archive.value(count);
  if constexpr (Archive::reads) {
    constexpr std::uint32_t min_bytes = 100;
    archive.check(count > 0 && count <= archive.left() / min_bytes, "a body with a wrong number of shapes");
    body.colliders.resize(count);
  }
  for (auto& collider : body.colliders) {
    visit_shape(archive, collider.shape);
    visit_all(archive, collider.local, collider.content, collider.density_factor);
    visit_optional(archive, collider.material, [&](auto& material) { visit_material(archive, material); });
    visit_optional(archive, collider.filter, [&](auto& filter) { visit_filter(archive, filter); });
  }
  if constexpr (Archive::reads) {
    const char* const fault = constants_fault(body);
    archive.check_number(fault == nullptr, fault);
  }
}

/// Who is there, under which numbers, and who comes next.
template <typename Archive, typename AnyDefinition>
void visit_numbers(Archive& archive, AnyDefinition& world_definition) {
  archive.list(world_definition.generation);
  archive.list(world_definition.free);
  archive.list(world_definition.collider_body);
  archive.list(world_definition.collider_child);
  archive.list(world_definition.free_colliders);
}

/// Writes what bodies are made of, each kind once.
template <typename Archive>
void write_constants(Archive& archive, const WorldDefinition& world_definition) {
  std::map<const BodyConstants*, std::uint32_t> numbers;
  std::vector<const BodyConstants*> kinds;
  std::vector<std::uint32_t> kind_of_body;
  for (const std::shared_ptr<const BodyConstants>& body : world_definition.bodies) {
    const auto [entry, is_new] = numbers.try_emplace(body.get(), static_cast<std::uint32_t>(kinds.size()));
    if (is_new) kinds.push_back(body.get());
    kind_of_body.push_back(entry->second);
  }
  archive.value(static_cast<std::uint32_t>(kinds.size()));
  for (const BodyConstants* kind : kinds) {
    archive.value(kind != nullptr);
    if (kind != nullptr) visit_constants(archive, *kind);
  }
  archive.list(kind_of_body);
}

template <typename Archive>
void read_constants(Archive& archive, WorldDefinition& world_definition) {
  std::vector<std::shared_ptr<const BodyConstants>> kinds(archive.count_of(1));
  for (std::shared_ptr<const BodyConstants>& kind : kinds) {
    bool is_there = false;
    archive.value(is_there);
    if (!is_there) continue;
    BodyConstants constants;
    visit_constants(archive, constants);
    kind = std::make_shared<const BodyConstants>(std::move(constants));
  }
  std::vector<std::uint32_t> kind_of_body;
  archive.list(kind_of_body);
  for (const std::uint32_t kind : kind_of_body) {
    archive.check(kind < kinds.size(), "a body of no kind");
    world_definition.bodies.push_back(kinds[kind]);
  }
}

/// Checks that all numbers of a world definition fit together.
template <typename Archive>
void check_numbers(Archive& archive, const WorldDefinition& world_definition) {
  const std::size_t bodies = world_definition.bodies.size();
  const std::size_t colliders = world_definition.collider_body.size();
  archive.check(world_definition.generation.size() == bodies, "another number of generations than of bodies");
  archive.check(world_definition.collider_child.size() == colliders, "another number of shapes' places than of shapes");
  const auto check_free = [&](std::span<const std::uint32_t> free, std::size_t count, const auto& is_free) {
    std::vector<std::uint8_t> named(count, 0);
    for (const std::uint32_t number : free) {
      archive.check(number < count && !named[number] && is_free(number), "a list of free numbers that has a wrong one");
      named[number] = 1;
    }
    for (std::uint32_t number = 0; number < count; ++number) {
      archive.check(named[number] == is_free(number), "a list of free numbers that lacks one");
    }
  };
  check_free(world_definition.free, bodies,
             [&](std::uint32_t body) { return world_definition.bodies[body] == nullptr; });
  constexpr std::uint32_t none = collision::ColliderTable::none;
  check_free(world_definition.free_colliders, colliders,
             [&](std::uint32_t c) { return world_definition.collider_body[c] == none; });
  std::vector<std::vector<std::uint8_t>> placed(bodies);
  for (std::size_t body = 0; body < bodies; ++body) {
    if (world_definition.bodies[body]) placed[body].resize(world_definition.bodies[body]->colliders.size(), 0);
  }
  for (std::size_t c = 0; c < colliders; ++c) {
    const std::uint32_t body = world_definition.collider_body[c];
    if (body == none) continue;
    const bool fits = body < bodies && world_definition.collider_child[c] < placed[body].size() &&
                      !placed[body][world_definition.collider_child[c]];
    archive.check(fits, "a shape that is not its body's");
    placed[body][world_definition.collider_child[c]] = 1;
  }
  for (const std::vector<std::uint8_t>& of_body : placed) {
    archive.check(std::find(of_body.begin(), of_body.end(), 0) == of_body.end(), "a body that lacks a shape");
  }
}

/// All of a world definition but geometry.
template <typename Archive>
void write_definition_of_world(Archive& archive, const WorldDefinition& world_definition) {
  write_constants(archive, world_definition);
  visit_numbers(archive, world_definition);
}

template <typename Archive>
std::shared_ptr<const WorldDefinition> read_definition_of_world(Archive& archive) {
  auto world_definition = std::make_shared<WorldDefinition>();
  read_constants(archive, *world_definition);
  visit_numbers(archive, *world_definition);
  check_numbers(archive, *world_definition);
  return world_definition;
}

}  // namespace atl
