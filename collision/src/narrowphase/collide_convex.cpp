// Any two solids: where faces nearly lie on each other they are clipped against each other, where lines do,
// their ends count, and elsewhere the shapes touch in a point.

#include <collision/narrowphase/collide.h>
#include <collision/narrowphase/feature_id.h>
#include <collision/narrowphase/support_feature.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "narrowphase/convex_axis.h"
#include "narrowphase/line_contact.h"
#include "narrowphase/smooth_axis.h"
#include "narrowphase/sphere_solid.h"

namespace atl::collision {
namespace {

// A flat face that may be the reference.
struct Reference {
  bool of_second = false;
  FlatFace face;
  double separation = -INFINITY;

  std::uint32_t packed() const {
    return PackedAxis{of_second ? AxisOf::FaceOfSecond : AxisOf::FaceOfFirst, face.number}.packed();
  }
};

// A face stands in for an axis across edges where it looks the same way, within 0.1 degrees, and its manifold is as
// deep, within a part of the size; that of the pair's last manifold within 2 degrees and a larger part, so that ids
// don't flicker while a body rocks.
constexpr double same_axis = 1 - 1.5e-6;
constexpr double kept_axis = 1 - 6e-4;
constexpr double depth_tolerance = 5e-5;
constexpr double hysteresis = 1e-3;

struct Solids {
  SolidPair pair;
  Core first_core, second_core;
  Vector3 normal_first;   // of the best axis, out of the first, its frame
  Vector3 normal_second;  // out of the second, its frame

  // The cores are large, and stay as they are until they are built.
  explicit Solids(const SolidPair& solids) : pair(solids) {}

  const Shape& shape(bool second) const { return second ? pair.second : pair.first; }
  const Polytope& core(bool second) const { return (second ? second_core : first_core).polytope(); }
  const Vector3& normal(bool second) const { return second ? normal_second : normal_first; }
  void set_normal(const Vector3& normal) {
    normal_first = normal;
    normal_second = -(pair.rotation.transpose() * normal);
  }

