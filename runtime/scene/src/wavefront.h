#pragma once

#include <atoll/types.h>

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace atl::scene {

/// The geometry of a Wavefront OBJ file.
struct Wavefront {
  std::vector<Vector3> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// Reads the vertices (v) and faces (f) of an OBJ file; polygons are cut into the triangles of a fan around their
/// first corner, and all other lines are passed over. Throws SceneError with `origin` and line.
Wavefront parse_wavefront(std::string_view text, const std::string& origin);

}  // namespace atl::scene
