// Rays against triangles, and surfaces of them.

#include "queries/ray_surface.h"

#include <collision/broadphase/ray_slabs.h>
#include <collision/shapes/height_field.h>
#include <collision/shapes/triangle_mesh.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace atl::collision {

TriangleRay::TriangleRay(const Ray& ray) : origin_(ray.origin) {
  Eigen::Index longest = 0;
  ray.direction.cwiseAbs().maxCoeff(&longest);
  z_ = static_cast<int>(longest);
  x_ = (z_ + 1) % 3;
  y_ = (z_ + 2) % 3;
  // Keeps the winding.
  if (ray.direction[z_] < 0) std::swap(x_, y_);
  scale_z_ = 1 / ray.direction[z_];
  shear_x_ = ray.direction[x_] * scale_z_;
  shear_y_ = ray.direction[y_] * scale_z_;
}

Vector3 TriangleRay::sheared(const Vector3& vertex) const {
  const Vector3 seen = vertex - origin_;
  return {seen[x_] - shear_x_ * seen[z_], seen[y_] - shear_y_ * seen[z_], scale_z_ * seen[z_]};
}

bool TriangleRay::hits(const Vector3& a, const Vector3& b, const Vector3& c, Sides sides, double max_t,
                       RayHit& hit) const {
  const Vector3 p = sheared(a);
  const Vector3 q = sheared(b);
  const Vector3 r = sheared(c);
  const double u = r.x() * q.y() - r.y() * q.x();
  const double v = p.x() * r.y() - p.y() * r.x();
  const double w = q.x() * p.y() - q.y() * p.x();
  if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return false;
  // Negative from the front: the sheared frame looks along the ray, so a front turns clockwise.
  const double doubled_area = u + v + w;
  const bool back = doubled_area < 0;
  if (doubled_area == 0 || (back && sides == Sides::Front)) return false;
  const double t = (u * p.z() + v * q.z() + w * r.z()) / doubled_area;
  if (!(t >= 0 && t <= max_t)) return false;
  const Vector3 normal = (b - a).cross(c - a).stableNormalized();
  hit = {t, back ? Vector3(-normal) : normal, RayHit::no_triangle, false, back};
  return true;
}

bool cast_ray(const std::array<Vector3, 3>& triangle, const Ray& ray, Sides sides, RayHit& hit) {
  return TriangleRay(ray).hits(triangle[0], triangle[1], triangle[2], sides, ray.max_t, hit);
}

namespace {

// The closest hit so far. Among equal ones the lowest triangle counts, whatever the order of visits.
class ClosestTriangle {
 public:
  ClosestTriangle(const Ray& ray, Sides sides) : ray_(ray), sides_(sides), max_t_(ray.max_t) {}

  void test(std::uint32_t number, const Vector3& a, const Vector3& b, const Vector3& c) {
    RayHit fresh;
    if (!ray_.hits(a, b, c, sides_, max_t_, fresh)) return;
    if (found_ && fresh.t == hit_.t && number > hit_.triangle) return;
    hit_ = fresh;
    hit_.triangle = number;
    max_t_ = fresh.t;
    found_ = true;
  }

  double max_t() const { return max_t_; }

  bool take(RayHit& hit) const {
    if (found_) hit = hit_;
    return found_;
  }

 private:
  TriangleRay ray_;
  Sides sides_;
  double max_t_;
  bool found_ = false;
  RayHit hit_;
};

// The ray's stretch within an interval of one coordinate, widened by more than rounding.
void clip(double origin, double direction, double lower, double upper, double& enter, double& leave) {
  const double slack = 1e-12 * (std::abs(origin) + std::max(std::abs(lower), std::abs(upper)));
  if (std::abs(direction) < 1e-300) {
    if (origin < lower - slack || origin > upper + slack) leave = -1;
    return;
  }
  const double a = (lower - slack - origin) / direction;
  const double b = (upper + slack - origin) / direction;
  enter = std::max(enter, std::min(a, b));
  leave = std::min(leave, std::max(a, b));
}

void test_cell(const HeightField& field, std::uint32_t i, std::uint32_t j, double lower, double upper,
               ClosestTriangle& closest) {
  const double a = field.height(i, j);
  const double b = field.height(i + 1, j);
  const double c = field.height(i + 1, j + 1);
  const double d = field.height(i, j + 1);
  if (std::isnan(a + c) || std::fmin(std::min(a, c), std::fmin(b, d)) > upper ||
      std::fmax(std::max(a, c), std::fmax(b, d)) < lower) {
    return;  // fmin and fmax leave holes out
  }
  const double x = i * field.spacing_x;
  const double y = j * field.spacing_y;
  const double next_x = (i + 1) * field.spacing_x;
  const double next_y = (j + 1) * field.spacing_y;
  const Vector3 first(x, y, a);
  const Vector3 across(next_x, next_y, c);
  const std::uint32_t number = 2 * (j * (field.columns - 1) + i);
  if (!std::isnan(b)) closest.test(number, first, {next_x, y, b}, across);
  if (!std::isnan(d)) closest.test(number + 1, first, across, {x, next_y, d});
}

}  // namespace

