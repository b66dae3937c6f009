#pragma once

#include <collision/shapes/collider_table.h>
#include <jobs/compact_array.h>

#include <cstdint>
#include <map>
#include <memory>
#include <utility>

#include "world/body_definition.h"

namespace atl {

/// Which bodies and colliders a world has, and what never changes of them: all of a state that snapshots share until a
/// body comes or goes. Made when one is asked for, and never changed.
struct WorldDefinition {
  jobs::CompactArray<std::shared_ptr<const BodyConstants>> bodies;  ///< by index; null where there is none
  jobs::CompactArray<std::uint32_t> generation;                     ///< by index
  jobs::CompactArray<std::uint32_t> free;                           ///< as BodyRecords::free
  jobs::CompactArray<std::uint32_t> collider_body;                  ///< as ColliderTable's
  jobs::CompactArray<std::uint32_t> collider_child;
  jobs::CompactArray<std::uint32_t> free_colliders;
};

/// Hulls, meshes and height fields, by kind and content.
using Geometry = std::map<std::pair<collision::ShapeKind, std::uint64_t>, std::shared_ptr<const void>>;

/// Hash of all that a body's motion depends on, of geometry by what it is made of.
std::uint64_t fingerprint(const BodyConstants& constants);

/// True if two bodies can't be told apart.
bool are_same(const BodyConstants& a, const BodyConstants& b);
/// True if two worlds have the same bodies under the same ids, and will give the same ids to the next ones.
bool are_same(const WorldDefinition& a, const WorldDefinition& b);

/// Throws Error if a body has one id in both and is not the same; `found` is what a world has, `saved` of a snapshot.
void check_bodies_match(const WorldDefinition& saved, const WorldDefinition& found);

/// The world definition with the geometry of another's bodies wherever it has none itself. Throws Error if there is
/// none with the same content.
std::shared_ptr<const WorldDefinition> with_geometry(const std::shared_ptr<const WorldDefinition>& world_definition,
                                                     const WorldDefinition& from);
std::shared_ptr<const WorldDefinition> with_geometry(const std::shared_ptr<const WorldDefinition>& world_definition,
                                                     const Geometry& from);
/// Gives a body the geometry that it lacks; returns whether it was all there.
bool give_geometry(BodyConstants& body, const Geometry& from);

/// Describes a property that no body made by a definition can have, in a message's words; null if there is none. A file
/// may be damaged or forged, so its bodies need not come from a definition. Geometry is left out: files of snapshots
/// don't have it.
const char* constants_fault(const BodyConstants& body);

}  // namespace atl
