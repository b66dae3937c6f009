#pragma once

#include <collision/shapes/pose.h>
#include <collision/shapes/shape.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace atl::collision {

/// A convex polytope, made once and never changed: flat arrays of at most 255 vertices, of faces that are
/// merged where they are coplanar, and of edges, with what the narrowphase walks along.
struct Hull {
  static constexpr std::size_t max_vertices = 255;

  struct Plane {
    Vector3 normal;  ///< unit, outwards
    double offset;   ///< m: solid where normal . p <= offset
  };

  /// Runs from vertex `tail` to `head`, counter-clockwise around the face on its left, seen from outside.
  struct Edge {
    std::uint16_t tail;
    std::uint16_t head;
    std::uint16_t left;   ///< face
    std::uint16_t right;  ///< face, around which it runs clockwise
  };

  std::vector<Vector3> vertices;  ///< m
  std::vector<Plane> planes;      ///< by face
  std::vector<Edge> edges;        ///< every edge once

  // Face f has vertices face_vertices[face_start[f] .. face_start[f + 1]), counter-clockwise from outside, and
  // face_edges holds, at the same place, the edge from each of them to the next.
  std::vector<std::uint16_t> face_start;
  std::vector<std::uint16_t> face_vertices;
  std::vector<std::uint16_t> face_edges;

  // Vertex v meets edges vertex_edges[vertex_start[v] .. vertex_start[v + 1]), in cyclic order.
  std::vector<std::uint16_t> vertex_start;
  std::vector<std::uint16_t> vertex_edges;

  /// m: the vertices' x, then all y, then all z, each up to a whole number of lanes with the last one repeated.
  std::vector<double> columns;
  static constexpr std::size_t lanes = 4;
  std::vector<double> plane_columns;  ///< the same of the planes: x, y and z of their normals, and offsets
  /// m: it reaches at least so far from the origin along every direction; minus infinity where the origin is outside.
  double min_reach = 0;

  MassProperties mass;
  double bounding_radius = 0;       ///< m, about the origin
  double inner_radius = 0;          ///< m, from the centre of mass to the nearest face
  Vector3 lower = Vector3::Zero();  ///< m, bounds
  Vector3 upper = Vector3::Zero();
  bool simplified = false;    ///< vertices were dropped to stay within max_vertices
  std::uint64_t content = 0;  ///< hash of vertices and faces
  /// The same hull in a frame at its centre of mass; null if it is in that frame already. Collision takes this one:
  /// bounds and rounding follow from the solid then, however far away from it a file put the frame.
  std::shared_ptr<const Hull> centred;

  std::size_t face_count() const { return planes.size(); }
  void find_columns();  ///< makes columns and min_reach of the rest
  void prepare();       ///< makes these and centred of the rest

  /// The vertex farthest along a direction, the first of equals, and how far that is, as dot() has it.
  std::size_t support(const Vector3& direction) const;
  double reach(const Vector3& direction) const;
};

struct PlacedShape {
  Shape shape;
  Pose pose;
};

/// A shape at a pose, as collision takes it: a hull in the frame of its centre of mass. A hull whose geometry isn't
/// there yet, as in a snapshot that is being checked, stays in its own.
PlacedShape centred(const Shape& shape, const Pose& pose);

/// Convex hull of a cloud of points (qhull). Vertices in order of first appearance in `points`, so the same
/// points give the same hull. Error text where there is none: fewer than 4 points, one that isn't finite, or
/// all in a plane (thinner than 1e-6 of the extent).
std::variant<Hull, std::string> build_hull(std::span<const Vector3> points);

/// A box as the hull of its corners, bit i of a corner's number set on the negative side of axis i.
Hull box_hull(const Vector3& half_extents);

/// Hash of a hull's vertices and faces: what Hull::content is.
std::uint64_t content_of(const Hull& hull);

/// Checks a hull that was read from outside: true if its derived data are exactly those that its vertices and faces
/// give, in the same order, and no index in it is out of range.
bool is_made_of_its_faces(const Hull& hull);

}  // namespace atl::collision
