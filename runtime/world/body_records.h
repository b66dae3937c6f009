#pragma once

#include <atoll/body.h>
#include <jobs/shared_values.h>
#include <solver/integrate/body_table.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "world/body_definition.h"
#include "world/constants_pool.h"

namespace atl {

/// What users add to a body that the solver's table doesn't hold, one entry a body index.
struct BodyRecords {
  std::vector<std::uint32_t> generation;
  std::vector<std::uint8_t> alive;
  std::vector<BodyType> type;
  std::vector<std::uint8_t> dynamic;  ///< 1 for dynamic bodies that are not in quarantine
  jobs::SharedValues<Material> material;
  /// m, of mass, body frame
  jobs::SharedValues<Vector3> centre = jobs::SharedValues<Vector3>(Vector3::Zero());
  std::vector<std::uint8_t> continuous;
  std::vector<std::uint64_t> user_data;
  std::vector<std::shared_ptr<const BodyConstants>> constants;  ///< of those alive
  /// Pairs that users disabled: by body, the others that it doesn't touch.
  std::map<std::uint32_t, std::vector<std::uint32_t>> disabled_pairs;
  std::vector<std::uint32_t> free;  ///< indices of removed bodies; the last is used first
  std::size_t count = 0;            ///< alive
  std::uint64_t version = 0;        ///< grows as bodies come and go
  ConstantsPool pool;               ///< of `constants`

  void resize(std::size_t bodies);
  std::size_t bytes() const;
};

/// What a body of a type may do.
solver::Mobility mobility_of(BodyType type);

/// Which optional stages the world's bodies call for. Kept up to date as bodies come and go.
struct Contents {
  std::size_t kinematic = 0;
  std::size_t with_friction = 0;
  std::size_t with_restitution = 0;
  std::size_t gyroscopic = 0;
  std::size_t smooth_surfaces = 0;

  void count(const solver::BodyTable& bodies, const BodyRecords& records, std::uint32_t body, int sign);
};

}  // namespace atl
