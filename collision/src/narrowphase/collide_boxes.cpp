// Box against box. The best of the fifteen axes comes from a kernel, for many pairs at once; the features that support
// it are clipped against each other here, so that every point knows which features made it.

#include <collision/narrowphase/box_axes.h>
#include <collision/narrowphase/collide.h>
#include <collision/narrowphase/fcl_narrowphase.h>
#include <collision/narrowphase/feature_id.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "narrowphase/box_pair.h"

namespace atl::collision {
namespace {

// Margin, as part of the size, above which boxes count as fast. The margin of two boxes at rest against each other is a
// third of this.
constexpr double fast_margin = 0.15;

// Part of the depth by which edges have to part fast overlapping boxes better than a face does, to be taken instead of
// the face. FCL applies the same to all boxes. A face is preferred because its four points keep a box from rolling.
// Measured while `pile` lands (240 steps): pairs are 15 cm deep 620 times; with 1 instead, 1470 times.
constexpr double face_preference = 0.95;

// Part of the size by which a face may part two boxes less well than the best axis, and still be taken.
constexpr double nearly_best = 1e-3;
// Cosine: within 0.1 degrees.
constexpr double same_way = 1 - 1.5e-6;

// A face axis: axis `code - 1` of the first box (code 1-3) or `code - 4` of the second (4-6), on one side.
struct FaceAxis {
  int code = 0;
  bool negative = false;

  bool of_second() const { return code > 3; }
  int index() const { return (code - 1) % 3; }
  int face() const { return 2 * index() + (negative ? 1 : 0); }
  std::uint32_t packed() const { return static_cast<std::uint32_t>(2 * code + (negative ? 1 : 0)); }
  static FaceAxis unpacked(std::uint32_t axis) { return {static_cast<int>(axis / 2), axis % 2 != 0}; }
};

// The code of an edge axis in Manifold::axis; the codes of faces are smaller.
constexpr std::uint32_t edge_axis(int code) { return static_cast<std::uint32_t>(2 * code); }

// Signed distance of the incident box from the reference face.
double face_separation(const BoxPair& pair, int axis, bool negative) {
  const double side = negative ? -1 : 1;
  return side * pair.position[axis] - pair.half_reference[axis] -
         pair.rotation.row(axis).cwiseAbs().dot(pair.half_incident);
}

double separation_along(const BoxPair& first_is_reference, const FaceAxis& axis) {
  return axis.of_second() ? face_separation(first_is_reference.swapped(), axis.index(), axis.negative)
                          : face_separation(first_is_reference, axis.index(), axis.negative);
}

// A corner of the outline that is being clipped, and the edges that meet in it; see face_point_id().
struct CutCorner {
  Vector3 position;
  int edge_in;
  int edge_out;
};

struct CutFace {
  std::array<CutCorner, 8> corners;  // a quadrilateral cut by four planes
  int count = 0;

