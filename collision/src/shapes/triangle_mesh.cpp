#include <collision/shapes/triangle_mesh.h>
#include <jobs/assert.h>
#include <jobs/hash.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "shapes/text.h"

namespace atl::collision {
namespace {

using Indices = std::array<std::uint32_t, 3>;

constexpr double largest_coordinate = 1e30;
// A triangle lower than this part of its longest edge has a normal that rounding decides.
constexpr double min_height = 1e-10;

// One side of a triangle, with its ends in increasing order.
struct OpenSide {
  std::uint32_t low, high;
  bool reversed;  // runs from high to low
  std::uint32_t triangle;
  std::uint32_t edge;
};

bool same_ends(const OpenSide& a, const OpenSide& b) { return a.low == b.low && a.high == b.high; }

Vector3 edge_of(const TriangleMesh& mesh, std::uint32_t triangle, std::uint32_t edge) {
  const Indices& corners = mesh.triangles[triangle];
  return mesh.vertices[corners[(edge + 1) % 3]] - mesh.vertices[corners[edge]];
}

std::string check_vertices(std::span<const Vector3> vertices) {
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Vector3& v = vertices[i];
    if (!v.allFinite() || v.cwiseAbs().maxCoeff() > largest_coordinate) {
      return text("found vertex ", i, " at (", v.x(), ", ", v.y(), ", ", v.z(),
                  "), expected finite coordinates up to 1e30 m");
    }
  }
  return {};
}

std::string find_normals(TriangleMesh& mesh) {
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Indices& corners = mesh.triangles[t];
    for (const std::uint32_t corner : corners) {
      if (corner >= mesh.vertices.size()) {
        return text("found vertex ", corner, " in triangle ", t, ", expected a number below ", mesh.vertices.size());
      }
    }
    const Vector3 first = mesh.vertices[corners[1]] - mesh.vertices[corners[0]];
    const Vector3 last = mesh.vertices[corners[2]] - mesh.vertices[corners[0]];
    const Vector3 doubled_area = first.cross(last);
    const double longest = std::max({first.squaredNorm(), last.squaredNorm(), (last - first).squaredNorm()});
    if (!(doubled_area.norm() > min_height * longest)) {
      return text("found no area in triangle ", t, " (vertices ", corners[0], ", ", corners[1], ", ", corners[2],
                  "), expected a height above 1e-10 of its longest edge");
    }
    mesh.normals.push_back(doubled_area.stableNormalized());
  }
  return {};
}

// The sides of all triangles that have no neighbour yet, with the ends numbered by `number`, neighbours next to
// each other.
std::vector<OpenSide> open_sides(const TriangleMesh& mesh, const std::vector<std::uint32_t>& number) {
  std::vector<OpenSide> sides;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::uint32_t e = 0; e < 3; ++e) {
      if (mesh.neighbours[t][e] != TriangleMesh::no_triangle) continue;
      const std::uint32_t tail = number[mesh.triangles[t][e]];
      const std::uint32_t head = number[mesh.triangles[t][(e + 1) % 3]];
      sides.push_back({std::min(tail, head), std::max(tail, head), tail > head, t, e});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const OpenSide& a, const OpenSide& b) {
    if (!same_ends(a, b)) return a.low != b.low ? a.low < b.low : a.high < b.high;
    return a.triangle != b.triangle ? a.triangle < b.triangle : a.edge < b.edge;
  });
  return sides;
}

void join(TriangleMesh& mesh, const OpenSide& a, const OpenSide& b) {
  ATL_ASSERT(mesh.neighbours[a.triangle][a.edge] == TriangleMesh::no_triangle, a.triangle, a.edge);
  ATL_ASSERT(mesh.neighbours[b.triangle][b.edge] == TriangleMesh::no_triangle, b.triangle, b.edge);
  mesh.neighbours[a.triangle][a.edge] = b.triangle;
  mesh.neighbours[b.triangle][b.edge] = a.triangle;
}

// Sides that share both vertices by index.
std::string join_by_index(TriangleMesh& mesh) {
  std::vector<std::uint32_t> number(mesh.vertices.size());
  std::iota(number.begin(), number.end(), 0u);
  const std::vector<OpenSide> sides = open_sides(mesh, number);
  for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
    const OpenSide& side = sides[i];
    const OpenSide& next = sides[i + 1];
    if (!same_ends(side, next)) continue;
    if (i + 2 < sides.size() && same_ends(side, sides[i + 2])) {
      return text("found the edge between vertices ", side.low, " and ", side.high, " in triangles ", side.triangle,
                  ", ", next.triangle, " and ", sides[i + 2].triangle, ", expected it in at most two");
    }
    if (side.reversed == next.reversed) {
      return text("found triangles ", side.triangle, " and ", next.triangle, " that both run from vertex ",
                  side.reversed ? side.high : side.low, " to vertex ", side.reversed ? side.low : side.high,
                  ", expected all counter-clockwise seen from the front");
    }
    join(mesh, side, next);
  }
  return {};
}

