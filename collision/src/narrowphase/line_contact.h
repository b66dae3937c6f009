#pragma once

#include <collision/narrowphase/manifold.h>

#include <cmath>

#include "narrowphase/convex_axis.h"

namespace atl::collision {

/// A straight piece of a shape's surface, and its place in feature_pair_id().
struct SurfaceLine {
  Vector3 tail, head;  ///< m, frame of the first shape
  int kind;
  int number;
  double width = INFINITY;  ///< m, how far beside the line the surface still counts as level
};

/// Two lines that run within 3 degrees of parallel touch along what they have in common: its ends become points
/// of the manifold, whose reference is the first shape,
/// cut off where they run out of the first line's width. False, and no points, if they don't, or if that isn't
/// within the margin.
bool line_points(const SurfaceLine& first, const SurfaceLine& second, const Vector3& normal, double margin,
                 Manifold& manifold);

/// The closest pieces of two segments' surfaces, exactly.
void collide_capsules(const Shape& first, const Shape& second, const Pose& pose, double margin, Manifold& manifold);

}  // namespace atl::collision
