// Box against box: FCL chooses the axis; the features that support it are clipped against each other here,
// so that every point knows which features made it.

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
Outline clip(const Outline& outline, Eigen::Index axis, double side, double limit, double slack, int edge) {
  Outline result;
  for (int i = 0; i < outline.count; ++i) {
    const OutlineCorner& from = outline.corners[static_cast<std::size_t>(i)];
    const OutlineCorner& to = outline.corners[static_cast<std::size_t>((i + 1) % outline.count)];
    const double from_outside = side * from.position[axis] - limit;
    const double to_outside = side * to.position[axis] - limit;
    const bool from_in = from_outside <= slack;
    const bool to_in = to_outside <= slack;
    if (from_in) result.add(from);
    if (from_in == to_in) continue;
    const double t = std::clamp(from_outside / (from_outside - to_outside), 0.0, 1.0);
    const Vector3 crossing = from.position + t * (to.position - from.position);
    result.add(from_in ? OutlineCorner{crossing, from.edge_out, edge} : OutlineCorner{crossing, edge, from.edge_out});
  }
  return result;
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
  outline = clip(outline, u, 1, pair.half_reference[u], slack, 4);
  outline = clip(outline, v, 1, pair.half_reference[v], slack, 5);
  outline = clip(outline, u, -1, pair.half_reference[u], slack, 6);
  outline = clip(outline, v, -1, pair.half_reference[v], slack, 7);

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

FaceAxis face_axis_of(const fcl_narrowphase::Axis& axis, const Matrix3& rotation) {
  FaceAxis face{axis.code, false};
  if (face.of_second()) {
    face.negative = -rotation.col(face.index()).dot(axis.normal) < 0;  // out of the second box
  } else {
    face.negative = axis.normal[face.index()] < 0;
  }
  return face;
}

Vector3 outward_normal(const FaceAxis& axis, const Matrix3& rotation) {
  const double side = axis.negative ? -1 : 1;
  return axis.of_second() ? Vector3(-side * rotation.col(axis.index())) : Vector3(side * Vector3::Unit(axis.index()));
}

// The face axis of the greatest separation; of equals, the first.
FaceAxis best_face_axis(const BoxPair& pair) {
  const Vector3 from_second = pair.rotation.transpose() * pair.position;
  FaceAxis best;
  double best_separation = -std::numeric_limits<double>::infinity();
  for (int code = 1; code <= 6; ++code) {
    FaceAxis axis{code, false};
    axis.negative = axis.of_second() ? from_second[axis.index()] > 0 : pair.position[axis.index()] < 0;
    const double separation = separation_along(pair, axis);
    if (separation <= best_separation) continue;
    best = axis;
    best_separation = separation;
  }
  return best;
}

// Two faces that lie on each other, tilted by a hair, often cross deepest at their edges. FCL's preference for
// faces is a part of the depth, and the depth of resting boxes is next to nothing: so here a face also wins
// where it looks the same way, within 8 degrees, and is as deep, within a part of the smaller box's size.
bool resembles_face(const BoxPair& pair, const fcl_narrowphase::Axis& edge, const FaceAxis& face, double size) {
  const Vector3 normal = outward_normal(face, pair.rotation);
  if (normal.dot(edge.normal) < 0.99) return false;
  const double edge_separation = std::abs(pair.position.dot(edge.normal)) -
                                 pair.half_reference.dot(edge.normal.cwiseAbs()) -
                                 pair.half_incident.dot((pair.rotation.transpose() * edge.normal).cwiseAbs());
  return separation_along(pair, face) >= edge_separation - 0.02 * size;
}

}  // namespace

void collide_boxes(const Vector3& half_first, const Vector3& half_second, const Pose& second, double margin,
                   Manifold& manifold) {
  const BoxPair pair{half_first, half_second, second.position, second.orientation.toRotationMatrix()};
  const FaceAxis previous = FaceAxis::unpacked(std::exchange(manifold.axis, 0));
  fcl_narrowphase::Axis found;
  if (!fcl_narrowphase::box_box(half_first, half_second, pair.position, pair.rotation, margin, found)) return;

  const double size = std::min(half_first.minCoeff(), half_second.minCoeff());
  FaceAxis axis = face_axis_of(found, pair.rotation);
  if (found.code > 6) {
    axis = best_face_axis(pair);
    if (!resembles_face(pair, found, axis, size)) {
      edge_manifold(pair, found, margin, manifold);
      return;
    }
  }
  // Parallel faces are equally good up to rounding: keep the previous one, or its points' ids would flicker.
  if (previous.code >= 1 && previous.code <= 6 && previous.packed() != axis.packed() &&
      separation_along(pair, previous) >= separation_along(pair, axis) - 1e-3 * size) {
    face_manifold(pair, previous, margin, manifold);
    if (manifold.count > 0) return;
  }
  face_manifold(pair, axis, margin, manifold);
}

}  // namespace atl::collision
