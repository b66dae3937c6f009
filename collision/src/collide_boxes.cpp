// Box against box: FCL says whether they meet. Its axis is good to a part of the depth, so the best of the fifteen is
// found here, and the features that support it are clipped against each other, so that every point knows which
// features made it.

#include <collision/collide.h>
#include <collision/fcl_narrowphase.h>
#include <collision/feature_id.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace atl::collision {
namespace {

// The two boxes in the frame of the reference box.
struct BoxPair {
  Vector3 half_reference;
  Vector3 half_incident;
  Vector3 position;  // of the incident box
  Matrix3 rotation;  // its axes, as columns

  BoxPair swapped() const {
    return {half_incident, half_reference, -(rotation.transpose() * position), rotation.transpose()};
  }
};

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
struct OutlineCorner {
  Vector3 position;
  int edge_in;
  int edge_out;
};

struct Outline {
  std::array<OutlineCorner, 8> corners;  // a quadrilateral cut by four planes
  int count = 0;

  void add(const OutlineCorner& corner) {
    if (count < 8) corners[static_cast<std::size_t>(count++)] = corner;
  }
};

struct IncidentFace {
  int number;
  Outline outline;
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
void clip(Outline& outline, Eigen::Index axis, double side, double limit, double slack, int edge) {
  std::array<double, 8> outside;
  bool cuts = false;
  for (int i = 0; i < outline.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    outside[k] = side * outline.corners[k].position[axis] - limit;
    cuts |= outside[k] > slack;
  }
  if (!cuts) return;
  Outline result;
  for (int i = 0; i < outline.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const std::size_t next = i + 1 == outline.count ? 0 : k + 1;
    const OutlineCorner& from = outline.corners[k];
    const OutlineCorner& to = outline.corners[next];
    const bool from_in = outside[k] <= slack;
    const bool to_in = outside[next] <= slack;
    if (from_in) result.add(from);
    if (from_in == to_in) continue;
    const double t = std::clamp(outside[k] / (outside[k] - outside[next]), 0.0, 1.0);
    const Vector3 crossing = from.position + t * (to.position - from.position);
    result.add(from_in ? OutlineCorner{crossing, from.edge_out, edge} : OutlineCorner{crossing, edge, from.edge_out});
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
  Outline outline = incident.outline;
  clip(outline, u, 1, pair.half_reference[u], slack, 4);
  clip(outline, v, 1, pair.half_reference[v], slack, 5);
  clip(outline, u, -1, pair.half_reference[u], slack, 6);
  clip(outline, v, -1, pair.half_reference[v], slack, 7);

  std::array<Manifold::Point, 8> points;
  int count = 0;
  for (int i = 0; i < outline.count; ++i) {
    const OutlineCorner& corner = outline.corners[static_cast<std::size_t>(i)];
    const double separation = side * corner.position[n] - pair.half_reference[n];
    if (separation > margin) continue;
    const FeatureId id = face_point_id(axis.of_second(), axis.face(), incident.number, corner.edge_in, corner.edge_out);
    points[static_cast<std::size_t>(count++)] = {corner.position, separation, id};
  }
  manifold.reference_is_second = axis.of_second();
  manifold.normal = side * Vector3::Unit(n);
  manifold.axis = axis.packed();
  reduce_points(points.data(), count, manifold);
}

// The edge of a box that lies farthest along a direction, of the four along one of its axes.
struct SupportEdge {
  Vector3 middle;  // in the box's frame
  int sides;       // bit i: on the negative side of axis i
};
SupportEdge support_edge(const Vector3& half_extents, const Vector3& direction, Eigen::Index axis) {
  SupportEdge edge{Vector3::Zero(), 0};
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (i == axis) continue;
    edge.middle[i] = direction[i] < 0 ? -half_extents[i] : half_extents[i];
    if (direction[i] < 0) edge.sides |= 1 << i;
  }
  return edge;
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
  manifold.axis = static_cast<std::uint32_t>(2 * axis.code);
  if (separation > margin) return;
  manifold.add(position, separation, edge_edge_id(static_cast<int>(i), first.sides, static_cast<int>(j), second.sides));
}

Vector3 outward_normal(const FaceAxis& axis, const Matrix3& rotation) {
  const double side = axis.negative ? -1 : 1;
  return axis.of_second() ? Vector3(-side * rotation.col(axis.index())) : Vector3(side * Vector3::Unit(axis.index()));
}

// The face axis of the greatest separation; of equals, the first.
struct BestFace {
  FaceAxis axis;
  double separation = -std::numeric_limits<double>::infinity();
};
BestFace best_face_axis(const BoxPair& pair) {
  const Matrix3 along = pair.rotation.cwiseAbs();
  const Vector3 from_second = pair.rotation.transpose() * pair.position;
  const Vector3 of_first = pair.position.cwiseAbs() - pair.half_reference - along * pair.half_incident;
  const Vector3 of_second = from_second.cwiseAbs() - pair.half_incident - along.transpose() * pair.half_reference;
  BestFace best;
  for (int i = 0; i < 3; ++i) {
    if (of_first[i] > best.separation) best = {{i + 1, pair.position[i] < 0}, of_first[i]};
  }
  for (int i = 0; i < 3; ++i) {
    if (of_second[i] > best.separation) best = {{i + 4, from_second[i] > 0}, of_second[i]};
  }
  return best;
}

// The axis across an edge of each that parts the boxes best (Gottschalk et al., "OBBTree", SIGGRAPH 1996, section 5).
// FCL's own choice prefers faces by a part of the depth, so it is made anew. Code as FCL's.
fcl_narrowphase::Axis best_edge_axis(const BoxPair& pair) {
  const Matrix3& r = pair.rotation;
  const Matrix3 along = r.cwiseAbs();
  const Vector3& t = pair.position;
  const Vector3& a = pair.half_reference;
  const Vector3& b = pair.half_incident;
  fcl_narrowphase::Axis best;
  best.code = 0;
  best.separation = -std::numeric_limits<double>::infinity();
  double best_side = 1;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Eigen::Index i1 = (i + 1) % 3;
    const Eigen::Index i2 = (i + 2) % 3;
    for (Eigen::Index j = 0; j < 3; ++j) {
      const double sine_squared = r(i1, j) * r(i1, j) + r(i2, j) * r(i2, j);
      if (sine_squared < 1e-12) continue;  // parallel edges have a face axis
      const Eigen::Index j1 = (j + 1) % 3;
      const Eigen::Index j2 = (j + 2) % 3;
      const double offset = t[i2] * r(i1, j) - t[i1] * r(i2, j);
      const double reach = a[i1] * along(i2, j) + a[i2] * along(i1, j) + b[j1] * along(i, j2) + b[j2] * along(i, j1);
      const double separation = (std::abs(offset) - reach) / std::sqrt(sine_squared);
      if (separation <= best.separation) continue;
      best.separation = separation;
      best.code = static_cast<int>(7 + 3 * i + j);
      best_side = offset < 0 ? -1 : 1;
    }
  }
  if (best.code == 0) return best;
  const Eigen::Index i = (best.code - 7) / 3;
  const Eigen::Index j = (best.code - 7) % 3;
  best.normal = (best_side * Vector3::Unit(i).cross(r.col(j))).normalized();
  return best;
}

// Two faces that lie on each other, tilted by a hair, often cross deepest at their edges. A face wins where it looks
// the same way, within 0.1 degrees, and that of the last manifold within 2 degrees, so that ids don't flicker while a
// box rocks (at 1 degree a stack of three boxes a centimetre wide fell over); if its manifold is as deep, within what a
// tilt by a hair comes to.
bool face_stands_in(const BoxPair& pair, const fcl_narrowphase::Axis& edge, const FaceAxis& face, bool is_previous,
                    double margin, double size, Manifold& manifold) {
  const double cosine = outward_normal(face, pair.rotation).dot(edge.normal);
  if (cosine < (is_previous ? 1 - 6e-4 : 1 - 1.5e-6)) return false;
  face_manifold(pair, face, margin, manifold);
  double deepest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < manifold.count; ++i) {
    deepest = std::min(deepest, manifold.points[static_cast<std::size_t>(i)].separation);
  }
  if (std::abs(deepest - edge.separation) <= 2e-3 * size) return true;
  manifold.count = 0;
  return false;
}

}  // namespace

