#include <limits>

#include "curve.h"
#include "placed.h"
#include "rim_search.h"

// The least translation that parts two overlapping solids is the distance from the origin to the boundary of their
// Minkowski difference, from inside. It is reached where that boundary is smooth, never on a crease, so the normal is
// one of these directions, each searched for what it can be:
//   - a face normal of either solid, caps and the base included;
//   - on the arc of an edge or the circle of a side, against whatever of the other solid: a search along the curve,
//     in pieces between which the function may bend sharply (an edge on a side line is such a bend);
//   - anywhere on the sphere where a rim rolls over a rim: a search from many starts.
// Every value is that of a real direction, so the result can only be too large: by less than 1e-10 of the size where
// the search finds the right minimum.

namespace atl::audit {
namespace {

double size_of(const Revolved& solid) { return std::hypot(solid.radius, solid.half_height); }
double size_of(const Polytope& polytope) {
  double square = 0;
  for (const Vector3& vertex : polytope.vertices) square = std::max(square, vertex.squaredNorm());
  return std::sqrt(square);
}

template <class A, class B>
class Search {
 public:
  Search(const A& a, const B& b, const Vector3& offset)
      : a_(a), b_(b), offset_(offset), bend_(size_of(a) + size_of(b) + offset.norm()) {}

  double overlap(const Vector3& normal) const { return reach(a_, normal) + reach(b_, -normal) - normal.dot(offset_); }

  void offer(const Vector3& normal) {
    const double depth = overlap(normal);
    if (depth < min_.depth) min_ = {depth, normal};
  }

  /// `sign` is 1 for directions out of a, -1 out of b.
  void offer_faces(const Polytope& polytope, double sign) {
    for (const Vector3& normal : polytope.normals) offer(sign * normal);
  }
  void offer_faces(const Revolved& solid, double sign) {
    offer(-sign * solid.axis);
    if (!solid.is_cone) offer(sign * solid.axis);
  }

  void search_edges(const Polytope& polytope, double sign) {
    for (const Polytope::Edge& edge : polytope.edges) {
      const Curve curve{Vector3::Zero(), sign * edge.from, sign * edge.toward, edge.angle};
      // On its arc the edge reaches as far as its tail does.
      const auto value = [&](double t) {
        const Vector3 normal = curve.at(t);
        const double own = sign * normal.dot(edge.tail);
        return own + (sign > 0 ? reach(b_, -normal) : reach(a_, normal)) - normal.dot(offset_);
      };
      search(curve, value);
    }
  }

  void search_side(const Revolved& solid, double sign) {
    int smallest = 0;
    solid.axis.cwiseAbs().minCoeff(&smallest);
    const Vector3 x = solid.axis.cross(Vector3::Unit(smallest)).normalized();
    const double radial = solid.side_cosine();
    const Curve curve{sign * solid.side_sine() * solid.axis, radial * x, radial * solid.axis.cross(x),
                      2 * std::numbers::pi};
    search(curve, [&](double t) { return overlap(curve.at(t)); });
  }

  const Penetration& min() const { return min_; }

 private:
  template <class Value>
  void search(const Curve& curve, const Value& value) {
    Breaks breaks(curve.angle);
    add_breaks(breaks, a_, 1, curve);
    add_breaks(breaks, b_, -1, curve);
    minimise_along(
        breaks, bend_, value, [&] { return min_.depth; }, [&](double t) { offer(curve.at(t).normalized()); });
  }
  static void add_breaks(Breaks& breaks, const Revolved& solid, double sign, const Curve& curve) {
    breaks.add_all(solid, sign, curve);
  }
  static void add_breaks(Breaks&, const Polytope&, double, const Curve&) {}

  const A& a_;
  const B& b_;
  Vector3 offset_;
  double bend_;
  Penetration min_{std::numeric_limits<double>::infinity(), Vector3::UnitZ()};
};

}  // namespace

Penetration penetration(const Polytope& a, const Revolved& b, const Vector3& offset) {
  Search search(a, b, offset);
  search.offer_faces(a, 1);
  search.offer_faces(b, -1);
  search.search_edges(a, 1);
  search.search_side(b, -1);
  return search.min();
}

Penetration penetration(const Revolved& a, const Revolved& b, const Vector3& offset) {
  Search search(a, b, offset);
  search.offer_faces(a, 1);
  search.offer_faces(b, -1);
  search.search_side(a, 1);
  search.search_side(b, -1);
  search_rims(a, b, offset, search.min(), [&](const Vector3& normal) { search.offer(normal); });
  return search.min();
}

}  // namespace atl::audit
