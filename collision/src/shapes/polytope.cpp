#include <collision/shapes/polytope.h>
#include <jobs/assert.h>

#include <cmath>
#include <vector>

namespace atl::collision {
namespace {

constexpr int sides = Core::sides;

// Edges and their neighbours, from faces given as loops of vertices.
struct Topology {
  std::vector<Hull::Edge> edges;
  std::vector<std::uint16_t> face_start, face_vertices, face_edges, vertex_start, vertex_edges;

  Topology(int vertex_count, const std::vector<std::vector<int>>& faces) {
    face_start.push_back(0);
    for (std::size_t f = 0; f < faces.size(); ++f) {
      const std::vector<int>& loop = faces[f];
      for (std::size_t i = 0; i < loop.size(); ++i) {
        face_vertices.push_back(static_cast<std::uint16_t>(loop[i]));
        face_edges.push_back(edge(loop[i], loop[(i + 1) % loop.size()], static_cast<std::uint16_t>(f)));
      }
      face_start.push_back(static_cast<std::uint16_t>(face_vertices.size()));
    }
    finish(vertex_count);
  }
  // A point or a segment.
  explicit Topology(int vertex_count) {
    face_start.push_back(0);
    if (vertex_count == 2) edges.push_back({0, 1, Polytope::no_face, Polytope::no_face});
    finish(vertex_count);
  }

  Polytope polytope(const Vector3* vertices, const Hull::Plane* planes) const {
    Polytope p;
    p.vertices = vertices;
    p.planes = planes;
    p.edges = edges.data();
    p.face_start = face_start.data();
    p.face_vertices = face_vertices.data();
    p.face_edges = face_edges.data();
    p.vertex_start = vertex_start.data();
    p.vertex_edges = vertex_edges.data();
    p.vertex_count = static_cast<int>(vertex_start.size()) - 1;
    p.face_count = static_cast<int>(face_start.size()) - 1;
    return p;
  }

 private:
  std::uint16_t edge(int tail, int head, std::uint16_t left) {
    for (std::size_t e = 0; e < edges.size(); ++e) {
      if (edges[e].tail != head || edges[e].head != tail) continue;
      edges[e].right = left;
      return static_cast<std::uint16_t>(e);
    }
    edges.push_back({static_cast<std::uint16_t>(tail), static_cast<std::uint16_t>(head), left, Polytope::no_face});
    return static_cast<std::uint16_t>(edges.size() - 1);
  }
  void finish(int vertex_count) {
    for (int v = 0; v < vertex_count; ++v) {
      vertex_start.push_back(static_cast<std::uint16_t>(vertex_edges.size()));
      for (std::size_t e = 0; e < edges.size(); ++e) {
        if (edges[e].tail == v || edges[e].head == v) vertex_edges.push_back(static_cast<std::uint16_t>(e));
      }
    }
    vertex_start.push_back(static_cast<std::uint16_t>(vertex_edges.size()));
  }
};

// Face 2 * axis + (1 if on the negative side); a vertex has bit i set on the negative side of axis i.
const Topology& box_topology() {
  static const Topology topology(8,
                                 {{0, 2, 6, 4}, {1, 5, 7, 3}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 6, 7, 5}});
  return topology;
}

// Upper ring, then lower ring; faces: top, bottom, then side k, which lies between vertices k - 1 and k.
const Topology& prism_topology() {
  static const Topology topology = [] {
    std::vector<std::vector<int>> faces(2);
    for (int k = 0; k < sides; ++k) {
      faces[0].push_back(k);
      faces[1].push_back(2 * sides - 1 - k);
    }
    for (int k = 0; k < sides; ++k) {
      const int before = (k + sides - 1) % sides;
      faces.push_back({sides + before, sides + k, k, before});
    }
    return Topology(2 * sides, faces);
  }();
  return topology;
}

// The ring, then the apex; faces: base, then side k.
const Topology& pyramid_topology() {
  static const Topology topology = [] {
    std::vector<std::vector<int>> faces(1);
    for (int k = 0; k < sides; ++k) faces[0].push_back(sides - 1 - k);
    for (int k = 0; k < sides; ++k) faces.push_back({(k + sides - 1) % sides, k, sides});
    return Topology(sides + 1, faces);
  }();
  return topology;
}

const Topology& triangle_topology() {
  static const Topology topology(3, {{0, 1, 2}, {0, 2, 1}});
  return topology;
}

const Topology& segment_topology() {
  static const Topology topology(2);
  return topology;
}

const Topology& point_topology() {
  static const Topology topology(1);
  return topology;
}

// Sides of a ring around the unit circle: normals, and the corner between each and the next.
struct Ring {
  std::array<std::array<double, 2>, sides> normals;
  std::array<std::array<double, 2>, sides> corners;

