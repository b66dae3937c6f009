#include "polytope.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>
#include <utility>

namespace atl::audit {
namespace {

using std::numbers::pi;

/// Arcs shorter than this (rad) belong to an edge inside a face, which no direction singles out.
constexpr double flat_angle = 1e-12;

}  // namespace

Vector3 any_across(const Vector3& direction) {
  int smallest = 0;
  direction.cwiseAbs().minCoeff(&smallest);
  return direction.cross(Vector3::Unit(smallest)).normalized();
}

Polytope Polytope::point() { return from_vertices({Vector3::Zero()}); }

Polytope Polytope::segment(const Vector3& half) {
  Polytope result = from_vertices({-half, half});
  const Vector3 direction = half.normalized();
  const Vector3 from = any_across(direction);
  result.edges.push_back({-half, half, direction, from, from, direction.cross(from), 2 * pi});
  return result;
}

Polytope Polytope::box(const Matrix3& axes, const Vector3& half_extents) {
  std::vector<Vector3> corners;
  for (int i = 0; i < 8; ++i) {
    const Vector3 sign((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1);
    corners.push_back(axes * sign.cwiseProduct(half_extents));
  }
  Polytope result = from_vertices(std::move(corners));
  constexpr std::array<std::array<std::uint32_t, 4>, 6> faces = {
      {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
  for (std::size_t f = 0; f < faces.size(); ++f) {
    result.add_face(faces[f]);
    // The axes themselves are more exact than cross products of corners.
    result.normals[f] = (f % 2 == 0 ? -1.0 : 1.0) * axes.col(static_cast<Eigen::Index>(f / 2));
  }
  result.join_edges();
  return result;
}

Polytope Polytope::from_vertices(std::vector<Vector3> vertices) {
  Polytope result;
  result.vertices = std::move(vertices);
  return result;
}

Polytope Polytope::plate(const std::array<Vector3, 3>& corners) {
  Polytope result = from_vertices({corners.begin(), corners.end()});
  result.add_face(std::array<std::uint32_t, 3>{0, 1, 2});
  result.add_face(std::array<std::uint32_t, 3>{0, 2, 1});
  const Vector3 front = result.normals[0];
  result.normals[1] = -front;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3& tail = corners[i];
    const Vector3& head = corners[(i + 1) % 3];
    const Vector3 direction = (head - tail).normalized();
    result.edges.push_back({tail, head, direction, front, -front, direction.cross(front), pi});
  }
  return result;
}

Polytope Polytope::column(const std::array<Vector3, 3>& corners, const Vector3& down, double depth) {
  std::vector<Vector3> vertices(corners.begin(), corners.end());
  for (const Vector3& corner : corners) vertices.push_back(corner + depth * down);
  Polytope result = from_vertices(std::move(vertices));
  result.add_face(std::array<std::uint32_t, 3>{0, 1, 2});
  result.add_face(std::array<std::uint32_t, 4>{0, 3, 4, 1});
  result.add_face(std::array<std::uint32_t, 4>{1, 4, 5, 2});
  result.add_face(std::array<std::uint32_t, 4>{2, 5, 3, 0});
  result.join_edges();
  return result;
}

void Polytope::add_face(std::span<const std::uint32_t> corners) {
  // Newell's method: the area vector of the polygon, about its first corner.
  Vector3 area = Vector3::Zero();
  const Vector3& first = vertices[corners[0]];
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    area += (vertices[corners[i]] - first).cross(vertices[corners[i + 1]] - first);
  }
  normals.push_back(area.normalized());
  face_vertices.insert(face_vertices.end(), corners.begin(), corners.end());
  face_start.push_back(static_cast<std::uint32_t>(face_vertices.size()));
}

void Polytope::join_edges() {
  // (lower vertex, higher vertex, runs downwards, face) of every side of every face; the two of an edge sort next to
  // each other.
  std::vector<std::tuple<std::uint32_t, std::uint32_t, bool, std::size_t>> sides;
  for (std::size_t f = 0; f < normals.size(); ++f) {
    const auto corners = face(f);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const std::uint32_t tail = corners[i];
      const std::uint32_t head = corners[(i + 1) % corners.size()];
      sides.emplace_back(std::min(tail, head), std::max(tail, head), tail > head, f);
    }
  }
  std::sort(sides.begin(), sides.end());
  for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
    const auto& [low, high, downwards, face_left] = sides[i];
    const auto& [next_low, next_high, next_downwards, face_right] = sides[i + 1];
    if (low != next_low || high != next_high) continue;
    add_edge(vertices[low], vertices[high], normals[face_left], normals[face_right]);
  }
}

void Polytope::add_edge(const Vector3& tail, const Vector3& head, const Vector3& from, const Vector3& to) {
  const Vector3 aside = to - to.dot(from) * from;
  const double angle = std::atan2(aside.norm(), to.dot(from));
  if (angle < flat_angle) return;
  edges.push_back({tail, head, (head - tail).normalized(), from, to, aside.normalized(), angle});
}

}  // namespace atl::audit
