// Rays against surfaces of triangles.

#include "ray_surface.h"

#include <collision/height_field.h>
#include <collision/ray_slabs.h>
#include <collision/triangle_mesh.h>

#include <algorithm>
#include <cmath>

#include "ray_triangle.h"

namespace atl::collision {
namespace {

// The closest hit so far. Of equal ones that of the lowest triangle counts, whatever the order of visits.
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
  if (std::min({a, b, c, d}) > upper || std::max({a, b, c, d}) < lower) return;
  const double x = i * field.spacing_x;
  const double y = j * field.spacing_y;
  const double next_x = (i + 1) * field.spacing_x;
  const double next_y = (j + 1) * field.spacing_y;
  const Vector3 first(x, y, a);
  const Vector3 across(next_x, next_y, c);
  const std::uint32_t number = 2 * (j * (field.columns - 1) + i);
  closest.test(number, first, {next_x, y, b}, across);
  closest.test(number + 1, first, across, {x, next_y, d});
}

}  // namespace

// Front to back with a stack of far children; where it is full (a tree deeper than a balanced one could ever be) a
// subtree is run through in its own order.
bool cast_ray_at_mesh(const TriangleMesh& mesh, const Ray& ray, Sides sides, RayHit& hit) {
  constexpr int max_depth = 96;
  struct Entry {
    std::uint32_t node;
    double t_enter;
  };
  const std::vector<TriangleTree::Node>& nodes = mesh.tree.nodes;
  const RaySlabs slabs(ray.origin, ray.direction, ray.max_t, Vector3::Zero());
  ClosestTriangle closest(ray, sides);
  const auto test = [&](std::uint32_t item) {
    const auto& corners = mesh.triangles[item];
    closest.test(item, mesh.vertices[corners[0]], mesh.vertices[corners[1]], mesh.vertices[corners[2]]);
  };
  Entry stack[max_depth];
  int top = 0;
  double t_root = 0;
  if (nodes.empty() || !slabs.valid() || !slabs.enter(nodes[0].box, ray.max_t, t_root)) return false;
  stack[top++] = {0, t_root};
  while (top > 0) {
    const Entry entry = stack[--top];
    if (entry.t_enter > closest.max_t()) continue;
    const TriangleTree::Node& node = nodes[entry.node];
    if (node.item != TriangleTree::no_item) {
      test(node.item);
      continue;
    }
    if (top + 2 > max_depth) {
      for (std::uint32_t i = entry.node; i < node.skip;) {
        double t_enter = 0;
        const bool enters = slabs.enter(nodes[i].box, closest.max_t(), t_enter);
        if (enters && nodes[i].item != TriangleTree::no_item) test(nodes[i].item);
        i = enters ? i + 1 : nodes[i].skip;
      }
      continue;
    }
    Entry near{entry.node + 1, 0};
    Entry far{nodes[near.node].skip, 0};
    bool hits_near = slabs.enter(nodes[near.node].box, closest.max_t(), near.t_enter);
    bool hits_far = far.node < node.skip && slabs.enter(nodes[far.node].box, closest.max_t(), far.t_enter);
    if (far.t_enter < near.t_enter) {
      std::swap(near, far);
      std::swap(hits_near, hits_far);
    }
    if (hits_far) stack[top++] = far;
    if (hits_near) stack[top++] = near;
  }
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
