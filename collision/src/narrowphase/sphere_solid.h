#pragma once

#include <collision/narrowphase/manifold.h>
#include <collision/shapes/pose.h>

namespace atl::collision {

/// A sphere, the first shape, against any solid. Exact, whether the centre is outside or inside.
void collide_sphere_solid(double radius, const Shape& solid, const Pose& second, double margin, Manifold& manifold);

}  // namespace atl::collision
