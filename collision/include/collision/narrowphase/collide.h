#pragma once

#include <collision/narrowphase/box_axes.h>
#include <collision/narrowphase/manifold.h>
#include <collision/shapes/pose.h>

namespace atl::collision {

/// Finds the contact points of a pair that are no farther apart than `margin` (m, >= 0). `second` is the pose
/// of the second shape in the frame of the first; the first is of the lower or the same kind. A pair of
/// half-spaces has none. On entry `manifold.axis` is the axis of the pair's last manifold, or 0: of two faces
/// that are equally good references, the one used before stays. Where `manifold.known`, its normal, its reference and
/// its middle are those of the last manifold (as_last()), which is followed. Else FCL is asked.
Narrowphase collide(const Shape& first_shape, const Shape& second_shape, const Pose& second, double margin,
                    Manifold& manifold);

/// The pairs' own functions, which collide() chooses from.
///
/// Boxes need no more of a last manifold that is known than `manifold.axis`.
Narrowphase collide_boxes(const Vector3& half_first, const Vector3& half_second, const Pose& second, double margin,
                          Manifold& manifold);
/// The same of a lane, whose axes were found.
Narrowphase collide_boxes(const Vector3& half_first, const Vector3& half_second, const BoxAxes& axes, std::size_t lane,
                          double margin, Manifold& manifold);
Narrowphase collide_spheres(double radius_first, double radius_second, const Pose& second, double margin,
                            Manifold& manifold);
/// Turns the contact of two spheres that are apart and near each other to where they will meet in the step, or pass by:
/// with the line of centres of the step's start they would bounce off the wrong way, or off each other where they miss.
/// `shift`: m, of the second against the first in the step, frame of the first.
void meet_at_impact(double radius_first, double radius_second, const Pose& second, const Vector3& shift,
                    Manifold& manifold);
Narrowphase collide_sphere_box(double radius, const Vector3& half_extents, const Pose& box, double margin,
                               Manifold& manifold);
/// The same for any two solids.
Narrowphase collide_convex(const Shape& first_shape, const Shape& second_shape, const Pose& second, double margin,
                           Manifold& manifold);

/// The same for a solid and a half-space.
void collide_half_space(const Shape& solid_shape, const Shape& half_space, const Pose& second, double margin,
                        Manifold& manifold);

}  // namespace atl::collision
