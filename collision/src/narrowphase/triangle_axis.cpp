#include "narrowphase/triangle_axis.h"

#include <collision/narrowphase/distance.h>
#include <collision/narrowphase/support_feature.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "narrowphase/point_distance.h"
#include "narrowphase/sphere_solid.h"
#include "shapes/hypotenuse.h"

namespace atl::collision {
namespace {

using Part = TriangleAxis::Part;

// A direction across an edge: components along the triangle's normal and outwards in its plane.
struct Turn {
  double up, out;

  double dot(const Turn& other) const { return up * other.up + out * other.out; }
  double cross(const Turn& other) const { return up * other.out - out * other.up; }
};

Turn normalized(const Turn& turn) {
  const double length = std::sqrt(turn.dot(turn));
  return length > 0 ? Turn{turn.up / length, turn.out / length} : Turn{1, 0};
}

// Grows with the angle from one direction on to another, up to half a turn.
double angle_measure(const Turn& from, const Turn& to) {
  const double sine = std::max(0.0, from.cross(to));
  return from.dot(to) > 0 ? sine : 2 - sine;
}

// True if a direction, of any length, surely has at least this angle measure; cheaper than to compute its measure.
bool is_beyond(const Turn& from, const Turn& to, double square, double measure) {
  if (!(from.dot(to) > 0)) return measure <= 1 || !(square > 0);
  const double sine = from.cross(to);
  return sine > 0 && sine * sine >= (1 + 1e-9) * measure * measure * square;
}

struct Edge {
  Vector3 tail, along, outward;  // along and outward of unit length
  double length;
};

Edge edge_of(const Triangle& triangle, std::size_t i) {
  const Vector3& tail = triangle.vertices[i];
  const Vector3 span = triangle.vertices[(i + 1) % 3] - tail;
  const double length = span.norm();
  const Vector3 along = length > 0 ? Vector3(span / length) : Vector3(Vector3::UnitX());
  return {tail, along, along.cross(triangle.normal), length};
}

class Search {
 public:
  Search(const SurfaceSolid& solid, const Triangle& triangle, double height, double max)
      : solid_(solid), triangle_(triangle), max_(max), tolerance_(1e-9 * solid.shape.inner_radius) {
    best_.normal = triangle.normal;
    best_.separation = height;
  }

  TriangleAxis run() {
    if (triangle_.convex_edges == 0) return best_;
    if (const Polytope& polytope = solid_.core.polytope(); polytope.hull != nullptr) {
      lowest_vertex_ = polytope.support(solid_.turned(Vector3(-triangle_.normal)));
      lowest_ = solid_.placed(polytope.vertices[lowest_vertex_]);
    } else {
      lowest_ = solid_.support(Vector3(-triangle_.normal));
    }
    bool is_over = true;
    for (std::size_t i = 0; i < 3; ++i) {
      edges_[i] = edge_of(triangle_, i);
      is_over &= edges_[i].outward.dot(lowest_ - edges_[i].tail) <= 0;
    }
    // The triangle's nearest point is right below the solid's.
    if (is_over && best_.separation >= 0) return best_;
    bool near_edge = false;
    for (std::size_t i = 0; i < 3; ++i) {
      if ((triangle_.convex_edges >> i & 1) == 0) continue;
      const Edge& edge = edges_[i];
      if (solid_.reach(edge.outward, edge.tail) <= 0) continue;
      near_edge = true;
      try_edge(i, edge);
      if (is_parted()) return best_;
    }
    if (!near_edge) return best_;
    try_faces_on_vertices();
    if (is_over || is_parted()) return best_;        // over: the solid goes through
    if (is_smooth(solid_.shape.kind)) return best_;  // all pushes at its vertices have been measured
    const double core_separation = best_.separation + solid_.core.radius();
    if (core_separation > -0.5 * solid_.shape.inner_radius && may_be_farther()) try_nearest_vertex();
    return best_;
  }

 private:
  bool is_parted() const { return best_.separation > max_; }

