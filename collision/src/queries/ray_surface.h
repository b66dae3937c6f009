#pragma once

#include <collision/queries/ray.h>

namespace atl::collision {

/// A ray prepared for tests against many triangles: "Watertight ray/triangle intersection" (Woop, Benthin and
/// Wald, JCGT 2013). In a frame sheared so that the ray is the z axis, which side of an edge the ray passes is
/// computed alike for both triangles of the edge, so it hits at least one of them.
class TriangleRay {
 public:
  explicit TriangleRay(const Ray& ray);

  /// True if the ray hits the triangle at a t of [0, max_t]; if so sets t, normal and back.
  bool hits(const Vector3& a, const Vector3& b, const Vector3& c, Sides sides, double max_t, RayHit& hit) const;

 private:
  Vector3 sheared(const Vector3& vertex) const;

  Vector3 origin_;
  int x_, y_, z_;  // axes, z_ the one that the ray runs most along
  double shear_x_, shear_y_, scale_z_;
};

/// Finds the closest hit on the triangles of a surface; of equal ones that of the lowest triangle.
bool cast_ray_at_mesh(const TriangleMesh& mesh, const Ray& ray, Sides sides, RayHit& hit);
bool cast_ray_at_field(const HeightField& field, const Ray& ray, Sides sides, RayHit& hit);

}  // namespace atl::collision
