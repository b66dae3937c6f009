#pragma once

#include <functional>

#include "placed.h"

namespace atl::audit {

/// Hands to `offer` the unit directions out of `a` at which the overlap of two solids of revolution may have a local
/// minimum with a rim of each in support: Newton's method on the sphere from every local minimum of a fixed grid that
/// may lead below `min`, and from `min` itself.
void search_rims(const Revolved& a, const Revolved& b, const Vector3& offset, const Penetration& min,
                 const std::function<void(const Vector3&)>& offer);

}  // namespace atl::audit