// Front to back.
bool cast_ray_at_mesh(const TriangleMesh& mesh, const Ray& ray, Sides sides, RayHit& hit) {
  const RaySlabs slabs(ray.origin, ray.direction, ray.max_t, Vector3::Zero());
  if (!slabs.valid()) return false;
  ClosestTriangle closest(ray, sides);
  const auto enter = [&](const Aabb& box) {
    double t_enter = 0;
    return slabs.enter(box, closest.max_t(), t_enter) ? t_enter : std::numeric_limits<double>::quiet_NaN();
  };
  mesh.tree.visit_near(
      enter, [&] { return closest.max_t(); },
      [&](std::uint32_t item) {
        const auto& corners = mesh.triangles[item];
        closest.test(item, mesh.vertices[corners[0]], mesh.vertices[corners[1]], mesh.vertices[corners[2]]);
      });
  return closest.take(hit);
}

// Strip by strip of cells along the axis on which the ray crosses more of them; in a strip, the cells between
// where the ray enters and where it leaves it. Ranges are widened by more than rounding, so that a ray along an
// edge sees the cells on both sides.
bool cast_ray_at_field(const HeightField& field, const Ray& ray, Sides sides, RayHit& hit) {
  const Vector3& o = ray.origin;
  const Vector3& d = ray.direction;
  if (!o.allFinite() || !d.allFinite()) return false;
  const double length_x = (field.columns - 1) * field.spacing_x;
  const double length_y = (field.rows - 1) * field.spacing_y;
  double enter = 0;
  double leave = ray.max_t;
  clip(o.x(), d.x(), 0, length_x, enter, leave);
  clip(o.y(), d.y(), 0, length_y, enter, leave);
  clip(o.z(), d.z(), field.lowest, field.highest, enter, leave);
  if (!(enter <= leave)) return false;

  const bool along_x = std::abs(d.x()) / field.spacing_x >= std::abs(d.y()) / field.spacing_y;
  const int axis = along_x ? 0 : 1;
  const double spacing = along_x ? field.spacing_x : field.spacing_y;
  const double slack_x = 1e-9 * field.spacing_x + 1e-12 * std::abs(o.x());
  const double slack_y = 1e-9 * field.spacing_y + 1e-12 * std::abs(o.y());
  const double slack_z = 1e-12 * (std::abs(o.z()) + std::abs(field.lowest) + std::abs(field.highest));
  const auto range = [&](int coordinate, double slack, double from, double to) {
    const double a = o[coordinate] + from * d[coordinate];
    const double b = o[coordinate] + to * d[coordinate];
    return std::pair(std::min(a, b) - slack, std::max(a, b) + slack);
  };
  const auto [low, high] = range(axis, along_x ? slack_x : slack_y, enter, leave);
  const HeightField::CellRange strips = along_x ? field.columns_between(low, high) : field.rows_between(low, high);
  ClosestTriangle closest(ray, sides);
  const bool forward = d[axis] >= 0;
  for (std::uint32_t k = strips.first; k < strips.end; ++k) {
    const std::uint32_t strip = forward ? k : strips.end - 1 - (k - strips.first);
    double from = enter;
    double to = leave;
    clip(o[axis], d[axis], strip * spacing, (strip + 1) * spacing, from, to);
    if (from > closest.max_t()) break;
    if (!(from <= to)) continue;
    const auto [side_low, side_high] = range(1 - axis, along_x ? slack_y : slack_x, from, to);
    const auto [lower, upper] = range(2, slack_z, from, to);
    const HeightField::CellRange cells =
        along_x ? field.rows_between(side_low, side_high) : field.columns_between(side_low, side_high);
    for (std::uint32_t cell = cells.first; cell < cells.end; ++cell) {
      test_cell(field, along_x ? strip : cell, along_x ? cell : strip, lower, upper, closest);
    }
  }
  return closest.take(hit);
}

}  // namespace atl::collision