  Reference measured(bool of_second, const FlatFace& face) const {
    const Vector3 normal = of_second ? Vector3(-(pair.rotation * face.normal)) : face.normal;
    return {of_second, face, pair.separation_along(normal)};
  }
};

// Faces that may be clipped against, the best first.
struct References {
  std::array<Reference, 2> faces;
  int count = 0;
};

// Breaks the tie between two references that part the solids equally: the last one comes first, then a disc, since
// clipping by a disc is more exact than clipping the disc by another face.
bool goes_first(const Solids& solids, const Reference& a, const Reference& b, std::uint32_t previous) {
  if (previous == a.packed() || previous == b.packed()) return previous == a.packed();
  const auto round = [&](const Reference& r) { return is_round(solids.shape(r.of_second).kind); };
  return round(a) && !round(b);
}

// True if a shape equals its core, and so has corners and edges of its own.
bool is_polytope(const Shape& shape) { return shape.kind == ShapeKind::Box || shape.kind == ShapeKind::Hull; }

// A vertex of what meets, of a core.
int vertex_of(const Polytope& core, const Feature& feature) {
  if (feature.kind == Feature::Kind::Vertex) return feature.index;
  return feature.kind == Feature::Kind::Edge ? core.edges[feature.index].tail
                                             : core.face_vertices[core.face_start[feature.index]];
}

// The face of a shape that looks along the axis most directly, of those at what meets there.
FlatFace face_at(const Solids& solids, bool second, const LocalAxis& axis) {
  const Shape& shape = solids.shape(second);
  const Polytope& core = solids.core(second);
  const Feature& feature = second ? axis.second : axis.first;
  if (!is_polytope(shape)) {
    return flat_face_along(shape, core, solids.normal(second));
  }
  if (feature.kind == Feature::Kind::Face) return flat_face(shape, core, feature.index, solids.normal(second));
  return flat_face_at(core, vertex_of(core, feature), solids.normal(second));
}

References reference_faces(const Solids& solids, const LocalAxis& axis, std::uint32_t previous) {
  constexpr double same = 1 - 1e-12;
  const double size = solids.pair.size();
  References found;
  for (const bool of_second : {false, true}) {
    const FlatFace face = face_at(solids, of_second, axis);
    if (face.number < 0) continue;
    Reference candidate{of_second, face, axis.separation};
    if (face.cosine < (candidate.packed() == previous ? kept_axis : same_axis)) continue;
    if (face.cosine < same) candidate = solids.measured(of_second, face);
    found.faces[static_cast<std::size_t>(found.count++)] = candidate;
  }
  if (found.count < 2) return found;
  auto& [a, b] = found.faces;
  const double equal = previous == a.packed() || previous == b.packed() ? hysteresis * size : 1e-5 * size;
  const double better = b.separation - a.separation;
  if (better > equal || (better >= -equal && goes_first(solids, b, a, previous))) std::swap(a, b);
  return found;
}

// The polygon that stands for a disc is a little wider: corners outside the disc are moved in, towards the middle of
// the outline, which keeps them on both faces.
void trim_to_disc(Outline& outline, double radius, double slack) {
  const double max = (radius + slack) * (radius + slack);
  const auto outside = [&](const Vector3& p) { return p.x() * p.x() + p.y() * p.y() > max; };
  Vector3 inner = Vector3::Zero();
  for (int i = 0; i < outline.count; ++i) inner += outline.corners[static_cast<std::size_t>(i)].position;
  inner /= std::max(outline.count, 1);
  for (int i = 0; i < outline.count && outside(inner); ++i)
    inner = outline.corners[static_cast<std::size_t>(i)].position;
  if (outside(inner)) {
    outline.count = 0;
    return;
  }
  for (int i = 0; i < outline.count; ++i) {
    Vector3& corner = outline.corners[static_cast<std::size_t>(i)].position;
    if (!outside(corner)) continue;
    const Vector3 d = corner - inner;
    const double dd = d.x() * d.x() + d.y() * d.y();
    const double half = inner.x() * d.x() + inner.y() * d.y();
    const double room = std::max(0.0, radius * radius - inner.x() * inner.x() - inner.y() * inner.y());
    corner = inner + std::min(1.0, (std::sqrt(half * half + dd * room) - half) / dd) * d;
  }
}

// The distance of a point beside a face, m.
double beside(const Shape& shape, const FacePolygon& face, const Vector3& point) {
  if (is_round(shape.kind)) return length_2d(point.x(), point.y()) - shape.radius;
  double farthest = -INFINITY;
  for (int i = 0; i < face.count; ++i) {
    const Vector3& tail = face.corners[static_cast<std::size_t>(i)];
    const Vector3& head = face.corners[static_cast<std::size_t>(i + 1 == face.count ? 0 : i + 1)];
    const Vector3 outward = (head - tail).cross(face.normal);
    farthest = std::max(farthest, outward.dot(point - tail) / std::max(outward.norm(), 1e-300));
  }
  return farthest;
}

// Leaves the manifold without points if nothing lies over the face.
void face_manifold(const Solids& solids, const Reference& reference, const LocalAxis& axis, double margin,
                   Manifold& manifold) {
  const SolidPair& pair = solids.pair;
  const bool second = reference.of_second;
  // The pose of the incident shape in the reference frame.
  const Matrix3 rotation = second ? Matrix3(pair.rotation.transpose()) : pair.rotation;
  const Vector3 position = second ? Vector3(-(rotation * pair.position)) : pair.position;

  FacePolygon face;
  face_polygon(solids.shape(second), solids.core(second), reference.face.number, face);
  Outline outline;
  const Vector3 towards = -(rotation.transpose() * face.normal);
  const Polytope& core = solids.core(!second);
  const int lowest =
      is_polytope(solids.shape(!second)) ? core.climb(vertex_of(core, second ? axis.first : axis.second), towards) : -1;
  const int incident_face =
      incident_outline(solids.shape(!second), core, towards, margin - reference.separation, outline, lowest);
  for (int i = 0; i < outline.count; ++i) {
    Vector3& corner = outline.corners[static_cast<std::size_t>(i)].position;
    corner = position + rotation * corner;
  }
  clip(outline, face, 1e-3 * pair.size());
  const Shape& shape = solids.shape(second);
  if (is_round(shape.kind)) trim_to_disc(outline, shape.radius, 1e-3 * pair.size());
  manifold.reference_is_second = second;
  manifold.count = 0;
  face_points(outline, face, incident_face, margin, manifold);
  manifold.on_face = true;
  manifold.axis = reference.packed();
}

// True if a point of the incident shape at the full depth along the face's normal lies over the face itself. In that
// case no direction nearby parts the solids better.
bool is_best_nearby(const Solids& solids, const Reference& reference, const Manifold& manifold) {
  const double size = solids.pair.size();
  FacePolygon face;
  bool has_face = false;
  for (int i = 0; i < manifold.count; ++i) {
    const Manifold::Point& point = manifold.points[static_cast<std::size_t>(i)];
    if (point.separation > reference.separation + 2e-6 * size) continue;
    if (!has_face)
      face_polygon(solids.shape(reference.of_second), solids.core(reference.of_second), reference.face.number, face);
    has_face = true;
    if (beside(solids.shape(reference.of_second), face, point.position) <= 1e-6 * size) return true;
  }
  return false;
}

// True if the face's normal can stand in for the best direction: the best leans from it by less than 0.1 degrees, and
// the manifold is as deep. For a point x of the incident shape and y of the reference, n . (x - y) bounds the
// separation along n. With x and y from opposite ends of the manifold, of width w, leaning by t costs t * w. The gain
// is at most the height of the points above the incident shape's lowest.
bool stands_in_nearby(const Solids& solids, const Reference& reference, const Manifold& manifold) {
  constexpr double lean = 1.4e-3;  // rad
  if (manifold.count < 2) return false;
  const double size = solids.pair.size();
  double min = INFINITY;
  double max = -INFINITY;
  int deepest = 0;
  for (int i = 0; i < manifold.count; ++i) {
    const double separation = manifold.points[static_cast<std::size_t>(i)].separation;
    if (separation < min) deepest = i;
    min = std::min(min, separation);
    max = std::max(max, separation);
  }
  if (!(min - reference.separation <= depth_tolerance * size)) return false;
  const auto at = [&](int i) -> const Vector3& { return manifold.points[static_cast<std::size_t>(i)].position; };
  const Vector3 d = at(1) - at(0);
  const double gain = max - reference.separation;
  if (manifold.count > 2) {
    // Points 0 and 1 lie opposite each other, and so do 2 and 3. A convex outline is as wide as its area by its
    // diameter.
    const Vector3 e = manifold.count == 4 ? Vector3(at(3) - at(2)) : Vector3(at(2) - at(0));
    const double area = 0.5 * d.cross(e).norm();
    double diameter = std::max(d.norm(), e.norm());
    if (manifold.count == 3) diameter = std::max(diameter, (at(2) - at(1)).norm());
    return gain * diameter <= lean * area;
  }
  // A line leans along its length or, over the face, to either side.
  if (!(gain <= lean * d.norm())) return false;
  FacePolygon face;
  face_polygon(solids.shape(reference.of_second), solids.core(reference.of_second), reference.face.number, face);
  const Vector3 aside = 0.05 * size * manifold.normal.cross(d).normalized();
  const Shape& shape = solids.shape(reference.of_second);
  return beside(shape, face, at(deepest) + aside) <= 0 && beside(shape, face, at(deepest) - aside) <= 0;
}

// The feature of the shape that a feature of its core stands for.
Feature shape_feature(const Shape& shape, const Polytope& core, const Feature& feature) {
  using enum Feature::Kind;
  if (!is_round(shape.kind)) return feature;
  switch (round_feature(shape, core, feature)) {
    case RoundFeature::UpperRim:
      return {Edge, 0};
    case RoundFeature::LowerRim:
      return {Edge, shape.kind == ShapeKind::Cone ? 0 : 1};
    case RoundFeature::Apex:
      return {Vertex, 0};
    case RoundFeature::Side:
      return {Face, 2};
    case RoundFeature::Cap:
      break;
  }
  return feature;
}

SurfaceLine edge_line(const Polytope& core, int edge, const Vector3& position, const Matrix3& rotation, double width) {
  const Hull::Edge& e = core.edges[edge];
  return {position + rotation * core.vertices[e.tail], position + rotation * core.vertices[e.head], 1, edge, width};
}

// Lines of one shape that may touch another's along their length: the line on a round side, or the edges of a
// polytope that meet at the contact, across the normal.
struct Lines {
  static constexpr int capacity = 8;
  std::array<SurfaceLine, capacity> lines;
  int count = 0;

