#pragma once

#include "world/stores.h"

namespace atl {

/// Stops the program where a world's stores contradict themselves or each other: see jobs/assert.h. Looks at all that is
/// alive, so its cost is linear in the world. Steps of builds with ATOLL_ASSERTS end with it.
void validate(const Stores& world);

}  // namespace atl
