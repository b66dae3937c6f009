#pragma once

#include <atoll/types.h>

#include <cstdint>
#include <map>

#include "view/film_shapes.h"
#include "view/triangles.h"

namespace atl {
class World;
}

namespace atl::view {

/// The surfaces of a run's bodies for other programs, each shape's once. A body has the one it came with all along.
class Surfaces {
 public:
  static constexpr int around = 16;  ///< sides of round shapes

  /// The number of a body's surface. Not all numbers are those of surfaces.
  std::uint32_t number_of(const World& world, BodyId id);
  const Triangles& operator[](std::uint32_t number) const { return surfaces_.at(number); }

 private:
  FilmShapes shapes_;
  std::map<BodyId, std::uint32_t> of_body_;
  std::map<std::uint32_t, Triangles> surfaces_;  // by number of shape
};

}  // namespace atl::view
