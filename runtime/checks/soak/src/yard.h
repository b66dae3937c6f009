#pragma once

#include <atoll/body.h>

#include <vector>

#include "things.h"

namespace atl::soak {

/// The permanent bodies of the yard: hills as a height field in the west and as a mesh in the east, walls around, a
/// belt, and a sensor over all of it.
std::vector<BodyDef> yard(Random& random);

/// The places where things are dropped, high enough that nothing lies there for long.
Vector3 place_above(std::size_t number);
inline constexpr std::size_t place_count = 49;

/// m: what is below has fallen through the ground.
inline constexpr double below_ground = -3;

}  // namespace atl::soak
