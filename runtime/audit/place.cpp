#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "placed.h"

namespace atl::audit {
namespace {

Matrix3 axes_of(const Quaternion& orientation) {
  return Eigen::Quaterniond(orientation).normalized().toRotationMatrix();
}

Polytope hull_of(const ConvexHull& hull, const Matrix3& axes) {
  std::vector<Vector3> vertices;
  vertices.reserve(hull.vertices().size());
  for (const Vector3& vertex : hull.vertices()) vertices.push_back(axes * vertex);
  Polytope result = Polytope::from_vertices(std::move(vertices));
  std::vector<std::uint32_t> corners;
  for (std::size_t f = 0; f < hull.face_count(); ++f) {
    const auto face = hull.face(f);
    corners.assign(face.begin(), face.end());
    result.add_face(corners);
  }
  result.join_edges();
  return result;
}

/// The solid of a convex shape at a place.
struct MakeSolid {
  Vector3 centre;
  Matrix3 axes;

  Solid operator()(const Sphere& sphere) const { return {centre, Polytope::point(), sphere.radius}; }
  Solid operator()(const Box& box) const { return {centre, Polytope::box(axes, box.half_extents)}; }
  Solid operator()(const Capsule& capsule) const {
    return {centre, Polytope::segment(capsule.half_height * axes.col(2)), capsule.radius};
  }
  Solid operator()(const Cylinder& solid) const {
    return {centre, Revolved{axes.col(2), solid.radius, solid.half_height, false}};
  }
  Solid operator()(const Cone& solid) const {
    return {centre, Revolved{axes.col(2), solid.radius, solid.half_height, true}};
  }
  Solid operator()(const Ellipsoid& solid) const { return {centre, Smooth::ellipsoid(axes, solid.half_axes)}; }
  Solid operator()(const TaperedCapsule& solid) const {
    return {centre, Smooth::balls(solid.half_height * axes.col(2), solid.radii)};
  }
  Solid operator()(const ConvexHull& hull) const { return {centre, hull_of(hull, axes)}; }
};

struct Place {
  Vector3 position;
  Matrix3 axes;

  template <class Convex>
  Placed operator()(const Convex& shape) const {
    return PlacedSolids{MakeSolid{position, axes}(shape)};
  }
  Placed operator()(const Compound& compound) const {
    PlacedSolids solids;
    for (const CompoundChild& child : compound.children) {
      const MakeSolid make{position + axes * child.position, axes * axes_of(child.orientation)};
      solids.push_back(std::visit(make, child.shape));
    }
    return solids;
  }
  Placed operator()(const HalfSpace& ground) const {
    const Vector3 normal = axes * ground.normal.normalized();
    return PlacedHalfSpace{normal, ground.offset + normal.dot(position)};
  }
  Placed operator()(const TriangleMesh& mesh) const {
    PlacedSurface surface{position, axes, mesh, {}};
    const auto triangles = mesh.triangles();
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      if (i % PlacedSurface::block_size == 0) surface.blocks.emplace_back();
      for (const std::uint32_t vertex : triangles[i]) surface.blocks.back().extend(mesh.vertices()[vertex]);
    }
    return surface;
  }
  Placed operator()(const HeightField& field) const {
    const auto is_hole = [](double height) { return std::isnan(height); };
    return PlacedSurface{position, axes, field, {}, std::ranges::any_of(field.heights(), is_hole)};
  }
};

/// Radius about the middle of the shape's bounds, which is where `middle` lies in its frame.
struct BoundingRadius {
  static double of_points(std::span<const Vector3> points) {
    Eigen::AlignedBox3d box;
    for (const Vector3& point : points) box.extend(point);
    double square = 0;
    for (const Vector3& point : points) square = std::max(square, (point - box.center()).squaredNorm());
    return std::sqrt(square);
  }

  double operator()(const Sphere& sphere) const { return sphere.radius; }
  double operator()(const Box& box) const { return box.half_extents.norm(); }
  double operator()(const Capsule& capsule) const { return capsule.radius + capsule.half_height; }
  double operator()(const Cylinder& solid) const { return std::hypot(solid.radius, solid.half_height); }
  double operator()(const Cone& solid) const { return std::hypot(solid.radius, solid.half_height); }
  double operator()(const Ellipsoid& solid) const { return solid.half_axes.maxCoeff(); }
  double operator()(const TaperedCapsule& solid) const {
    return (solid.radii[0] + solid.radii[1]) / 2 + solid.half_height;
  }
  double operator()(const ConvexHull& hull) const { return of_points(hull.vertices()); }
  double operator()(const Compound& compound) const {
    const Placed placed = Place{Vector3::Zero(), Matrix3::Identity()}(compound);
    const Vector3 middle = bounds_of(placed).center();
    double radius = 0;
    for (const Solid& solid : std::get<PlacedSolids>(placed)) {
      const Eigen::AlignedBox3d box = bounds_of(solid);
      radius = std::max(radius, (box.center() - middle).norm() + box.diagonal().norm() / 2);
    }
    return radius;
  }
  template <class Unbounded>
  double operator()(const Unbounded&) const {
    return std::numeric_limits<double>::infinity();
  }
};

}  // namespace

Placed place(const PlacedShape& shape) {
  return std::visit(Place{shape.pose.position, axes_of(shape.pose.orientation)}, shape.shape);
}

double bounding_radius(const Shape& shape) { return std::visit(BoundingRadius{}, shape); }

Eigen::AlignedBox3d bounds_of(const Solid& solid) {
  Vector3 low, high;
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = solid.centre[axis] - reach(solid, -Vector3::Unit(axis));
    high[axis] = solid.centre[axis] + reach(solid, Vector3::Unit(axis));
  }
  return {low, high};
}

Eigen::AlignedBox3d bounds_of(const Placed& placed) {
  Eigen::AlignedBox3d box;
  if (const auto* solids = std::get_if<PlacedSolids>(&placed)) {
    for (const Solid& solid : *solids) box.extend(bounds_of(solid));
  } else if (const auto* surface = std::get_if<PlacedSurface>(&placed)) {
    box = surface_bounds(*surface).transformed(Eigen::Translation3d(surface->origin) * surface->axes);
  }
  return box;
}

}  // namespace atl::audit
