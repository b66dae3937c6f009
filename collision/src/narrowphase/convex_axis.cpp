#include "narrowphase/convex_axis.h"

#include <collision/narrowphase/fcl_narrowphase.h>
#include <collision/shapes/shape.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace atl::collision {
namespace {

// The first face from one on that a point lies farther beyond than a limit (m), or nearly: four at a time, most fail.
int next_face_beyond(const Polytope& polytope, int face, const Vector3& point, double limit) {
  const double x = point.x();
  const double y = point.y();
  const double z = point.z();
  const auto beyond = [&](int f) {
    const Hull::Plane& plane = polytope.planes[f];
    return plane.normal.x() * x + plane.normal.y() * y + (plane.normal.z() * z - plane.offset);
  };
  const auto larger = [](double a, double b) { return a > b ? a : b; };
  const int count = polytope.face_count;
  while (face + 3 < count &&
         larger(larger(beyond(face), beyond(face + 1)), larger(beyond(face + 2), beyond(face + 3))) <= limit) {
    face += 4;
  }
  while (face < count && beyond(face) <= limit) ++face;
  return face;
}

// Tries faces that may part overlapping solids better than the axis found. A face can only be better if its plane is
// nearer to a point shared by both solids, within rounding. A shallow overlap leaves the faces that meet at the
// contact. Another descent starts from each face that isn't much worse than the axis.
void try_faces(const Polytope& first, const Polytope& second, const SolidPair& pair, GaussMapDescent& descent,
               LocalAxis& best) {
  const double slack = 1e-9 * pair.size();
  const auto promising = [&](double separation) { return separation > 2 * best.separation - 0.02 * pair.size(); };
  const auto next_of = [&](const Polytope& polytope, int face, const Vector3& point) {
    return next_face_beyond(polytope, face, point, best.separation + 0.999 * slack);
  };
  for (int f = next_of(first, 0, best.on_second); f < first.face_count && best.separation < 0;
       f = next_of(first, f + 1, best.on_second)) {
    const Hull::Plane& plane = first.planes[f];
    if (plane.normal.dot(best.on_second) - plane.offset <= best.separation + slack) continue;
    if (best.first.kind == Feature::Kind::Face && best.first.index == f) continue;
    if (!promising(descent.separation_from_first(f))) continue;
    const LocalAxis axis = descent.from_face_of_first(f);
    if (axis.separation > best.separation + slack) best = axis;
  }
  const auto on_first = [&] {
    return Vector3(pair.rotation.transpose() * (best.on_second - best.separation * best.normal - pair.position));
  };
  Vector3 point = on_first();
  for (int f = next_of(second, 0, point); f < second.face_count && best.separation < 0;
       f = next_of(second, f + 1, point)) {
    const Hull::Plane& plane = second.planes[f];
    if (plane.normal.dot(point) - plane.offset <= best.separation + slack) continue;
    if (best.second.kind == Feature::Kind::Face && best.second.index == f) continue;
    if (!promising(descent.separation_from_second(f))) continue;
    const LocalAxis axis = descent.from_face_of_second(f);
    if (axis.separation <= best.separation + slack) continue;
    best = axis;
    point = on_first();
  }
}

// True if a feature of a round shape's core lies on its side: a side face or an edge between two, not a cap or a rim.
bool is_on_side(const Shape& shape, const Polytope& core, const Feature& feature) {
  return round_feature(shape, core, feature) == RoundFeature::Side;
}

// The azimuth around which a round shape's core is made finer, in the shape's frame: that of the contact, or that of
// the normal if the contact is on the side or on the shape's axis.
Vector3 direction_about(const Shape& shape, bool on_side, const Vector3& contact, const Vector3& outward) {
  if (!is_round(shape.kind)) return Vector3::UnitX();
  const double far = 1e-3 * shape.radius;
  const bool has_azimuth = outward.x() * outward.x() + outward.y() * outward.y() > 1e-12;
  if (has_azimuth && on_side) return outward;
  if (contact.x() * contact.x() + contact.y() * contact.y() > far * far) return contact;
  return has_azimuth ? outward : Vector3(Vector3::UnitX());
}

struct About {
  Vector3 first = Vector3::UnitX();
  Vector3 second = Vector3::UnitX();
};

About look_closer(const SolidPair& pair, const Polytope& first, const Polytope& second, const LocalAxis& axis) {
  const Vector3 on_first = axis.on_second - axis.separation * axis.normal;
  const Vector3 on_second = pair.rotation.transpose() * (axis.on_second - pair.position);
  return {direction_about(pair.first, is_on_side(pair.first, first, axis.first), on_first, axis.normal),
          direction_about(pair.second, is_on_side(pair.second, second, axis.second), on_second,
                          -(pair.rotation.transpose() * axis.normal))};
}

// Sine of the angle between two directions in the x-y plane; 1 where it is more than a right one.
double turned(const Vector3& a, const Vector3& b) {
  if (a.x() * b.x() + a.y() * b.y() < 0) return 1;
  return std::abs(a.x() * b.y() - a.y() * b.x()) / (length_2d(a.x(), a.y()) * length_2d(b.x(), b.y()));
}

struct SideEdge {
  bool exists = false;
  Vector3 tail, head;
};

// True if the normal is one of a round shape's side, whatever feature of the core was found.
bool is_side_normal(const Shape& shape, const Vector3& outward, double tolerance) {
  const double across = length_2d(outward.x(), outward.y());
  if (shape.kind == ShapeKind::Cylinder) return std::abs(outward.z()) < tolerance * across;
  const double leaning = shape.radius * across - 2 * shape.half_height * outward.z();
  return std::abs(leaning) < tolerance * (shape.radius + shape.half_height) && across > 0;
}

About look_where_known(const SolidPair& pair, const KnownAxis& known) {
  constexpr double slightly = 1e-3;
  const Vector3 outward_second = -(pair.rotation.transpose() * known.normal);
  const Vector3 on_second = pair.rotation.transpose() * (known.point - pair.position);
  return {
      direction_about(pair.first, is_side_normal(pair.first, known.normal, slightly), known.point, known.normal),
      direction_about(pair.second, is_side_normal(pair.second, outward_second, slightly), on_second, outward_second)};
}

// The line that touches: on a side along the normal, or an edge. Frame of the shape.
SideEdge touching_line(const Shape& shape, const Polytope& core, const Feature& feature, const Vector3& outward) {
  if (shape.kind == ShapeKind::Capsule) {
    if (feature.kind != Feature::Kind::Edge) return {};
    const Vector3 end = shape.half_height * Vector3::UnitZ();
    return {true, shape.radius * outward - end, shape.radius * outward + end};
  }
  if (is_round(shape.kind)) {
    if (!is_on_side(shape, core, feature) && !is_side_normal(shape, outward, 1e-9)) return {};
    const double scale = shape.radius / std::max(length_2d(outward.x(), outward.y()), 1e-300);
    const Vector3 rim(scale * outward.x(), scale * outward.y(), -shape.half_height);
    const double top = shape.kind == ShapeKind::Cone ? 0 : 1;
    return {true, rim, Vector3(top * rim.x(), top * rim.y(), shape.half_height)};
  }
  if (feature.kind != Feature::Kind::Edge) return {};
  const Hull::Edge& edge = core.edges[feature.index];
  return {true, core.vertices[edge.tail], core.vertices[edge.head]};
}

// Puts a point that is off the rim of a round shape onto it, at the normal's azimuth. False where it wasn't off.
bool settle_on_rim(const Shape& shape, const Polytope& core, const Feature& feature, const Vector3& outward,
                   double tolerance, Vector3& point) {
  if (!is_round(shape.kind) || feature.kind == Feature::Kind::Face || is_on_side(shape, core, feature)) return false;
  if (shape.kind == ShapeKind::Cone && point.z() > -shape.half_height + tolerance) return false;
  const double radius = length_2d(point.x(), point.y());
  if (!(std::abs(radius - shape.radius) > tolerance)) return false;
  const double across = length_2d(outward.x(), outward.y());
  const Vector3& way = across > 0.1 ? outward : point;
  const double scale = shape.radius / (across > 0.1 ? across : radius);
  point.x() = scale * way.x();
  point.y() = scale * way.y();
  return true;
}

// Moves the witness point from the polygonal cores to the solids: onto a rim, or where lines on both solids cross.
void settle_witness(const SolidPair& pair, const Polytope& first, const Polytope& second, LocalAxis& axis) {
  const Vector3 outward_second = -(pair.rotation.transpose() * axis.normal);
  const double tolerance = 1e-4 * pair.size();
  Vector3 on_second = pair.rotation.transpose() * (axis.on_second - pair.position);
  Vector3 on_first = axis.on_second - axis.separation * axis.normal;
  if (settle_on_rim(pair.second, second, axis.second, outward_second, tolerance, on_second)) {
    axis.on_second = pair.position + pair.rotation * on_second;
  } else if (settle_on_rim(pair.first, first, axis.first, axis.normal, tolerance, on_first)) {
    axis.on_second = on_first + axis.separation * axis.normal;
  }
  const SideEdge a = touching_line(pair.first, first, axis.first, axis.normal);
  const SideEdge b = touching_line(pair.second, second, axis.second, outward_second);
  if (!a.exists || !b.exists) return;
  const Vector3 tail = pair.position + pair.rotation * b.tail;
  const Vector3 u = a.head - a.tail;
  const Vector3 v = pair.rotation * (b.head - b.tail);
  const Vector3 w = tail - a.tail;
  const Vector3 cross = u.cross(v);
  const double cc = cross.squaredNorm();
  if (!(cc > 1e-6 * u.squaredNorm() * v.squaredNorm())) return;
  const double s = w.cross(v).dot(cross) / cc;
  const double t = w.cross(u).dot(cross) / cc;
  if (s < 0 || s > 1 || t < 0 || t > 1) return;
  axis.on_second = tail + t * v;
}

// Part of the size by which a depth that FCL finds may differ from the depth along its axis. FCL's refinement stops at
// half of it (see fcl_narrowphase.cpp).
constexpr double depth_agreement = 2e-2;

LocalAxis walk_from(const KnownAxis& known, GaussMapDescent& descent) {
  const PackedAxis axis = PackedAxis::unpacked(known.features);
  switch (axis.of) {
    case AxisOf::FaceOfFirst:
      return descent.from_face_of_first(axis.number);
    case AxisOf::FaceOfSecond:
      return descent.from_face_of_second(axis.number);
    case AxisOf::Edges:
      return descent.from_edges(axis.number, axis.second_number, known.normal);
    case AxisOf::Features:
    case AxisOf::None:
      break;
  }
  return descent.from_direction(known.normal);
}

// Any direction, where they coincide.
Vector3 line_of_centres(const SolidPair& pair) {
  const double distance = pair.position.norm();
  return distance > 0 ? Vector3(pair.position / distance) : Vector3::UnitZ();
}

// Turns an axis of the cores into one of the solids.
void grow_by_radii(const SolidPair& pair, const Core& first, const Core& second, LocalAxis& axis) {
  axis.on_second -= second.radius() * axis.normal;
  axis.separation =
      pair.has_round() ? pair.separation_along(axis.normal) : axis.separation - first.radius() - second.radius();
}

}  // namespace

