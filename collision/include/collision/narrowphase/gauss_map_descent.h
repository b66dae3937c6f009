#pragma once

#include <collision/shapes/polytope.h>
#include <collision/shapes/pose.h>

namespace atl::collision {

/// A feature of a polytope.
struct Feature {
  enum class Kind : std::uint8_t { Vertex, Edge, Face };
  Kind kind = Kind::Vertex;
  int index = 0;
};

/// A direction that no neighbouring one parts two polytopes better along.
struct LocalAxis {
  Vector3 normal = Vector3::UnitZ();    ///< unit, from the first to the second, frame of the first
  double separation = 0;                ///< m, along the normal; negative: overlap
  Vector3 on_second = Vector3::Zero();  ///< m, the second's point that is nearest or deepest, frame of the first
  Feature first, second;                ///< the features that meet there
  /// True if the nearest point of the first lies on its feature. False if the walk ran out of steps.
  bool confirmed = false;
};

/// Walks over the Gauss maps of two polytopes to a local maximum of their separation.
///
/// The separation along n is n . (b - a), where a and b are the support vertices. While these stay the same it
/// is linear in n, so an overlapping pair has its maxima where the region of a pair of vertices has its
/// corners: normals of faces, and directions across an edge of each (Gregorius, "The separating axis test
/// between convex polyhedra", GDC 2013). A pair that is apart may also have its maximum, which is then the
/// distance, along an edge of the region or inside. The walk is an active-set method: it slides towards b - a
/// until it meets a region's border, along the border to a corner, and leaves a corner over the edge of the
/// face (of the Minkowski difference) that the origin's foot lies beyond, until the foot is inside.
class GaussMapDescent {
 public:
  GaussMapDescent(const Polytope& first, const Polytope& second, const Vector3& position, const Matrix3& rotation);

  LocalAxis from_direction(const Vector3& unit_normal);
  LocalAxis from_face_of_first(int face);
  LocalAxis from_face_of_second(int face);
  /// Starts from the direction across an edge of each that is on the side of `unit_normal`.
  LocalAxis from_edges(int first, int second, const Vector3& unit_normal);

  /// Separation (m) along a face's normal.
  double separation_from_first(int face) const;
  double separation_from_second(int face) const;

 private:
  static constexpr int max_steps = 64;

  enum class State : std::uint8_t { Vertices, EdgeOfFirst, EdgeOfSecond, FaceOfFirst, FaceOfSecond, Edges, Done };

  struct Hit {
    double t;
    int edge = -1;
    int face = -1;
  };

  Vector3 of_second(int vertex) const { return position_ + rotation_ * second_.vertices[vertex]; }
  Vector3 to_second(const Vector3& direction) const { return rotation_.transpose() * direction; }

  bool supports(const Polytope& polytope, const Hull::Edge& edge, const Vector3& along, const Vector3& normal) const;
  void nearest_hit(const Polytope& polytope, int vertex, const Vector3& from, const Vector3& towards, Hit& hit) const;
  LocalAxis walk(State state);
  State slide_from_vertices();
  State slide_on_edge(bool of_second_solid);
  State leave_face_of_first();
  State leave_face_of_second();
  State leave_edges();
  State slide_on_parallel_edges();
  bool limit_by_face(const Vector3& edge, Vector3& direction, const Polytope& polytope, const Hull::Edge& faces,
                     bool is_second, Hit& hit) const;
  LocalAxis result() const;

  const Polytope& first_;
  const Polytope& second_;
  Vector3 position_;
  Matrix3 rotation_;
  double tolerance_;  // m

  Vector3 n_ = Vector3::UnitZ();
  int a_ = 0, b_ = 0;            // support vertices
  int edge_a_ = 0, edge_b_ = 0;  // active edges
  int face_ = 0;
  State last_ = State::Vertices;  // the state that result() describes
  bool confirmed_ = false;
};

}  // namespace atl::collision
