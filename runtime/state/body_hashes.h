#pragma once

#include <atoll/body_hash.h>

#include <cstdint>
#include <vector>

#include "world/stores.h"

namespace atl {

/// By body index; zero where there is none.
std::vector<BodyHash> body_hashes(const Stores& world);
BodyHash body_hash(const Stores& world, std::uint32_t body);

}  // namespace atl
