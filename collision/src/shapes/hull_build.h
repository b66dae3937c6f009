#pragma once

#include <collision/shapes/hull.h>

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

/// Makes a hull of a cloud's faces: vertices in order of the cloud, planes, edges and adjacency, mass and
/// extents. False where the faces are not the closed surface of a polytope, or too many.
bool assemble(std::span<const Vector3> points, const ConvexFacets& facets, Hull& hull);

/// Largest distance (m) of a point outside a hull; 0 if all are inside.
double largest_excess(const Hull& hull, std::span<const Vector3> points);

/// Largest distance (m) of a face's corner outside a side of the face; 0 if all faces are convex polygons.
double largest_dent(const Hull& hull);

/// Mass properties of the polyhedron of the hull's vertices and faces.
MassProperties polyhedron_mass(const Hull& hull);

/// Chooses at most Hull::max_vertices of the points (of extent 1), in order, whose hull is close to that of all.
std::vector<std::size_t> choose_extreme_points(std::span<const Vector3> points);

}  // namespace atl::collision
