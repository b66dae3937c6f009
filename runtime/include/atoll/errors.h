#pragma once

#include <atoll/body.h>
#include <atoll/types.h>
#include <atoll/world.h>

#include <optional>
#include <span>
#include <vector>

namespace atl {

/// Shape and pose of one body as the audit sees it: nothing but the final state.
struct PlacedShape {
  BodyType type = BodyType::Dynamic;
  Shape shape = Box{};
  Pose pose = {};
};

/// Least translation that parts a pair, over the pairs that overlap by more than 10 um.
struct PenetrationReport {
  double max = 0;           ///< m
  double p99 = 0;           ///< m, nearest rank
  double mean = 0;          ///< m
  double max_relative = 0;  ///< of the smaller shape's bounding radius
  std::size_t pairs = 0;    ///< how many overlap
};

/// Distance from an ideal rest pose, over the dynamic bodies.
struct RestReport {
  double sink_max = 0;   ///< m, downwards along gravity, >= 0
  double sink_mean = 0;  ///< m, signed
  double drift_max = 0;  ///< m, across gravity
  double tilt_max = 0;   ///< rad
};

/// Signed overlap in m of two placed shapes (positive: the least translation that parts them; negative:
/// a lower bound of the gap), in double, by closed forms and an exact 15-axis separating-axis test for
/// boxes (Gottschalk, Lin and Manocha, "OBBTree", SIGGRAPH 1996, section 5) that share nothing with the
/// simulation's narrowphase.
double overlap(const PlacedShape& a, const PlacedShape& b);

/// Tests all pairs with at least one dynamic body (a sweep along one axis prunes them). O(n log n + pairs).
PenetrationReport measure_penetration(std::span<const PlacedShape> shapes);

/// `ideal` and `actual` hold the same bodies in the same order; up is a unit vector against gravity.
RestReport measure_rest(std::span<const PlacedShape> ideal, std::span<const PlacedShape> actual, const Vector3& up);

}  // namespace atl