void collide_boxes(const Vector3& half_first, const Vector3& half_second, const Pose& second, double margin,
                   Manifold& manifold) {
  const BoxPair pair{half_first, half_second, second.position, second.orientation.toRotationMatrix()};
  const FaceAxis previous = FaceAxis::unpacked(std::exchange(manifold.axis, 0));
  if (!pair.position.allFinite() || !pair.rotation.allFinite()) return;
  const double size = std::min(half_first.minCoeff(), half_second.minCoeff());
  const auto [axis, face_separation] = best_face_axis(pair);
  if (axis.code == 0) return;  // so far away that sums overflow
  const fcl_narrowphase::Axis edge = best_edge_axis(pair);
  const double separation = std::max(face_separation, edge.separation);
  if (!(separation <= margin)) {
    manifold.gap = separation;
    return;
  }
  // FCL drops pairs that don't overlap: it is shown the first box grown by the margin then.
  const Vector3 grown = half_first + Vector3::Constant(separation > 0 ? margin : 0);
  fcl_narrowphase::Axis found;
  if (!fcl_narrowphase::box_box(grown, half_second, pair.position, pair.rotation, margin, found)) return;

  const bool had_face = previous.code >= 1 && previous.code <= 6;
  if (edge.separation > face_separation + 1e-9 * size) {
    if (had_face && face_stands_in(pair, edge, previous, true, margin, size, manifold)) return;
    if (face_stands_in(pair, edge, axis, false, margin, size, manifold)) return;
    edge_manifold(pair, edge, margin, manifold);
    return;
  }
  // Parallel faces are equally good up to rounding: keep the previous one, or its points' ids would flicker.
  if (had_face && previous.packed() != axis.packed() &&
      separation_along(pair, previous) >= face_separation - 1e-3 * size) {
    face_manifold(pair, previous, margin, manifold);
    if (manifold.count > 0) return;
  }
  face_manifold(pair, axis, margin, manifold);
}

}  // namespace atl::collision
