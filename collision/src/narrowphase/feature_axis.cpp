// The best axis of two features in closed form. A solid's boundary, as a contact sees it, is made of points (vertices,
// the ends of a capsule, an apex), rims and lines. The outward normals of a line make a constant angle with it: a right
// angle for edges and the sides of capsules and cylinders, another for a cone's.

#include <collision/shapes/shape.h>

#include <algorithm>
#include <cmath>

#include "narrowphase/convex_axis.h"

namespace atl::collision {
namespace {

// Cosine: the axis given is within half a step of a core's sides, and what leads farther is another contact.
constexpr double near_enough = 0.95;

// Part of the size within which the reach of features and that of the solids count as equal; it covers rounding.
constexpr double same_reach = 1e-9;

// Part of a line's length by which it may be met beyond its ends.
constexpr double past_end = 1e-9;

struct Segment {
  Vector3 tail, head;
};

// A feature in the frame of the first solid.
struct Boundary {
  enum class Kind { None, Point, Rim, Line };
  Kind kind = Kind::None;
  Vector3 origin = Vector3::Zero();  // the point, the rim's centre, a point of the line
  Vector3 along = Vector3::Zero();   // unit: the rim's axis, or the line
  double lean = 0;                   // of a line: cosine between it and its outward normals
  double radius = 0;                 // m: of the rim, or by which the surface stands off a point or a line
  double half_length = 0;            // m: of a line, from its origin to either end; of a cone's, of its axis

