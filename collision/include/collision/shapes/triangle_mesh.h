#pragma once

#include <collision/shapes/triangle.h>
#include <collision/shapes/triangle_tree.h>

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace atl::collision {

/// A surface of triangles, made once and never changed.
struct TriangleMesh {
  std::vector<Vector3> vertices;                         ///< m
  std::vector<std::array<std::uint32_t, 3>> triangles;   ///< vertices, counter-clockwise seen from the front
  std::vector<Vector3> normals;                          ///< unit, by triangle
  std::vector<std::array<std::uint32_t, 3>> neighbours;  ///< triangle beyond edge i -> i + 1; no_triangle
  std::vector<std::uint8_t> convex_edges;                ///< bits, by triangle; see Triangle
  double smooth_angle = 0;                               ///< rad: edges that bend by less are none
  std::vector<std::array<Vector3, 3>> corner_normals;    ///< by triangle; empty where the angle is 0
  std::vector<std::uint8_t> materials;                   ///< numbers, by triangle; empty: all 0
  TriangleTree tree;
  Vector3 lower = Vector3::Zero();  ///< m, bounds
  Vector3 upper = Vector3::Zero();
  double bounding_radius = 0;  ///< m, about the origin
  bool closed = false;         ///< every edge has two triangles
  std::uint64_t content = 0;   ///< hash of vertices, triangles, the angle and materials

  static constexpr std::uint32_t no_triangle = ~0u;

  std::uint8_t material(std::uint32_t index) const { return materials.empty() ? std::uint8_t{0} : materials[index]; }
  Triangle triangle(std::uint32_t index) const;
  /// The same in two steps: vertices and normal, which tell of most triangles that nothing comes near them; the rest.
  Triangle face(std::uint32_t index) const;
  void complete(std::uint32_t index, Triangle& face) const;
};

/// Error text where there is no surface: no triangle, a vertex that isn't finite (or beyond 1e30 m), an index
/// out of range, a triangle without area (named), or an edge that more than two triangles share or that two run
/// along in the same direction. Triangles are neighbours where they share two vertices by index and, beyond
/// that, where the edges of just two coincide exactly, as in files that repeat vertices. Nor is there one of an angle
/// that isn't in [0, pi), or of materials for another number of triangles, unless there are none.
///
/// With a smooth angle the surface has normals at the triangles' corners: the mean of the triangles around, as far as
/// edges that bend by less lead, with the weights that are exact on a sphere (Max, "Weights for computing vertex
/// normals from facet normals", J. Graphics Tools 4, 1999).
std::variant<TriangleMesh, std::string> build_triangle_mesh(std::span<const Vector3> vertices,
                                                            std::span<const std::array<std::uint32_t, 3>> triangles,
                                                            double smooth_angle = 0,
                                                            std::vector<std::uint8_t> materials = {});

}  // namespace atl::collision
