#pragma once

#include <collision/shapes/hull.h>
#include <collision/shapes/shape.h>

#include <array>
#include <cmath>
#include <cstdint>

namespace atl::collision {

/// std::hypot without its care for overflow, which takes ten times as long and differs between C libraries.
inline double length_2d(double x, double y) { return std::sqrt(x * x + y * y); }

/// The unit vector from the z axis to a point; along x where the point is on it.
inline Vector3 outwards_from_axis(const Vector3& point) {
  const double length = length_2d(point.x(), point.y());
  return length > 0 ? Vector3(point.x() / length, point.y() / length, 0) : Vector3(Vector3::UnitX());
}

/// A convex polytope as the narrowphase sees it: flat arrays that belong to somebody else, laid out as in Hull.
/// A segment has one edge and no face, a point has neither; a plate (a triangle) has a front and a back.
struct Polytope {
  const Vector3* vertices = nullptr;
  const Hull::Plane* planes = nullptr;
  const Hull::Edge* edges = nullptr;
  const std::uint16_t* face_start = nullptr;
  const std::uint16_t* face_vertices = nullptr;
  const std::uint16_t* face_edges = nullptr;
  const std::uint16_t* vertex_start = nullptr;
  const std::uint16_t* vertex_edges = nullptr;
  int vertex_count = 0;
  int face_count = 0;
  const Hull* hull = nullptr;  ///< whose these arrays are, if a hull's: it tells supports in lanes
  /// The vertices are an upper and a lower ring that lie straight above each other.
  bool is_prism = false;

  /// An edge's `left` and `right` where there is no face.
  static constexpr std::uint16_t no_face = 0xffff;

  /// The vertex farthest along a direction, the first of equals.
  int support(const Vector3& direction) const;
  /// A vertex as far along a direction as any, from one near it: from neighbour to neighbour.
  int climb(int vertex, const Vector3& direction) const;
  /// Calls visit(face) for the faces that meet in a vertex.
  template <typename Visit>
  void for_each_face_at(int vertex, const Visit& visit) const {
    for (int i = vertex_start[vertex]; i < vertex_start[vertex + 1]; ++i) {
      const Hull::Edge& edge = edges[vertex_edges[i]];
      // Each face is on the left of the one of its two edges there that leaves the vertex.
      const int face = edge.tail == vertex ? edge.left : edge.right;
      if (face != no_face) visit(face);
    }
  }
  int face_size(int face) const { return face_start[face + 1] - face_start[face]; }
};

Polytope polytope_of(const Hull& hull);

/// A polytope with memory of its own, for shapes that don't bring their arrays along.
///
/// Cylinders and cones become prisms and pyramids of 24 sides, which touch the shape along the middle of every
/// side: the reach along a side's normal is exact, and in between too far by the square of the angle between
/// neighbours. The sides are densest around one direction, so a descent that ends there can be refined.
class Core {
 public:
  static constexpr int sides = 24;
  static constexpr int levels = 4;  ///< 0: sides spread evenly; then 2, 0.2 and 0.03 degrees apart

  Core() = default;
  Core(const Core&) = delete;
  Core& operator=(const Core&) = delete;

  /// Any solid. `about` is the direction in the x-y plane, of any length but 0, that sides are densest around.
  /// Spheres and capsules give the point or segment that lies at `radius` from their surface.
  void build(const Shape& shape, int level = 0, const Vector3& about = Vector3::UnitX());
  /// Front (face 0) and back (face 1) of a triangle, counter-clockwise seen along -normal; edge i runs from
  /// vertex i to i + 1.
  void build_triangle(const std::array<Vector3, 3>& vertices, const Vector3& unit_normal);

  const Polytope& polytope() const { return polytope_; }
  double radius() const { return radius_; }  ///< m, that the solid reaches beyond the polytope

 private:
  void build_ring(double radius, double height, const Vector3& about, int level, int first_vertex);

  Polytope polytope_;
  double radius_ = 0;
  std::array<Vector3, 2 * sides> vertices_;
  std::array<Hull::Plane, sides + 2> planes_;
};

}  // namespace atl::collision
