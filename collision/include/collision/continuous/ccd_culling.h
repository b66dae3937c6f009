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
  bool passes_core;     ///< the shape's core is kept apart from it
};

/// What the shape of a collider may meet, of what is near its body, which ends `aside` of where it did; in order. Most
/// it passes by, and a plane that keeps them apart tells that for less than a sweep costs.
void find_approaching(const CcdStep& step, const FastBody& fast, const Vector3& aside, std::uint32_t collider,
                      std::span<const CcdPair> candidates, std::vector<Approach>& approaching);

}  // namespace atl::collision