// Vertices by the first one at the same place.
std::vector<std::uint32_t> first_at_place(std::span<const Vector3> vertices) {
  std::vector<std::uint32_t> order(vertices.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
    for (int axis = 0; axis < 3; ++axis) {
      if (vertices[i][axis] != vertices[j][axis]) return vertices[i][axis] < vertices[j][axis];
    }
    return i < j;
  });
  std::vector<std::uint32_t> first(vertices.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool repeated = i > 0 && vertices[order[i]] == vertices[order[i - 1]];
    first[order[i]] = repeated ? first[order[i - 1]] : order[i];
  }
  return first;
}

// Joins the sides that are still open by place: pairs that lie on each other in opposite directions. If more than two
// sides meet, it is ambiguous which belong together, so none are joined.
void join_by_place(TriangleMesh& mesh) {
  const std::vector<OpenSide> sides = open_sides(mesh, first_at_place(mesh.vertices));
  for (std::size_t begin = 0; begin < sides.size();) {
    std::size_t end = begin + 1;
    while (end < sides.size() && same_ends(sides[begin], sides[end])) ++end;
    if (end - begin == 2 && sides[begin].reversed != sides[begin + 1].reversed &&
        sides[begin].triangle != sides[begin + 1].triangle) {
      join(mesh, sides[begin], sides[begin + 1]);
    }
    begin = end;
  }
}

void find_convex_edges(TriangleMesh& mesh) {
  mesh.closed = true;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    unsigned bits = 0;
    for (std::uint32_t e = 0; e < 3; ++e) {
      const std::uint32_t neighbour = mesh.neighbours[t][e];
      const bool open = neighbour == TriangleMesh::no_triangle;
      if (open) mesh.closed = false;
      if (open || is_convex_edge(mesh.normals[t], mesh.normals[neighbour], edge_of(mesh, t, e))) bits |= 1u << e;
    }
    mesh.convex_edges.push_back(static_cast<std::uint8_t>(bits));
  }
}

// The corner of a triangle that lies at a place.
std::uint32_t corner_at(const TriangleMesh& mesh, std::uint32_t triangle, const Vector3& place) {
  const Indices& corners = mesh.triangles[triangle];
  ATL_ASSERT(
      mesh.vertices[corners[0]] == place || mesh.vertices[corners[1]] == place || mesh.vertices[corners[2]] == place,
      triangle, place.x(), place.y(), place.z());
  return mesh.vertices[corners[0]] == place ? 0 : mesh.vertices[corners[1]] == place ? 1 : 2;
}

// The smooth surface's normal at a triangle's corner: a weighted sum over the triangles around the corner, both ways
// from this one up to a crease.
Vector3 corner_normal(const TriangleMesh& mesh, std::uint32_t triangle, std::uint32_t corner) {
  const Vector3 place = mesh.vertices[mesh.triangles[triangle][corner]];
  const double min_cosine = std::cos(mesh.smooth_angle);
  Vector3 sum = Vector3::Zero();
  const auto add = [&](std::uint32_t t, std::uint32_t at) {
    const Vector3 next = edge_of(mesh, t, at);
    const Vector3 last = -edge_of(mesh, t, (at + 2) % 3);
    sum += next.cross(last) / (next.squaredNorm() * last.squaredNorm());
  };
  add(triangle, corner);
  for (const bool onwards : {true, false}) {
    std::uint32_t t = triangle, at = corner;
    for (;;) {
      const std::uint32_t beyond = mesh.neighbours[t][onwards ? (at + 2) % 3 : at];
      if (beyond == TriangleMesh::no_triangle || mesh.normals[t].dot(mesh.normals[beyond]) < min_cosine) break;
      if (beyond == triangle) return sum.normalized();  // all around
      t = beyond;
      at = corner_at(mesh, t, place);
      add(t, at);
    }
  }
  return sum.normalized();
}

void find_corner_normals(TriangleMesh& mesh) {
  if (mesh.smooth_angle == 0) return;
  mesh.corner_normals.resize(mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::uint32_t corner = 0; corner < 3; ++corner)
      mesh.corner_normals[t][corner] = corner_normal(mesh, t, corner);
  }
}