double SolidPair::separation_along(const Vector3& normal) const {
  return normal.dot(position) - reach_along(first, normal) - reach_along(second, -(rotation.transpose() * normal));
}

// Puts sides ever closer around where the shapes meet, until the features that meet settle or that stays where it is.
bool refine_axis(const SolidPair& pair, const KnownAxis& known, Core& first, Core& second, LocalAxis& axis) {
  if (!pair.has_round()) return false;
  constexpr int last_level = Core::levels - 1;
  constexpr int max_rounds = 10;
  // rad, by level: as far as the sides are dense; of the last, where they are less than 0.1 degrees apart.
  constexpr std::array<double, Core::levels> settled = {0.6, 0.25, 0.03, 2e-3};
  const bool first_round = is_round(pair.first.kind);
  const bool second_round = is_round(pair.second.kind);
  axis.on_second += second.radius() * axis.normal;
  axis.separation += first.radius() + second.radius();
  LocalAxis best = axis;
  double best_separation = pair.separation_along(axis.normal);
  About about =
      known.exists ? look_where_known(pair, known) : look_closer(pair, first.polytope(), second.polytope(), axis);
  int level = known.exists ? last_level : 1;
  for (int round = 0; round < max_rounds; ++round) {
    if (first_round) first.build(pair.first, level, about.first);
    if (second_round) second.build(pair.second, level, about.second);
    GaussMapDescent descent(first.polytope(), second.polytope(), pair.position, pair.rotation);
    axis = descent.from_direction(axis.normal);
    const double separation = pair.separation_along(axis.normal);
    LocalAxis exact = axis;
    if (settle_on_features(pair, first.polytope(), second.polytope(), exact) &&
        exact.separation >= best_separation - 1e-12 * pair.size()) {
      axis = exact;
      return true;
    }
    // Among axes equal within rounding the last one wins, since the core was finest around its features.
    if (separation >= best_separation - 1e-12 * pair.size()) {
      best = axis;
      best_separation = separation;
    }
    const About before = about;
    about = look_closer(pair, first.polytope(), second.polytope(), axis);
    const double moved = std::max(first_round ? turned(before.first, about.first) : 0,
                                  second_round ? turned(before.second, about.second) : 0);
    // Out of where the sides are dense they were too far apart to tell where it went.
    const bool still = moved < settled[static_cast<std::size_t>(level)];
    if (still && level == last_level) break;
    level = still ? level + 1 : std::max(level - 1, 0);
  }
  axis = best;
  axis.on_second -= second.radius() * axis.normal;
  axis.separation = best_separation;
  settle_witness(pair, first.polytope(), second.polytope(), axis);
  return false;
}