  void add(const SurfaceLine& line) {
    if (count < capacity) lines[static_cast<std::size_t>(count++)] = line;
  }
};

Lines lines_at(const Solids& solids, bool second, const Feature& feature) {
  Lines lines;
  const Shape& shape = solids.shape(second);
  const Polytope& core = solids.core(second);
  const Vector3 position = second ? solids.pair.position : Vector3(Vector3::Zero());
  const Matrix3 rotation = second ? solids.pair.rotation : Matrix3(Matrix3::Identity());
  const Vector3& normal = solids.normal(second);
  const double sharp = 1e-3 * solids.pair.size();
  if (!is_polytope(shape)) {
    const SideLine side = side_line(shape, normal);
    // The width in which a round side falls away by half a thousandth of the size. A cone's side is sharp at the apex.
    const bool tapered = shape.kind == ShapeKind::TaperedCapsule;
    const double radius = tapered ? std::min(shape.radius, shape.top_radius) : shape.radius;
    const double width = shape.kind == ShapeKind::Cone ? sharp : std::sqrt(sharp * radius);
    if (side.exists) lines.add({position + rotation * side.tail, position + rotation * side.head, 2, 2, width});
    return lines;
  }
  if (feature.kind == Feature::Kind::Face) return lines;
  const int vertex = feature.kind == Feature::Kind::Vertex ? feature.index : core.edges[feature.index].tail;
  for (int i = core.vertex_start[vertex]; i < core.vertex_start[vertex + 1]; ++i) {
    const int edge = core.vertex_edges[i];
    if (feature.kind == Feature::Kind::Edge && edge != feature.index) continue;
    const Vector3 along = core.vertices[core.edges[edge].head] - core.vertices[core.edges[edge].tail];
    if (std::abs(along.dot(normal)) > 0.02 * along.norm()) continue;
    lines.add(edge_line(core, edge, position, rotation, sharp));
  }
  return lines;
}

bool line_manifold(const Solids& solids, const LocalAxis& axis, double margin, Manifold& manifold) {
  const Lines first = lines_at(solids, false, axis.first);
  const Lines second = lines_at(solids, true, axis.second);
  for (int i = 0; i < first.count; ++i) {
    for (int j = 0; j < second.count; ++j) {
      const SurfaceLine& line = second.lines[static_cast<std::size_t>(j)];
      manifold.count = 0;
      if (!line_points(first.lines[static_cast<std::size_t>(i)], line, axis.normal, margin, manifold)) continue;
      const double error = std::abs(manifold.min_separation() - axis.separation);
      if (error <= depth_tolerance * solids.pair.size()) return true;
    }
  }
  return false;
}

FeatureId witness_id(const Solids& solids, const LocalAxis& axis) {
  const Feature first = shape_feature(solids.pair.first, solids.core(false), axis.first);
  const Feature second = shape_feature(solids.pair.second, solids.core(true), axis.second);
  return feature_pair_id(static_cast<int>(first.kind), first.index, static_cast<int>(second.kind), second.index, 0);
}

// The axis to remember for a manifold without a reference face: two edges that cross, if there are such.
std::uint32_t edges_of(const Solids& solids, const LocalAxis& axis) {
  const bool crossing = axis.first.kind == Feature::Kind::Edge && axis.second.kind == Feature::Kind::Edge;
  if (!crossing || solids.pair.has_round() || solids.pair.has_smooth()) return 0;
  return PackedAxis{AxisOf::Edges, axis.first.index, axis.second.index}.packed();
}

void point_manifold(const Solids& solids, const LocalAxis& axis, Manifold& manifold) {
  manifold.reference_is_second = false;
  manifold.normal = axis.normal;
  manifold.count = 0;
  manifold.add(axis.on_second, axis.separation, witness_id(solids, axis));
}

// Faces that meet in a sliver may lose the deepest point. It takes the place of the point nearest to it.
void add_witness(const Solids& solids, const LocalAxis& axis, Manifold& manifold) {
  Vector3 position = axis.on_second;
  if (manifold.reference_is_second) {
    const Vector3 on_first = axis.on_second - axis.separation * axis.normal;
    position = solids.pair.rotation.transpose() * (on_first - solids.pair.position);
  }
  int place = manifold.count;
  if (place == max_points) {
    const auto distance = [&](int i) {
      return (manifold.points[static_cast<std::size_t>(i)].position - position).squaredNorm();
    };
    place = 0;
    for (int i = 1; i < max_points; ++i) {
      if (distance(i) < distance(place)) place = i;
    }
  } else {
    ++manifold.count;
  }
  manifold.points[static_cast<std::size_t>(place)] = {position, axis.separation, witness_id(solids, axis)};
}

// Clips against the faces that the axis is the normal of, or nearly. False, and no points, where that loses depth.
bool face_contact(const Solids& solids, const LocalAxis& axis, double margin, std::uint32_t previous,
                  Manifold& manifold) {
  constexpr double same = 1 - 1e-12;
  const double size = solids.pair.size();
  const References references = reference_faces(solids, axis, previous);
  for (int i = 0; i < references.count; ++i) {
    const Reference& reference = references.faces[static_cast<std::size_t>(i)];
    face_manifold(solids, reference, axis, margin, manifold);
    if (manifold.count == 0) continue;
    const double allowed = reference.packed() == previous ? hysteresis : depth_tolerance;
    if (std::abs(manifold.min_separation() - axis.separation) <= allowed * size) return true;
  }
  for (int i = 0; i < references.count; ++i) {
    const Reference& reference = references.faces[static_cast<std::size_t>(i)];
    if (reference.face.cosine < same) continue;
    face_manifold(solids, reference, axis, margin, manifold);
    add_witness(solids, axis, manifold);
    return true;
  }
  manifold.axis = 0;
  manifold.count = 0;
  return false;
}

// Round shapes that lie flat: where the axis is a face's normal and the best for the shapes themselves, it needn't be
// refined.
bool lies_flat(const Solids& solids, const Reference& reference, const LocalAxis& axis, double margin,
               Manifold& manifold) {
  face_manifold(solids, reference, axis, margin, manifold);
  return is_best_nearby(solids, reference, manifold) || stands_in_nearby(solids, reference, manifold);
}

bool flat_contact(const Solids& solids, const LocalAxis& axis, double margin, std::uint32_t previous,
                  Manifold& manifold) {
  const References references = reference_faces(solids, axis, previous);
  for (int i = 0; i < references.count; ++i) {
    if (lies_flat(solids, references.faces[static_cast<std::size_t>(i)], axis, margin, manifold)) return true;
  }
  manifold.axis = 0;
  manifold.count = 0;
  return false;
}

// The same of the last face, before any axis is looked for. As far as that may be missed one stays on the last face.
bool still_flat(Solids& solids, double margin, std::uint32_t previous, AxisSearch& found, Manifold& manifold) {
  const PackedAxis last = PackedAxis::unpacked(previous);
  if (last.of != AxisOf::FaceOfFirst && last.of != AxisOf::FaceOfSecond) return false;
  const SolidPair& pair = solids.pair;
  const bool second = last.of == AxisOf::FaceOfSecond;
  if (!is_round(pair.first.kind)) solids.first_core.build(pair.first);
  if (!is_round(pair.second.kind)) solids.second_core.build(pair.second);
  const Reference reference =
      solids.measured(second, flat_face(solids.shape(second), solids.core(second), last.number, Vector3::UnitZ()));
  const Vector3& outward = reference.face.normal;
  LocalAxis& axis = found.axis;
  axis.normal = second ? Vector3(-(pair.rotation * outward)) : outward;
  axis.separation = reference.separation;
  found.by = Narrowphase::Kept;
  found.gap = axis.separation;
  found.touches = axis.separation <= margin;
  if (!found.touches) return true;
  solids.set_normal(axis.normal);
  (second ? axis.second : axis.first) = {Feature::Kind::Face, last.number};
  const int lowest = is_polytope(solids.shape(!second)) ? solids.core(!second).support(solids.normal(!second)) : 0;
  (second ? axis.first : axis.second) = {Feature::Kind::Vertex, lowest};
  if (!lies_flat(solids, reference, axis, margin, manifold)) return false;
  const Vector3& deepest = manifold.points[static_cast<std::size_t>(manifold.deepest())].position;
  axis.on_second = second ? Vector3(pair.position + pair.rotation * deepest + axis.separation * axis.normal) : deepest;
  return !face_may_be_better(pair, solids.core(false), solids.core(true), axis, hysteresis * pair.size());
}

}  // namespace

Narrowphase collide_convex(const Shape& first_shape, const Shape& second_shape, const Pose& second, double margin,
                           Manifold& manifold) {
  const std::uint32_t previous = std::exchange(manifold.axis, 0);
  const bool known = std::exchange(manifold.known, false);
  manifold.count = 0;
  if (first_shape.kind == ShapeKind::Sphere) {
    collide_sphere_solid(first_shape.radius, second_shape, second, margin, manifold);
    return Narrowphase::ClosedForm;
  }
  if (first_shape.kind == ShapeKind::Capsule && second_shape.kind == ShapeKind::Capsule) {
    collide_capsules(first_shape, second_shape, second, margin, manifold);
    return Narrowphase::ClosedForm;
  }
  Solids solids({first_shape, second_shape, second.position, second.orientation.toRotationMatrix()});
  const SolidPair& pair = solids.pair;
  KnownAxis last;
  if (known) {
    const bool of_second = manifold.reference_is_second;
    const Vector3& normal = manifold.normal;
    const Vector3& middle = manifold.middle;
    last = {true, of_second ? Vector3(-(pair.rotation * normal)) : normal,
            of_second ? Vector3(pair.position + pair.rotation * middle) : middle, previous};
  }
  AxisSearch found;
  LocalAxis& axis = found.axis;
  if (known && pair.has_round() && !pair.has_smooth() && still_flat(solids, margin, previous, found, manifold)) {
    if (!found.touches) manifold.gap = found.gap;
    return found.by;
  }
  manifold.axis = 0;
  manifold.count = 0;
  const bool smooth = pair.has_smooth();
  bool settled = !smooth && find_on_last_features(pair, last, solids.first_core, solids.second_core, axis);
  if (settled) {
    found.by = Narrowphase::Kept;
  } else {
    const auto find = smooth ? find_smooth_axis : find_axis;
    found = find(pair, margin, last, solids.first_core, solids.second_core);
    if (!found.touches) {
      manifold.gap = found.gap;
      return found.by;
    }
  }
  solids.set_normal(axis.normal);

  if (pair.has_round() && !smooth) {
    if (!settled) {
      if (flat_contact(solids, axis, margin, previous, manifold)) return found.by;
      settled = settle_on_features(pair, solids.first_core.polytope(), solids.second_core.polytope(), axis) ||
                refine_axis(pair, last, solids.first_core, solids.second_core, axis);
      solids.set_normal(axis.normal);
    }
    if (!(axis.separation <= margin)) {
      manifold.gap = axis.separation;
      return found.by;
    }
  }
  if (face_contact(solids, axis, margin, previous, manifold)) return found.by;
  manifold.on_face = false;
  manifold.axis = settled ? packed_features(axis) : edges_of(solids, axis);
  if (!line_manifold(solids, axis, margin, manifold)) point_manifold(solids, axis, manifold);
  return found.by;
}

}  // namespace atl::collision
