#pragma once

#include <collision/manifold.h>

namespace atl::collision {

// Ids by kind in the top bits; within a kind every field has bits of its own, so ids are exact: equal if and
// only if the features are.

/// A corner of the clipped incident face: where the edge that the outline arrives on meets the one it leaves
/// on. Edges 0-3 are the incident face's, 4-7 the reference face's. Two incident edges make an incident
/// corner, one of each a crossing of edges, two reference edges a corner of the reference face.
/// Faces are numbered 2 * axis + (1 if on the negative side).
constexpr FeatureId face_point_id(bool reference_is_second, int reference_face, int incident_face, int edge_in,
                                  int edge_out) {
  return 1u << 28 | static_cast<FeatureId>(reference_is_second) << 16 | static_cast<FeatureId>(reference_face) << 12 |
         static_cast<FeatureId>(incident_face) << 8 | static_cast<FeatureId>(edge_in) << 4 |
         static_cast<FeatureId>(edge_out);
}

/// Edge against edge: each by its axis and the sides (bits) of the box it lies on.
constexpr FeatureId edge_edge_id(int axis_first, int sides_first, int axis_second, int sides_second) {
  return 2u << 28 | static_cast<FeatureId>(axis_first) << 12 | static_cast<FeatureId>(sides_first) << 8 |
         static_cast<FeatureId>(axis_second) << 4 | static_cast<FeatureId>(sides_second);
}

/// A corner of a box on a half-space; bit i is set on the negative side of axis i.
constexpr FeatureId corner_id(int corner) { return 3u << 28 | static_cast<FeatureId>(corner); }

/// The only point there can be, as a sphere's.
constexpr FeatureId single_point_id() { return 4u << 28; }

}  // namespace atl::collision
