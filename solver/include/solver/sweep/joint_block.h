#pragma once

#include <solver/integrate/solver_bodies.h>

#include <cstdint>

namespace atl::solver {

/// m/s or rad/s: as good as unlimited, and its sums and differences are finite.
inline constexpr float unlimited_speed = 1e30f;

/// Eight joints of one colour, one a lane, for the wide kernels: no two share a dynamic body. All of them hold the
/// origins of their frames together, or none does; and all have rows beside (JointRowBlock), or none has. A lane
/// without a joint holds zeros.
///
/// Arms and the offset of the origins are of world axes. They follow the bodies' displacements, so a joint is right
/// at the end of a step as at its start. So does the inertia of bodies that nothing touches; of others it is that which
/// contacts see.
struct alignas(64) JointBlock {
  template <std::size_t n>
  using Lanes = float[n][block_lanes];

  std::int32_t first[block_lanes];  ///< index into SolverBodies
  std::int32_t second[block_lanes];

  // The members from here on are set in blocks with a point, by the last sweep that refreshed them.
  Lanes<3> arm_first;  ///< m, of the frame's origin from the centre of mass
  Lanes<3> arm_second;
  Lanes<3> offset;              ///< m, from the first frame's origin to the second's
  Lanes<6> mass;                ///< kg, inverse of K = J M^-1 J^T: xx, yy, zz, xy, xz, yz
  Lanes<3> impulse;             ///< N s, on the second body
  Lanes<3> inverse_mass_first;  ///< 1/kg, along the world's axes: 0 where a body is locked
  Lanes<3> inverse_mass_second;
  Lanes<3> carried_first;  ///< N m s, see joint_sweep-inl.h: what turning made of the impulses that are carried over
  Lanes<3> carried_second;

  float bias_rate[block_lanes];  ///< its Softness
  float mass_scale[block_lanes];
  float impulse_scale[block_lanes];

  Lanes<3> start_arm_first;  ///< at the start of the step
  Lanes<3> start_arm_second;
  Lanes<3> start_offset;
  Lanes<3> carried_linear;  ///< N s, of blocks with rows

  std::int32_t joint[block_lanes];  ///< -1 in a lane without one
  std::uint32_t first_row;          ///< in the array of JointRowBlocks, where the block's lie one after another
  std::uint8_t rows;                ///< most of its lanes
  std::uint8_t point;               ///< 1 if the origins stay together
  std::uint8_t write_first;         ///< bit a lane: the first body is dynamic
  std::uint8_t write_second;
  std::uint8_t looks_back;  ///< 1 if a law of its rows does: sweeps note the rates that rows leave
};

/// One coordinate of each joint of a block: its row of the Jacobian (see joint_coordinates.h) and its law, as numbers
/// that are the same for all laws.
///
/// Let u0 be the rate without this row's impulse and w = J M^-1 J^T. A spring makes of it scale * u0 + shift, a motor
/// then brings it as near to its speed as its force lets it, or a servo by a part of the way, dry friction takes all it
/// has off what that leaves or holds it at 0, and a limit keeps the rest in [lower_speed, upper_speed]. Where a limit
/// is exceeded, sweeps with a bias put the speed that a soft spring at it would leave in place of the bound. What is
/// locked is exceeded on both sides, by as much as it is off. A row that does nothing, as those of lanes with fewer
/// than the block, has mass 0.
struct alignas(64) JointRowBlock {
  template <std::size_t n>
  using Lanes = float[n][block_lanes];

  Lanes<3> linear;  ///< on the second body; the opposite on the first
  Lanes<3> angular_first;
  Lanes<3> angular_second;
  float impulse[block_lanes];       ///< N s or N m s
  float mass[block_lanes];          ///< 1 / w
  float inverse_mass[block_lanes];  ///< w

  float spring_scale[block_lanes];
  float spring_shift[block_lanes];      ///< m/s or rad/s
  float motor_part[block_lanes];        ///< of the way to its speed: 1, or less of a servo
  float motor_speed[block_lanes];       ///< from where the substep starts
  float next_motor_speed[block_lanes];  ///< and where the next one does
  float motor_change[block_lanes];      ///< largest change of the rate by the motor
  float friction_change[block_lanes];   ///< and friction
  float lower_speed[block_lanes];
  float upper_speed[block_lanes];
  /// 1 where sweeps without a bias leave the ends of the range alone: of what bounces there, and has yet to arrive.
  float open_ends[block_lanes];

  float soft_lower[block_lanes];  ///< 1 where the lower end is exceeded, or the coordinate locked
  float soft_upper[block_lanes];
  float soft_scale[block_lanes];
  float soft_shift[block_lanes];
  float soft_motor_part[block_lanes];
  float soft_motor_change[block_lanes];
  float soft_friction_change[block_lanes];

  float rate[block_lanes];  ///< m/s or rad/s, as the row last left it, where the block looks back
};

/// Frames of a block's joints as the step begins, of blocks with rows: what lanes find coordinates from.
struct alignas(64) JointFrameBlock {
  template <std::size_t n>
  using Lanes = float[n][block_lanes];

  Lanes<4> axes_first;       ///< x, y, z, w: from the first frame to the world
  Lanes<4> turn;             ///< from the second frame to the first
  float ratio[block_lanes];  ///< of gears
};

/// Coordinate and law of each joint of a block, of which a row is made in each substep; springs and servos are looked
/// up in the joint. Positions and ends of ranges count from `base`, so single precision is enough for them: it is the
/// full turn next to the position as the step begins, or the position of what is a rate only.
struct alignas(64) JointCoordinateBlock {
  float coordinate[block_lanes];  ///< Coordinate as a number, -1 in lanes without a row
  float locked[block_lanes];      ///< 1
  float idles[block_lanes];       ///< 1 where nothing acts but the ends of its range
  float fades[block_lanes];       ///< 1 of a turn that does, see law_row()
  float base[block_lanes];        ///< m or rad
  float lower[block_lanes];
  float upper[block_lanes];
  float motor_speed[block_lanes];
  float motor_impulse[block_lanes];     ///< N s or N m s, the most of a substep
  float friction_impulse[block_lanes];  ///< likewise

  float position[block_lanes];  ///< found: as of the pose that bodies have now, over full turns
  float value[block_lanes];     ///< the value that the law sees
  float share[block_lanes];
  float response[block_lanes];  ///< J M^-1 J^T if the joint didn't hold

  // The law of a spring or armature in a substep: an impulse of spring_impulse - spring_slope * rate. Once bodies have
  // moved, rows answer otherwise to an impulse. It stays what it is, since a force that changed with that would be no
  // derivative of the spring's energy: it would whirl where rows change fast.
  float spring_impulse[block_lanes];  ///< N s or N m s
  float spring_slope[block_lanes];    ///< kg or kg m^2
  float servo_slope[block_lanes];     ///< likewise of a servo, 0 without one

  std::uint32_t kinds;   ///< bit a Coordinate that there is in some lane
  std::uint8_t springs;  ///< bit a lane: with a spring, a servo or an armature
};

/// Additional data of a row if joints are closed by separate velocities (split impulse).
struct alignas(64) SplitRowBlock {
  float impulse[block_lanes];  ///< N s or N m s, of this substep
};

}  // namespace atl::solver
