#include <collision/shapes/hull.h>
#include <jobs/assert.h>

#include <algorithm>
#include <array>
#include <limits>
#include <tuple>

#include "shapes/hull_build.h"

namespace atl::collision {
namespace {

using Index = std::uint16_t;
constexpr std::uint32_t unused = std::numeric_limits<std::uint32_t>::max();
constexpr Index no_index = std::numeric_limits<Index>::max();

std::vector<std::uint32_t> faces_at_corners(const ConvexFacets& facets) {
  std::vector<std::uint32_t> count;
  for (const std::uint32_t corner : facets.corners) {
    if (corner >= count.size()) count.resize(corner + 1);
    ++count[corner];
  }
  return count;
}

// Faces of vertex numbers, each from its smallest on, in lexicographic order: whatever order they were found in.
std::vector<std::vector<Index>> canonical_faces(const ConvexFacets& facets, const std::vector<std::uint32_t>& number) {
  std::vector<std::vector<Index>> faces;
  for (std::size_t f = 0; f < facets.size(); ++f) {
    std::vector<Index> face;
    for (const std::uint32_t corner : facets.face(f)) face.push_back(static_cast<Index>(number[corner]));
    std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
    faces.push_back(std::move(face));
  }
  std::sort(faces.begin(), faces.end());
  return faces;
}

// Normal by Newell's method about the face's first corner, through the mean of the corners: where they are not
// quite in one plane, that is the middle between them.
Hull::Plane plane_of(const Hull& hull, const std::vector<Index>& face) {
  ATL_ASSERT(face.size() >= 3, face.size());
  const Vector3& origin = hull.vertices[face[0]];
  Vector3 normal = Vector3::Zero();
  double reach = 0;
  for (std::size_t i = 1; i + 1 < face.size(); ++i) {
    normal += (hull.vertices[face[i]] - origin).cross(hull.vertices[face[i + 1]] - origin);
  }
  normal.stableNormalize();
  for (const Index vertex : face) reach += normal.dot(hull.vertices[vertex]);
  return {normal, reach / static_cast<double>(face.size())};
}

// Adds a face's edges. False where a side has more than two faces or two that run along it the same way.
bool add_edges(const std::vector<Index>& face, Index number, std::vector<Index>& between, Hull& hull) {
  const std::size_t vertices = hull.vertices.size();
  for (std::size_t i = 0; i < face.size(); ++i) {
    const Index tail = face[i];
    const Index head = face[(i + 1) % face.size()];
    if (between[tail * vertices + head] != no_index) return false;
    const Index known = between[head * vertices + tail];
    const Index edge = known != no_index ? known : static_cast<Index>(hull.edges.size());
    if (known != no_index) {
      ATL_ASSERT(hull.edges[known].right == no_index, known, hull.edges[known].right, number);
      hull.edges[known].right = number;
    } else {
      hull.edges.push_back({tail, head, number, no_index});
    }
    between[tail * vertices + head] = edge;
    hull.face_edges.push_back(edge);
  }
  return true;
}

// The edge after `edge`, counter-clockwise seen from outside, around one of its ends: the face on the left of
// the way out of the vertex lies between the two.
Index next_around(const Hull& hull, Index edge, Index vertex) {
  const Index face = hull.edges[edge].tail == vertex ? hull.edges[edge].left : hull.edges[edge].right;
  const std::size_t begin = hull.face_start[face];
  const std::size_t end = hull.face_start[face + 1u];
  for (std::size_t i = begin; i < end; ++i) {
    if (hull.face_vertices[i] == vertex) return hull.face_edges[i == begin ? end - 1 : i - 1];
  }
  return edge;
}

// False where the edges at a vertex are not a single cycle.
bool link_vertices(Hull& hull) {
  std::vector<Index> first(hull.vertices.size(), no_index);
  std::vector<std::size_t> degree(hull.vertices.size(), 0);
  for (std::size_t e = 0; e < hull.edges.size(); ++e) {
    for (const Index end : {hull.edges[e].tail, hull.edges[e].head}) {
      if (first[end] == no_index) first[end] = static_cast<Index>(e);
      ++degree[end];
    }
  }
  hull.vertex_start = {0};
  for (std::size_t v = 0; v < hull.vertices.size(); ++v) {
    if (degree[v] < 3) return false;
    Index edge = first[v];
    for (std::size_t i = 0; i < degree[v]; ++i) {
      if (i > 0 && edge == first[v]) return false;
      hull.vertex_edges.push_back(edge);
      edge = next_around(hull, edge, static_cast<Index>(v));
    }
    if (edge != first[v]) return false;
    hull.vertex_start.push_back(static_cast<Index>(hull.vertex_edges.size()));
  }
  return true;
}

void find_bounds(Hull& hull) {
  hull.lower = hull.upper = hull.vertices[0];
  double square = 0;
  for (const Vector3& vertex : hull.vertices) {
    hull.lower = hull.lower.cwiseMin(vertex);
    hull.upper = hull.upper.cwiseMax(vertex);
    square = std::max(square, vertex.squaredNorm());
  }
  hull.bounding_radius = std::sqrt(square);
}

void measure(Hull& hull) {
  hull.mass = polyhedron_mass(hull);
  find_bounds(hull);
  hull.inner_radius = std::numeric_limits<double>::infinity();
  for (const Hull::Plane& plane : hull.planes) {
    hull.inner_radius = std::min(hull.inner_radius, plane.offset - plane.normal.dot(hull.mass.centre));
  }
  hull.prepare();
}

Hull centred_at(const Vector3& centre, const Hull& hull) {
  Hull result = hull;
  for (Vector3& vertex : result.vertices) vertex -= centre;
  for (Hull::Plane& plane : result.planes) plane.offset -= plane.normal.dot(centre);
  result.mass.centre.setZero();
  find_bounds(result);
  result.find_columns();
  return result;
}

}  // namespace

void Hull::prepare() {
  find_columns();
  centred = mass.centre.isZero(0) ? nullptr : std::make_shared<const Hull>(centred_at(mass.centre, *this));
}

PlacedShape centred(const Shape& shape, const Pose& pose) {
  const Hull* hull = shape.kind == ShapeKind::Hull ? shape.hull : nullptr;
  if (hull == nullptr || !hull->centred) return {shape, pose};
  return {Shape::convex_hull(*hull->centred), placed(pose, {hull->mass.centre, Quaternion::Identity()})};
}

bool assemble(std::span<const Vector3> points, const ConvexFacets& facets, Hull& hull) {
  hull = Hull{};
  const std::vector<std::uint32_t> count = faces_at_corners(facets);
  std::vector<std::uint32_t> number(count.size(), unused);
  for (std::size_t i = 0; i < count.size(); ++i) {
    if (count[i] == 0) continue;
    number[i] = static_cast<std::uint32_t>(hull.vertices.size());
    hull.vertices.push_back(points[i]);
  }
  const std::size_t vertices = hull.vertices.size();
  if (vertices < 4 || vertices > Hull::max_vertices || facets.size() < 4) return false;

  std::vector<Index> between(vertices * vertices, no_index);
  hull.face_start = {0};
  for (const std::vector<Index>& face : canonical_faces(facets, number)) {
    if (!add_edges(face, static_cast<Index>(hull.planes.size()), between, hull)) return false;
    hull.planes.push_back(plane_of(hull, face));
    hull.face_vertices.insert(hull.face_vertices.end(), face.begin(), face.end());
    hull.face_start.push_back(static_cast<Index>(hull.face_vertices.size()));
  }
  for (const Hull::Edge& edge : hull.edges) {
    if (edge.right == no_index) return false;
  }
  if (vertices + hull.face_count() != hull.edges.size() + 2 || !link_vertices(hull)) return false;
  ATL_ASSERT(hull.face_vertices.size() == hull.face_edges.size(), hull.face_vertices.size(), hull.face_edges.size());
  ATL_ASSERT(hull.face_edges.size() == 2 * hull.edges.size(), hull.face_edges.size(), hull.edges.size());
  ATL_ASSERT(hull.vertex_edges.size() == 2 * hull.edges.size(), hull.vertex_edges.size(), hull.edges.size());
  ATL_ASSERT(hull.vertex_start.size() == vertices + 1, hull.vertex_start.size(), vertices);
  measure(hull);
  return hull.mass.volume > 0 && hull.inner_radius > 0;
}

bool is_made_of_its_faces(const Hull& hull) {
  ConvexFacets facets;
  for (std::size_t f = 0; f < hull.face_count(); ++f) {
    const std::vector<std::uint32_t> face(hull.face_vertices.begin() + hull.face_start[f],
                                          hull.face_vertices.begin() + hull.face_start[f + 1]);
    if (face.size() < 3) return false;
    facets.add(face);
  }
  Hull made;
  if (!assemble(hull.vertices, facets, made)) return false;
  const auto same_plane = [](const Hull::Plane& a, const Hull::Plane& b) {
    return a.normal == b.normal && a.offset == b.offset;
  };
  const auto same_edge = [](const Hull::Edge& a, const Hull::Edge& b) {
    return std::tie(a.tail, a.head, a.left, a.right) == std::tie(b.tail, b.head, b.left, b.right);
  };
  return made.vertices == hull.vertices && std::ranges::equal(made.planes, hull.planes, same_plane) &&
         std::ranges::equal(made.edges, hull.edges, same_edge) && made.face_start == hull.face_start &&
         made.face_vertices == hull.face_vertices && made.face_edges == hull.face_edges &&
         made.vertex_start == hull.vertex_start && made.vertex_edges == hull.vertex_edges &&
         made.mass.volume == hull.mass.volume && made.mass.centre == hull.mass.centre &&
         made.mass.unit_inertia == hull.mass.unit_inertia && made.bounding_radius == hull.bounding_radius &&
         made.inner_radius == hull.inner_radius && made.lower == hull.lower && made.upper == hull.upper;
}

double largest_excess(const Hull& hull, std::span<const Vector3> points) {
  double largest = 0;
  for (const Vector3& point : points) {
    for (const Hull::Plane& plane : hull.planes) largest = std::max(largest, plane.normal.dot(point) - plane.offset);
  }
  return largest;
}

double largest_dent(const Hull& hull) {
  double largest = 0;
  for (std::size_t f = 0; f < hull.face_count(); ++f) {
    const std::size_t begin = hull.face_start[f];
    const auto face = std::span(hull.face_vertices).subspan(begin, hull.face_start[f + 1] - begin);
    for (std::size_t i = 0; i < face.size(); ++i) {
      const Vector3& tail = hull.vertices[face[i]];
      const Vector3& head = hull.vertices[face[(i + 1) % face.size()]];
      const Vector3 out = (head - tail).cross(hull.planes[f].normal).normalized();
      for (const Index vertex : face) largest = std::max(largest, out.dot(hull.vertices[vertex] - tail));
    }
  }
  return largest;
}

Hull box_hull(const Vector3& half_extents) {
  std::array<Vector3, 8> corners;
  for (std::size_t i = 0; i < 8; ++i) {
    for (int axis = 0; axis < 3; ++axis)
      corners[i][axis] = (i >> axis & 1) != 0 ? -half_extents[axis] : half_extents[axis];
  }
  constexpr std::array<std::array<std::uint32_t, 4>, 6> faces = {
      {{0, 2, 6, 4}, {1, 5, 7, 3}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 6, 7, 5}}};
  ConvexFacets facets;
  for (const auto& face : faces) facets.add(face);
  Hull hull;
  [[maybe_unused]] const bool closed = assemble(corners, facets, hull);
  ATL_ASSERT(closed, half_extents.x(), half_extents.y(), half_extents.z());
  return hull;
}

