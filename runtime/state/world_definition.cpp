#include "state/world_definition.h"

#include <atoll/error.h>
#include <collision/shapes/height_field.h>
#include <collision/shapes/hull.h>
#include <collision/shapes/triangle_mesh.h>

#include <algorithm>
#include <sstream>
#include <string>
#include <utility>

#include "state/hex.h"
#include "state/state_archive.h"
#include "state/world_definition_state.h"

namespace atl {
namespace {

using collision::ShapeKind;

void describe(std::ostream& out, const CheckedCollider& collider) {
  const collision::Shape& shape = collider.shape;
  out << name_of(shape.kind);
  switch (shape.kind) {
    case ShapeKind::Sphere:
      out << " of radius " << shape.radius << " m";
      break;
    case ShapeKind::Box:
      out << " of half extents (" << shape.half_extents.x() << ", " << shape.half_extents.y() << ", "
          << shape.half_extents.z() << ") m";
      break;
    case ShapeKind::Capsule:
    case ShapeKind::Cylinder:
    case ShapeKind::Cone:
      out << " of radius " << shape.radius << " m and half height " << shape.half_height << " m";
      break;
    case ShapeKind::Ellipsoid:
      out << " of half axes (" << shape.half_extents.x() << ", " << shape.half_extents.y() << ", "
          << shape.half_extents.z() << ") m";
      break;
    case ShapeKind::TaperedCapsule:
      out << " of radii " << shape.radius << " m and " << shape.top_radius << " m and half height " << shape.half_height
          << " m";
      break;
    case ShapeKind::HalfSpace:
      break;
    default:
      out << " with the fingerprint " << hex(collider.content);
  }
}

std::string described(const BodyConstants& body) {
  constexpr const char* types[] = {"static", "kinematic", "dynamic"};
  std::ostringstream out;
  out.precision(17);
  out << "a " << types[static_cast<std::size_t>(body.type)] << " ";
  if (body.colliders.size() > 1) out << "Compound of " << body.colliders.size() << " shapes, the first a ";
  describe(out, body.colliders.front());
  if (body.inverse_mass > 0) out << ", " << 1 / body.inverse_mass << " kg";
  out << ", fingerprint " << hex(fingerprint(body));
  return out.str();
}

std::string id_of(const WorldDefinition& world_definition, std::size_t body) {
  return "body (index " + std::to_string(body) + ", generation " + std::to_string(world_definition.generation[body]) +
         ")";
}

bool needs_geometry(const CheckedCollider& collider) {
  return collider.geometry == nullptr &&
         (collider.shape.kind == ShapeKind::Hull || collision::is_surface(collider.shape.kind));
}

bool needs_geometry(const BodyConstants& body) {
  const auto needs = [](const CheckedCollider& collider) { return needs_geometry(collider); };
  return std::any_of(body.colliders.begin(), body.colliders.end(), needs);
}

bool lacks_geometry(const WorldDefinition& world_definition) {
  return std::any_of(world_definition.bodies.begin(), world_definition.bodies.end(),
                     [](const auto& body) { return body && needs_geometry(*body); });
}

Geometry geometry_of(const WorldDefinition& world_definition) {
  Geometry geometry;
  for (const std::shared_ptr<const BodyConstants>& body : world_definition.bodies) {
    if (!body) continue;
    for (const CheckedCollider& collider : body->colliders) {
      if (collider.geometry) geometry.try_emplace({collider.shape.kind, collider.content}, collider.geometry);
    }
  }
  return geometry;
}

void give_geometry(CheckedCollider& collider, const std::shared_ptr<const void>& geometry) {
  collider.geometry = geometry;
  switch (collider.shape.kind) {
    case ShapeKind::Hull:
      collider.shape = collision::Shape::convex_hull(*static_cast<const collision::Hull*>(geometry.get()));
      break;
    case ShapeKind::Mesh:
      collider.shape = collision::Shape::triangle_mesh(*static_cast<const collision::TriangleMesh*>(geometry.get()));
      break;
    default:
      collider.shape = collision::Shape::height_field(*static_cast<const collision::HeightField*>(geometry.get()));
  }
}

}  // namespace

std::uint64_t fingerprint(const BodyConstants& constants) {
  StateHash hash;
  visit_constants(hash, constants);
  return hash.result();
}

bool are_same(const BodyConstants& a, const BodyConstants& b) { return &a == &b || fingerprint(a) == fingerprint(b); }

bool are_same(const WorldDefinition& a, const WorldDefinition& b) {
  if (&a == &b) return true;
  if (a.bodies.size() != b.bodies.size() || a.generation != b.generation || a.free != b.free ||
      a.collider_body != b.collider_body || a.collider_child != b.collider_child ||
      a.free_colliders != b.free_colliders) {
    return false;
  }
  for (std::size_t i = 0; i < a.bodies.size(); ++i) {
    if ((a.bodies[i] == nullptr) != (b.bodies[i] == nullptr)) return false;
    if (a.bodies[i] && !are_same(*a.bodies[i], *b.bodies[i])) return false;
  }
  return true;
}

void check_bodies_match(const WorldDefinition& saved, const WorldDefinition& found) {
  for (std::size_t i = 0; i < std::min(saved.bodies.size(), found.bodies.size()); ++i) {
    if (!saved.bodies[i] || !found.bodies[i] || saved.generation[i] != found.generation[i]) continue;
    if (are_same(*saved.bodies[i], *found.bodies[i])) continue;
    throw Error("World::restore: " + id_of(found, i) + " is " + described(*found.bodies[i]) + "; expected " +
                described(*saved.bodies[i]) + ", as in the snapshot");
  }
}

bool give_geometry(BodyConstants& body, const Geometry& from) {
  for (CheckedCollider& collider : body.colliders) {
    if (!needs_geometry(collider)) continue;
    const auto found = from.find({collider.shape.kind, collider.content});
    if (found == from.end()) return false;
    give_geometry(collider, found->second);
  }
  return true;
}

std::shared_ptr<const WorldDefinition> with_geometry(const std::shared_ptr<const WorldDefinition>& world_definition,
                                                     const WorldDefinition& from) {
  return lacks_geometry(*world_definition) ? with_geometry(world_definition, geometry_of(from)) : world_definition;
}

std::shared_ptr<const WorldDefinition> with_geometry(const std::shared_ptr<const WorldDefinition>& world_definition,
                                                     const Geometry& from) {
  if (!lacks_geometry(*world_definition)) return world_definition;
  std::map<const BodyConstants*, std::shared_ptr<const BodyConstants>> completed;
  auto result = std::make_shared<WorldDefinition>(*world_definition);
  for (std::size_t i = 0; i < world_definition->bodies.size(); ++i) {
    const std::shared_ptr<const BodyConstants>& body = world_definition->bodies[i];
    if (!body || !needs_geometry(*body)) continue;
    std::shared_ptr<const BodyConstants>& whole = completed[body.get()];
    if (!whole) {
      BodyConstants copy = *body;
      if (!give_geometry(copy, from)) {
        throw Error("World::restore: no body of the world has the geometry of " + id_of(*world_definition, i) + ", " +
                    described(*body) + "; expected a world with it, as files don't hold geometry");
      }
      whole = std::make_shared<const BodyConstants>(std::move(copy));
    }
    result->bodies[i] = whole;
  }
  return result;
}

}  // namespace atl