  // True if another direction may part the two farther than the best so far. If the support point of the best is as far
  // from the triangle as the best separation, that is the distance, and no direction can be better.
  bool may_be_farther() const {
    if (best_.support_count == 0) return true;
    Vector3 point = best_.support[0];
    if (best_.support_count == 2) {
      const Edge& edge = edges_[static_cast<std::size_t>(best_.index)];
      const Vector3 line = best_.support[1] - point;
      const Vector3 across = best_.normal.cross(edge.along);
      const double rate = across.dot(line);
      if (rate != 0) point += std::clamp(across.dot(edge.tail - point) / rate, 0.0, 1.0) * line;
    }
    const double apart = (point - closest_point_of_triangle(triangle_.vertices, point)).norm();
    return apart - solid_.core.radius() > best_.separation + 0.5 * tolerance_;
  }

  bool improves(double separation) const { return separation > best_.separation + tolerance_; }

  void try_edge(std::size_t i, const Edge& edge) {
    edge_ = i;
    up_ = solid_.turned(triangle_.normal);
    out_ = solid_.turned(edge.outward);
    from_ = solid_.seen(edge.tail);
    border_ = is_border(triangle_, i);
    const Vector3& beyond = triangle_.neighbour_normals[i];
    end_ = border_ ? Turn{0, 1} : normalized({beyond.dot(triangle_.normal), beyond.dot(edge.outward)});
    if (!may_improve(edge)) return;
    if (is_round(solid_.shape.kind) || is_smooth(solid_.shape.kind)) {
      search_round();
    } else {
      walk();
    }
  }

  // The separation is never more than that of the point which is the lowest along the triangle's normal.
  bool may_improve(const Edge& edge) const {
    const Vector3 to_lowest = lowest_ - edge.tail;
    const Turn apart{triangle_.normal.dot(to_lowest), edge.outward.dot(to_lowest)};
    const bool within = apart.out > 0 && apart.cross(end_) > 0;
    const double max = within ? hypotenuse(apart.up, apart.out) : std::max(apart.up, apart.dot(end_));
    return improves(max);
  }

  void offer(const Turn& turn, double separation, const Vector3& first, const Vector3* second = nullptr) {
    if (!improves(separation)) return;
    best_.normal = (solid_.rotation * (turn.up * up_ + turn.out * out_)).normalized();
    best_.separation = separation;
    best_.part = Part::Edge;
    best_.index = static_cast<int>(edge_);
    best_.of_neighbour = !border_ && turn.up == end_.up && turn.out == end_.out;
    best_.support[0] = solid_.placed(first);
    best_.support_count = 1;
    if (second == nullptr) return;
    best_.support[1] = solid_.placed(*second);
    best_.support_count = 2;
  }

  // Goes from the triangle's normal to the neighbour's, from one support vertex to the next. While the vertex stays,
  // the separation is that of two points, which is largest along the line between them.
  void walk() {
    const Polytope& polytope = solid_.core.polytope();
    const double radius = solid_.core.radius();
    constexpr int max_steps = 255;
    Turn at{1, 0};
    if (lowest_vertex_ < 0) lowest_vertex_ = polytope.support(-up_);
    int vertex = lowest_vertex_;
    for (int step = 0; step < max_steps; ++step) {
      const Vector3& x = polytope.vertices[vertex];
      Turn stop = end_;
      double nearest = angle_measure(at, end_);
      int next = -1;
      for (int k = polytope.vertex_start[vertex]; k < polytope.vertex_start[vertex + 1]; ++k) {
        const Hull::Edge& e = polytope.edges[polytope.vertex_edges[k]];
        const int other = e.tail == vertex ? e.head : e.tail;
        const Vector3 step_to = polytope.vertices[other] - x;
        const double a = up_.dot(step_to);
        const double b = out_.dot(step_to);
        const double square = a * a + b * b;
        if (is_beyond(at, {-b, a}, square, nearest)) continue;
        const double length = std::sqrt(square);
        const Turn turn{-b / length, a / length};
        const double angle = angle_measure(at, turn);
        if (angle >= nearest) continue;
        nearest = angle;
        stop = turn;
        next = other;
      }
      const Turn apart{up_.dot(x - from_), out_.dot(x - from_)};
      const double distance = hypotenuse(apart.up, apart.out);
      if (distance > 0 && at.cross(apart) > 0 && apart.cross(stop) > 0 && at.dot(apart) + stop.dot(apart) > 0) {
        offer({apart.up / distance, apart.out / distance}, distance - radius, x);
      }
      offer(stop, stop.dot(apart) - radius, x, next >= 0 ? &polytope.vertices[next] : nullptr);
      if (next < 0) return;
      vertex = next;
      at = stop;
    }
  }

