#pragma once
/// Polytopes as the audit tests them: vertices, faces, and the arc of directions that each edge supports.

#include <atoll/types.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace atl::audit {

/// A convex polytope, which may be flat (a point, a segment, a triangle), in world axes about a point of its own.
struct Polytope {
  /// The directions in which a polytope reaches farthest along a whole edge: unit vectors
  /// cos(t) * from + sin(t) * toward for t in [0, angle], from the normal of one face to that of the other.
  struct Edge {
    Vector3 tail, head;  ///< m
    Vector3 direction;   ///< unit, from tail to head
    Vector3 from, to;    ///< unit normals at the arc's ends
    Vector3 toward;      ///< unit, across `direction` and `from`
    double angle;        ///< rad, above 0; pi at the rim of a plate, 2 pi if the edge is all there is
    double length() const { return (head - tail).norm(); }
  };

  std::vector<Vector3> vertices;  ///< m
  std::vector<Vector3> normals;   ///< unit, outwards, by face
  std::vector<Edge> edges;
  // Face f has vertices face_vertices[face_start[f] .. face_start[f + 1]), counter-clockwise from outside.
  std::vector<std::uint32_t> face_start = {0};
  std::vector<std::uint32_t> face_vertices;

  std::span<const std::uint32_t> face(std::size_t index) const {
    return std::span(face_vertices).subspan(face_start[index], face_start[index + 1] - face_start[index]);
  }
  bool is_point() const { return vertices.size() == 1; }
  bool is_segment() const { return vertices.size() == 2; }

  static Polytope point();
  static Polytope segment(const Vector3& half);  ///< from -half to half
  static Polytope box(const Matrix3& axes, const Vector3& half_extents);
  /// Faces are appended one by one with add_face(); join_edges() ends it.
  static Polytope from_vertices(std::vector<Vector3> vertices);
  /// A triangle without thickness.
  static Polytope plate(const std::array<Vector3, 3>& corners);
  /// The column under a triangle, down to `depth` along the unit vector `down`. Its lower end is left open: a shape in
  /// the column is never pushed out through it.
  static Polytope column(const std::array<Vector3, 3>& corners, const Vector3& down, double depth);

  void add_face(std::span<const std::uint32_t> corners);
  /// Makes the edges that two faces share.
  void join_edges();

 private:
  void add_edge(const Vector3& tail, const Vector3& head, const Vector3& from, const Vector3& to);
};

/// How far the polytope reaches along a direction: the greatest p . direction, m for a unit one.
inline double reach(const Polytope& polytope, const Vector3& direction) {
  double farthest = polytope.vertices[0].dot(direction);
  for (std::size_t i = 1; i < polytope.vertices.size(); ++i) {
    const double along = polytope.vertices[i].dot(direction);
    farthest = along > farthest ? along : farthest;
  }
  return farthest;
}

/// A unit vector across a direction.
Vector3 any_across(const Vector3& direction);

}  // namespace atl::audit
