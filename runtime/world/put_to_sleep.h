#pragma once
/// Bodies that users put to sleep.

#include <cstdint>

#include "world/stores.h"

namespace atl {

/// With its island, as contacts of the last step and joints make it: see World::sleep().
void put_to_sleep(Stores& world, std::uint32_t body);

}  // namespace atl
