// Geometry that shapes share: made once, checked as it is made.

#include <atoll/error.h>
#include <atoll/shapes.h>
#include <collision/shapes/height_field.h>
#include <collision/shapes/hull.h>
#include <collision/shapes/triangle_mesh.h>
#include <features/with_hulls.h>
#include <features/with_meshes.h>

#include <sstream>
#include <string>
#include <utility>

#include "world/left_out.h"

namespace atl {
namespace {

template <typename Geometry>
std::shared_ptr<const Geometry> built(const char* what, std::variant<Geometry, std::string>&& result) {
  if (const std::string* problem = std::get_if<std::string>(&result)) throw Error(std::string(what) + ": " + *problem);
  return std::make_shared<const Geometry>(std::get<Geometry>(std::move(result)));
}

// These three functions hold everything that builds without these shapes leave out.

auto hull_of(std::span<const Vector3> points) {
  if constexpr (!with_hulls) throw_left_out("a ConvexHull is made", "these", "HULLS");
  return collision::build_hull(points);
}

auto mesh_of(std::span<const Vector3> vertices, std::span<const TriangleMesh::Indices> triangles, double smooth_angle,
             std::vector<std::uint8_t>&& materials) {
  if constexpr (!with_meshes) throw_left_out("a TriangleMesh is made", "these", "MESHES");
  return collision::build_triangle_mesh(vertices, triangles, smooth_angle, std::move(materials));
}

auto field_of(std::uint32_t columns, std::uint32_t rows, double spacing_x, double spacing_y,
              std::vector<double>&& heights, bool smooth, std::vector<std::uint8_t>&& materials) {
  if constexpr (!with_meshes) throw_left_out("a HeightField is made", "these", "MESHES");
  return collision::build_height_field(columns, rows, spacing_x, spacing_y, std::move(heights), smooth,
                                       std::move(materials));
}

void check_factors(const char* what, const Vector3& factors) {
  if (factors.allFinite() && factors.cwiseAbs().minCoeff() > 0) return;
  std::ostringstream out;
  out << what << ": factors are (" << factors.x() << ", " << factors.y() << ", " << factors.z()
      << "); expected three finite numbers other than 0";
  throw Error(out.str());
}

std::vector<Vector3> stretched(std::span<const Vector3> points, const Vector3& factors) {
  std::vector<Vector3> result;
  result.reserve(points.size());
  for (const Vector3& point : points) result.emplace_back(point.cwiseProduct(factors));
  return result;
}

}  // namespace

ConvexHull::ConvexHull(std::span<const Vector3> points) : hull_(built("ConvexHull", hull_of(points))) {}

ConvexHull ConvexHull::scaled(const Vector3& factors) const {
  check_factors("ConvexHull::scaled", factors);
  auto result = hull_of(stretched(hull_->vertices, factors));
  if (auto* hull = std::get_if<collision::Hull>(&result)) hull->simplified = hull->simplified || hull_->simplified;
  ConvexHull copy = *this;
  copy.hull_ = built("ConvexHull::scaled", std::move(result));
  return copy;
}

std::span<const Vector3> ConvexHull::vertices() const { return hull_->vertices; }
std::size_t ConvexHull::face_count() const { return hull_->face_count(); }

std::span<const std::uint16_t> ConvexHull::face(std::size_t index) const {
  const std::size_t count = hull_->face_count();
  if (index >= count) {
    throw Error("ConvexHull::face: index is " + std::to_string(index) +
                "; expected less than face_count() = " + std::to_string(count));
  }
  const std::size_t begin = hull_->face_start[index];
  return std::span(hull_->face_vertices).subspan(begin, hull_->face_start[index + 1] - begin);
}

bool ConvexHull::simplified() const { return hull_->simplified; }
double ConvexHull::volume() const { return hull_->mass.volume; }
Vector3 ConvexHull::centre_of_mass() const { return hull_->mass.centre; }

TriangleMesh::TriangleMesh(std::span<const Vector3> vertices, std::span<const Indices> triangles, double smooth_angle,
                           std::vector<std::uint8_t> materials)
    : mesh_(built("TriangleMesh", mesh_of(vertices, triangles, smooth_angle, std::move(materials)))) {}

TriangleMesh TriangleMesh::scaled(const Vector3& factors) const {
  check_factors("TriangleMesh::scaled", factors);
  std::vector<Indices> triangles = mesh_->triangles;
  if ((factors.array() < 0).count() % 2 == 1) {
    for (Indices& corners : triangles) std::swap(corners[1], corners[2]);
  }
  TriangleMesh copy = *this;
  copy.mesh_ = built("TriangleMesh::scaled", mesh_of(stretched(mesh_->vertices, factors), triangles,
                                                     mesh_->smooth_angle, std::vector(mesh_->materials)));
  return copy;
}

std::span<const Vector3> TriangleMesh::vertices() const { return mesh_->vertices; }
std::span<const TriangleMesh::Indices> TriangleMesh::triangles() const { return mesh_->triangles; }
bool TriangleMesh::closed() const { return mesh_->closed; }
double TriangleMesh::smooth_angle() const { return mesh_->smooth_angle; }
std::span<const std::uint8_t> TriangleMesh::materials() const { return mesh_->materials; }

HeightField::HeightField(std::uint32_t columns, std::uint32_t rows, double spacing_x, double spacing_y,
                         std::vector<double> heights, bool smooth, std::vector<std::uint8_t> materials)
    : field_(built("HeightField",
                   field_of(columns, rows, spacing_x, spacing_y, std::move(heights), smooth, std::move(materials)))) {}

std::uint32_t HeightField::columns() const { return field_->columns; }
std::uint32_t HeightField::rows() const { return field_->rows; }
double HeightField::spacing_x() const { return field_->spacing_x; }
double HeightField::spacing_y() const { return field_->spacing_y; }
std::span<const double> HeightField::heights() const { return field_->heights; }
bool HeightField::smooth() const { return field_->smooth; }
std::span<const std::uint8_t> HeightField::materials() const { return field_->materials; }

}  // namespace atl
