#include <limits>

#include "placed.h"

namespace atl {
namespace audit {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

void keep_deeper(Penetration& deepest, const Penetration& other) {
  if (other.depth > deepest.depth) deepest = other;
}

struct Pair {
  Penetration operator()(const PlacedSolids& a, const PlacedSolids& b) const {
    Penetration deepest{-infinity, Vector3::UnitZ()};
    for (const Solid& of_a : a) {
      for (const Solid& of_b : b) keep_deeper(deepest, penetration(of_a, of_b));
    }
    return deepest;
  }

  Penetration operator()(const PlacedSolids& a, const PlacedHalfSpace& b) const {
    Penetration deepest{-infinity, -b.normal};
    for (const Solid& solid : a) {
      keep_deeper(deepest, {reach(solid, -b.normal) - (b.normal.dot(solid.centre) - b.offset), -b.normal});
    }
    return deepest;
  }

  Penetration operator()(const PlacedSolids& a, const PlacedSurface& b) const {
    Penetration deepest{-infinity, Vector3::UnitZ()};
    for (const Solid& solid : a) keep_deeper(deepest, penetration(solid, b));
    return deepest;
  }

  /// Only half-spaces that face each other exactly can be parted.
  Penetration operator()(const PlacedHalfSpace& a, const PlacedHalfSpace& b) const {
    return {a.normal == -b.normal ? a.offset + b.offset : infinity, a.normal};
  }

  Penetration operator()(const PlacedSurface& a, const PlacedHalfSpace& b) const {
    Penetration deepest{-infinity, -b.normal};
    for (const Vector3& vertex : vertices_of(a)) {
      keep_deeper(deepest, {b.offset - b.normal.dot(vertex), -b.normal});
    }
    return deepest;
  }

  Penetration operator()(const PlacedSurface& a, const PlacedSurface& b) const { return (*this)(triangles_of(a), b); }

  template <class A, class B>
  Penetration operator()(const A& a, const B& b) const {
    return swapped((*this)(b, a));
  }
};

}  // namespace

Penetration penetration(const Placed& a, const Placed& b) { return std::visit(Pair{}, a, b); }

double overlap(const Placed& a, const Placed& b) { return penetration(a, b).depth; }

}  // namespace audit

double overlap(const PlacedShape& a, const PlacedShape& b) { return audit::overlap(audit::place(a), audit::place(b)); }

}  // namespace atl
