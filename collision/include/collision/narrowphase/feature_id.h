#pragma once

#include <collision/narrowphase/manifold.h>

namespace atl::collision {

// Ids by kind in the four top bits; within a kind every field has bits of its own, so ids are exact: equal if
// and only if the features are. Bits 56-59 are free. Where the second shape is a triangle of a surface, its
// number is in bits 28-55: a triangle has but one face, so the second face's field is not needed.
//
// Faces, edges and vertices are numbered as in polytope.h. Of the round shapes, the cap at positive z is face 0
// of a cylinder, the other face 1; the base of a cone is its face 0.

/// Flag beside an edge's number: the edge is the reference face's, not the incident one's.
inline constexpr int reference_edge = 1 << 8;

/// A corner of the clipped incident face: where the edge that the outline arrives on meets the one it leaves
/// on, each by its place around its own face (0-255), with `reference_edge` set or not. Two incident edges make
/// an incident corner, one of each a crossing of edges, two reference edges a corner of the reference face. Of
/// a segment, an end arrives and leaves on its own number, and a cut arrives on the number of the end it cuts
/// off.
constexpr FeatureId face_point_id(bool reference_is_second, int reference_face, int incident_face, int edge_in,
                                  int edge_out) {
  const int first = reference_is_second ? incident_face : reference_face;
  const int second = reference_is_second ? reference_face : incident_face;
  return FeatureId{1} << 60 | static_cast<FeatureId>(second) << 28 | static_cast<FeatureId>(reference_is_second) << 27 |
         static_cast<FeatureId>(first) << 18 | static_cast<FeatureId>(edge_in) << 9 | static_cast<FeatureId>(edge_out);
}

/// Edge of a box against edge of a box: each by its axis and the sides (bits) of the box it lies on.
constexpr FeatureId edge_edge_id(int axis_first, int sides_first, int axis_second, int sides_second) {
  return FeatureId{2} << 60 | static_cast<FeatureId>(axis_first) << 12 | static_cast<FeatureId>(sides_first) << 8 |
         static_cast<FeatureId>(axis_second) << 4 | static_cast<FeatureId>(sides_second);
}

/// A corner of a solid on a half-space. Boxes: bit i is set on the negative side of axis i. Round shapes: places around
/// the upper rim (cylinder) count from 0, around the lower rim or the base from 16; ends of lines on the side from 32.
constexpr FeatureId corner_id(int corner) { return FeatureId{3} << 60 | static_cast<FeatureId>(corner); }

/// The only point there can be, as a sphere's.
constexpr FeatureId single_point_id() { return FeatureId{4} << 60; }

/// A feature of each shape, and which of their points it is: 0 the nearest, 1 and 2 the ends of parallel lines'
/// common part. Kind: 0 vertex, 1 edge, 2 face; number: up to 1023.
constexpr FeatureId feature_pair_id(int kind_first, int number_first, int kind_second, int number_second, int place) {
  return FeatureId{5} << 60 | static_cast<FeatureId>(kind_second) << 38 | static_cast<FeatureId>(number_second) << 28 |
         static_cast<FeatureId>(kind_first) << 12 | static_cast<FeatureId>(number_first) << 2 |
         static_cast<FeatureId>(place);
}

/// The same point where the second shape is a triangle of a surface. `number` is less than 2^28. It overwrites the id's
/// part about the triangle's own face; in a feature_pair_id() also that about its edges and vertices.
constexpr FeatureId with_triangle(FeatureId id, std::uint32_t number) {
  constexpr FeatureId field = ((FeatureId{1} << 28) - 1) << 28;
  return (id & ~field) | static_cast<FeatureId>(number) << 28;
}

}  // namespace atl::collision