  // The reach (m) along an outward direction.
  double reach(const Vector3& outward) const {
    const double across = kind == Kind::Rim ? perpendicular(outward).norm() : 1;
    return outward.dot(origin) + radius * across;
  }
  Vector3 perpendicular(const Vector3& v) const { return v - v.dot(along) * along; }
  Vector3 surface_point(const Vector3& outward) const {
    return origin + radius * (kind == Kind::Rim ? Vector3(perpendicular(outward).normalized()) : outward);
  }
  // The part of the surface that looks along an outward normal of a line.
  Segment surface_line(const Vector3& outward) const {
    if (lean != 0) {
      // From the apex down to the rim: slant * (sine of the normals' lean = 2 h / slant, its cosine = r / slant).
      const double up = std::sqrt(1 - lean * lean);
      const double slant = 2 * half_length / up;
      return {origin + slant * (lean / up * (outward - lean * along) - up * along), origin};
    }
    const Vector3 middle = origin + radius * outward;
    return {middle - half_length * along, middle + half_length * along};
  }
};

Boundary boundary_at(const SolidPair& pair, const Polytope& core, const Feature& feature, bool second) {
  using enum Feature::Kind;
  const Shape& shape = second ? pair.second : pair.first;
  const auto at = [&](const Vector3& local) { return second ? Vector3(pair.position + pair.rotation * local) : local; };
  const auto turned = [&](const Vector3& local) { return second ? Vector3(pair.rotation * local) : local; };
  Boundary boundary;
  if (!is_round(shape.kind)) {
    const double radius = shape.kind == ShapeKind::Capsule ? shape.radius : 0;
    if (feature.kind == Vertex) {
      boundary.kind = Boundary::Kind::Point;
      boundary.origin = at(core.vertices[feature.index]);
      boundary.radius = radius;
    } else if (feature.kind == Edge) {
      const Vector3& tail = core.vertices[core.edges[feature.index].tail];
      const Vector3& head = core.vertices[core.edges[feature.index].head];
      const double length = (head - tail).norm();
      if (!(length > 0)) return boundary;
      boundary.kind = Boundary::Kind::Line;
      boundary.origin = at(0.5 * (tail + head));
      boundary.along = turned((head - tail) / length);
      boundary.radius = radius;
      boundary.half_length = 0.5 * length;
    }
    return boundary;
  }

  const bool cone = shape.kind == ShapeKind::Cone;
  const double h = shape.half_height;
  boundary.along = second ? Vector3(pair.rotation.col(2)) : Vector3(Vector3::UnitZ());
  const Vector3 middle = second ? pair.position : Vector3(Vector3::Zero());
  switch (round_feature(shape, core, feature)) {
    case RoundFeature::UpperRim:
    case RoundFeature::LowerRim: {
      boundary.kind = Boundary::Kind::Rim;
      const bool upper = round_feature(shape, core, feature) == RoundFeature::UpperRim;
      boundary.origin = middle + (upper ? h : -h) * boundary.along;
      boundary.radius = shape.radius;
      break;
    }
    case RoundFeature::Apex:
      boundary.kind = Boundary::Kind::Point;
      boundary.origin = middle + h * boundary.along;
      break;
    case RoundFeature::Side:
      boundary.kind = Boundary::Kind::Line;
      boundary.origin = cone ? Vector3(middle + h * boundary.along) : middle;
      boundary.lean = cone ? shape.radius / length_2d(shape.radius, 2 * h) : 0;
      boundary.radius = cone ? 0 : shape.radius;
      boundary.half_length = h;
      break;
    case RoundFeature::Cap:
      break;
  }
  return boundary;
}

// True if a point lies beside a segment, not beyond its ends.
bool is_beside(const Segment& line, const Vector3& point) {
  const Vector3 v = line.head - line.tail;
  const double s = v.dot(point - line.tail);
  const double vv = v.squaredNorm();
  return s >= -past_end * vv && s <= (1 + past_end) * vv;
}

// The direction across two lines that both look along it, and where it meets the second's surface.
bool across_lines(const Boundary& first, const Boundary& second, Vector3& normal, Vector3& on_second) {
  const Vector3& a = first.along;
  const Vector3& b = second.along;
  const double g = a.dot(b);
  const double sine_squared = 1 - g * g;
  if (!(sine_squared > 1e-4)) return false;
  // n = (x a + y b + z a x b) with n . a = lean of the first, and -n . b that of the second.
  const double x = (first.lean + g * second.lean) / sine_squared;
  const double y = (-second.lean - g * first.lean) / sine_squared;
  const double rest = 1 - (x * first.lean - y * second.lean);
  if (!(rest > 0)) return false;
  const Vector3 cross = a.cross(b);
  const double z = std::sqrt(rest / sine_squared);
  const Vector3 found = x * a + y * b + (cross.dot(normal) < 0 ? -z : z) * cross;
  const Segment line_first = first.surface_line(found);
  const Segment line_second = second.surface_line(-found);
  // Closest points of two lines (Ericson, "Real-Time Collision Detection", 2005, section 5.1.8).
  const Vector3 u = line_first.head - line_first.tail;
  const Vector3 v = line_second.head - line_second.tail;
  const Vector3 w = line_second.tail - line_first.tail;
  const Vector3 uv = u.cross(v);
  const double cc = uv.squaredNorm();
  if (!(cc > 1e-6 * u.squaredNorm() * v.squaredNorm())) return false;
  const double s = w.cross(v).dot(uv) / cc;
  const double t = w.cross(u).dot(uv) / cc;
  if (std::min(s, t) < -past_end || std::max(s, t) > 1 + past_end) return false;
  normal = found;
  on_second = line_second.tail + t * v;
  return true;
}

// The outward normal of a line that parts it best from a point or a rim. `outward` is one near it.
bool from_line(const Boundary& line, const Boundary& other, Vector3& outward) {
  const Vector3 w = other.origin - line.origin;
  const double k = std::sqrt(1 - line.lean * line.lean);
  if (other.kind == Boundary::Kind::Point) {
    const Vector3 away = line.perpendicular(w);
    const double distance = away.norm();
    if (!(distance > 0)) return false;
    outward = line.lean * line.along + k / distance * away;
    return true;
  }
  Vector3 m = line.perpendicular(outward);
  const double length = m.norm();
  if (!(length > 0.1)) return false;
  m = line.lean * line.along + k / length * m;
  constexpr int max_steps = 12;
  for (int step = 0; step < max_steps; ++step) {
    // With m turning about the line by an angle, s = m . w - r sqrt(1 - (m . a)^2), and its derivatives.
    const Vector3 radial = m - line.lean * line.along;
    const Vector3 tangent = line.along.cross(radial);
    const double z = m.dot(other.along);
    const double f2 = 1 - z * z;
    if (!(f2 > 1e-6)) return false;
    const double f = std::sqrt(f2);
    const double dz = tangent.dot(other.along);
    const double ddz = -radial.dot(other.along);
    const double slope = tangent.dot(w) + other.radius * z * dz / f;
    const double bend = -radial.dot(w) + other.radius * (z * ddz / f + dz * dz / (f2 * f));
    if (!(bend < 0)) return false;
    const double turn = std::clamp(-slope / bend, -0.3, 0.3);
    const Vector3 turned = radial + turn * tangent;
    m = line.lean * line.along + k / turned.norm() * turned;
    if (std::abs(turn) > 1e-6) continue;
    outward = m;
    return true;
  }
  return false;
}

// Finds the outward direction from a point or its sphere to the nearest point of a rim, or to another point.
bool from_point(const Boundary& point, const Boundary& other, Vector3& outward) {
  Vector3 w = other.origin - point.origin;
  if (other.kind == Boundary::Kind::Rim) {
    const Vector3 across = other.perpendicular(w);
    const double distance = across.norm();
    if (!(distance > 1e-6 * other.radius)) return false;
    w -= other.radius / distance * across;
  }
  const double distance = w.norm();
  if (!(distance > 0)) return false;
  outward = w / distance;
  return true;
}

// The same feature, by numbers that need no core.
Feature without_core(const Shape& shape, const Polytope& core, const Feature& feature) {
  using enum Feature::Kind;
  if (!is_round(shape.kind)) return feature;
  const bool cone = shape.kind == ShapeKind::Cone;
  switch (round_feature(shape, core, feature)) {
    case RoundFeature::UpperRim:
      return {Vertex, 0};
    case RoundFeature::LowerRim:
      return {Vertex, cone ? 0 : Core::sides};
    case RoundFeature::Apex:
      return {Vertex, Core::sides};
    case RoundFeature::Side:
      return {Face, cone ? 1 : 2};
    case RoundFeature::Cap:
      break;
  }
  return feature;
}

constexpr int index_bits = 12;
int packed(const Feature& feature) { return static_cast<int>(feature.kind) << index_bits | feature.index; }
Feature unpacked(int feature) {
  return {static_cast<Feature::Kind>(feature >> index_bits), feature & ((1 << index_bits) - 1)};
}

bool faces_may_be_better(const SolidPair& pair, const Polytope& core, bool second, const LocalAxis& axis,
                         double slack) {
  const double size = pair.size();
  // The other solid's, which is at least as deep in any face as that parts the solids by.
  const Vector3 point =
      second ? Vector3(pair.rotation.transpose() * (axis.on_second - axis.separation * axis.normal - pair.position))
             : axis.on_second;
  const auto may_be_better = [&](const Vector3& normal, double offset) {
    if (normal.dot(point) - offset <= axis.separation + slack) return false;
    const Vector3 outward = second ? Vector3(-(pair.rotation * normal)) : normal;
    return pair.separation_along(outward) > 2 * axis.separation - 0.02 * size;
  };
  const Shape& shape = second ? pair.second : pair.first;
  if (!is_round(shape.kind)) {
    for (int face = 0; face < core.face_count; ++face) {
      if (may_be_better(core.planes[face].normal, core.planes[face].offset)) return true;
    }
    return false;
  }
  const double h = shape.half_height;
  const bool cone = shape.kind == ShapeKind::Cone;
  if (may_be_better(-Vector3::UnitZ(), h) || (!cone && may_be_better(Vector3::UnitZ(), h))) return true;
  if ((second ? axis.second : axis.first).kind == Feature::Kind::Face) return false;
  const double from_axis = length_2d(point.x(), point.y());
  if (!(from_axis > 0)) return true;
  const double up = cone ? shape.radius / length_2d(shape.radius, 2 * h) : 0;
  const double across = std::sqrt(1 - up * up) / from_axis;
  return may_be_better({across * point.x(), across * point.y(), up}, cone ? h * up : shape.radius);
}

}  // namespace

std::uint32_t packed_features(const LocalAxis& axis) {
  return PackedAxis{AxisOf::Features, packed(axis.first), packed(axis.second)}.packed();
}

bool find_on_last_features(const SolidPair& pair, const KnownAxis& known, Core& first, Core& second, LocalAxis& axis) {
  const PackedAxis last = PackedAxis::unpacked(known.features);
  if (!known.exists || last.of != AxisOf::Features) return false;
  if (!is_round(pair.first.kind)) first.build(pair.first);
  if (!is_round(pair.second.kind)) second.build(pair.second);
  axis.normal = known.normal;
  axis.first = unpacked(last.number);
  axis.second = unpacked(last.second_number);
  axis.confirmed = true;
  if (!settle_on_features(pair, first.polytope(), second.polytope(), axis)) return false;
  return !face_may_be_better(pair, first.polytope(), second.polytope(), axis, 1e-9 * pair.size());
}

bool face_may_be_better(const SolidPair& pair, const Polytope& first, const Polytope& second, const LocalAxis& axis,
                        double slack) {
  return axis.separation < 0 &&
         (faces_may_be_better(pair, first, false, axis, slack) || faces_may_be_better(pair, second, true, axis, slack));
}

bool settle_on_features(const SolidPair& pair, const Polytope& first, const Polytope& second, LocalAxis& axis) {
  using enum Boundary::Kind;
  const Boundary a = boundary_at(pair, first, axis.first, false);
  const Boundary b = boundary_at(pair, second, axis.second, true);
  if (a.kind == None || b.kind == None) return false;
  Vector3 normal = axis.normal;
  Vector3 on_second;
  if (a.kind == Line && b.kind == Line) {
    if (!across_lines(a, b, normal, on_second)) return false;
  } else if (a.kind == Line) {
    if (!from_line(a, b, normal)) return false;
    on_second = b.surface_point(-normal);
    if (!is_beside(a.surface_line(normal), on_second)) return false;
  } else if (b.kind == Line) {
    Vector3 outward = -normal;
    if (!from_line(b, a, outward)) return false;
    normal = -outward;
    on_second = a.surface_point(normal);
    if (!is_beside(b.surface_line(outward), on_second)) return false;
  } else if (a.kind == Point) {
    if (!from_point(a, b, normal)) return false;
    on_second = b.surface_point(-normal);
  } else if (b.kind == Point) {
    Vector3 outward = -normal;
    if (!from_point(b, a, outward)) return false;
    normal = -outward;
    on_second = b.surface_point(outward);
  } else {
    return false;
  }
  if (!(normal.dot(axis.normal) > near_enough)) return false;
  // They part the solids by as much as the features only if those are what reaches farthest.
  const double separation = pair.separation_along(normal);
  if (!(std::abs(-b.reach(-normal) - a.reach(normal) - separation) <= same_reach * pair.size())) return false;
  if (a.kind != Line && b.kind == Line) on_second += separation * normal;
  axis.normal = normal;
  axis.separation = separation;
  axis.on_second = on_second;
  axis.first = without_core(pair.first, first, axis.first);
  axis.second = without_core(pair.second, second, axis.second);
  return true;
}

}  // namespace atl::collision