  void add(const CutCorner& corner) {
    if (count < 8) corners[static_cast<std::size_t>(count++)] = corner;
  }
};

struct IncidentFace {
  int number;
  CutFace outline;
};

// The face of the incident box that looks most directly at the reference face.
IncidentFace incident_face(const BoxPair& pair, int axis, bool negative) {
  const Vector3 normal = (negative ? -1.0 : 1.0) * pair.rotation.row(axis).transpose();
  Eigen::Index i = 0;
  normal.cwiseAbs().maxCoeff(&i);
  const bool incident_negative = normal[i] > 0;
  const Eigen::Index j = (i + 1) % 3;
  const Eigen::Index k = (i + 2) % 3;
  const Vector3 centre =
      pair.position + (incident_negative ? -1.0 : 1.0) * pair.half_incident[i] * pair.rotation.col(i);
  const Vector3 u = pair.half_incident[j] * pair.rotation.col(j);
  const Vector3 v = pair.half_incident[k] * pair.rotation.col(k);
  IncidentFace face{static_cast<int>(2 * i) + (incident_negative ? 1 : 0), {}};
  face.outline.add({centre + u + v, 3, 0});
  face.outline.add({centre - u + v, 0, 1});
  face.outline.add({centre - u - v, 1, 2});
  face.outline.add({centre + u - v, 2, 3});
  return face;
}

// Sutherland and Hodgman, "Reentrant polygon clipping", CACM 1974, against side * p[axis] <= limit, keeping
// track of edges. Corners up to `slack` outside count as inside: of flush boxes, none flickers.
void clip(CutFace& outline, Eigen::Index axis, double side, double limit, double slack, int edge) {
  std::array<double, 8> outside;
  bool cuts = false;
  for (int i = 0; i < outline.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    outside[k] = side * outline.corners[k].position[axis] - limit;
    cuts |= outside[k] > slack;
  }
  if (!cuts) return;
  CutFace result;
  for (int i = 0; i < outline.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const std::size_t next = i + 1 == outline.count ? 0 : k + 1;
    const CutCorner& from = outline.corners[k];
    const CutCorner& to = outline.corners[next];
    const bool from_in = outside[k] <= slack;
    const bool to_in = outside[next] <= slack;
    if (from_in) result.add(from);
    if (from_in == to_in) continue;
    const double t = std::clamp(outside[k] / (outside[k] - outside[next]), 0.0, 1.0);
    const Vector3 crossing = from.position + t * (to.position - from.position);
    result.add(from_in ? CutCorner{crossing, from.edge_out, edge} : CutCorner{crossing, edge, from.edge_out});
  }
  outline = result;
}

void face_manifold(const BoxPair& first_is_reference, const FaceAxis& axis, double margin, Manifold& manifold) {
  const BoxPair pair = axis.of_second() ? first_is_reference.swapped() : first_is_reference;
  const double side = axis.negative ? -1 : 1;
  const double slack = 1e-3 * std::min(pair.half_reference.minCoeff(), pair.half_incident.minCoeff());
  const Eigen::Index n = axis.index();
  const Eigen::Index u = (n + 1) % 3;
  const Eigen::Index v = (n + 2) % 3;

  const IncidentFace incident = incident_face(pair, axis.index(), axis.negative);
  CutFace outline = incident.outline;
  clip(outline, u, 1, pair.half_reference[u], slack, 4);
  clip(outline, v, 1, pair.half_reference[v], slack, 5);
  clip(outline, u, -1, pair.half_reference[u], slack, 6);
  clip(outline, v, -1, pair.half_reference[v], slack, 7);

  std::array<Manifold::Point, 8> points;
  int count = 0;
  for (int i = 0; i < outline.count; ++i) {
    const CutCorner& corner = outline.corners[static_cast<std::size_t>(i)];
    const double separation = side * corner.position[n] - pair.half_reference[n];
    if (separation > margin) continue;
    const FeatureId id = face_point_id(axis.of_second(), axis.face(), incident.number, corner.edge_in, corner.edge_out);
    points[static_cast<std::size_t>(count++)] = {corner.position, separation, id};
  }
  manifold.reference_is_second = axis.of_second();
  manifold.normal = side * Vector3::Unit(n);
  manifold.on_face = true;
  manifold.axis = axis.packed();
  reduce_points(points.data(), count, manifold);
}

// Closest points of the two edges (Ericson, "Real-Time Collision Detection", 2005, section 5.1.8).
void edge_manifold(const BoxPair& pair, const fcl_narrowphase::Axis& axis, double margin, Manifold& manifold) {
  const Eigen::Index i = (axis.code - 7) / 3;
  const Eigen::Index j = (axis.code - 7) % 3;
  const Vector3& normal = axis.normal;
  const SupportEdge first = support_edge(pair.half_reference, normal, i);
  const SupportEdge second = support_edge(pair.half_incident, -(pair.rotation.transpose() * normal), j);
  const Vector3 middle = pair.position + pair.rotation * second.middle;
  const Vector3 direction = pair.rotation.col(j);

  const Vector3 offset = middle - first.middle;
  const double cosine = direction[i];
  const double sine_squared = 1 - cosine * cosine;
  if (sine_squared < 1e-12) return;  // parallel edges have a face axis
  const double along_second = (offset[i] * cosine - direction.dot(offset)) / sine_squared;
  const double on_second = std::clamp(along_second, -pair.half_incident[j], pair.half_incident[j]);
  const Vector3 position = middle + on_second * direction;
  const double on_first = std::clamp(position[i], -pair.half_reference[i], pair.half_reference[i]);
  const Vector3 opposite = first.middle + on_first * Vector3::Unit(i);

  const double separation = normal.dot(position - opposite);
  manifold.reference_is_second = false;
  manifold.normal = normal;
  manifold.on_face = false;
  manifold.axis = edge_axis(axis.code);
  if (separation > margin) return;
  manifold.add(position, separation, edge_edge_id(static_cast<int>(i), first.sides, static_cast<int>(j), second.sides));
}

Vector3 outward_normal(const FaceAxis& axis, const Matrix3& rotation) {
  const double side = axis.negative ? -1 : 1;
  return axis.of_second() ? Vector3(-side * rotation.col(axis.index())) : Vector3(side * Vector3::Unit(axis.index()));
}

// Two faces that lie on each other, tilted by a hair, often cross deepest at their edges. A face wins where it looks
// the same way, within 0.1 degrees, and that of the last manifold within 2 degrees, so that ids don't flicker while a
// box rocks (at 1 degree a stack of three boxes a centimetre wide fell over); if its manifold is as deep, within what a
// tilt by a hair comes to.
bool face_stands_in(const BoxPair& pair, const fcl_narrowphase::Axis& edge, const FaceAxis& face, bool is_previous,
                    double margin, double size, Manifold& manifold) {
  const double cosine = outward_normal(face, pair.rotation).dot(edge.normal);
  if (cosine < (is_previous ? 1 - 6e-4 : same_way)) return false;
  face_manifold(pair, face, margin, manifold);
  if (std::abs(manifold.min_separation() - edge.separation) <= 2e-3 * size) return true;
  manifold.count = 0;
  return false;
}

// The pair of a lane.
BoxPair pair_of(const Vector3& half_first, const Vector3& half_second, const BoxAxes& axes, std::size_t lane) {
  BoxPair pair;
  pair.half_reference = half_first;
  pair.half_incident = half_second;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    pair.position[row] = axes.position[i][lane];
    for (std::size_t j = 0; j < 3; ++j) {
      pair.rotation(row, static_cast<Eigen::Index>(j)) = axes.rotation[3 * j + i][lane];
    }
  }
  return pair;
}

FaceAxis face_axis(const BoxPair& pair, int code) {
  if (code <= 3) return {code, pair.position[code - 1] < 0};
  return {code, pair.rotation.col(code - 4).dot(pair.position) > 0};
}

// m, along a unit direction from the first to the second.
double separation_along(const BoxPair& pair, const Vector3& normal) {
  return normal.dot(pair.position) - normal.cwiseAbs().dot(pair.half_reference) -
         (pair.rotation.transpose() * normal).cwiseAbs().dot(pair.half_incident);
}

// The best axes of a pair, as the lanes found them.
struct BestAxes {
  FaceAxis face;
  fcl_narrowphase::Axis edge;
  double face_separation;  // m
  double separation;       // m, of the better of both
  bool on_edges;           // the edges' is better
};

// True if a face is as good a reference as the best, within rounding and nearly_best. Any better axis was ruled out.
bool is_as_good(const BoxPair& pair, const BestAxes& best, const FaceAxis& face, double size) {
  return face.packed() == best.face.packed() ||
         separation_along(pair, face) >= best.face_separation - nearly_best * size;
}

// The manifold on the axis of the last one, if there is one and it is still as good as the best. Among equally good
// faces the last one stays, or its points' ids would flicker.
bool keep_axis(const BoxPair& pair, const BestAxes& best, std::uint32_t last, double margin, double size,
               Manifold& manifold) {
  const FaceAxis face = FaceAxis::unpacked(last);
  if (face.code >= 1 && face.code <= 6) {
    if (best.on_edges) return face_stands_in(pair, best.edge, face, true, margin, size, manifold);
    if (!is_as_good(pair, best, face, size)) return false;
    face_manifold(pair, face, margin, manifold);
    return manifold.count > 0 || face.packed() == best.face.packed();
  }
  if (!best.on_edges || last != edge_axis(best.edge.code)) return false;
  edge_manifold(pair, best.edge, margin, manifold);
  return true;
}

// Edges that cross, or a face beside their axis.
void on_edges(const BoxPair& pair, const fcl_narrowphase::Axis& edge, const FaceAxis& face, double margin, double size,
              Manifold& manifold) {
  if (!face_stands_in(pair, edge, face, false, margin, size, manifold)) edge_manifold(pair, edge, margin, manifold);
}

// A pair that touches by a new axis: the best one.
void take_best(const BoxPair& pair, const BestAxes& best, double margin, double size, Manifold& manifold) {
  if (best.on_edges) {
    on_edges(pair, best.edge, best.face, margin, size, manifold);
  } else {
    face_manifold(pair, best.face, margin, manifold);
  }
}

// The first manifold of a pair, on FCL's axis. That is refuted where the boxes don't overlap along it by what FCL says,
// or if they overlap along it although another one parts them.
Narrowphase first_manifold(const BoxPair& pair, const BestAxes& best, double margin, double size, Manifold& manifold) {
  // FCL drops pairs that don't overlap: those are shown to it with the first box grown by the margin.
  const double growth = best.separation > 0 ? margin : 0;
  fcl_narrowphase::Axis answer;
  if (!fcl_narrowphase::box_box(pair.half_reference + Vector3::Constant(growth), pair.half_incident, pair.position,
                                pair.rotation, margin, answer)) {
    return Narrowphase::Fcl;
  }
  const double along = separation_along(pair, answer.normal);
  const double as_shown = along - growth * answer.normal.cwiseAbs().sum();
  const bool refuted = !(std::abs(as_shown - answer.separation) <= 1e-9 * (size + pair.position.norm())) ||
                       (best.separation > 0 && along < 0);
  if (refuted) {
    take_best(pair, best, margin, size, manifold);
    return Narrowphase::Repaired;
  }
  if (answer.code <= 6) {
    face_manifold(pair, face_axis(pair, answer.code), margin, manifold);
  } else {
    answer.separation = along;
    on_edges(pair, answer, best.face, margin, size, manifold);
  }
  return Narrowphase::Fcl;
}

}  // namespace