RoundFeature round_feature(const Shape& shape, const Polytope& core, const Feature& feature) {
  using enum RoundFeature;
  const bool cone = shape.kind == ShapeKind::Cone;
  const auto ring = [](int vertex) { return vertex / Core::sides; };  // or the apex
  const auto rim = [&](int number) { return cone || number == 1 ? LowerRim : UpperRim; };
  switch (feature.kind) {
    case Feature::Kind::Vertex:
      return cone && feature.index == Core::sides ? Apex : rim(ring(feature.index));
    case Feature::Kind::Edge: {
      const Hull::Edge& edge = core.edges[feature.index];
      return ring(edge.tail) == ring(edge.head) ? rim(ring(edge.tail)) : Side;
    }
    case Feature::Kind::Face:
      return feature.index < (cone ? 1 : 2) ? Cap : Side;
  }
  return Cap;
}

bool SolidPair::has_round() const { return is_round(first.kind) || is_round(second.kind); }

AxisSearch find_axis(const SolidPair& pair, double margin, const KnownAxis& known, Core& first, Core& second) {
  AxisSearch found;
  LocalAxis& axis = found.axis;
  first.build(pair.first);
  second.build(pair.second);
  GaussMapDescent descent(first.polytope(), second.polytope(), pair.position, pair.rotation);
  // A face elsewhere may part cores that overlap better than what a walk came to.
  const auto search_faces = [&] {
    if (axis.separation < 0) try_faces(first.polytope(), second.polytope(), pair, descent, axis);
  };
  const auto settle = [&](Narrowphase by) {
    grow_by_radii(pair, first, second, axis);
    found.by = by;
    found.gap = axis.separation;
    found.touches = found.gap <= margin && axis.normal.allFinite();
    return found;
  };

  if (known.exists) {
    axis = walk_from(known, descent);
    if (!axis.confirmed) axis = descent.from_direction(line_of_centres(pair));
    search_faces();
    return settle(Narrowphase::Kept);
  }

  axis = descent.from_direction(line_of_centres(pair));
  if (!settle(Narrowphase::ClosedForm).touches) return found;
  fcl_narrowphase::Axis answer;
  if (!fcl_narrowphase::convex(pair.first, pair.second, pair.position, pair.rotation, margin, answer)) {
    found.touches = false;
    found.by = Narrowphase::Fcl;
    return found;
  }
  axis = descent.from_direction(answer.normal);
  const double along_answer = axis.separation;
  search_faces();
  const bool stands =
      std::abs(pair.separation_along(answer.normal) - answer.separation) <= depth_agreement * pair.size() &&
      axis.separation - along_answer <= depth_agreement * pair.size();
  return settle(stands ? Narrowphase::Fcl : Narrowphase::Repaired);
}

}  // namespace atl::collision
