#pragma once

#include <collision/shapes/hull.h>

#include "shapes/convex_facets.h"

namespace atl::collision {

/// Makes a hull of a cloud's faces: vertices in order of the cloud, planes, edges and adjacency, mass and
/// extents. False where the faces are not the closed surface of a polytope, or too many.
bool assemble(std::span<const Vector3> points, const ConvexFacets& facets, Hull& hull);

/// Largest distance (m) of a point outside a hull; 0 if all are inside.
double largest_excess(const Hull& hull, std::span<const Vector3> points);

/// Largest distance (m) of a face's corner outside a side of the face; 0 if all faces are convex polygons.
double largest_dent(const Hull& hull);

/// Mass properties of the polyhedron of the hull's vertices and faces.
MassProperties polyhedron_mass(const Hull& hull);

/// At most Hull::max_vertices of the points (of extent 1), in order, whose hull is close to that of all.
std::vector<std::size_t> choose_extreme_points(std::span<const Vector3> points);

}  // namespace atl::collision
