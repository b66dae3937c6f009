#include <collision/narrowphase/collide.h>
#include <collision/narrowphase/distance.h>
#include <collision/narrowphase/surface_contacts.h>
#include <collision/shapes/aabb.h>
#include <collision/shapes/height_field.h>
#include <collision/shapes/shape.h>
#include <collision/shapes/triangle_mesh.h>
#include <features/with_meshes.h>
#include <jobs/assert.h>

#include <algorithm>
#include <cmath>

#include "narrowphase/sphere_solid.h"

namespace atl::collision {
namespace {

// The nearest triangle so far, all in the frame of the solid.
class NearestTriangle {
 public:
  NearestTriangle(const Shape& solid, const Pose& surface, double limit)
      : solid_(solid), surface_(surface), limit_(limit) {}

  void test(std::uint32_t number, const std::array<Vector3, 3>& vertices) {
    std::array<Vector3, 3> seen;
    for (std::size_t i = 0; i < 3; ++i) seen[i] = surface_.position + surface_.orientation * vertices[i];
    const ClosestPoints fresh = closest_points(solid_, seen);
    if (!(fresh.distance <= limit_)) return;
    if (found_ && fresh.distance == best_.distance && number > triangle_) return;
    best_ = fresh;
    triangle_ = number;
    limit_ = fresh.distance;
    found_ = true;
  }

  double limit() const { return limit_; }

  bool take(const Pose& solid_pose, Distance& result) const {
    if (!found_) return false;
    const auto place = [&](const Vector3& point) -> Vector3 {
      return solid_pose.position + solid_pose.orientation * point;
    };
    result = {best_.distance, place(best_.on_first), place(best_.on_second), solid_pose.orientation * best_.normal,
              triangle_};
    return true;
  }