  // Uses the tangents of half the angles: 0, rising, infinity, and mirrored. No trigonometry, so the same bits on every
  // machine.
  explicit Ring(const std::array<double, sides / 2 - 1>& half_tangents) {
    constexpr std::size_t half = sides / 2;
    for (std::size_t k = 0; k < sides; ++k) {
      if (k == half) {
        normals[k] = {-1, 0};
        continue;
      }
      const double t = k == 0 ? 0 : k < half ? half_tangents[k - 1] : -half_tangents[sides - 1 - k];
      const double scale = 1 / (1 + t * t);
      normals[k] = {scale * (1 - t * t), scale * 2 * t};
    }
    for (std::size_t k = 0; k < sides; ++k) {
      const auto& u = normals[k];
      const auto& v = normals[(k + 1) % sides];
      const double scale = 1 / (1 + u[0] * v[0] + u[1] * v[1]);
      corners[k] = {scale * (u[0] + v[0]), scale * (u[1] + v[1])};
    }
  }
};

// Dense sides in steps of 1.7 from q on, so that what a descent finds among them is off by less than a third of
// how far it went. The others keep the corners between them from standing out by more than a twelfth.
const Ring& ring(int level) {
  static const std::array<Ring, Core::levels> rings = {
      Ring({0.13165249758739583, 0.2679491924311227, 0.41421356237309503, 0.5773502691896257, 0.7673269879789604,
            0.9999999999999999, 1.3032253728412058, 1.7320508075688767, 2.414213562373095, 3.7320508075688776,
            7.5957541127251424}),
      Ring({0.0175, 0.03, 0.0525, 0.09, 0.157, 0.27, 0.42, 0.65, 1, 1.7, 4}),
      Ring({2e-3, 3.4e-3, 6e-3, 1.04e-2, 1.8e-2, 0.04, 0.1, 0.25, 0.55, 1.1, 2.8}),
      Ring({3e-4, 5.1e-4, 9e-4, 1.56e-3, 2.7e-3, 0.008, 0.03, 0.1, 0.32, 0.85, 2.4})};
  return rings[static_cast<std::size_t>(level)];
}

}  // namespace

// Four at a time, so that products don't wait for comparisons.
int Polytope::support(const Vector3& direction) const {
  if (hull) return static_cast<int>(hull->support(direction));
  const double x = direction.x();
  const double y = direction.y();
  const double z = direction.z();
  const auto reach = [&](int i) { return vertices[i].x() * x + vertices[i].y() * y + vertices[i].z() * z; };
  const int count = is_prism && z >= 0 ? vertex_count / 2 : vertex_count;
  int best = is_prism && z < 0 ? vertex_count / 2 : 0;
  double farthest = reach(best);
  int i = best + 1;
  for (; i + 3 < count; i += 4) {
    const double r0 = reach(i);
    const double r1 = reach(i + 1);
    const double r2 = reach(i + 2);
    const double r3 = reach(i + 3);
    const double low = r1 > r0 ? r1 : r0;
    const double high = r3 > r2 ? r3 : r2;
    const double max = high > low ? high : low;
    if (!(max > farthest)) continue;
    farthest = max;
    best = max == r0 ? i : max == r1 ? i + 1 : max == r2 ? i + 2 : i + 3;
  }
  for (; i < count; ++i) {
    const double r = reach(i);
    if (!(r > farthest)) continue;
    farthest = r;
    best = i;
  }
  return best;
}

int Polytope::climb(int vertex, const Vector3& direction) const {
  ATL_ASSERT(vertex >= 0 && vertex < vertex_count, vertex, vertex_count);
  double farthest = vertices[vertex].dot(direction);
  for (int step = 0; step < vertex_count; ++step) {
    const int from = vertex;
    for (int i = vertex_start[from]; i < vertex_start[from + 1]; ++i) {
      const Hull::Edge& edge = edges[vertex_edges[i]];
      const int next = edge.tail == from ? edge.head : edge.tail;
      const double reach = vertices[next].dot(direction);
      if (reach <= farthest) continue;
      farthest = reach;
      vertex = next;
    }
    if (vertex == from) break;
  }
  return vertex;
}

Polytope polytope_of(const Hull& hull) {
  Polytope p;
  p.vertices = hull.vertices.data();
  p.planes = hull.planes.data();
  p.edges = hull.edges.data();
  p.face_start = hull.face_start.data();
  p.face_vertices = hull.face_vertices.data();
  p.face_edges = hull.face_edges.data();
  p.vertex_start = hull.vertex_start.data();
  p.vertex_edges = hull.vertex_edges.data();
  p.vertex_count = static_cast<int>(hull.vertices.size());
  p.face_count = static_cast<int>(hull.planes.size());
  p.hull = &hull;
  return p;
}

