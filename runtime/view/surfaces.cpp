#include "view/surfaces.h"

#include <atoll/world.h>

namespace atl::view {

std::uint32_t Surfaces::number_of(const World& world, BodyId id) {
  const auto known = of_body_.find(id);
  if (known != of_body_.end()) return known->second;
  const Shape shape = world.definition(id).shape;
  const std::uint32_t number = shapes_.number_of(shape);
  if (!surfaces_.contains(number)) surfaces_.emplace(number, triangles_of(shape, around));
  return of_body_[id] = number;
}

}  // namespace atl::view
