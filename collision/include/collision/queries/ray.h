#pragma once

#include <collision/shapes/shape.h>

#include <array>
#include <cstdint>
#include <limits>

namespace atl::collision {

/// The points origin + t * direction, 0 <= t <= max_t.
struct Ray {
  Vector3 origin = Vector3::Zero();                        ///< m
  Vector3 direction = Vector3::UnitZ();                    ///< unit, so t is a distance
  double max_t = std::numeric_limits<double>::infinity();  ///< m, >= 0
};

/// The sides of surfaces (meshes, height fields) at which a ray stops.
enum class Sides : std::uint8_t { Front, Both };

struct RayHit {
  static constexpr std::uint32_t no_triangle = ~0u;

  double t = 0;                          ///< m
  Vector3 normal = Vector3::UnitZ();     ///< unit, of the side that was hit, so never along the ray
  std::uint32_t triangle = no_triangle;  ///< of a surface
  bool started_inside = false;           ///< of a solid: then t = 0 and the normal is -direction
  bool back = false;                     ///< a surface was hit from behind
};

/// Finds the first point where a ray meets a shape; ray and hit are in the shape's frame. False if there is none.
///
/// Solids: a ray that starts in the interior hits at once (see started_inside); one that starts on the surface hits if
/// it goes inwards and misses if it goes outwards. Surfaces have no inside. Closed forms throughout: the line is
/// clipped against the solid's quadrics and planes; triangles are tested so that no ray slips between two that share an
/// edge.
bool cast_ray(const Shape& shape, const Ray& ray, Sides sides, RayHit& hit);

/// The same for a triangle, whose front is where it is counter-clockwise. Sets t, normal and back.
bool cast_ray(const std::array<Vector3, 3>& triangle, const Ray& ray, Sides sides, RayHit& hit);

}  // namespace atl::collision