 private:
  const Shape& solid_;
  Pose surface_;
  double limit_;
  bool found_ = false;
  ClosestPoints best_;
  std::uint32_t triangle_ = Distance::no_triangle;
};

std::array<Vector3, 3> corners(const TriangleMesh& mesh, std::uint32_t number) {
  const auto& corner = mesh.triangles[number];
  return {mesh.vertices[corner[0]], mesh.vertices[corner[1]], mesh.vertices[corner[2]]};
}

Aabb reached_from(const Bounds& bounds, double margin) {
  return Aabb::around(bounds.lower - Vector3::Constant(margin), bounds.upper + Vector3::Constant(margin));
}

void nearest_of_mesh(const TriangleMesh& mesh, const Bounds& bounds, NearestTriangle& nearest) {
  const auto limit = [&] {
    const double reach = nearest.limit() * (1 + 1e-12);
    return reach * reach;
  };
  mesh.tree.visit_near([&](const Aabb& box) { return square_apart(box, bounds); }, limit,
                       [&](std::uint32_t item) { nearest.test(item, corners(mesh, item)); });
}

// The triangles of the cell nearest to the middle of the bounds limit how far away others need to be looked at.
void nearest_of_field(const HeightField& field, const Bounds& bounds, NearestTriangle& nearest) {
  const Vector3 middle = 0.5 * (bounds.lower + bounds.upper);
  const auto cell = [](double coordinate, double spacing, std::uint32_t samples) {
    return static_cast<std::uint32_t>(std::clamp(std::floor(coordinate / spacing), 0.0, samples - 2.0));
  };
  const std::uint32_t below = 2 * (cell(middle.y(), field.spacing_y, field.rows) * (field.columns - 1) +
                                   cell(middle.x(), field.spacing_x, field.columns));
  for (const std::uint32_t number : {below, below + 1}) {
    if (!field.is_hole(number)) nearest.test(number, field.face(number).vertices);
  }
  const double limit = std::min(nearest.limit(), 1e30);
  field.query(reached_from(bounds, limit),
              [&](std::uint32_t number) { nearest.test(number, field.face(number).vertices); });
}

}  // namespace

bool find_distance(const Shape& solid, const Pose& solid_pose, const Shape& other, const Pose& other_pose, double limit,
                   Distance& result) {
  if (is_convex_solid(other.kind)) {
    ATL_ASSERT(is_convex_solid(solid.kind), static_cast<int>(solid.kind));
    const ClosestPoints found = closest_points(solid, other, relative(solid_pose, other_pose));
    if (!(found.distance <= limit)) return false;
    const auto place = [&](const Vector3& point) -> Vector3 {
      return solid_pose.position + solid_pose.orientation * point;
    };
    result = {found.distance, place(found.on_first), place(found.on_second), solid_pose.orientation * found.normal,
              Distance::no_triangle};
    return true;
  }
  if (other.kind == ShapeKind::HalfSpace) {
    const Vector3 normal = other_pose.orientation * other.normal;
    const Vector3 seen = solid_pose.orientation.conjugate() * -normal;
    const Vector3 lowest = solid_pose.position + solid_pose.orientation * support_point(solid, seen);
    const double height = normal.dot(lowest - other_pose.position) - other.offset;
    if (!(height <= limit)) return false;
    result = {std::max(0.0, height), lowest, lowest - height * normal, -normal, Distance::no_triangle};
    return true;
  }
  if constexpr (!with_meshes) return false;
  const Pose seen = relative(other_pose, solid_pose);
  const Bounds bounds = bounds_of(solid, seen.position, seen.orientation.toRotationMatrix());
  NearestTriangle nearest(solid, relative(solid_pose, other_pose), limit);
  if (other.kind == ShapeKind::Mesh) {
    nearest_of_mesh(*other.mesh, bounds, nearest);
  } else {
    nearest_of_field(*other.field, bounds, nearest);
  }
  return nearest.take(solid_pose, result);
}

namespace {

// Takes a manifold's depth and deepest point if it is deeper than what was found. `reference`: the pose of the
// reference shape.
void take_depth(const Manifold& manifold, const Pose& reference, bool reference_is_solid, Distance& result) {
  const double separation = manifold.min_separation();
  if (!(separation < result.distance)) return;
  const Vector3 normal = reference.orientation * manifold.normal;
  const Vector3& deepest = manifold.points[static_cast<std::size_t>(manifold.deepest())].position;
  const Vector3 on_incident = reference.position + reference.orientation * deepest;
  const Vector3 on_reference = on_incident - separation * normal;
  result.distance = separation;
  result.normal = reference_is_solid ? normal : Vector3(-normal);
  result.on_solid = reference_is_solid ? on_reference : on_incident;
  result.on_other = reference_is_solid ? on_incident : on_reference;
}

void find_depth_in_convex(const Shape& solid, const Pose& solid_pose, const Shape& other, const Pose& other_pose,
                          Distance& result) {
  Manifold manifold;
  if (solid.kind == ShapeKind::Sphere) {
    collide_sphere_solid(solid.radius, other, relative(solid_pose, other_pose), 0, manifold);
    return take_depth(manifold, other_pose, false, result);
  }
  const bool solid_first = solid.kind <= other.kind;
  const Shape& lower = solid_first ? solid : other;
  const Shape& higher = solid_first ? other : solid;
  const Pose in_lower = solid_first ? relative(solid_pose, other_pose) : relative(other_pose, solid_pose);
  collide(lower, higher, in_lower, 0, manifold);
  // The first look takes the axis that FCL says. From there the next one looks for the best, whatever its features.
  manifold = as_last(manifold);
  manifold.axis = 0;
  collide(lower, higher, in_lower, 0, manifold);
  const bool reference_is_solid = solid_first != manifold.reference_is_second;
  take_depth(manifold, reference_is_solid ? solid_pose : other_pose, reference_is_solid, result);
}

}  // namespace

bool find_signed_distance(const Shape& solid, const Pose& solid_pose, const Shape& other, const Pose& other_pose,
                          double limit, Distance& result) {
  if (!find_distance(solid, solid_pose, other, other_pose, limit, result)) return false;
  ATL_ASSERT(!(result.distance < 0), result.distance);
  if (result.distance > 0) return true;
  if (is_convex_solid(other.kind)) {
    find_depth_in_convex(solid, solid_pose, other, other_pose, result);
  } else if (other.kind == ShapeKind::HalfSpace) {
    const Vector3 out = -result.normal;
    result.distance = std::min(0.0, out.dot(result.on_solid - result.on_other));
  } else if (solid.bounding_radius > 0) {
    if constexpr (!with_meshes) return true;
    SurfaceManifolds manifolds;
    collide_surface(solid, other, relative(other_pose, solid_pose), 0, manifolds);
    for (std::size_t i = 0; i < static_cast<std::size_t>(manifolds.count); ++i) {
      take_depth(manifolds.manifolds[i], other_pose, false, result);
    }
  }
  return true;
}

bool overlaps(const Shape& solid, const Pose& solid_pose, const Shape& other, const Pose& other_pose) {
  Distance unused;
  return find_distance(solid, solid_pose, other, other_pose, 0, unused);
}

}  // namespace atl::collision
