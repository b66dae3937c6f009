#include <collision/shapes/aabb.h>
#include <collision/shapes/height_field.h>
#include <collision/shapes/hull.h>
#include <collision/shapes/triangle_mesh.h>

#include <algorithm>
#include <bit>
#include <cstdint>

namespace atl::collision {
namespace {

// Runs for every shape in every step, where std::nextafter is slow and a branch on the rounding a coin toss.
float round_down(double value) {
  const auto rounded = static_cast<float>(value);
  const bool above = static_cast<double>(rounded) > value;
  if (rounded == 0) return above ? -std::numeric_limits<float>::denorm_min() : rounded;
  // Counting down through positive floats, or up through negative ones, gives the next lower.
  const int step = static_cast<int>(above) * (rounded > 0 ? -1 : 1);
  return std::bit_cast<float>(std::bit_cast<std::int32_t>(rounded) + step);
}

float round_up(double value) { return -round_down(-value); }

// The half extents of a disc of radius 1 about z, along the axes that the rotation turns it against.
Vector3 disc_reach(const Matrix3& rotation) {
  return (rotation.col(0).cwiseAbs2() + rotation.col(1).cwiseAbs2()).cwiseSqrt();
}

// Computed in lanes of vertices.
Bounds bounds_of_hull(const Hull& hull, const Vector3& position, const Matrix3& rotation) {
  using Lanes = Eigen::Array<double, Hull::lanes, 1>;
  const std::size_t size = hull.columns.size() / 3;
  std::array<Lanes, 3> lower, upper;
  lower.fill(Lanes::Constant(std::numeric_limits<double>::infinity()));
  upper.fill(Lanes::Constant(-std::numeric_limits<double>::infinity()));
  for (std::size_t i = 0; i < size; i += Hull::lanes) {
    const Eigen::Map<const Lanes> x(hull.columns.data() + i);
    const Eigen::Map<const Lanes> y(hull.columns.data() + size + i);
    const Eigen::Map<const Lanes> z(hull.columns.data() + 2 * size + i);
    // The sums in the order in which a product of a matrix and a vector has them.
    const std::array<Lanes, 3> turned = {(rotation(0, 0) * x + rotation(0, 1) * y) + rotation(0, 2) * z,
                                         (rotation(1, 0) * x + rotation(1, 1) * y) + rotation(1, 2) * z,
                                         rotation(2, 0) * x + (rotation(2, 1) * y + rotation(2, 2) * z)};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lower[axis] = lower[axis].min(turned[axis]);
      upper[axis] = upper[axis].max(turned[axis]);
    }
  }
  const Vector3 min(lower[0].minCoeff(), lower[1].minCoeff(), lower[2].minCoeff());
  const Vector3 max(upper[0].maxCoeff(), upper[1].maxCoeff(), upper[2].maxCoeff());
  return {position + min, position + max};
}

// The reach of a mesh along a direction. Skips subtrees that reach less far than the best so far.
double reach_of_mesh(const TriangleMesh& mesh, const Vector3& direction) {
  double reach = -std::numeric_limits<double>::infinity();
  const auto short_of = [&](const Aabb& box) {
    double limit = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto& side = direction[axis] < 0 ? box.lower : box.upper;
      limit += direction[axis] * side[static_cast<std::size_t>(axis)];
    }
    return -limit;
  };
  mesh.tree.visit_near(
      short_of, [&] { return -reach; },
      [&](std::uint32_t item) {
        for (const std::uint32_t v : mesh.triangles[item]) reach = std::max(reach, mesh.vertices[v].dot(direction));
      });
  return reach;
}

Bounds bounds_of_mesh(const TriangleMesh& mesh, const Vector3& position, const Matrix3& rotation) {
  Bounds bounds{position, position};
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3 direction = rotation.row(axis).transpose();
    bounds.lower[axis] -= reach_of_mesh(mesh, -direction);
    bounds.upper[axis] += reach_of_mesh(mesh, direction);
  }
  return bounds;
}

}  // namespace

Aabb Aabb::around(const Vector3& lower, const Vector3& upper) {
  return {{round_down(lower.x()), round_down(lower.y()), round_down(lower.z())},
          {round_up(upper.x()), round_up(upper.y()), round_up(upper.z())}};
}

Bounds bounds_of_box(const Vector3& lower, const Vector3& upper, const Vector3& position, const Matrix3& rotation) {
  const Vector3 centre = position + rotation * (lower + upper) / 2;
  const Vector3 half = rotation.cwiseAbs() * (upper - lower) / 2;
  return {centre - half, centre + half};
}

Bounds bounds_of(const Shape& shape, const Vector3& position, const Matrix3& rotation) {
  const Vector3 axis = shape.half_height * rotation.col(2);
  switch (shape.kind) {
    case ShapeKind::Sphere:
    case ShapeKind::Capsule: {
      const Vector3 half = axis.cwiseAbs() + Vector3::Constant(shape.radius);
      return {position - half, position + half};
    }
    case ShapeKind::Box: {
      const Vector3 half = rotation.cwiseAbs() * shape.half_extents;
      return {position - half, position + half};
    }
    case ShapeKind::Cylinder: {
      const Vector3 half = axis.cwiseAbs() + shape.radius * disc_reach(rotation);
      return {position - half, position + half};
    }
    case ShapeKind::Cone: {
      const Vector3 base = shape.radius * disc_reach(rotation);
      return {position + axis.cwiseMin(-axis - base), position + axis.cwiseMax(base - axis)};
    }
    case ShapeKind::Ellipsoid: {
      const Vector3 half = (rotation * shape.half_extents.asDiagonal()).rowwise().norm();
      return {position - half, position + half};
    }
    case ShapeKind::TaperedCapsule: {
      const Vector3 bottom = Vector3::Constant(shape.radius);
      const Vector3 top = Vector3::Constant(shape.top_radius);
      return {position + (-axis - bottom).cwiseMin(axis - top), position + (bottom - axis).cwiseMax(axis + top)};
    }
    case ShapeKind::Hull:
      return bounds_of_hull(*shape.hull, position, rotation);
    case ShapeKind::Mesh:
      return bounds_of_mesh(*shape.mesh, position, rotation);
    case ShapeKind::HeightField: {
      const HeightField& field = *shape.field;
      const Vector3 upper((field.columns - 1) * field.spacing_x, (field.rows - 1) * field.spacing_y, field.highest);
      return bounds_of_box({0, 0, field.lowest}, upper, position, rotation);
    }
    case ShapeKind::HalfSpace:
      break;
  }
  const Vector3 everywhere = Vector3::Constant(std::numeric_limits<double>::infinity());
  return {-everywhere, everywhere};
}

}  // namespace atl::collision