void measure(TriangleMesh& mesh) {
  std::vector<Aabb> boxes;
  boxes.reserve(mesh.triangles.size());
  mesh.lower = mesh.upper = mesh.vertices[mesh.triangles[0][0]];
  for (const Indices& corners : mesh.triangles) {
    const Vector3& a = mesh.vertices[corners[0]];
    const Vector3& b = mesh.vertices[corners[1]];
    const Vector3& c = mesh.vertices[corners[2]];
    const Vector3 lower = a.cwiseMin(b).cwiseMin(c);
    const Vector3 upper = a.cwiseMax(b).cwiseMax(c);
    boxes.push_back(Aabb::around(lower, upper));
    mesh.lower = mesh.lower.cwiseMin(lower);
    mesh.upper = mesh.upper.cwiseMax(upper);
    for (const Vector3* vertex : {&a, &b, &c}) mesh.bounding_radius = std::max(mesh.bounding_radius, vertex->norm());
  }
  mesh.tree.build(boxes);
}

std::uint64_t content_of(const TriangleMesh& mesh) {
  jobs::Hash hash;
  for (const Vector3& vertex : mesh.vertices) hash.add_all(vertex);
  for (const Indices& corners : mesh.triangles) {
    for (const std::uint32_t corner : corners) hash.add(std::uint64_t{corner});
  }
  if (mesh.smooth_angle > 0) hash.add(mesh.smooth_angle);
  for (const std::uint8_t number : mesh.materials) hash.add(std::uint64_t{number});
  return hash.value();
}

}  // namespace

Triangle TriangleMesh::triangle(std::uint32_t index) const {
  Triangle result = face(index);
  complete(index, result);
  return result;
}

Triangle TriangleMesh::face(std::uint32_t index) const {
  Triangle result;
  result.normal = normals[index];
  ATL_ASSERT(index < triangles.size(), index, triangles.size());
  for (std::size_t i = 0; i < 3; ++i) result.vertices[i] = vertices[triangles[index][i]];
  return result;
}

void TriangleMesh::complete(std::uint32_t index, Triangle& face) const {
  face.convex_edges = convex_edges[index];
  if (!corner_normals.empty()) face.corner_normals = corner_normals[index];
  for (std::size_t i = 0; i < 3; ++i) {
    const std::uint32_t neighbour = neighbours[index][i];
    face.neighbour_normals[i] = neighbour == no_triangle ? face.normal : normals[neighbour];
  }
}

std::variant<TriangleMesh, std::string> build_triangle_mesh(std::span<const Vector3> vertices,
                                                            std::span<const Indices> triangles, double smooth_angle,
                                                            std::vector<std::uint8_t> materials) {
  if (!(smooth_angle >= 0 && smooth_angle < std::numbers::pi)) {
    return text("found a smooth angle of ", smooth_angle, ", expected one in [0, pi) rad");
  }
  if (triangles.empty()) return text("found no triangle, expected at least one");
  if (triangles.size() >= TriangleMesh::no_triangle / 2) {
    return text("found ", triangles.size(), " triangles, expected fewer than 2^31");
  }
  if (!materials.empty() && materials.size() != triangles.size()) {
    return text("found numbers of materials for ", materials.size(), " triangles, expected ", triangles.size(),
                ", or none");
  }
  if (std::string problem = check_vertices(vertices); !problem.empty()) return problem;
  TriangleMesh mesh;
  mesh.vertices.assign(vertices.begin(), vertices.end());
  mesh.triangles.assign(triangles.begin(), triangles.end());
  if (std::string problem = find_normals(mesh); !problem.empty()) return problem;
  constexpr std::uint32_t none = TriangleMesh::no_triangle;
  mesh.neighbours.assign(triangles.size(), Indices{none, none, none});
  if (std::string problem = join_by_index(mesh); !problem.empty()) return problem;
  join_by_place(mesh);
  find_convex_edges(mesh);
  mesh.smooth_angle = smooth_angle;
  mesh.materials = std::move(materials);
  find_corner_normals(mesh);
  measure(mesh);
  ATL_ASSERT(mesh.normals.size() == triangles.size() && mesh.convex_edges.size() == triangles.size(),
             mesh.normals.size(), mesh.convex_edges.size(), triangles.size());
  ATL_ASSERT(mesh.corner_normals.size() == (smooth_angle > 0 ? triangles.size() : 0), mesh.corner_normals.size(),
             triangles.size());
  ATL_ASSERT(mesh.tree.items.size() == triangles.size(), mesh.tree.items.size(), triangles.size());
  mesh.content = content_of(mesh);
  return mesh;
}

}  // namespace atl::collision
