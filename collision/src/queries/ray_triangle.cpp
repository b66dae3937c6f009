#include "queries/ray_triangle.h"

#include <cmath>
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

}  // namespace atl::collision
