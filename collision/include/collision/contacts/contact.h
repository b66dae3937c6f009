#pragma once

#include <collision/broadphase/pair.h>
#include <collision/narrowphase/manifold.h>
#include <collision/shapes/pose.h>

#include <algorithm>
#include <array>
#include <cstdint>

namespace atl::collision {

/// The part of a contact that the solver reads and writes: rows of four floats, which kernels load for many contacts at
/// once by transposes. World axes; the normal points from the first shape to the second.
///
/// All points of a manifold share the normal, so a point is stored by its place in the tangent plane: (x, y) from the
/// centre, along the tangents that tangents() makes of the normal.
struct alignas(64) ContactManifold {
  float normal[3];
  float friction;         ///< Coulomb coefficient of the pair
  float anchor_first[3];  ///< m, of the centre from the first body's centre of mass
  float restitution;
  float anchor_second[3];
  float friction_radius;  ///< m, mean distance of the points from the centre: the arm of friction against twisting
  float x[max_points];
  float y[max_points];
  float separation[max_points];  ///< no_point where there is none
  /// N s, of the last substep. Negative of a point that has bounced: that is told, and is nothing to start from.
  float normal_impulse[max_points];
  float friction_impulse[3];  ///< N s, in the tangent plane, on the second body
  float torsional_impulse;    ///< N m s, about the normal, on the second body
};
static_assert(sizeof(ContactManifold) == 128);

/// So far apart that no speed closes it: such a point's impulse is always zero.
inline constexpr float no_point = 1e10f;

/// Leaves a manifold without impulses to start from, or to tell.
inline void forget_impulses(ContactManifold& manifold) {
  std::fill_n(manifold.normal_impulse, max_points, 0.0f);
  std::fill_n(manifold.friction_impulse, 3, 0.0f);
  manifold.torsional_impulse = 0;
}

/// N s, of a point's normal_impulse: with which the next step starts.
inline float kept_impulse(float impulse) { return impulse > 0 ? impulse : 0; }

/// Two unit vectors that make a right-handed frame with a unit normal (t1 x t2 = n). Duff et al., "Building an
/// orthonormal basis, revisited", JCGT 2017. The kernels do the same operations in the same order.
struct Tangents {
  std::array<float, 3> first;
  std::array<float, 3> second;
};
Tangents tangents(const float normal[3]);

/// A pair and what its manifold was when the narrowphase last computed it, in the frames of its shapes, so that
/// separations can follow small motion in closed form. "Incident" and "reference" as in Manifold. Rows of four floats
/// are for kernels. The first cache line is all that is read of a pair that stays apart.
struct alignas(64) Contact {
  Pair pair;  ///< colliders
  std::uint32_t body_first = 0;
  std::uint32_t body_second = 0;
  float size = 0;  ///< m, inner radius of the smaller shape: tolerances are parts of it
  bool reference_is_second = false;
  std::uint8_t count = 0;
  /// The number of this contact among the contacts of a solid and a surface. A pair with a surface has a fixed row of
  /// them, each with a normal of its own; the unused ones have no points.
  std::uint8_t part = 0;
  bool has_local_offset : 1 = false;  ///< a shape of it isn't at its body's centre of mass, or turned
  bool recycles : 1 = false;          ///< its tolerance isn't 0
  bool on_face : 1 = false;           ///< see Manifold
  /// A lower bound (m) of the distance between two solids that were found apart, else 0. The next three members say
  /// where the solids were at that time.
  float gap = 0;
  float radius = 0;                       ///< m: how far turning by 1 rad may bring the shapes nearer
  std::array<double, 3> apart_from = {};  ///< m, world: origin of the second shape from the first's
  double turned = 0;                      ///< sum of how much the bodies had turned in all

  std::array<float, 4> orientation = {};  ///< x, y, z, w of incident in reference, as computed
  std::array<float, 3> normal = {};       ///< reference frame
  float margin = -1;                      ///< m, speculative, as computed; -1 before the first
  /// x, y, z (m, from the centre, in the reference frame) and the separation of each point, as computed.
  std::array<std::array<float, 4>, max_points> points = {};
  /// m, mean of the points, incident frame; the incident's origin where there are none.
  std::array<double, 3> centre_incident = {};
  std::array<double, 3> centre_reference = {};  ///< m, the same point in the reference frame, as computed
  std::array<FeatureId, max_points> ids = {};
  float tolerance = 0;  ///< how far the pair may drift, as part of the size, and turn, rad, before it is recomputed
  std::uint32_t axis = 0;
  std::uint8_t material = 0;  ///< the number of that of a surface's triangles

  void set_tolerance(float value) {
    tolerance = value;
    recycles = value > 0;
  }
};
static_assert(sizeof(Contact) == 256);

/// Stores the features of a manifold, which may have no points, computed with the given margin. The former features are
/// lost: match impulses before. `incident` is the pose of the incident shape in the frame of the reference. `tolerance`
/// says for how long the manifold may be recycled, see Contact.
void store_features(Contact& contact, const Manifold& manifold, const Pose& incident, double margin, float tolerance);

}  // namespace atl::collision
