#include <algorithm>
#include <cmath>

#include "placed.h"

namespace atl::audit {
namespace {

/// Edges closer to parallel than this span no plane of their own: the axis adds at most this share of the boxes'
/// size to what the face axes already say.
constexpr double parallel_sine = 1e-12;

/// Half the length of a box's shadow on a unit axis; both in the box's frame.
double shadow(const Vector3& half_extents, const Vector3& axis) { return half_extents.dot(axis.cwiseAbs()); }

}  // namespace

// The Minkowski difference of two boxes is bounded by planes whose normals are the face normals of either box and the
// cross products of their edges, so the least overlap over these 15 axes is the least translation that parts them.
// Each axis is a unit vector that is projected on afresh: a cross product of nearly parallel edges may point a little
// aside, but its overlap is still one of a translation that parts the boxes, so it can never report too little.
double box_overlap(const PlacedBox& a, const PlacedBox& b) {
  // All in a's frame, where a's axes are the unit vectors and b's are the columns of r.
  const Matrix3 r = a.axes.transpose() * b.axes;
  const Vector3 d = a.axes.transpose() * (b.centre - a.centre);

  const Vector3 on_a = a.half_extents + r.cwiseAbs() * b.half_extents - d.cwiseAbs();
  const Vector3 on_b = b.half_extents + r.cwiseAbs().transpose() * a.half_extents - (r.transpose() * d).cwiseAbs();
  double least = std::min(on_a.minCoeff(), on_b.minCoeff());

  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const Vector3 cross = Vector3::Unit(i).cross(r.col(j));
      const double sine = cross.norm();
      if (sine < parallel_sine) continue;
      const Vector3 axis = cross / sine;
      const double overlap =
          shadow(a.half_extents, axis) + shadow(b.half_extents, r.transpose() * axis) - std::abs(d.dot(axis));
      least = std::min(least, overlap);
    }
  }
  return least;
}

}  // namespace atl::audit
