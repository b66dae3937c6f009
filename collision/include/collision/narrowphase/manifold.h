#pragma once

#include <collision/shapes/shape.h>

#include <array>
#include <cstdint>
#include <limits>

namespace atl::collision {

/// The pair of features that makes a contact point. Equal features have equal ids from step to step, and the features
/// of one manifold have different ones. See feature_id.h for how they are put together.
using FeatureId = std::uint64_t;

inline constexpr int max_points = 4;

/// The source of a manifold's axis.
enum class Narrowphase {
  ClosedForm,  ///< a formula, or the pair was found apart
  Kept,        ///< the axis of the pair's last manifold, or one beside it
  Fcl,         ///< FCL's answer, of a pair that begins to touch
  Repaired,    ///< ours instead of FCL's answer, which the separation along its axis or a face refutes
};
constexpr bool asks_fcl(Narrowphase by) { return by == Narrowphase::Fcl || by == Narrowphase::Repaired; }

/// Contact points of a pair as the narrowphase finds them. Everything is in the frame of the reference shape:
/// the one whose face (or, where there is none, whose side) the points are measured against.
struct Manifold {
  struct Point {
    Vector3 position;   ///< m, on the incident shape
    double separation;  ///< m, from the reference surface along the normal; negative inside
    FeatureId id;
  };

  bool reference_is_second = false;
  Vector3 normal = Vector3::UnitZ();  ///< unit, out of the reference shape
  bool on_face = false;               ///< it is the normal of a flat face of the reference, and turns with that
  std::uint32_t axis = 0;             ///< the axis the normal was found on; 0: none
  bool known = false;                 ///< on entry to collide(), as the next: see there
  Vector3 middle = Vector3::Zero();   ///< m, of the last manifold's points
  int count = 0;
  std::uint8_t material = 0;  ///< the number of that of a surface's triangles
  double rise = 0;            ///< m, along the normal: see collide_surface()
  double gap = 0;  ///< m, where there are no points: the shapes are at least this far apart, if it is known, else 0
  std::array<Point, max_points> points;

  void add(const Vector3& position, double separation, FeatureId id) {
    points[static_cast<std::size_t>(count++)] = {position, separation, id};
  }
  /// Number of the deepest point, the first of equals.
  int deepest() const {
    const auto separation = [this](int i) { return points[static_cast<std::size_t>(i)].separation; };
    int min = 0;
    for (int i = 1; i < count; ++i) {
      if (separation(i) < separation(min)) min = i;
    }
    return min;
  }
  /// m, of the deepest point; infinite where there are none.
  double min_separation() const {
    return count > 0 ? points[static_cast<std::size_t>(deepest())].separation : std::numeric_limits<double>::infinity();
  }
};

/// Makes of a pair's manifold the one that collide() takes on entry when it looks at the pair again.
Manifold as_last(const Manifold& found);

/// More points than any two faces make; see Outline.
inline constexpr int max_points_to_reduce = 512;

/// Chooses four points that span the contact: the deepest, the one farthest from it, and one on either side
/// of the line between them that adds most area; the first of those that are about as good, so that rounding
/// doesn't choose. `count` may be at most max_points already; then all are kept.
void reduce_points(const Manifold::Point* points, int count, Manifold& manifold);

}  // namespace atl::collision
