#pragma once

#include <collision/contacts/contact.h>
#include <solver/integrate/solver_bodies.h>

#include <cstdint>

namespace atl::solver {

using collision::max_points;

/// The sides of a block's contacts whose bodies may move; the others are fixed. Locked means Both, where some bodies
/// may move along some axes only. Kernels use it; in blocks ContactTraits::locked says so.
enum class MovableSides : std::uint8_t { Both, First, Second, Locked };

/// The features that some contact of a block has in this step. Kernels leave out the work of the others, which would
/// change no bit.
struct ContactTraits {
  std::uint8_t points = max_points;  ///< no contact has more
  bool friction = true;
  bool bounces = true;
  bool locked = true;  ///< some body is locked along an axis, and not all that may move stay in one plane
  bool rims = false;   ///< some contact has one: found before the others, and kept
};

/// Eight contacts of one colour, one a lane, for the wide kernels: no two share a dynamic body.
///
/// The points of a manifold share the normal, so all four are solved in three relative speeds: along the
/// normal at the centre (u), and of spin about the two tangents (w1, w2). Point i closes at
/// u + y_i w1 - x_i w2, and K maps impulses to changes of the three. Lanes without a contact hold zeros and
/// K00 = 1.
struct alignas(64) ContactBlock {
  template <std::size_t n>
  using Lanes = float[n][block_lanes];

  std::int32_t first[block_lanes];  ///< index into SolverBodies
  std::int32_t second[block_lanes];
  Lanes<3> normal;
  Lanes<3> tangent;       ///< the first; the second is normal x tangent
  Lanes<3> anchor_first;  ///< half way through the step
  Lanes<3> anchor_second;
  Lanes<3> start_normal;   ///< u, w1 and w2 as the step begins, m/s and rad/s
  Lanes<3> start_tangent;  ///< likewise slip along the tangents, m/s, and spin about the normal, rad/s
  Lanes<4> x;
  Lanes<4> y;
  Lanes<4> start_separation;  ///< at the start of the step
  Lanes<4> separation;        ///< at the last sweep that refreshed it
  Lanes<4> normal_impulse;
  Lanes<6> k;  ///< 00, 01, 02, 11, 12, 22
  Lanes<2> inverse_mass;
  Lanes<2> friction_impulse;
  float torsional_impulse[block_lanes];
  Lanes<3> friction_mass;  ///< inverse of the tangential 2 x 2 matrix: 11, 12, 22
  float twist_mass[block_lanes];
  float friction[block_lanes];
  float friction_radius[block_lanes];
  float push_speed[block_lanes];     ///< m/s, the fastest that overlap is pushed apart
  float bias_rate[block_lanes];      ///< of its Softness
  float impulse_scale[block_lanes];  ///< likewise; the scale of the mass is what is left of 1
  std::int32_t slot[block_lanes];    ///< of the contact; -1 in a lane without one
  std::uint8_t write_first;          ///< bit a lane: the first body is dynamic
  std::uint8_t write_second;
  std::uint8_t contacts;  ///< lanes with one
  MovableSides movable;
  ContactTraits traits;
};

/// Counts of contacts by the work that kernels did for them, by blocks.
struct ContactWork {
  std::int64_t contacts = 0;
  std::int64_t several_points = 0;
  std::int64_t two_movable = 0;
  std::int64_t friction = 0;
  std::int64_t bounces = 0;

  void add(const ContactBlock& block) {
    contacts += block.contacts;
    if (block.traits.points > 1) several_points += block.contacts;
    if (block.movable == MovableSides::Both) two_movable += block.contacts;
    if (block.traits.friction) friction += block.contacts;
    if (block.traits.bounces) bounces += block.contacts;
  }
  ContactWork& operator+=(const ContactWork& other) {
    contacts += other.contacts;
    several_points += other.several_points;
    two_movable += other.two_movable;
    friction += other.friction;
    bounces += other.bounces;
    return *this;
  }
};

/// Additional data of a block if its group has restitution.
struct alignas(64) BounceBlock {
  float separation[4][block_lanes];  ///< m, as the substep begins: of what flies as far as it gets
  float spent[4][block_lanes];       ///< N s, of bounces of this step, which are not carried over
  float restitution[block_lanes];
  std::uint8_t closes;  ///< bit a lane: some point may bounce in this substep
};

/// Additional data of a block if surfaces in its group move along, or resist rolling or spinning.
struct alignas(64) SurfaceBlock {
  template <std::size_t n>
  using Lanes = float[n][block_lanes];

  Lanes<2> slip;                ///< m/s, along the tangents
  Lanes<3> spin;                ///< rad/s, about the tangents and the normal
  Lanes<2> rolling_impulse;     ///< N m s, about the tangents
  Lanes<3> rolling_mass;        ///< inverse of the tangential 2 x 2 matrix of spins: 11, 12, 22
  Lanes<1> rolling_friction;    ///< m
  Lanes<1> torsional_friction;  ///< m
  Lanes<1> cosine;              ///< of the direction of most friction, along the tangents
  Lanes<1> sine;
  Lanes<1> ratio;  ///< of the friction across that direction, to that along it
  Lanes<1> rise;   ///< m/s, of the surface along the normal, at the end of the step; the opposite at its start
};

/// Additional data of a block if bodies of its group have motion locks. A contact of bodies that stay in one plane has
/// at most two points, its first.
struct alignas(64) PlanarBlock {
  float planar[block_lanes];    ///< 1 for such a contact, else 0
  float point[2][block_lanes];  ///< which of the manifold's points they are; -1 if there is none
};

/// The pivots of a block's contacts as the step begins (ContactArm), and how far their planes turn in half of it, kept
/// if bodies of its group turn. Without rims the pivots are where the contacts are.
struct alignas(64) TurningBlock {
  float plane_turn[3][block_lanes];   ///< rad
  float pivot_first[3][block_lanes];  ///< m, from the body's centre of mass
  float pivot_second[3][block_lanes];
};

/// The rims of a block's contacts and their axes, kept if bodies of its group roll. It holds nothing for blocks
/// without.
struct alignas(64) RimBlock {
  float rim_first[3][block_lanes];  ///< m
  float rim_second[3][block_lanes];
  float axis_first[3][block_lanes];
  float axis_second[3][block_lanes];
};

/// The part of their carried impulses that contacts begin a substep with, where a body was struck. Sweeps go downhill
/// in the work that impulses do against the free motion plus the energy of the change that they make (the dual problem
/// of Gauss's principle; Moreau, "Quadratic programming in mechanics: dynamics of one-sided constraints", SIAM Journal
/// on Control 4, 1966). They would begin at 0 without impulses. A contact whose impulses add more than 0 is better off
/// with less of them: after an impact they would stop again what has stopped since, and few sweeps leave the bodies
/// some of that energy. So they are scaled to where its share of the sum is least.
struct alignas(64) FittingBlock {
  float scale[block_lanes];
  bool any;  ///< some body of the block was struck; else scales are not set, and 1
};

/// Additional data of a block if overlap is removed by separate velocities (split impulse).
struct alignas(64) SplitBlock {
  float impulse[4][block_lanes];  ///< N s, of this substep
};

}  // namespace atl::solver
