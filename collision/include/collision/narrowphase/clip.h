#pragma once

#include <collision/narrowphase/manifold.h>
#include <collision/shapes/shape.h>

#include <array>
#include <cstdint>

namespace atl::collision {

/// Most corners of a face: as many as a hull has vertices.
inline constexpr int max_face_corners = 255;

/// A flat face of a solid.
struct FacePolygon {
  Vector3 normal;  ///< unit, outwards
  double offset;   ///< m: normal . p of its points
  int number;      ///< of the face; see feature_id.h
  int count = 0;
  std::array<Vector3, max_face_corners> corners;  ///< m, counter-clockwise seen from outside

  void add(const Vector3& corner) { corners[static_cast<std::size_t>(count++)] = corner; }
};

/// A corner of what is left of an incident face, and the edges that meet in it; see face_point_id().
struct OutlineCorner {
  Vector3 position;
  std::uint16_t edge_in;
  std::uint16_t edge_out;
};

/// A convex outline, or a segment (two corners), or a point.
struct Outline {
  static constexpr int capacity = 2 * max_face_corners + 2;  // every plane that cuts adds one corner
  int count = 0;
  std::array<OutlineCorner, capacity> corners;

  void add(const OutlineCorner& corner) {
    if (count < capacity) corners[static_cast<std::size_t>(count++)] = corner;
  }
  /// The next corner of a face: corner i arrives on edge i - 1 and leaves on edge i.
  void add_face_corner(const Vector3& position, int face_size);
  /// The next end of a segment.
  void add_end(const Vector3& position);
};

/// Cuts an outline down to what lies over a face, in the face's frame. Corners up to `slack` (m) outside count as
/// inside, so that none flickers where faces are flush. Sutherland and Hodgman, "Reentrant polygon clipping",
/// CACM 1974, keeping track of edges.
void clip(Outline& outline, const FacePolygon& face, double slack);

/// The outline's corners that are no farther from the face than `margin` (m), reduced to four, as the points
/// of a manifold whose reference is the face. `reference_is_second` must be set in the manifold; normal and
/// points are.
void face_points(const Outline& outline, const FacePolygon& face, int incident_face, double margin, Manifold& manifold);

}  // namespace atl::collision
