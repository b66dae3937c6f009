#include <collision/narrowphase/gauss_map_descent.h>
#include <jobs/assert.h>

#include <algorithm>
#include <cmath>

namespace atl::collision {
namespace {

constexpr double tiny = 1e-300;
constexpr double parallel = 1e-20;  // squared sine of the angle between two edges

double extent(const Polytope& p) {
  return p.vertex_count > 1 ? (p.vertices[p.vertex_count - 1] - p.vertices[0]).norm() : 0;
}

// The edge of a face whose line a point in the face's plane lies farthest beyond; -1 if none.
int edge_beyond(const Polytope& p, int face, const Vector3& point, double tolerance) {
  const Vector3& normal = p.planes[face].normal;
  int edge = -1;
  double farthest = tolerance;
  const int begin = p.face_start[face];
  const int end = p.face_start[face + 1];
  for (int i = begin; i < end; ++i) {
    const Vector3& tail = p.vertices[p.face_vertices[i]];
    const Vector3& head = p.vertices[p.face_vertices[i + 1 == end ? begin : i + 1]];
    const Vector3 outward = (head - tail).cross(normal);
    const double beyond = outward.dot(point - tail);
    if (beyond <= 0) continue;
    const double distance = beyond / std::max(outward.norm(), tiny);
    if (distance <= farthest) continue;
    farthest = distance;
    edge = p.face_edges[i];
  }
  return edge;
}

}  // namespace

GaussMapDescent::GaussMapDescent(const Polytope& first, const Polytope& second, const Vector3& position,
                                 const Matrix3& rotation)
    : first_(first),
      second_(second),
      position_(position),
      rotation_(rotation),
      // Rounding is a part of 1e-16 of the coordinates.
      tolerance_(1e-13 * (extent(first) + extent(second) + position.norm())) {}

LocalAxis GaussMapDescent::from_direction(const Vector3& unit_normal) {
  n_ = unit_normal;
  a_ = first_.support(n_);
  b_ = second_.support(-to_second(n_));
  return walk(State::Vertices);
}

LocalAxis GaussMapDescent::from_face_of_first(int face) {
  ATL_ASSERT(face >= 0 && face < first_.face_count, face, first_.face_count);
  face_ = face;
  n_ = first_.planes[face].normal;
  a_ = first_.face_vertices[first_.face_start[face]];
  b_ = second_.support(-to_second(n_));
  return walk(State::FaceOfFirst);
}

LocalAxis GaussMapDescent::from_face_of_second(int face) {
  ATL_ASSERT(face >= 0 && face < second_.face_count, face, second_.face_count);
  face_ = face;
  n_ = -(rotation_ * second_.planes[face].normal);
  a_ = first_.support(n_);
  b_ = second_.face_vertices[second_.face_start[face]];
  return walk(State::FaceOfSecond);
}

// True if neither face beside the edge rises along the normal, so that the edge is a support along it.
bool GaussMapDescent::supports(const Polytope& polytope, const Hull::Edge& edge, const Vector3& along,
                               const Vector3& normal) const {
  if (edge.left == Polytope::no_face || edge.right == Polytope::no_face) return false;
  return normal.dot(polytope.planes[edge.left].normal.cross(along)) <= 0 &&
         normal.dot(along.cross(polytope.planes[edge.right].normal)) <= 0;
}

LocalAxis GaussMapDescent::from_edges(int first, int second, const Vector3& unit_normal) {
  const Hull::Edge& ea = first_.edges[first];
  const Hull::Edge& eb = second_.edges[second];
  const Vector3 u = first_.vertices[ea.head] - first_.vertices[ea.tail];
  const Vector3 v = second_.vertices[eb.head] - second_.vertices[eb.tail];
  const Vector3 across = u.cross(rotation_ * v);
  const double sine = across.norm();
  if (sine * sine <= 1e-6 * u.squaredNorm() * v.squaredNorm()) return from_direction(unit_normal);
  n_ = (across.dot(unit_normal) < 0 ? -1 : 1) / sine * across;
  if (!supports(first_, ea, u, n_) || !supports(second_, eb, v, -to_second(n_))) return from_direction(unit_normal);
  edge_a_ = first;
  edge_b_ = second;
  a_ = ea.tail;
  b_ = eb.tail;
  return walk(State::Edges);
}

double GaussMapDescent::separation_from_first(int face) const {
  const Hull::Plane& plane = first_.planes[face];
  return plane.normal.dot(of_second(second_.support(-to_second(plane.normal)))) - plane.offset;
}

double GaussMapDescent::separation_from_second(int face) const {
  const Hull::Plane& plane = second_.planes[face];
  const Vector3& nearest = first_.vertices[first_.support(-(rotation_ * plane.normal))];
  return plane.normal.dot(to_second(nearest - position_)) - plane.offset;
}

LocalAxis GaussMapDescent::walk(State state) {
  confirmed_ = false;
  for (int step = 0; step < max_steps && state != State::Done; ++step) {
    last_ = state;
    switch (state) {
      case State::Vertices:
        state = slide_from_vertices();
        break;
      case State::EdgeOfFirst:
        state = slide_on_edge(false);
        break;
      case State::EdgeOfSecond:
        state = slide_on_edge(true);
        break;
      case State::FaceOfFirst:
        state = leave_face_of_first();
        break;
      case State::FaceOfSecond:
        state = leave_face_of_second();
        break;
      case State::Edges:
        state = leave_edges();
        break;
      case State::Done:
        break;
    }
  }
  if (state != State::Done) last_ = state;
  return result();
}

// The first neighbour that gets as far out as a vertex, as the direction moves from + t towards.
void GaussMapDescent::nearest_hit(const Polytope& p, int vertex, const Vector3& from, const Vector3& towards,
                                  Hit& hit) const {
  const Vector3& at = p.vertices[vertex];
  for (int i = p.vertex_start[vertex]; i < p.vertex_start[vertex + 1]; ++i) {
    const Hull::Edge& edge = p.edges[p.vertex_edges[i]];
    const Vector3 along = p.vertices[edge.tail == vertex ? edge.head : edge.tail] - at;
    const double rise = towards.dot(along);
    if (rise <= 0) continue;
    const double t = std::max(0.0, -from.dot(along)) / rise;
    if (!(t < hit.t)) continue;
    hit.t = t;
    hit.edge = p.vertex_edges[i];
    hit.face = -1;
  }
}

GaussMapDescent::State GaussMapDescent::slide_from_vertices() {
  const Vector3 w = of_second(b_) - first_.vertices[a_];
  const double length = w.norm();
  if (length <= tolerance_) {
    confirmed_ = true;
    return State::Done;
  }
  Vector3 direction = w / length;
  // Straight across, every way is as good, and none is found: take one.
  if (n_.dot(direction) < -1 + 1e-12) direction = (direction + 1e-3 * n_.unitOrthogonal()).normalized();
  Hit hit_first{INFINITY};
  nearest_hit(first_, a_, n_, direction, hit_first);
  Hit hit_second{hit_first.t};
  nearest_hit(second_, b_, -to_second(n_), -to_second(direction), hit_second);
  if (hit_second.edge >= 0) {
    n_ = (n_ + hit_second.t * direction).stableNormalized();
    edge_b_ = hit_second.edge;
    return State::EdgeOfSecond;
  }
  if (hit_first.edge >= 0) {
    n_ = (n_ + hit_first.t * direction).stableNormalized();
    edge_a_ = hit_first.edge;
    return State::EdgeOfFirst;
  }
  n_ = direction;
  confirmed_ = true;
  return State::Done;
}

// Limits a turn about an edge, from n towards `direction`, to where it passes the normals of the edge's faces. A turn
// that starts right opposite `direction` has no side to go to, so it gets a small push.
bool GaussMapDescent::limit_by_face(const Vector3& edge, Vector3& direction, const Polytope& polytope,
                                    const Hull::Edge& faces, bool is_second, Hit& hit) const {
  double turn = edge.dot(n_.cross(direction));
  if (std::abs(turn) < 1e-12) {
    if (n_.dot(direction) > 0) return false;
    direction = (direction + 1e-3 * edge.cross(n_)).normalized();
    turn = edge.dot(n_.cross(direction));
  }
  const int face = turn > 0 ? faces.right : faces.left;
  if (face == Polytope::no_face) return false;
  const Vector3& outward = polytope.planes[face].normal;
  const Vector3 limit = is_second ? Vector3(-(rotation_ * outward)) : outward;
  const double side = turn > 0 ? 1 : -1;
  const double ahead = side * edge.dot(n_.cross(limit));
  if (n_.dot(limit) < 0 && ahead <= 1e-12) return false;  // half a turn away, or more
  const double rest = side * edge.dot(limit.cross(direction));
  if (rest <= 0) return false;
  const double t = std::max(0.0, ahead) / rest;
  if (!(t < hit.t)) return false;
  hit.t = t;
  hit.face = face;
  hit.edge = -1;
  return true;
}

// Towards the other's vertex, but for what lies along the edge.
GaussMapDescent::State GaussMapDescent::slide_on_edge(bool of_second_solid) {
  const Polytope& polytope = of_second_solid ? second_ : first_;
  const Hull::Edge& edge = polytope.edges[of_second_solid ? edge_b_ : edge_a_];
  const Vector3 edge_vector = polytope.vertices[edge.head] - polytope.vertices[edge.tail];
  const Vector3 tail = of_second_solid ? of_second(edge.tail) : polytope.vertices[edge.tail];
  Vector3 along = of_second_solid ? Vector3(rotation_ * edge_vector) : edge_vector;
  const double length = along.norm();
  along /= std::max(length, tiny);
  const Vector3 to_vertex = (of_second_solid ? first_.vertices[a_] : of_second(b_)) - tail;
  const double s = along.dot(to_vertex);
  const Vector3 away = to_vertex - s * along;
  const double distance = away.norm();
  if (distance > tolerance_) {
    Vector3 direction = of_second_solid ? Vector3(-away / distance) : Vector3(away / distance);
    Hit hit{INFINITY};
    limit_by_face(along, direction, polytope, edge, of_second_solid, hit);
    Hit hit_other{hit.t};
    if (of_second_solid) {
      nearest_hit(first_, a_, n_, direction, hit_other);
    } else {
      nearest_hit(second_, b_, -to_second(n_), -to_second(direction), hit_other);
    }
    if (hit_other.edge >= 0) {
      n_ = (n_ + hit_other.t * direction).stableNormalized();
      (of_second_solid ? edge_a_ : edge_b_) = hit_other.edge;
      return State::Edges;
    }
    if (hit.face >= 0) {
      face_ = hit.face;
      const Vector3& outward = polytope.planes[face_].normal;
      n_ = of_second_solid ? Vector3(-(rotation_ * outward)) : outward;
      return of_second_solid ? State::FaceOfSecond : State::FaceOfFirst;
    }
    n_ = direction;
  }
  if (s < -tolerance_ || s > length + tolerance_) {
    (of_second_solid ? b_ : a_) = s < 0 ? edge.tail : edge.head;
    return State::Vertices;
  }
  confirmed_ = true;
  return State::Done;
}

GaussMapDescent::State GaussMapDescent::leave_face_of_first() {
  const int edge = edge_beyond(first_, face_, of_second(b_), tolerance_);
  if (edge < 0) {
    confirmed_ = true;
    return State::Done;
  }
  edge_a_ = edge;
  return State::EdgeOfFirst;
}

GaussMapDescent::State GaussMapDescent::leave_face_of_second() {
  const Vector3 point = to_second(first_.vertices[a_] - position_);
  const int edge = edge_beyond(second_, face_, point, tolerance_);
  if (edge < 0) {
    confirmed_ = true;
    return State::Done;
  }
  edge_b_ = edge;
  return State::EdgeOfSecond;
}

// Edges that run along each other share their arc: along it the way leads on to the next face of either.
GaussMapDescent::State GaussMapDescent::slide_on_parallel_edges() {
  const Hull::Edge& ea = first_.edges[edge_a_];
  const Hull::Edge& eb = second_.edges[edge_b_];
  const Vector3& tail = first_.vertices[ea.tail];
  Vector3 along = first_.vertices[ea.head] - tail;
  const double length = along.norm();
  along /= std::max(length, tiny);
  const Vector3 from = of_second(eb.tail);
  const Vector3 to = of_second(eb.head);
  // Takes an end of the second edge that lies beside the first edge, if there is one.
  const double s_tail = along.dot(from - tail);
  b_ = s_tail >= 0 && s_tail <= length ? eb.tail : eb.head;
  Vector3 direction = from - tail - s_tail * along;
  const double distance = direction.norm();
  if (distance > tolerance_) {
    direction /= distance;
    n_ = (n_ - n_.dot(along) * along).stableNormalized();
    Hit hit{INFINITY};
    limit_by_face(along, direction, first_, ea, false, hit);
    Hit hit_second{hit.t};
    limit_by_face((to - from).stableNormalized(), direction, second_, eb, true, hit_second);
    if (hit_second.face >= 0) {
      face_ = hit_second.face;
      n_ = -(rotation_ * second_.planes[face_].normal);
      const double s_head = along.dot(to - tail);
      const double low = std::min(s_tail, s_head);
      a_ = low <= 0 && std::max(s_tail, s_head) >= 0 ? ea.tail : ea.head;
      return State::FaceOfSecond;
    }
    if (hit.face >= 0) {
      face_ = hit.face;
      n_ = first_.planes[face_].normal;
      return State::FaceOfFirst;
    }
    n_ = direction;
  }
  confirmed_ = true;
  return State::Done;
}

// The closest points of two lines (Ericson, "Real-Time Collision Detection", 2005, section 5.1.8).
GaussMapDescent::State GaussMapDescent::leave_edges() {
  const Hull::Edge& ea = first_.edges[edge_a_];
  const Hull::Edge& eb = second_.edges[edge_b_];
  const Vector3 u = first_.vertices[ea.head] - first_.vertices[ea.tail];
  const Vector3 v = rotation_ * (second_.vertices[eb.head] - second_.vertices[eb.tail]);
  const Vector3 w = of_second(eb.tail) - first_.vertices[ea.tail];
  const Vector3 cross = u.cross(v);
  const double uu = u.squaredNorm();
  const double vv = v.squaredNorm();
  const double cc = cross.squaredNorm();
  if (cc <= parallel * uu * vv) return slide_on_parallel_edges();
  if (cc > 1e-10 * uu * vv) n_ = (cross.dot(n_) < 0 ? -1 : 1) / std::sqrt(cc) * cross;
  const double s = w.cross(v).dot(cross) / cc;
  const double t = w.cross(u).dot(cross) / cc;
  const double beyond_a = std::max(-s, s - 1) * std::sqrt(uu);
  const double beyond_b = std::max(-t, t - 1) * std::sqrt(vv);
  if (std::max(beyond_a, beyond_b) <= tolerance_) {
    confirmed_ = true;
    return State::Done;
  }
  if (beyond_a >= beyond_b) {
    a_ = s < 0 ? ea.tail : ea.head;
    return State::EdgeOfSecond;
  }
  b_ = t < 0 ? eb.tail : eb.head;
  return State::EdgeOfFirst;
}

LocalAxis GaussMapDescent::result() const {
  using enum Feature::Kind;
  LocalAxis axis;
  axis.normal = n_;
  axis.confirmed = confirmed_;
  axis.on_second = of_second(b_);
  switch (last_) {
    case State::Vertices:
    case State::Done:
      axis.separation = n_.dot(axis.on_second - first_.vertices[a_]);
      axis.first = {Vertex, a_};
      axis.second = {Vertex, b_};
      break;
    case State::EdgeOfFirst:
      axis.separation = n_.dot(axis.on_second - first_.vertices[first_.edges[edge_a_].tail]);
      axis.first = {Edge, edge_a_};
      axis.second = {Vertex, b_};
      break;
    case State::FaceOfFirst:
      axis.separation = n_.dot(axis.on_second) - first_.planes[face_].offset;
      axis.first = {Face, face_};
      axis.second = {Vertex, b_};
      break;
    case State::EdgeOfSecond: {
      const Hull::Edge& edge = second_.edges[edge_b_];
      const Vector3 tail = of_second(edge.tail);
      const Vector3 along = of_second(edge.head) - tail;
      const double t = along.dot(first_.vertices[a_] - tail) / std::max(along.squaredNorm(), tiny);
      axis.on_second = tail + std::clamp(t, 0.0, 1.0) * along;
      axis.separation = n_.dot(tail - first_.vertices[a_]);
      axis.first = {Vertex, a_};
      axis.second = {Edge, edge_b_};
      break;
    }
    case State::FaceOfSecond: {
      const Hull::Plane& plane = second_.planes[face_];
      const Vector3& a = first_.vertices[a_];
      axis.separation = plane.normal.dot(to_second(a - position_)) - plane.offset;
      axis.on_second = a + axis.separation * n_;
      axis.first = {Vertex, a_};
      axis.second = {Face, face_};
      break;
    }
    case State::Edges: {
      const Hull::Edge& ea = first_.edges[edge_a_];
      const Hull::Edge& eb = second_.edges[edge_b_];
      const Vector3 tail = of_second(eb.tail);
      const Vector3 u = first_.vertices[ea.head] - first_.vertices[ea.tail];
      const Vector3 v = of_second(eb.head) - tail;
      const Vector3 w = tail - first_.vertices[ea.tail];
      const Vector3 cross = u.cross(v);
      const double cc = cross.squaredNorm();
      double t = w.cross(u).dot(cross) / cc;
      if (cc <= parallel * u.squaredNorm() * v.squaredNorm()) {
        // The middle of what they have in common, seen along the second.
        const double vv = std::max(v.squaredNorm(), tiny);
        const double t_tail = -v.dot(w) / vv;
        const double t_head = v.dot(u - w) / vv;
        t = 0.5 * (std::clamp(t_tail, 0.0, 1.0) + std::clamp(t_head, 0.0, 1.0));
      }
      axis.on_second = tail + std::clamp(t, 0.0, 1.0) * v;
      axis.separation = n_.dot(w);
      axis.first = {Edge, edge_a_};
      axis.second = {Edge, edge_b_};
      break;
    }
  }
  return axis;
}

}  // namespace atl::collision
