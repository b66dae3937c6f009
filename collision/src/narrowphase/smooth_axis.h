#pragma once

#include "narrowphase/convex_axis.h"

namespace atl::collision {

/// Does what find_axis() does for a pair in which one is an ellipsoid or a tapered capsule. Such a shape is a core and
/// a radius (convex_core.h), so GJK finds the axis as long as the cores are apart. Where they overlap, the second is
/// moved out along the last axis, or FCL's, until it just touches; the axis there is a better one, and so on until it
/// stays. An axis that is off by an angle is so by that times depth / (depth + R) in the next round, with R the sum of
/// the radii of curvature less the depth, positive at a local maximum of the separation.
AxisSearch find_smooth_axis(const SolidPair& pair, double margin, const KnownAxis& known, Core& first, Core& second);

}  // namespace atl::collision
