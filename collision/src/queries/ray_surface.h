#pragma once

#include <collision/queries/ray.h>

namespace atl::collision {

bool cast_ray_at_mesh(const TriangleMesh& mesh, const Ray& ray, Sides sides, RayHit& hit);
bool cast_ray_at_field(const HeightField& field, const Ray& ray, Sides sides, RayHit& hit);

}  // namespace atl::collision
