#pragma once

#include <atoll/world.h>
#include <jobs/arrays.h>

#include <utility>
#include <vector>

namespace atl {

/// A contact that pushed in a substep and may be gone when the step ends. `a` is the lower body.
struct ContactHit {
  BodyId a, b;
  std::uint32_t child_a = 0, child_b = 0;
  double impulse = 0;   ///< N s
  double approach = 0;  ///< m/s

  std::pair<BodyId, BodyId> pair() const { return {a, b}; }
};

struct BodyVelocity {
  Vector3 linear;   ///< m/s
  Vector3 angular;  ///< rad/s
};

/// Which bodies touch, and what that changed.
struct ContactEvents {
  using Pairs = std::vector<std::pair<BodyId, BodyId>>;

  std::vector<ContactEvent> events;
  Pairs touched;  ///< in order, as of the last step with events
  Pairs before;
  Pairs now;              ///< scratch: of active contacts
  bool reported = false;  ///< by the last step

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(events, touched, before, now); }
};

/// Which bodies are in sensors, and what that changed.
struct SensorEvents {
  std::vector<SensorEvent> events;
  std::vector<std::pair<BodyId, BodyId>> within;  ///< sensors and bodies, in order, as of the last step
  std::vector<std::pair<BodyId, BodyId>> before;  ///< scratch
  // Poses with which the step began, where a continuous sensor is.
  std::vector<double> start_positions;     ///< m, 3 a body
  std::vector<double> start_orientations;  ///< 4 a body

  auto arrays() const { return std::tie(events, within, before, start_positions, start_orientations); }
};

}  // namespace atl
