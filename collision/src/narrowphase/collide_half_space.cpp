// Solids on half-spaces: the corners of the feature that looks most directly down.

#include <collision/narrowphase/collide.h>
#include <collision/narrowphase/feature_id.h>
#include <collision/narrowphase/support_feature.h>
#include <collision/shapes/shape.h>
#include <jobs/assert.h>

namespace atl::collision {
namespace {

// Numbers of the corners of an outline; see corner_id().
constexpr int lower_rim = 16;
constexpr int side_ends = 32;

int corner_number(const Shape& shape, const Polytope& core, int face, const Outline& outline, int i) {
  const OutlineCorner& corner = outline.corners[static_cast<std::size_t>(i)];
  switch (shape.kind) {
    case ShapeKind::Sphere:
    case ShapeKind::Capsule:
    case ShapeKind::Ellipsoid:
    case ShapeKind::TaperedCapsule:
      return side_ends + i;
    case ShapeKind::Cylinder:
    case ShapeKind::Cone: {
      if (face == 2) return side_ends + i;
      const bool upper = shape.kind == ShapeKind::Cylinder && face == 0;
      // A place on the rim has the number of the edge that leads on from it, anticlockwise.
      return upper ? corner.edge_out : lower_rim + corner.edge_in;
    }
    default:
      return core.face_vertices[core.face_start[face] + i];
  }
}

}  // namespace

void collide_half_space(const Shape& solid_shape, const Shape& half_space, const Pose& second, double margin,
                        Manifold& manifold) {
  manifold.count = 0;
  manifold.axis = 0;
  manifold.reference_is_second = true;
  manifold.normal = half_space.normal;
  manifold.on_face = true;
  const Matrix3 rotation = second.orientation.conjugate().toRotationMatrix();
  const Vector3 centre = rotation * -second.position;
  const Vector3 down = -(rotation.transpose() * half_space.normal);
  const Vector3 lowest = support_point(solid_shape, down);
  const double centre_height = half_space.normal.dot(centre) - half_space.offset;
  const double lowest_height = centre_height - down.dot(lowest);
  if (!(lowest_height <= margin)) return;
  if (solid_shape.kind == ShapeKind::Sphere) {
    manifold.add(centre - solid_shape.radius * half_space.normal, lowest_height, single_point_id());
    return;
  }

  Core core;
  core.build(solid_shape);
  const Polytope& polytope = core.polytope();
  Outline outline;
  const int face = incident_outline(solid_shape, polytope, down, margin - lowest_height, outline);
  ATL_ASSERT(outline.count <= max_face_corners, outline.count);
  std::array<Manifold::Point, max_face_corners + 1> points;
  int count = 0;
  bool has_lowest = false;
  for (int i = 0; i < outline.count; ++i) {
    const Vector3& corner = outline.corners[static_cast<std::size_t>(i)].position;
    const double height = centre_height - down.dot(corner);
    has_lowest |= height <= lowest_height + 1e-9 * solid_shape.inner_radius;
    if (height > margin) continue;
    points[static_cast<std::size_t>(count++)] = {centre + rotation * corner, height,
                                                 corner_id(corner_number(solid_shape, polytope, face, outline, i))};
  }
  // The face of a hull that looks most directly down need not have its lowest corner.
  if (!has_lowest && solid_shape.kind == ShapeKind::Hull) {
    points[static_cast<std::size_t>(count++)] = {centre + rotation * lowest, lowest_height,
                                                 corner_id(polytope.support(down))};
  }
  reduce_points(points.data(), count, manifold);
}

}  // namespace atl::collision
