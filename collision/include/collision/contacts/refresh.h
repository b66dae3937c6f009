#pragma once

#include <collision/contacts/contact.h>
#include <jobs/block_lanes.h>

#include <array>

namespace atl::collision {

using jobs::block_lanes;

/// The motion of a body in a step, in a row that kernels load: of its centre, and of its surface by turning, in m.
struct alignas(16) StepReach {
  float shift[3];
  float turn;
};

/// A block of up to eight contacts whose separations are to follow the motion of their shapes, one a lane. Poses are of
/// the shapes in the world. Unused lanes repeat a used one.
struct RefreshBlock {
  template <typename T>
  using Lanes = std::array<T, block_lanes>;

  Lanes<const Contact*> contact;
  Lanes<ContactManifold*> manifold;
  Lanes<const double*> position_reference;     ///< x, y, z, m
  Lanes<const double*> orientation_reference;  ///< x, y, z, w
  Lanes<const double*> position_incident;
  Lanes<const double*> orientation_incident;
  /// m, world, a row of four floats each: from the body's centre of mass to the shape's origin.
  Lanes<const float*> offset_reference;
  Lanes<const float*> offset_incident;
  Lanes<const StepReach*> reach_first;
  Lanes<const StepReach*> reach_second;
};

// A pair may drift this part of the smaller shape's size, and turn this far (rad), before its features are found
// anew. Separations stay exact for fixed features; what goes stale is where the outlines cross, by at most the
// drift. Chosen so that a resting scene keeps everything and a sliding box asks FCL every few millimetres.
inline constexpr float flat_tolerance = 2e-3f;
// The same for round shapes. While one rolls, the features themselves move over it, so only resting contacts are
// recycled.
inline constexpr float round_tolerance = 1e-5f;

/// Separation below which a pair gets contact points before it touches: part of the smaller shape's size, and
/// what the pair's speeds can close in one step (up to half that size), so that a contact is there in the
/// substep in which it is needed. 5% of the inner radius is 2.5 cm for a cube of 1 m: a resting neighbour across
/// a 2 cm gap is watched.
inline constexpr float margin_share = 0.05f;
inline constexpr float approach_share = 0.5f;
constexpr double speculative_margin(double size, double approach) {
  return margin_share * size + (approach < approach_share * size ? approach : approach_share * size);
}

}  // namespace atl::collision