void Core::build_ring(double radius, double height, const Vector3& about, int level, int first_vertex) {
  ATL_ASSERT(level >= 0 && level < levels, level);
  ATL_ASSERT(about.x() != 0 || about.y() != 0, about.z());
  const double scale = radius / length_2d(about.x(), about.y());
  const double c = scale * about.x();
  const double s = scale * about.y();
  const Ring& shape = ring(level);
  for (std::size_t k = 0; k < sides; ++k) {
    const auto& corner = shape.corners[k];
    vertices_[static_cast<std::size_t>(first_vertex) + k] = {c * corner[0] - s * corner[1],
                                                             s * corner[0] + c * corner[1], height};
  }
}

void Core::build(const Shape& shape, int level, const Vector3& about) {
  const double r = shape.radius;
  const double h = shape.half_height;
  radius_ = 0;
  switch (shape.kind) {
    case ShapeKind::Sphere:
      vertices_[0] = Vector3::Zero();
      polytope_ = point_topology().polytope(vertices_.data(), planes_.data());
      radius_ = r;
      break;
    case ShapeKind::Capsule:
      vertices_[0] = {0, 0, -h};
      vertices_[1] = {0, 0, h};
      polytope_ = segment_topology().polytope(vertices_.data(), planes_.data());
      radius_ = r;
      break;
    case ShapeKind::Box: {
      const Vector3& half = shape.half_extents;
      for (std::size_t i = 0; i < 8; ++i) {
        vertices_[i] = {i & 1 ? -half.x() : half.x(), i & 2 ? -half.y() : half.y(), i & 4 ? -half.z() : half.z()};
      }
      for (std::size_t f = 0; f < 6; ++f) {
        const auto axis = static_cast<Eigen::Index>(f / 2);
        planes_[f] = {(f & 1 ? -1.0 : 1.0) * Vector3::Unit(axis), half[axis]};
      }
      polytope_ = box_topology().polytope(vertices_.data(), planes_.data());
      break;
    }
    case ShapeKind::Cylinder:
    case ShapeKind::Cone: {
      const bool cone = shape.kind == ShapeKind::Cone;
      const double scale = 1 / length_2d(about.x(), about.y());
      const double slant = cone ? length_2d(r, 2 * h) : 1;
      const double across = cone ? 2 * h / slant : 1;
      const double up = cone ? r / slant : 0;
      const double c = across * scale * about.x();
      const double s = across * scale * about.y();
      const double offset = cone ? h * up : r;
      const std::size_t first_side = cone ? 1 : 2;
      const Ring& unit = ring(level);
      for (std::size_t k = 0; k < sides; ++k) {
        const auto& normal = unit.normals[k];
        planes_[first_side + k] = {{c * normal[0] - s * normal[1], s * normal[0] + c * normal[1], up}, offset};
      }
      if (cone) {
        build_ring(r, -h, about, level, 0);
        vertices_[sides] = {0, 0, h};
        planes_[0] = {-Vector3::UnitZ(), h};
        polytope_ = pyramid_topology().polytope(vertices_.data(), planes_.data());
      } else {
        build_ring(r, h, about, level, 0);
        for (std::size_t k = 0; k < sides; ++k) vertices_[sides + k] = {vertices_[k].x(), vertices_[k].y(), -h};
        planes_[0] = {Vector3::UnitZ(), h};
        planes_[1] = {-Vector3::UnitZ(), h};
        polytope_ = prism_topology().polytope(vertices_.data(), planes_.data());
        polytope_.is_prism = true;
      }
      break;
    }
    case ShapeKind::Hull:
      polytope_ = polytope_of(*shape.hull);
      break;
    case ShapeKind::Ellipsoid:
    case ShapeKind::TaperedCapsule:
    case ShapeKind::HalfSpace:
    case ShapeKind::Mesh:
    case ShapeKind::HeightField:
      vertices_[0] = Vector3::Zero();
      polytope_ = point_topology().polytope(vertices_.data(), planes_.data());
      break;
  }
}

void Core::build_triangle(const std::array<Vector3, 3>& vertices, const Vector3& unit_normal) {
  ATL_ASSERT(!(std::abs(unit_normal.squaredNorm() - 1) > 1e-9), unit_normal.norm());
  for (std::size_t i = 0; i < 3; ++i) vertices_[i] = vertices[i];
  const double offset = unit_normal.dot(vertices[0]);
  planes_[0] = {unit_normal, offset};
  planes_[1] = {-unit_normal, -offset};
  radius_ = 0;
  polytope_ = triangle_topology().polytope(vertices_.data(), planes_.data());
}

}  // namespace atl::collision
