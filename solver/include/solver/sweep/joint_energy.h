#pragma once

#include <jobs/arrays.h>
#include <solver/integrate/solver_bodies.h>
#include <solver/sweep/group_joints.h>
#include <solver/sweep/group_tendons.h>
#include <solver/sweep/joined_motion.h>
#include <solver/sweep/kernels.h>

#include <cstdint>
#include <vector>

namespace atl::solver {

/// Keeps swept joints from making energy. The velocities that joints allow and that are nearest to those without
/// joints, by kinetic energy, can only have less of it. So impulses that raise it come from sweeps that haven't
/// converged, as when light links hold heavy ones by long arms. All impulses are then scaled down until the energy is
/// as it was; the joints stretch instead. Springs and motors act as forces, ahead of that. Velocities that close gaps
/// may have more, but no more than their mass would have at a speed at which gaps may close: joints that the sweeps
/// have lost hold of would throw what hangs on them.
///
/// Applies to components of joined bodies on which nothing else acts: nothing touches them, and no moving anchor leads
/// them.
class JointEnergy {
 public:
  /// Bounds the energy of a substep's velocities: of those that close gaps at up to `speed` (m/s), or with 0 of those
  /// that it ends with, before bounces. `bodies` are rows of SolverBodies from `first_dynamic` on.
  void bound(const JoinedMotion& motion, const JointStep& step, const Kernels& kernels, std::uint32_t first_dynamic,
             double speed, SolverBodies& bodies, GroupJoints& joints, GroupTendons& tendons);

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(components_, forced_, work_); }

 private:
  void find_forced(const JointStep& step, const GroupJoints& joints, const GroupTendons& tendons);
  bool find_scales(const JoinedMotion& motion, std::uint32_t first_dynamic, double speed);
  // The scale of a body's impulses, by its place in the group: 1 if they are not changed.
  float scale_of(const JoinedMotion& motion, std::size_t body) const {
    return motion.is_joined(body) ? components_[motion.component_of(body)].scale : 1;
  }
  void scale(const JoinedMotion& motion, std::uint32_t first_dynamic, SolverBodies& bodies) const;

  // J: of impulses scaled by s, linear s + square s^2 is added to the energy before, and may be as much as `allowed`.
  struct Change {
    double before = 0, linear = 0, square = 0, allowed = 0;
    float scale = 1;

    double greatest_scale() const;
  };

  std::vector<Change> components_;
  std::vector<VelocityRows> forced_;  // the changes by springs and motors; empty without any
  std::vector<WorkRow> work_;         // by body
};

}  // namespace atl::solver