// Sum over tetrahedra from an inner point to the triangles of each face's fan. A tetrahedron with one corner at
// the origin has the second moments V / 20 * (sum of p p^T over its corners + s s^T), s the sum of its corners
// (Tonon, "Explicit exact formulas for the 3-D tetrahedron inertia tensor", J. Math. Stat. 1 (2004); the same
// as Mirtich's face integrals, J. Graphics Tools 1 (1996), without the choice of a projection).
MassProperties polyhedron_mass(const Hull& hull) {
  Vector3 inner = Vector3::Zero();
  for (const Vector3& vertex : hull.vertices) inner += vertex;
  inner /= static_cast<double>(hull.vertices.size());

  double volume = 0;
  Vector3 first = Vector3::Zero();
  Matrix3 second = Matrix3::Zero();
  for (std::size_t f = 0; f < hull.face_count(); ++f) {
    const Vector3 a = hull.vertices[hull.face_vertices[hull.face_start[f]]] - inner;
    for (std::size_t i = hull.face_start[f] + 1u; i + 1 < hull.face_start[f + 1]; ++i) {
      const Vector3 b = hull.vertices[hull.face_vertices[i]] - inner;
      const Vector3 c = hull.vertices[hull.face_vertices[i + 1]] - inner;
      const double part = a.dot(b.cross(c)) / 6;
      const Vector3 sum = a + b + c;
      volume += part;
      first += part / 4 * sum;
      second += part / 20 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
    }
  }
  const Vector3 centre = first / volume;
  const Matrix3 covariance = second / volume - centre * centre.transpose();
  return {volume, inner + centre, covariance.trace() * Matrix3::Identity() - covariance};
}

}  // namespace atl::collision