  // The same of a solid that is no polytope, along a direction about the edge.
  double round_separation(const Turn& turn) const {
    const Vector3 normal = turn.up * up_ + turn.out * out_;
    if (is_smooth(solid_.shape.kind)) return -reach_along(solid_.shape, -normal) - normal.dot(from_);
    const double rim = solid_.shape.radius * std::sqrt(normal.x() * normal.x() + normal.y() * normal.y());
    const double end = solid_.shape.half_height * normal.z();
    const double reach = solid_.shape.kind == ShapeKind::Cone ? std::max(rim + end, -end) : rim + std::abs(end);
    return -reach - normal.dot(from_);
  }
  // `on_line`: the solid's side line looks along the normal, so both its ends are as near.
  void offer_round(const Turn& turn, bool on_line = false) {
    if (angle_measure({1, 0}, turn) > angle_measure({1, 0}, end_) || turn.out < 0) return;
    const Vector3 normal = turn.up * up_ + turn.out * out_;
    const double separation = round_separation(turn);
    if (!improves(separation)) return;
    const SideLine side = on_line ? side_line(solid_.shape, -normal) : SideLine{};
    if (side.exists) {
      offer(turn, separation, side.tail, &side.head);
    } else {
      offer(turn, separation, support_point(solid_.shape, -normal));
    }
  }

  // Offers the directions at which the support jumps from one end of a line to the other, or across a disc.
  void offer_kinks() {
    const Shape& shape = solid_.shape;
    if (shape.kind == ShapeKind::Ellipsoid) return;
    const Turn axis = normalized({up_.z(), out_.z()});
    const double tilt = hypotenuse(up_.z(), out_.z());
    for (const double sign : {1.0, -1.0}) {
      if (is_round(shape.kind)) offer_round({sign * axis.up, sign * axis.out});
      if (shape.kind == ShapeKind::Cylinder) {
        offer_round({sign * axis.out, -sign * axis.up}, true);
        continue;
      }
      const bool cone = shape.kind == ShapeKind::Cone;
      const double slant = cone ? hypotenuse(shape.radius, 2 * shape.half_height) : 2 * shape.half_height;
      const double cosine = -(shape.radius - (cone ? 0 : shape.top_radius)) / slant / tilt;
      if (!(tilt > 0) || std::abs(cosine) > 1) continue;
      const double sine = sign * std::sqrt(1 - cosine * cosine);
      offer_round({cosine * axis.up + sine * axis.out, cosine * axis.out - sine * axis.up}, true);
    }
  }

  // Samples, the best of them improved by golden section, and the directions in which the support jumps.
  void search_round() {
    constexpr int samples = 8;
    constexpr int rounds = 24;
    constexpr double golden = 0.61803398874989485;
    const Turn middle = end_.up > -0.99 ? normalized({1 + end_.up, end_.out}) : Turn{0, 1};
    const auto at = [&](double t) {
      const Turn& low = t < 1 ? Turn{1, 0} : middle;
      const Turn& high = t < 1 ? middle : end_;
      const double s = t < 1 ? t : t - 1;
      return normalized({(1 - s) * low.up + s * high.up, (1 - s) * low.out + s * high.out});
    };
    double best_t = 0;
    double best = -INFINITY;
    for (int i = 0; i <= samples; ++i) {
      const double t = 2.0 * i / samples;
      const double separation = round_separation(at(t));
      if (separation <= best) continue;
      best = separation;
      best_t = t;
    }
    offer_kinks();
    offer_round(end_);
    // Between samples there is little more to gain: by far too little where another part of the triangle is left
    // much sooner.
    if (best < best_.separation - 0.2 * solid_.shape.inner_radius) return;
    double low = std::max(0.0, best_t - 2.0 / samples);
    double high = std::min(2.0, best_t + 2.0 / samples);
    double first = high - golden * (high - low);
    double second = low + golden * (high - low);
    double at_first = round_separation(at(first));
    double at_second = round_separation(at(second));
    for (int i = 0; i < rounds; ++i) {
      if (at_first >= at_second) {
        high = second;
        second = std::exchange(first, second - golden * (second - low));
        at_second = std::exchange(at_first, round_separation(at(first)));
      } else {
        low = first;
        first = std::exchange(second, first + golden * (high - first));
        at_first = std::exchange(at_second, round_separation(at(second)));
      }
    }
    offer_round(at(0.5 * (low + high)));
  }

