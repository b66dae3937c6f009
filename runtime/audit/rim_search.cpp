#include "rim_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

namespace atl::audit {
namespace {

using Vector2 = Eigen::Vector2d;
using Matrix2 = Eigen::Matrix2d;

constexpr std::size_t grid_size = 192;
constexpr std::size_t neighbour_count = 8;
/// Part of the size by which the grid point next to a smooth minimum may lie above it: the grid's points are nowhere
/// farther than 0.18 rad, and 0.18^2 / 2 is 0.016; more, because curvature grows towards the poles.
constexpr double grid_slack = 0.05;

struct Grid {
  std::array<Vector3, grid_size> directions;
  std::array<std::array<std::size_t, neighbour_count>, grid_size> neighbours;
};

/// A Fibonacci lattice on the sphere.
Grid make_grid() {
  Grid grid;
  const double golden_angle = std::numbers::pi * (3 - std::sqrt(5.0));
  for (std::size_t i = 0; i < grid_size; ++i) {
    const double z = 1 - (2 * static_cast<double>(i) + 1) / grid_size;
    const double r = std::sqrt(1 - z * z);
    const double angle = golden_angle * static_cast<double>(i);
    grid.directions[i] = Vector3(r * std::cos(angle), r * std::sin(angle), z);
  }
  for (std::size_t i = 0; i < grid_size; ++i) {
    std::array<std::pair<double, std::size_t>, grid_size> order;
    for (std::size_t j = 0; j < grid_size; ++j) order[j] = {-grid.directions[i].dot(grid.directions[j]), j};
    std::partial_sort(order.begin(), order.begin() + neighbour_count + 1, order.end());
    for (std::size_t j = 0; j < neighbour_count; ++j) grid.neighbours[i][j] = order[j + 1].second;
  }
  return grid;
}

/// The point of a solid that lies farthest along a direction, and the second derivative of its reach, which is
/// bend * along * along^T.
struct Support {
  Vector3 point;
  Vector3 along = Vector3::Zero();
  double bend = 0;
};

Support support(const Revolved& solid, const Vector3& direction) {
  const double axial = solid.axis.dot(direction);
  const Vector3 aside = direction - axial * solid.axis;
  const double across = aside.norm();
  if (solid.is_cone && 2 * solid.half_height * axial > solid.radius * across) {
    return {.point = solid.half_height * solid.axis};
  }
  const double height = solid.is_cone || axial < 0 ? -solid.half_height : solid.half_height;
  const Vector3 centre = height * solid.axis;
  if (across < 1e-12) return {.point = centre};
  const Vector3 radial = aside / across;
  return {centre + solid.radius * radial, solid.axis.cross(radial), solid.radius / across};
}

class Descent {
 public:
  Descent(const Revolved& a, const Revolved& b, const Vector3& offset) : a_(a), b_(b), offset_(offset) {}

  double overlap(const Vector3& normal) const { return reach(a_, normal) + reach(b_, -normal) - normal.dot(offset_); }

  /// Newton's method in the tangent plane, halving steps that don't descend. Ends where none does: at a minimum, or at
  /// a sharp bend, which other searches look at.
  Vector3 descend(Vector3 normal) const {
    constexpr double longest_step = 0.2;
    double depth = overlap(normal);
    for (int i = 0; i < 30; ++i) {
      const Support on_a = support(a_, normal);
      const Support on_b = support(b_, -normal);
      int smallest = 0;
      normal.cwiseAbs().minCoeff(&smallest);
      Eigen::Matrix<double, 3, 2> tangents;
      tangents.col(0) = normal.cross(Vector3::Unit(smallest)).normalized();
      tangents.col(1) = normal.cross(tangents.col(0));
      const Vector2 gradient = tangents.transpose() * (on_a.point - on_b.point - offset_);
      const Vector2 along_a = tangents.transpose() * on_a.along;
      const Vector2 along_b = tangents.transpose() * on_b.along;
      const Matrix2 second = on_a.bend * along_a * along_a.transpose() + on_b.bend * along_b * along_b.transpose() -
                             depth * Matrix2::Identity();
      Vector2 step = -gradient;
      if (second(0, 0) > 0 && second.determinant() > 0) step = second.inverse() * -gradient;
      const double length = step.norm();
      if (!(length > 1e-13)) break;
      if (length > longest_step || second.determinant() <= 0) step *= longest_step / length;
      bool descended = false;
      for (int halvings = 0; halvings < 20 && !descended; ++halvings, step /= 2) {
        const Vector3 next = (normal + tangents * step).normalized();
        const double next_depth = overlap(next);
        if (next_depth < depth) {
          normal = next;
          depth = next_depth;
          descended = true;
        }
      }
      if (!descended) break;
    }
    return normal;
  }

 private:
  const Revolved& a_;
  const Revolved& b_;
  Vector3 offset_;
};

}  // namespace

void search_rims(const Revolved& a, const Revolved& b, const Vector3& offset, const Penetration& min,
                 const std::function<void(const Vector3&)>& offer) {
  static const Grid grid = make_grid();
  const Descent descent(a, b, offset);
  std::array<double, grid_size> depths;
  for (std::size_t i = 0; i < grid_size; ++i) depths[i] = descent.overlap(grid.directions[i]);
  const double slack =
      grid_slack * (std::hypot(a.radius, a.half_height) + std::hypot(b.radius, b.half_height) + offset.norm());
  for (std::size_t i = 0; i < grid_size; ++i) {
    if (depths[i] - slack > min.depth) continue;
    const auto& neighbours = grid.neighbours[i];
    const bool lowest =
        std::all_of(neighbours.begin(), neighbours.end(), [&](std::size_t j) { return depths[i] <= depths[j]; });
    if (lowest) offer(descent.descend(grid.directions[i]));
  }
  offer(descent.descend(min.normal));
}

}  // namespace atl::audit
