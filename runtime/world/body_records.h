#pragma once

#include <atoll/body.h>
#include <jobs/compact_array.h>
#include <jobs/shared_values.h>
#include <solver/integrate/body_table.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "world/body_definition.h"
#include "world/constants_pool.h"

namespace atl {

/// For jobs::SharedValues: the last word has padding after it.
inline std::array<std::uint64_t, 2> words_of(const CollisionFilter& filter) {
  return {std::uint64_t{filter.category} << 32 | filter.mask, static_cast<std::uint32_t>(filter.group)};
}

/// The user's data of bodies that the solver's table doesn't hold, one entry per body index.
struct BodyRecords {
  jobs::CompactArray<std::uint32_t> generation;
  jobs::CompactArray<std::uint8_t> alive;
  jobs::CompactArray<BodyType> type;
  jobs::CompactArray<std::uint8_t> dynamic;  ///< 1 for dynamic bodies that are not in quarantine
  jobs::SharedValues<Material> material;
  /// m, of mass, body frame
  jobs::SharedValues<Vector3> centre = jobs::SharedValues<Vector3>(Vector3::Zero());
  jobs::CompactArray<std::uint8_t> continuous;
  jobs::CompactArray<std::uint8_t> sensor;
  jobs::SharedValues<CollisionFilter> filter;  ///< of those of its colliders that have none of their own
  jobs::CompactArray<std::uint64_t> user_data;
  std::map<std::uint32_t, std::string> names;                          ///< of bodies that have one
  jobs::CompactArray<std::shared_ptr<const BodyConstants>> constants;  ///< of those alive
  /// Pairs that users disabled: by body, the others that it doesn't touch, in order; no entry where there are none.
  std::map<std::uint32_t, std::vector<std::uint32_t>> disabled_pairs;
  jobs::CompactArray<std::uint32_t> free;  ///< indices of removed bodies; the last is used first
  std::size_t count = 0;                   ///< alive
  std::uint64_t version = 0;               ///< grows as bodies come and go
  ConstantsPool pool;                      ///< of `constants`

  void resize(std::size_t bodies);
  void disable_pair(std::uint32_t first, std::uint32_t second);
  void enable_pair(std::uint32_t first, std::uint32_t second);
  /// See jobs/arrays.h.
  auto arrays() const {
    return std::tie(generation, alive, type, continuous, sensor, user_data, constants, dynamic, free, material, centre,
                    filter);
  }
};

/// The ways in which a body of this type may move.
solver::Mobility mobility_of(BodyType type);

/// Which optional stages the world's bodies call for. Kept up to date as bodies come and go.
struct Contents {
  std::size_t kinematic = 0;
  std::size_t with_friction = 0;
  std::size_t with_restitution = 0;
  std::size_t gyroscopic = 0;
  std::size_t surfaces = 0;       ///< meshes and height fields
  std::size_t own_materials = 0;  ///< bodies with a child that has its own
  std::size_t sensors = 0;
  std::size_t continuous_sensors = 0;
  std::size_t with_event_force = 0;  ///< bodies that ask for events of contacts that go on
  std::size_t with_speed_limit = 0;
  std::size_t fixed_colliders = 0;   ///< of static bodies
  std::size_t fixed_with_edges = 0;  ///< of these, those that are no half-space
  std::size_t moving_compounds = 0;  ///< bodies with several shapes that aren't static

  void count(const solver::BodyTable& bodies, const BodyRecords& records, std::uint32_t body, int sign);
};

}  // namespace atl
