#include <algorithm>
#include <cmath>
#include <limits>

#include "placed.h"

namespace atl {
namespace audit {
namespace {

double sphere_box(const PlacedSphere& sphere, const PlacedBox& box) {
  const Vector3 centre = box.axes.transpose() * (sphere.centre - box.centre);
  const Vector3 beyond = centre.cwiseAbs() - box.half_extents;
  // A centre inside leaves through the nearest face, the least negative component.
  if (beyond.maxCoeff() <= 0) return sphere.radius - beyond.maxCoeff();
  return sphere.radius - beyond.cwiseMax(0).norm();
}

/// How far a shape reaches below the surface.
double depth(const PlacedSphere& sphere, const PlacedHalfSpace& ground) {
  return sphere.radius - (ground.normal.dot(sphere.centre) - ground.offset);
}
double depth(const PlacedBox& box, const PlacedHalfSpace& ground) {
  const double reach = box.half_extents.dot((box.axes.transpose() * ground.normal).cwiseAbs());
  return reach - (ground.normal.dot(box.centre) - ground.offset);
}

struct Overlap {
  double operator()(const PlacedSphere& a, const PlacedSphere& b) const {
    return a.radius + b.radius - (b.centre - a.centre).norm();
  }
  double operator()(const PlacedSphere& a, const PlacedBox& b) const { return sphere_box(a, b); }
  double operator()(const PlacedBox& a, const PlacedSphere& b) const { return sphere_box(b, a); }
  double operator()(const PlacedBox& a, const PlacedBox& b) const { return box_overlap(a, b); }

  template <class Finite>
  double operator()(const Finite& a, const PlacedHalfSpace& b) const {
    return depth(a, b);
  }
  template <class Finite>
  double operator()(const PlacedHalfSpace& a, const Finite& b) const {
    return depth(b, a);
  }
  /// Only half-spaces that face each other exactly can be parted.
  double operator()(const PlacedHalfSpace& a, const PlacedHalfSpace& b) const {
    return a.normal == -b.normal ? a.offset + b.offset : std::numeric_limits<double>::infinity();
  }
};

}  // namespace

Placed place(const PlacedShape& shape) {
  const Vector3& centre = shape.pose.position;
  const Matrix3 axes = Eigen::Quaterniond(shape.pose.orientation).normalized().toRotationMatrix();
  if (const auto* sphere = std::get_if<Sphere>(&shape.shape)) return PlacedSphere{centre, sphere->radius};
  if (const auto* box = std::get_if<Box>(&shape.shape)) return PlacedBox{centre, axes, box->half_extents};
  const auto& ground = std::get<HalfSpace>(shape.shape);
  const Vector3 local = ground.normal.normalized();
  const Vector3 normal = axes * local;
  return PlacedHalfSpace{normal, ground.offset + normal.dot(centre)};
}

double overlap(const Placed& a, const Placed& b) { return std::visit(Overlap{}, a, b); }

}  // namespace audit

double overlap(const PlacedShape& a, const PlacedShape& b) { return audit::overlap(audit::place(a), audit::place(b)); }

}  // namespace atl
