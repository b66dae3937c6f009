#pragma once

#include <collision/narrowphase/manifold.h>
#include <collision/shapes/pose.h>
#include <collision/shapes/shape.h>

#include <array>

namespace atl::collision {

/// Manifolds that a solid and a surface can have, each with a normal of its own: floor, two walls of a corner, and
/// one to spare.
inline constexpr int max_surface_manifolds = 4;

struct SurfaceManifolds {
  int count = 0;
  double gap = 0;  ///< m: without manifolds, how far the two are apart at least, if that was asked for
  std::array<Manifold, max_surface_manifolds> manifolds;
};

/// Contact points of a convex solid with a triangle mesh or height field. `solid_pose` is in the frame of the
/// surface, which is the reference of all manifolds. Triangles of a material that look the same way (within a degree;
/// exactly, to a ball) make one manifold, as if they were one face; where there are more ways than manifolds, similar
/// ones (within 15 degrees) are put together, and then the shallowest are left out. Of faces that bend away from each
/// other, only those push that the solid leaves soonest. Nothing is allocated. A pose that isn't finite has none.
///
/// A ball on a surface that stands for a smooth one has the normals of that. It is going to shift by `shift` (m, in the
/// surface's frame) in the step, and what it slides on bends: its normal is that half way, and `rise` is the part of
/// the way that the surface gains along it from there to the end of the step, and has lost by then since its start.
/// On plain triangles a ball has a manifold for each facet that it is over, or comes to within the step.
///
/// With a `max_gap` (m) the gap of two that don't touch is found as well, up to so much: by the ball and the box
/// around the solid.
void collide_surface(const Shape& solid, const Shape& surface, const Pose& solid_pose, double margin,
                     SurfaceManifolds& result, const Vector3& shift = Vector3::Zero(), double max_gap = 0);

/// The distance (m) of a ball from the triangles of a surface, up to `max` (m); 0 for any other shape. `centre` is in
/// the frame of the surface.
double gap_of_ball(const Vector3& centre, double radius, const Shape& surface, double max);

/// True if a surface's triangles or cells approximate a smooth surface.
bool is_smooth(const Shape& surface);

}  // namespace atl::collision