Narrowphase collide_boxes(const Vector3& half_first, const Vector3& half_second, const BoxAxes& axes, std::size_t lane,
                          double margin, Manifold& manifold) {
  manifold.count = 0;
  const bool known = std::exchange(manifold.known, false);
  const std::uint32_t last = std::exchange(manifold.axis, 0);
  const int face_code = static_cast<int>(axes.face_code[lane]);
  const int edge_code = static_cast<int>(axes.edge_code[lane]);
  if (face_code == 0) return Narrowphase::ClosedForm;  // not finite, or so far away that sums overflow
  const double face_apart = axes.face[lane];
  const double separation = std::max(face_apart, axes.edge[lane]);
  const double gap = std::max(separation, axes.centres[lane]);
  if (!(gap <= margin)) {
    manifold.gap = gap;
    return Narrowphase::ClosedForm;
  }
  const BoxPair pair = pair_of(half_first, half_second, axes, lane);
  if (!pair.position.allFinite() || !pair.rotation.allFinite()) return Narrowphase::ClosedForm;
  const double size = std::min(pair.half_reference.minCoeff(), pair.half_incident.minCoeff());
  const bool is_fast = margin > fast_margin * size;
  const double as_good_as_face = (is_fast && face_apart < 0 ? face_preference : 1) * face_apart + 1e-9 * size;
  BestAxes best{face_axis(pair, face_code), {}, face_apart, separation, axes.edge[lane] > as_good_as_face};
  if (best.on_edges) best.edge = {box_axis(axes, lane, edge_code), axes.edge[lane], edge_code};

  Narrowphase by = Narrowphase::Kept;
  if (!known) {
    by = first_manifold(pair, best, margin, size, manifold);
  } else if (!keep_axis(pair, best, last, margin, size, manifold)) {
    take_best(pair, best, margin, size, manifold);
  }
  if (manifold.count > 0 && FaceAxis::unpacked(manifold.axis).code > 6 && is_fast) {
    add_other_features(pair, std::max(margin, size), manifold);
  }
  return by;
}

Narrowphase collide_boxes(const Vector3& half_first, const Vector3& half_second, const Pose& second, double margin,
                          Manifold& manifold) {
  BoxAxes axes;
  find_box_axes(half_first, half_second, second, axes);
  return collide_boxes(half_first, half_second, axes, 0, margin, manifold);
}

}  // namespace atl::collision
