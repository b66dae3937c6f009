#pragma once

#include <collision/continuous/ccd_candidates.h>

#include <cstdint>
#include <span>
#include <vector>

namespace atl::collision {

/// Something that a fast body's shape may meet in the step.
struct Approach {
  std::uint32_t other;  ///< collider
  bool apart;           ///< they have no contact with points
  Vector3 shift;        ///< m, of the fast body against the other one
  double closing;       ///< m, how far their surfaces come towards each other at most
  double size;          ///< m, inner radius of the smaller shape
  bool both_stop;       ///< the other one is a fast body that may stop, too
  bool passes_core;     ///< the shape's core is kept apart from it, and its core from the shape where both stop
};

/// Selects from `candidates`, the shapes near a fast body, those that a collider of the body may meet if the body's end
/// pose is shifted by `aside` (m); in order. A body passes by most of its candidates, and a separating plane proves
/// that at less cost than a sweep.
void find_approaching(const CcdStep& step, const FastBody& fast, const Vector3& aside, std::uint32_t collider,
                      std::span<const CcdPair> candidates, std::vector<Approach>& approaching);

}  // namespace atl::collision
