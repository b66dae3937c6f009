#pragma once

#include <collision/shapes/shape.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace atl::collision {

/// Faces of a convex hull, counter-clockwise seen from outside: face f has the points
/// corners[start[f] .. start[f + 1]), by their index in the cloud.
struct ConvexFacets {
  std::vector<std::uint32_t> start = {0};
  std::vector<std::uint32_t> corners;

  std::size_t size() const { return start.size() - 1; }
  std::span<const std::uint32_t> face(std::size_t index) const {
    return std::span(corners).subspan(start[index], start[index + 1] - start[index]);
  }
  void add(std::span<const std::uint32_t> face_corners) {
    corners.insert(corners.end(), face_corners.begin(), face_corners.end());
    start.push_back(static_cast<std::uint32_t>(corners.size()));
  }
};

/// The faces that qhull finds for a cloud of at least 4 points of extent about 1, with neighbours merged where
/// the centre of one lies within `tolerance` of the plane of the other. Returns qhull's message where it gives
/// up, else nothing.
std::string find_facets(std::span<const Vector3> points, double tolerance, ConvexFacets& facets);

}  // namespace atl::collision