  // True if the surface can push along a direction at a vertex, as far as the triangle knows: no part of it or of its
  // neighbours lies ahead.
  bool may_push(const Vector3& direction, std::size_t vertex) const {
    const std::array<std::size_t, 2> edges = {vertex, (vertex + 2) % 3};
    bool convex = false;
    for (const std::size_t i : edges) {
      const Edge& edge = edges_[i];
      const double inwards = i == vertex ? edge.along.dot(direction) : -edge.along.dot(direction);
      if (inwards > 1e-9) return false;
      const bool is_convex = (triangle_.convex_edges >> i & 1) != 0;
      convex |= is_convex;
      if (is_border(triangle_, i)) {
        if (direction.dot(triangle_.normal) < 0) return false;
        continue;
      }
      const double ahead = direction.dot(edge.along.cross(triangle_.neighbour_normals[i]));
      if (ahead > (is_convex ? 1e-9 : convex_edge_angle)) return false;
    }
    return convex;
  }

  void offer_vertex(std::size_t vertex, const Vector3& normal, double separation, const Vector3* support) {
    if (!improves(separation) || !may_push(normal, vertex)) return;
    best_.normal = normal;
    best_.separation = separation;
    best_.part = Part::Vertex;
    best_.index = static_cast<int>(vertex);
    best_.of_neighbour = false;
    best_.support_count = support != nullptr ? 1 : 0;
    if (support != nullptr) best_.support[0] = *support;
  }

  void try_face_on_vertices(const Vector3& outwards, double offset) {
    const Vector3 normal = -(solid_.rotation * outwards);
    for (std::size_t v = 0; v < 3; ++v) {
      offer_vertex(v, normal, normal.dot(solid_.position - triangle_.vertices[v]) - offset, nullptr);
    }
  }

  // The round side, along the line of it that the vertex lies on.
  void try_side_on_vertices() {
    const Shape& shape = solid_.shape;
    const double rise = shape.kind == ShapeKind::Cone ? shape.radius : 0;
    const double run = shape.kind == ShapeKind::Cone ? 2 * shape.half_height : 1;
    const double slant = hypotenuse(rise, run);
    for (std::size_t v = 0; v < 3; ++v) {
      const Vector3 seen = solid_.seen(triangle_.vertices[v]);
      const double across = hypotenuse(seen.x(), seen.y());
      if (!(across > 0)) continue;
      const Vector3 outwards(run * seen.x() / (slant * across), run * seen.y() / (slant * across), rise / slant);
      const Vector3 rim(shape.radius * seen.x() / across, shape.radius * seen.y() / across, -shape.half_height);
      const double separation = outwards.dot(seen - rim);
      const Vector3 support = seen - separation * outwards;
      if (std::abs(support.z()) > shape.half_height) continue;
      const Vector3 placed = solid_.placed(support);
      offer_vertex(v, -(solid_.rotation * outwards), separation, &placed);
    }
  }

  // Against all of a smooth surface: exact, whether a vertex is outside or inside.
  void try_vertices() {
    for (std::size_t v = 0; v < 3; ++v) {
      const Vector3 seen = solid_.seen(triangle_.vertices[v]);
      const SurfaceDistance nearest = distance_to_surface(solid_.shape, seen);
      const Vector3 support = solid_.placed(seen - nearest.distance * nearest.normal);
      offer_vertex(v, -(solid_.rotation * nearest.normal), nearest.distance, &support);
    }
  }

