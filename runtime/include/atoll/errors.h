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
  double max_relative = 0;  ///< of the smaller shape's bounding radius (about the middle of its bounds)
  std::size_t pairs = 0;    ///< how many overlap
};

/// Distance from an ideal rest pose, over the dynamic bodies.
struct RestReport {
  double sink_max = 0;   ///< m, downwards along gravity, >= 0
  double sink_mean = 0;  ///< m, signed
  double drift_max = 0;  ///< m, across gravity
  double tilt_max = 0;   ///< rad
};

/// Signed overlap in m of two placed shapes, in double, by code that shares nothing with the simulation's narrowphase.
///
/// Positive: the least translation that parts them. Exact for spheres and capsules (closed forms of the distance
/// between their cores), for boxes and hulls (all face normals and all pairs of edges that meet on the Gauss map:
/// Gottschalk, Lin and Manocha, "OBBTree", SIGGRAPH 1996, section 5; Gregorius, "The separating axis test between
/// convex polyhedra", GDC 2013) and for half-spaces. With a cylinder or a cone it is the least of the overlaps along
/// all directions that can be a local minimum, found by closed form (caps, faces) or by numerical search along the arcs
/// of edges and sides and from many starts where a rim rolls over a rim: at most 1e-7 of the size too large.
///
/// Negative: minus the distance, if one of the two is a sphere or a capsule or a half-space; else minus a lower bound
/// of it.
///
/// A compound counts by the deepest of its children. A mesh has no inside: a solid overlaps a triangle by the least
/// translation, forwards, backwards or over an edge, that takes it off that triangle, and a mesh by the largest over
/// its triangles. A solid that has sunk in by more than half is nearer to the back and counts by that; one that has
/// passed through altogether no longer overlaps. A height field is solid below: each of its triangles stands for the
/// column under it, and the largest over the columns counts. A solid all of which lies deep below counts by at least
/// what it takes to leave the column sideways. Surfaces against half-spaces count by their deepest vertex, against each
/// other by their triangles.
///
/// The pose is that of the frame that the shape is given in.
double overlap(const PlacedShape& a, const PlacedShape& b);

/// Tests all pairs with at least one dynamic body (a sweep along one axis prunes them). O(n log n + pairs).
PenetrationReport measure_penetration(std::span<const PlacedShape> shapes);

/// `ideal` and `actual` hold the same bodies in the same order; up is a unit vector against gravity.
RestReport measure_rest(std::span<const PlacedShape> ideal, std::span<const PlacedShape> actual, const Vector3& up);

}  // namespace atl
