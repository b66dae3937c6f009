#pragma once

#include <jobs/arrays.h>
#include <jobs/block_lanes.h>
#include <solver/integrate/body_table.h>
#include <solver/integrate/motion_locks.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace atl::solver {

using jobs::block_lanes;

// The hot state of an island group's bodies, in rows of four floats that kernels load for several bodies at
// once by transposes. Velocities are of the world frame. Displacements and velocities are changes since the start of
// the step, so single precision is enough however far from the origin a body is, and however many small changes a
// velocity has: rounded at its own size, each would take it the same way.

struct alignas(32) VelocityRows {
  float linear[3];   ///< m/s
  float inertia_xx;  ///< of the inverse inertia, world frame, 1/(kg m^2); it rides along
  float angular[3];  ///< rad/s
  float inertia_yy;
};

struct alignas(16) InertiaRow {
  float zz, xy, xz, yz;  ///< the rest of the inverse inertia
};

struct alignas(32) DisplacementRows {
  float linear[3];    ///< m
  float carries;      ///< 1 if contact points turn with the body; 0 for a ball, on which they stay behind
  float rotation[4];  ///< x, y, z, w, world frame
};

/// Velocity at the start of the substep, before constraints, since the start of the step: what they changed since is
/// what warm-starts the next substep.
struct alignas(32) FreeVelocityRows {
  float linear[3];
  float inverse_mass;  ///< 1/kg
  float angular[3];
  float unused;
};

struct alignas(32) AccelerationRows {
  float linear[3];        ///< m/s^2, with the damping of the speed that the step begins with
  float linear_damping;   ///< factor a substep
  float angular[3];       ///< rad/s^2, likewise
  float angular_damping;  ///< factor a substep
};

/// The terms of Euler's equations for a body with unequal moments of inertia, which tumbles.
struct alignas(16) GyroscopicRows {
  float principal[4] = {0, 0, 0, 1};  ///< x, y, z, w: orientation of its principal axes at the start of the step
  float ratio[3] = {0, 0, 0};         ///< (I2 - I3) / I1, (I3 - I1) / I2, (I1 - I2) / I3
  float active = 0;                   ///< 1, or 0 where the moments are equal
  float moment[4] = {1, 1, 1, 0};     ///< kg m^2

  /// `axes` of the world frame.
  static GyroscopicRows of(const Quaternion& axes, const Vector3& moment) {
    GyroscopicRows rows;
    for (int k = 0; k < 4; ++k) rows.principal[k] = static_cast<float>(axes.coeffs()[k]);
    for (int k = 0; k < 3; ++k) {
      rows.ratio[k] = static_cast<float>((moment[(k + 1) % 3] - moment[(k + 2) % 3]) / moment[k]);
      rows.moment[k] = static_cast<float>(moment[k]);
    }
    rows.active = 1;
    return rows;
  }
};

/// The axes of the world along which a body may move.
struct alignas(16) LockRow {
  float free[3] = {1, 1, 1};  ///< 1, or 0 along a locked one
  float kind = 0;             ///< 1, 2, 3 if it stays in its plane across x, y, z; -1 if it may turn about all axes,
                              ///< else -2; 0 unless dynamic

  static LockRow of(std::uint8_t locks) {
    LockRow row;
    for (unsigned k = 0; k < 3; ++k) row.free[k] = linear_locks(locks) >> k & 1u ? 0.0f : 1.0f;
    const int plane = plane_of(locks);
    row.kind = plane >= 0 ? static_cast<float>(plane + 1) : angular_locks(locks) == 0 ? -1.0f : -2.0f;
    return row;
  }
};

/// The way in which the contacts on a body move along as it turns.
struct alignas(16) ShapeRows {
  float half_turn[3] = {0, 0, 0};  ///< rad: that half way through the step, as expected when it begins
  float kind = 0;  ///< 0: turns too little in the step to matter, 1: turns, 2: turns and has round shapes
};

/// The change of a velocity by impacts since the start of the step: at once, where forces act over time.
struct alignas(32) BlowRows {
  float linear[4] = {0, 0, 0, 0};   ///< m/s
  float angular[4] = {0, 0, 0, 0};  ///< rad/s
};

/// Rows that groups have only if they need them.
struct OptionalRows {
  bool gyroscopic = false;
  bool correction = false;
  bool locks = false;
  bool shape = false;
  bool blow = false;
};

/// Bodies of one island group. Index 0 stands for every fixed body and is never written; copies of kinematic
/// bodies follow, then the islands' dynamic bodies. The count is padded to full blocks.
struct SolverBodies {
  std::vector<VelocityRows> velocity;  ///< since the start of the step
  std::vector<InertiaRow> inertia;
  std::vector<DisplacementRows> displacement;
  std::vector<FreeVelocityRows> free_velocity;
  std::vector<VelocityRows> start_velocity;  ///< at the start of the step, with the inertia of that time
  std::vector<AccelerationRows> acceleration;
  std::vector<GyroscopicRows> gyroscopic;  ///< empty if no body needs it
  std::vector<VelocityRows> correction;    ///< by which overlap is removed in this substep; empty where nothing asks
  std::vector<LockRow> locks;              ///< empty if no body has motion locks
  std::vector<ShapeRows> shape;            ///< empty if contacts stay where they are on all bodies in the step
  std::vector<BlowRows> blow;              ///< empty if nothing bounces
  bool roll = false;                       ///< some of them are of kind 2
  bool balls = true;                       ///< some body may be one (see DisplacementRows::carries)

  void reset(std::size_t count, const OptionalRows& with) {
    const std::size_t padded = (count + block_lanes - 1) / block_lanes * block_lanes;
    velocity.assign(padded, {});
    inertia.assign(padded, {});
    displacement.assign(padded, {{0, 0, 0}, 1, {0, 0, 0, 1}});
    free_velocity.assign(padded, {});
    start_velocity.assign(padded, {});
    acceleration.assign(padded, {{0, 0, 0}, 1, {0, 0, 0}, 1});
    gyroscopic.assign(with.gyroscopic ? padded : 0, {});
    correction.assign(with.correction ? padded : 0, {});
    locks.assign(with.locks ? padded : 0, {});
    shape.assign(with.shape ? padded : 0, {});
    blow.assign(with.blow ? padded : 0, {});
    roll = false;
  }
  /// See jobs/arrays.h.
  auto arrays() const {
    return std::tie(velocity, inertia, displacement, free_velocity, start_velocity, acceleration, gyroscopic,
                    correction, locks, shape, blow);
  }
  std::size_t padded_count() const { return velocity.size(); }
};

}  // namespace atl::solver