  void try_faces_on_vertices() {
    const Shape& shape = solid_.shape;
    if (is_smooth(shape.kind)) return try_vertices();
    if (shape.kind == ShapeKind::Cylinder) try_face_on_vertices(Vector3::UnitZ(), shape.half_height);
    if (shape.kind == ShapeKind::Cylinder || shape.kind == ShapeKind::Cone) {
      try_face_on_vertices(-Vector3::UnitZ(), shape.half_height);
      try_side_on_vertices();
      return;
    }
    // A vertex that the surface can push at is the triangle's farthest along the direction, so that most faces look
    // away from one that is nearer: by far more than rounding, and what may_push() lets pass.
    std::array<Vector3, 3> seen;
    for (std::size_t v = 0; v < 3; ++v) seen[v] = solid_.seen(triangle_.vertices[v]);
    const double slack =
        1e-8 * std::max({seen[0].lpNorm<1>(), seen[1].lpNorm<1>(), seen[2].lpNorm<1>(), shape.bounding_radius});
    const Polytope& polytope = solid_.core.polytope();
    if (polytope.hull != nullptr) return try_faces_in_lanes(*polytope.hull, seen, slack);
    for (int f = 0; f < polytope.face_count; ++f) {
      const auto& [normal, offset] = polytope.planes[f];
      const double min = std::min({normal.dot(seen[0]), normal.dot(seen[1]), normal.dot(seen[2])}) - offset;
      if (min + slack > best_.separation) try_face_on_vertices(normal, offset);
    }
  }

  void try_faces_in_lanes(const Hull& hull, const std::array<Vector3, 3>& seen, double slack) {
    using Lanes = Eigen::Array<double, Hull::lanes, 1>;
    const std::size_t size = hull.plane_columns.size() / 4;
    for (std::size_t i = 0; i < size; i += Hull::lanes) {
      const auto column = [&](std::size_t k) {
        return Eigen::Map<const Lanes>(hull.plane_columns.data() + k * size + i);
      };
      const auto over = [&](const Vector3& point) -> Lanes {
        return (column(0) * point.x() + column(1) * point.y()) + column(2) * point.z();
      };
      const Lanes min = over(seen[0]).min(over(seen[1])).min(over(seen[2])) - column(3) + slack;
      if (!(min.maxCoeff() > best_.separation)) continue;
      for (std::size_t lane = 0; lane < Hull::lanes && i + lane < hull.planes.size(); ++lane) {
        const Hull::Plane& plane = hull.planes[i + lane];
        if (min[static_cast<Eigen::Index>(lane)] > best_.separation) try_face_on_vertices(plane.normal, plane.offset);
      }
    }
  }

  void try_nearest_vertex() {
    std::array<Vector3, 3> triangle;
    for (std::size_t v = 0; v < 3; ++v) triangle[v] = solid_.seen(triangle_.vertices[v]);
    Shape core = solid_.shape;
    if (solid_.core.radius() > 0) core.radius = 0;
    const ClosestPoints closest = closest_points(core, triangle);
    if (!(closest.distance > tolerance_)) return;
    const Vector3 normal = -(solid_.rotation * closest.normal);
    std::size_t vertex = 0;
    for (std::size_t v = 1; v < 3; ++v) {
      if (normal.dot(triangle_.vertices[v] - triangle_.vertices[vertex]) > 0) vertex = v;
    }
    const Vector3 support = solid_.placed(closest.on_first);
    offer_vertex(vertex, normal, closest.distance - solid_.core.radius(), &support);
  }

  const SurfaceSolid& solid_;
  const Triangle& triangle_;
  double max_;        // m
  double tolerance_;  // m
  std::array<Edge, 3> edges_;
  TriangleAxis best_;
  Vector3 lowest_ = Vector3::Zero();  // of the solid along the triangle's normal
  int lowest_vertex_ = -1;            // of its polytope, the same; or not known
  // The edge being looked at, in the solid's frame.
  std::size_t edge_ = 0;
  Vector3 up_ = Vector3::UnitZ(), out_ = Vector3::UnitX(), from_ = Vector3::Zero();
  Turn end_ = {0, 1};
  bool border_ = false;
};

}  // namespace

TriangleAxis find_triangle_axis(const SurfaceSolid& solid, const Triangle& triangle, double height, double max) {
  return Search(solid, triangle, height, max).run();
}

}  // namespace atl::collision
