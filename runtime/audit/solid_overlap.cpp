#include <cmath>

#include "placed.h"

namespace atl::audit {
namespace {

bool is_point_or_segment(const Polytope& polytope) { return polytope.is_point() || polytope.is_segment(); }

/// A direction in which to separate two cores that touch without defining one: points and segments that coincide.
Vector3 any_normal(const Polytope& a, const Polytope& b) {
  for (const Polytope* core : {&a, &b}) {
    if (core->is_segment()) return any_across(core->vertices[1] - core->vertices[0]);
  }
  return Vector3::UnitZ();
}

/// Two cores of which `a` is a point or a segment: exact apart too.
Penetration rounded(const Polytope& a, const Polytope& b, const Vector3& offset) {
  Penetration axis = penetration(a, b, offset);
  const bool has_axis = std::isfinite(axis.depth);
  if (has_axis && axis.depth > 0) return axis;
  const Vector3 way = shortest_way(a, b, offset);
  const double distance = way.norm();
  if (distance > 0) return {-distance, way / distance};
  return {0, has_axis ? axis.normal : any_normal(a, b)};
}

struct Cores {
  Vector3 offset;  ///< from a's centre to b's
  bool round;      ///< whether one of the two is a sphere or a capsule

  Penetration operator()(const Polytope& a, const Polytope& b) const {
    if (!round) return penetration(a, b, offset);
    if (is_point_or_segment(a)) return rounded(a, b, offset);
    return swapped(rounded(b, a, -offset));
  }
  Penetration operator()(const Polytope& a, const Revolved& b) const {
    if (a.is_point()) {
      const SignedDistance found = signed_distance(b, -offset);
      return {-found.distance, -found.gradient};
    }
    if (a.is_segment()) return segment_revolved(a.vertices[0], a.vertices[1], a, b);
    return penetration(a, b, offset);
  }
  Penetration operator()(const Revolved& a, const Polytope& b) const { return swapped(Cores{-offset, round}(b, a)); }
  Penetration operator()(const Revolved& a, const Revolved& b) const { return penetration(a, b, offset); }

  Penetration operator()(const Smooth& a, const Smooth& b) const { return penetration(a, b, offset); }
  template <class Other>
  Penetration operator()(const Other& a, const Smooth& b) const {
    return penetration(a, b, offset);
  }
  template <class Other>
  Penetration operator()(const Smooth& a, const Other& b) const {
    return swapped(penetration(b, a, -offset));
  }

  /// The signed distance to a convex solid is convex along a segment, so its derivative's zero is found by bisection.
  Penetration segment_revolved(const Vector3& begin, const Vector3& end, const Polytope& a, const Revolved& b) const {
    double low = 0;
    double high = 1;
    SignedDistance found = {};
    for (int i = 0; i < 60; ++i) {
      const double t = (low + high) / 2;
      found = signed_distance(b, begin + t * (end - begin) - offset);
      if (found.distance <= 0) return penetration(a, b, offset);
      (found.gradient.dot(end - begin) > 0 ? high : low) = t;
    }
    return {-found.distance, -found.gradient};
  }
};

}  // namespace

Penetration penetration(const Solid& a, const Solid& b) {
  const double rounding = a.rounding + b.rounding;
  const Penetration cores = std::visit(Cores{b.centre - a.centre, rounding > 0}, a.core, b.core);
  return {cores.depth + rounding, cores.normal};
}

}  // namespace atl::audit
