#pragma once

#include <atoll/shapes.h>

#include <array>
#include <cstdint>
#include <vector>

namespace atl::view {

/// A shape's surface for drawing, in its body's frame, m: triangles counter-clockwise seen from outside. Vertices at an
/// edge are shared, but for those of compounds' children.
struct Triangles {
  std::vector<Vector3> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;

  void add(const Triangles& other, const Pose& at);
};

/// Round shapes become polyhedra with `around` sides, >= 3. A half-space becomes a square of 200 m about the point of
/// its plane that is nearest to the origin.
Triangles triangles_of(const Shape& shape, int around = 24);

}  // namespace atl::view
