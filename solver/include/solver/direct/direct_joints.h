#pragma once

#include <jobs/arrays.h>
#include <solver/direct/joint_assembly.h>
#include <solver/direct/joint_matrix.h>
#include <solver/integrate/motion.h>

#include <cstdint>
#include <span>
#include <vector>

namespace atl::solver {

/// What the stages of a substep work on.
struct DirectInput {
  Joint* joints;           ///< by index
  const BodyTable& table;  ///< as of the start of the step
  SolverBodies& bodies;
  double h;  ///< s
};

/// Joints that hang together (JointAssembly), solved at once: J M^-1 J^T (JointMatrix) is factored in double at the
/// poses of every substep, in linear time where joints make no loop (Baraff, "Linear-time dynamics using Lagrange
/// multipliers", SIGGRAPH 1996).
///
/// A substep is one of RATTLE (Andersen, "Rattle: a velocity version of the Shake algorithm", J. Comput. Phys. 1983):
/// impulses along the rows of its start bring the positions at its end onto the constraint, and others along the rows
/// of its end the velocities. It is of second order and symplectic, so nothing is damped, and nothing stretches,
/// whatever the ratio of masses.
///
/// What tension adds to a body's inertia (arm_stiffness.h) keeps light links still under heavy loads.
///
/// Limits, motors and springs are rows of the same system; which of them hold is found by a few rounds from what held
/// in the substep before.
class DirectJoints {
 public:
  /// Takes the joints in. Returns false if loops would fill the factor to more than a few blocks a joint.
  bool analyse(std::span<const JointLink> links, std::span<const Joint> joints, const BodyTable& table);

  /// Where the bodies of the joints are among the solver's, before a step. `local(body)`.
  template <typename Local>
  void locate(const Local& local) {
    for (JointMember& member : assembly_.members) member.local = local(member.body);
  }
  void begin_step(const DirectInput& input);

  /// Before the half of a substep's forces is taken away or given back, by which velocities in a step are behind
  /// positions.
  void note_rates(const DirectInput& input);
  /// After that: what springs, servos, motors and joints do in that half. -1 as the step begins, 1 as it ends.
  void kick(const DirectInput& input, int sign);
  /// Once the velocities that the first substep starts with are there.
  void start(const DirectInput& input);
  void begin_substep();
  /// After forces: velocities that keep the joints at the present poses, springs, motors and limits.
  void solve_velocities(const DirectInput& input);
  /// After bodies have moved: takes them back to where the joints hold, with the velocities that this means.
  void solve_positions(const DirectInput& input);
  /// After that: velocities that keep the joints at the new poses.
  void relax(const DirectInput& input);
  /// Writes impulses, forces and limits to the joints.
  void end_step(const DirectInput& input);
  /// After that: velocities that keep the joints, after what else changed them.
  void project(const DirectInput& input);
  /// Once poses have been written back: takes them where the joints hold, if they are not. Notes how the bodies moved
  /// in the step, of dt seconds.
  void settle(const DirectInput& input, BodyTable& table, collision::MotionBounds& bounds, double dt, FastBodies& fast);

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(assembly_, matrix_, b_, tears_); }

 private:
  void place(const DirectInput& input);
  void factor_laws(const DirectInput& input);
  void start_laws(const DirectInput& input);
  void close_gaps(const DirectInput& input);
  void note_armature(const DirectInput& input, double times);
  void solve_laws(int rounds, const DirectInput* impacts);
  void solve_and_apply();
  template <typename Solve>
  void solve_passively(const Solve& solve);
  bool solve_within(double far, double h);

  JointAssembly assembly_;
  JointMatrix matrix_;
  std::vector<double> b_;      // m/s or rad/s that rates are to change by, and then N s or N m s
  std::vector<double> tears_;  // likewise, of what was apart as the substep began
  bool acts_ = false;          // some row has a spring, a motor or an armature
  bool looks_back_ = false;    // some row's impulse depends on the rate before
  bool rotors_ = false;        // some row has an armature
  bool bounces_ = false;       // some row may, at an end of its range
  bool late_ = false;          // velocities are half a substep behind positions
  bool torn_ = false;          // something was apart as the substep began
};

}  // namespace atl::solver
