#pragma once

#include <atoll/body.h>
#include <atoll/contact_problem.h>
#include <atoll/error.h>
#include <atoll/joint.h>
#include <atoll/types.h>

#include <functional>
#include <span>
#include <vector>

namespace atl {

/// Shape and pose of one body as the audit sees it: nothing but the final state.
struct PlacedShape {
  BodyType type = BodyType::Dynamic;
  Shape shape = Box{};
  Pose pose = {};
};

/// Least translation that parts a pair, over the pairs that overlap by more than 10 um.
struct PenetrationReport {
  double max = 0;           ///< m
  double p99 = 0;           ///< m, nearest rank
  double mean = 0;          ///< m
  double max_relative = 0;  ///< of the smaller shape's bounding radius (about the middle of its bounds)
  std::size_t pairs = 0;    ///< how many overlap
};

/// Distance from an ideal rest pose, over the dynamic bodies.
struct RestReport {
  double sink_max = 0;   ///< m, downwards along gravity, >= 0
  double sink_mean = 0;  ///< m, signed
  double drift_max = 0;  ///< m, across gravity
  double tilt_max = 0;   ///< rad
};

/// A joint as the audit sees it: bodies by their place among the states that it is given.
struct PlacedJoint {
  JointKind kind = BallJoint{};
  std::size_t first = 0;
  std::size_t second = 0;
  Pose frame_first = {};  ///< in the body's frame
  Pose frame_second = {};
};

/// How far joints are from holding what they lock and limit.
struct JointDriftReport {
  double max = 0;                ///< m, of locked offsets: of ball joints and the like the distance of the anchors
  double mean = 0;               ///< m, over the joints
  double rms = 0;                ///< m, over the joints
  double angle_max = 0;          ///< rad, of locked axes
  double excess_max = 0;         ///< m, beyond the ranges of offsets and distances
  double angle_excess_max = 0;   ///< rad, beyond the ranges of angles
  std::size_t worst = 0;         ///< of max
  std::size_t angles = 0;        ///< joints that lock an axis
  std::size_t ranges = 0;        ///< joints that limit an offset or a distance
  std::size_t angle_ranges = 0;  ///< joints that limit an angle
};

/// How far a contact problem's impulses are from solving it.
struct ResidualReport {
  /// The natural map's norm over all patches, relative to that of the free velocities at the contacts, or, where
  /// these are 0, of what the impulses make of them: 0 at a solution, about 1 where nothing was done.
  double relative = 0;
  double absolute = 0;  ///< m/s, that norm before the division
  double worst = 0;     ///< m/s, of one patch
  std::size_t worst_patch = 0;
  std::vector<double> by_patch;  ///< m/s
  /// m/s, by patch: what `relative` divides by, but for the root of the sum of squares; of free velocities, and of what
  /// the impulses make of them.
  std::vector<double> free_by_patch, change_by_patch;
};

/// Mechanical energy and momentum of some bodies.
struct MotionReport {
  double kinetic = 0;                          ///< J
  double potential = 0;                        ///< J, against the world's origin
  Vector3 momentum = Vector3::Zero();          ///< kg m/s
  Vector3 angular_momentum = Vector3::Zero();  ///< kg m^2/s, about the world's origin
};

/// A body in motion as the audit sees it.
struct MovingBody {
  MassProperties mass = {};
  BodyState state = {};
  double gravity_scale = 1;
};

/// Signed overlap in m of two placed shapes, in double, by code that shares nothing with the simulation's narrowphase.
///
/// Positive: the least translation that parts them. Exact for spheres and capsules (closed forms of the distance
/// between their cores), for boxes and hulls (all face normals and all pairs of edges that meet on the Gauss map:
/// Gottschalk, Lin and Manocha, "OBBTree", SIGGRAPH 1996, section 5; Gregorius, "The separating axis test between
/// convex polyhedra", GDC 2013) and for half-spaces. With a cylinder or a cone it is the least of the overlaps along
/// all directions that can be a local minimum, found by closed form (caps, faces) or by numerical search along the arcs
/// of edges and sides and from many starts where a rim rolls over a rim: at most 1e-7 of the size too large.
///
/// Negative: minus the distance, if one of the two is round all over or a half-space; else minus a lower bound
/// of it.
///
/// A compound counts by the deepest of its children. A mesh has no inside: a solid overlaps a triangle by the least
/// translation, forwards, backwards or over an edge, that takes it off that triangle, and a mesh by the largest over
/// its triangles. A solid that has sunk in by more than half is nearer to the back and counts by that; one that has
/// passed through altogether no longer overlaps. A height field is solid below: each of its triangles stands for
/// the column under it, and the largest over the columns counts. A solid all of which lies deep below counts by at
/// least what it takes to leave the column sideways. One with holes counts as a mesh does. Surfaces against half-
/// spaces count by their deepest vertex, against each other by their triangles.
///
/// The pose is that of the frame that the shape is given in.
double overlap(const PlacedShape& a, const PlacedShape& b);

/// Tells if two bodies, given by their places, may touch at all: overlap of a pair that may not is no error.
using MayTouch = std::function<bool(std::size_t, std::size_t)>;

/// Tests all pairs with at least one dynamic body (a sweep along one axis prunes them). O(n log n + pairs).
PenetrationReport measure_penetration(std::span<const PlacedShape> shapes, const MayTouch& may_touch = {});

/// `ideal` and `actual` hold the same bodies in the same order; up is a unit vector against gravity.
RestReport measure_rest(std::span<const PlacedShape> ideal, std::span<const PlacedShape> actual, const Vector3& up);

/// In double, from the problem and its impulses alone: velocities follow from the impulses and not from what the solver
/// made of them. Rows of spin are taken per arm, r_w / L and L u_w, so that all have the same units, and K is the
/// patch's friction cone {r_i >= 0, |r_T| <= mu R, |r_w / L| <= mu R}. With u corrected as de Saxce and Feng do ("The
/// bipotential method", 1998), by max(gap_i, 0) / h + mu (|u_T| + L |u_w|) at the normal rows, the residual of a patch
/// is that of the natural map, |r - P_K(r - m u)| / m, a velocity and zero exactly at a solution. m is the harmonic
/// mean of the effective masses of the patch's rows: one number a patch, so that P_K is the orthogonal projection.
///
/// The norm of the free u counts the gaps but not friction's term: of all points that would close within the substep,
/// and of the rows of friction of the patches that have such a point.
///
/// Without friction there are no rows of friction, and with L = 0 none of spin. Throws Error on a body that is not
/// there, a patch without points or with more than 4, friction or radius < 0, a torsional impulse where L = 0, substep
/// <= 0.
ResidualReport measure_contact_residual(const ContactProblem& problem);

/// From the poses alone, in double, by code that shares nothing with the solver. Poses know angles up to full turns:
/// beyond a range is what no number of turns brings back into it. Of a gear they tell nothing. A joint counts once for
/// max, mean and rms: by the length of the vector of its locked offsets (of a rod, its length's error). Throws Error on
/// a body that is not there.
JointDriftReport measure_joint_drift(std::span<const PlacedJoint> joints, std::span<const BodyState> states);

MotionReport measure_motion(std::span<const MovingBody> bodies, const Vector3& gravity);

}  // namespace atl
