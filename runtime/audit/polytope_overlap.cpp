#include <array>
#include <cmath>
#include <limits>

#include "placed.h"

namespace atl::audit {
namespace {

/// Edges closer to parallel than this span no plane of their own: the axis adds at most this share of the shapes'
/// size to what the face axes already say.
constexpr double parallel_sine = 1e-12;

/// Slack of the tests that leave out pairs of edges. What they let through in error is projected on afresh.
constexpr double cull_slack = 1e-9;

bool same_side(double x, double y) {
  return (x > cull_slack && y > cull_slack) || (x < -cull_slack && y < -cull_slack);
}

/// True if a great circle with the given pole misses the edge's arc.
bool circle_misses(const Polytope::Edge& edge, const Vector3& pole) {
  return edge.angle < 3 && same_side(edge.from.dot(pole), edge.to.dot(pole));
}

/// True if a direction on the great circle of the arc lies on the arc's half of it.
bool on_arc_side(const Polytope::Edge& edge, const Vector3& direction) {
  if (edge.angle > 4) return true;
  return direction.dot(edge.angle < 3 ? Vector3(edge.from + edge.to) : edge.toward) > -cull_slack;
}

struct Segment {
  Vector3 tail, head;
};

Segment segment_of(const Polytope& polytope) { return {polytope.vertices.front(), polytope.vertices.back()}; }

Vector3 nearest_on(const Segment& segment, const Vector3& point) {
  const Vector3 along = segment.head - segment.tail;
  const double square = along.squaredNorm();
  const double t = square > 0 ? std::clamp((point - segment.tail).dot(along) / square, 0.0, 1.0) : 0;
  return segment.tail + t * along;
}

class Shortest {
 public:
  void offer(const Vector3& way) {
    if (way.squaredNorm() >= square_) return;
    square_ = way.squaredNorm();
    way_ = way;
  }
  const Vector3& way() const { return way_; }

 private:
  Vector3 way_ = Vector3::Zero();
  double square_ = std::numeric_limits<double>::infinity();
};

/// The squared distance is convex in the two parameters, so its least value is at an end of either segment or where
/// both derivatives vanish.
void offer_segments(const Segment& from, const Segment& to, Shortest& shortest) {
  shortest.offer(nearest_on(to, from.tail) - from.tail);
  shortest.offer(nearest_on(to, from.head) - from.head);
  shortest.offer(to.tail - nearest_on(from, to.tail));
  shortest.offer(to.head - nearest_on(from, to.head));
  const Vector3 d1 = from.head - from.tail;
  const Vector3 d2 = to.head - to.tail;
  const Vector3 gap = to.tail - from.tail;
  const double square1 = d1.squaredNorm();
  const double square2 = d2.squaredNorm();
  const double mixed = d1.dot(d2);
  const double determinant = d1.cross(d2).squaredNorm();
  if (determinant <= parallel_sine * parallel_sine * square1 * square2) return;
  const double s = (gap.dot(d1) * square2 - gap.dot(d2) * mixed) / determinant;
  const double t = (gap.dot(d1) * mixed - gap.dot(d2) * square1) / determinant;
  if (s > 0 && s < 1 && t > 0 && t < 1) shortest.offer(gap + t * d2 - s * d1);
}

void offer_face(const Vector3& point, const Polytope& to, std::size_t face, Shortest& shortest) {
  const auto corners = to.face(face);
  const Vector3& normal = to.normals[face];
  const double height = normal.dot(point - to.vertices[corners[0]]);
  if (height < 0) return;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector3& tail = to.vertices[corners[i]];
    const Vector3& head = to.vertices[corners[(i + 1) % corners.size()]];
    if ((head - tail).cross(normal).dot(point - tail) > 0) return;
  }
  shortest.offer(-height * normal);
}

}  // namespace

// The Minkowski difference of two polytopes is bounded by planes whose normals are the face normals of either and the
// cross products of their edges, so the least overlap over these axes is the least translation that parts them
// (Gottschalk, Lin and Manocha, "OBBTree", SIGGRAPH 1996, section 5). A pair of edges makes a face of it only if their
// arcs on the Gauss map cross (Gregorius, "The separating axis test between convex polyhedra", GDC 2013); the others
// are left out. Each axis is a unit vector that is projected on afresh: a cross product of nearly parallel edges may
// point a little aside, but its overlap is still one of a translation that parts the shapes, so it can never report
// too little.
Penetration penetration(const Polytope& a, const Polytope& b, const Vector3& offset) {
  Penetration min{std::numeric_limits<double>::infinity(), Vector3::UnitZ()};
  const auto offer = [&](const Vector3& normal) {
    const double depth = reach(a, normal) + reach(b, -normal) - normal.dot(offset);
    if (depth < min.depth) min = {depth, normal};
  };
  for (const Vector3& normal : a.normals) offer(normal);
  for (const Vector3& normal : b.normals) offer(-normal);

  for (const Polytope::Edge& on_a : a.edges) {
    for (const Polytope::Edge& on_b : b.edges) {
      if (circle_misses(on_a, on_b.direction) || circle_misses(on_b, on_a.direction)) continue;
      const Vector3 cross = on_a.direction.cross(on_b.direction);
      const double sine = cross.norm();
      if (sine < parallel_sine) continue;
      for (const double sign : {1.0, -1.0}) {
        const Vector3 normal = sign / sine * cross;
        if (!on_arc_side(on_a, normal) || !on_arc_side(on_b, -normal)) continue;
        if (normal.dot(on_a.tail - on_b.tail - offset) < min.depth) offer(normal);
      }
    }
  }
  return min;
}

Vector3 shortest_way(const Polytope& from, const Polytope& to, const Vector3& offset) {
  const Segment moved = {segment_of(from).tail - offset, segment_of(from).head - offset};
  Shortest shortest;
  if (to.edges.empty()) offer_segments(moved, segment_of(to), shortest);
  for (const Polytope::Edge& edge : to.edges) offer_segments(moved, {edge.tail, edge.head}, shortest);
  for (std::size_t face = 0; face < to.normals.size(); ++face) {
    offer_face(moved.tail, to, face, shortest);
    if (from.is_segment()) offer_face(moved.head, to, face, shortest);
  }
  return shortest.way();
}

}  // namespace atl::audit
