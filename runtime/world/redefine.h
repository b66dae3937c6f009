#pragma once
/// A body that becomes another kind of body, under the same id.

#include <atoll/body.h>

#include <cstdint>
#include <span>

#include "world/body_definition.h"
#include "world/stores.h"

namespace atl {

/// Constants of a body that follows the definition. Throws Error if that is unusable, or if joints of the body forbid
/// it.
BodyConstants redefined(const Stores& world, std::uint32_t body, const BodyDef& def);
/// Gives a body these constants, and all stores what follows from them. Its frame moves on as it did. What touches it
/// is found anew if its type, shapes, centre of mass or what it collides with changed.
void redefine(Stores& world, std::uint32_t body, const BodyConstants& constants);

/// The samples of a height field that are given other heights, but for how many rows there are.
struct Samples {
  std::uint32_t column, row, columns;
};
/// Does World::set_heights(), and throws what it throws.
void change_heights(Stores& world, std::uint32_t body, const Samples& samples, std::span<const double> heights);

}  // namespace atl
