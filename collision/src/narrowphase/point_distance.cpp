#include "narrowphase/point_distance.h"

#include <algorithm>
#include <cmath>

namespace atl::collision {
namespace {

// Scales the part across z to a new length.
Vector3 at_radius(const Vector3& point, double across, double radius, double z) {
  const double scale = across > 0 ? radius / across : 0;
  return {scale * point.x(), scale * point.y(), z};
}

double across_z(const Vector3& point) { return std::sqrt(point.x() * point.x() + point.y() * point.y()); }

Vector3 closest_of_cylinder(double radius, double half_height, const Vector3& point) {
  const double z = std::clamp(point.z(), -half_height, half_height);
  const double across = across_z(point);
  return across <= radius ? Vector3(point.x(), point.y(), z) : at_radius(point, across, radius, z);
}

// Works in the half-plane of the point and the axis. The point is below the base, inside, or nearest to the side, which
// runs from the rim (radius, -h) to the apex (0, h).
Vector3 closest_of_cone(double radius, double half_height, const Vector3& point) {
  const double across = across_z(point);
  const double height = 2 * half_height;
  const double above = point.z() + half_height;
  if (above <= 0) {
    return across <= radius ? Vector3(point.x(), point.y(), -half_height)
                            : at_radius(point, across, radius, -half_height);
  }
  const double outside = (across - radius) * height + above * radius;
  if (outside <= 0) return point;
  const double slant_square = height * height + radius * radius;
  const double t = ((radius - across) * radius + above * height) / slant_square;
  if (t >= 1) return {0, 0, half_height};
  if (t <= 0) return at_radius(point, across, radius, -half_height);
  return at_radius(point, across, radius * (1 - t), -half_height + t * height);
}

}  // namespace

// Distinguishes the regions around the triangle: Ericson, "Real-Time Collision Detection", 5.1.5.
Vector3 closest_point_of_triangle(const std::array<Vector3, 3>& triangle, const Vector3& point) {
  const Vector3& a = triangle[0];
  const Vector3 ab = triangle[1] - a;
  const Vector3 ac = triangle[2] - a;
  const Vector3 ap = point - a;
  const double d1 = ab.dot(ap);
  const double d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const Vector3 bp = point - triangle[1];
  const double d3 = ab.dot(bp);
  const double d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return triangle[1];
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  const Vector3 cp = point - triangle[2];
  const double d5 = ab.dot(cp);
  const double d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return triangle[2];
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) {
    return triangle[1] + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (triangle[2] - triangle[1]);
  }
  const double sum = va + vb + vc;
  return a + vb / sum * ab + vc / sum * ac;
}

Vector3 closest_point(const ConvexCore& core, const Vector3& point) {
  switch (core.kind) {
    case ConvexCore::Kind::Segment:
      return {0, 0, std::clamp(point.z(), -core.half_height, core.half_height)};
    case ConvexCore::Kind::Box:
      return point.cwiseMax(-core.half_extents).cwiseMin(core.half_extents);
    case ConvexCore::Kind::Cylinder:
      return closest_of_cylinder(core.core_radius, core.half_height, point);
    case ConvexCore::Kind::Cone:
      return closest_of_cone(core.core_radius, core.half_height, point);
    case ConvexCore::Kind::Triangle:
      return closest_point_of_triangle(core.triangle, point);
    case ConvexCore::Kind::Point:
    case ConvexCore::Kind::Hull:
    case ConvexCore::Kind::Ellipsoid:
    case ConvexCore::Kind::TaperedCapsule:
      break;
  }
  return Vector3::Zero();
}

}  // namespace atl::collision
