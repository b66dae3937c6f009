#pragma once

#include <jobs/arrays.h>
#include <solver/constraints/joint.h>
#include <solver/constraints/law_mode.h>
#include <solver/integrate/body_table.h>
#include <solver/integrate/solver_bodies.h>
#include <solver/islands/islands.h>

#include <cstdint>
#include <span>
#include <vector>

namespace atl::solver {

/// A body of an assembly.
struct JointMember {
  std::uint32_t body;
  std::uint32_t local;  ///< among the solver's bodies
  double inverse_mass;
  bool dynamic;
  Vector3 start, position;                    ///< m
  Quaternion start_turn, turn;                ///< orientations
  Matrix3 inertia;                            ///< kg m^2, world frame
  Matrix3 stiffness;                          ///< N m, geometric
  Matrix3 inverse_inertia = Matrix3::Zero();  ///< 1/(kg m^2), world frame, with a share of the stiffness
  Vector3 velocity, spin;                     ///< m/s, rad/s
  Quaternion next_turn;                       ///< as it would be at the substep's end
  Vector3 velocity_before, spin_before;       ///< as they were loaded
  Vector3 impulse, angular_impulse;           ///< N s, N m s
};

/// A row of a joint beside its point.
struct AssemblyRow {
  JointRow at;
  LawMode mode;
  double impulse;          ///< N s or N m s, in this substep
  double impulse_before;   ///< likewise, as velocities were loaded
  double position;         ///< m or rad
  double mass;             ///< kg or kg m^2, effective
  double bend;             ///< m/s or rad/s, see note_bends()
  double rate_before = 0;  ///< m/s or rad/s, as the substep begins, before its forces
  double unpaid = 0;       ///< N s or N m s: what the armature is to pay, see DirectJoints::note_armature()
  LimitImpact impact;
  bool bounces = false;  ///< at that end, in this substep

  /// Where it is held, locked or at an end of the range.
  double bound(const Law& law) const { return mode.limit() > 0 ? law.upper : law.lower; }
};

/// A joint of an assembly.
struct JointNode {
  std::uint32_t joint;
  std::uint32_t first, second;  ///< members
  bool point;
  std::uint32_t begin, end;  ///< rows beside the point
  Vector3 arm_first, arm_second;
  Vector3 bend;            ///< m/s, see note_bends()
  Vector3 offset;          ///< m, of the origins, as the substep begins
  Vector3 impulse;         ///< of the point, in this substep
  Vector3 impulse_before;  ///< likewise, as velocities were loaded
  Vector3 tension;         ///< N, followed over some substeps

  bool is_point_only() const { return point && begin == end; }
};

/// Joints that hang together, and their bodies, as they move through a substep.
struct JointAssembly {
  std::vector<JointMember> members;  ///< in order of bodies
  std::vector<JointNode> nodes;
  std::vector<AssemblyRow> rows;

  static JointAssembly of(std::span<const JointLink> links, std::span<const Joint> joints, const BodyTable& table);

  /// m/s: of the second frame's origin against the first's.
  Vector3 point_speed(const JointNode& node) const {
    const JointMember& a = members[node.first];
    const JointMember& b = members[node.second];
    return (b.velocity + b.spin.cross(node.arm_second)) - (a.velocity + a.spin.cross(node.arm_first));
  }
  double row_speed(const JointNode& node, const AssemblyRow& row) const {
    const JointMember& a = members[node.first];
    const JointMember& b = members[node.second];
    return row.at.rate(a.velocity, a.spin, b.velocity, b.spin);
  }
  JointFrames frames_of(const Joint& joint, const JointNode& node) const {
    const JointMember& first = members[node.first];
    const JointMember& second = members[node.second];
    return joint_frames(joint, first.position, first.turn, second.position, second.turn);
  }
  /// An impulse along a row, on the second body.
  void apply(const JointNode& node, const JointRow& row, double impulse);

  void load_velocities(const SolverBodies& bodies);
  /// Of positions that are closed for themselves.
  void load_no_velocities();
  /// Not to be carried over into the next substep: there the impulses act along other rows.
  void store_velocities(SolverBodies& bodies) const;

  /// Whether what was gained in h seconds since velocities were loaded would take a body so far that no row is true
  /// there: near where rows are singular the solution of the linear system says nothing of where joints close.
  bool moves_far(double h, double far) const;
  /// Takes back what was gained since velocities were loaded.
  void take_back();
  /// Whether the kinetic energy of bodies and armatures has grown since velocities were loaded by more than springs,
  /// servos and motors have done, and tuning::energy_tolerance of it. Armatures turn at the rates of their rows, and by
  /// what they have not yet paid for where they `owe` it before or after.
  bool makes_energy(const Joint* joints, bool owes_before, bool owes_after) const;
  /// Leaves out what tension adds to inertia.
  void leave_out_tension();
  /// Moves bodies by what was gained since velocities were loaded.
  void move_bodies(SolverBodies& bodies, double h) const;

  /// Where bodies are now.
  void place_members(const SolverBodies& bodies);
  /// Arms, rows and coordinates there, and inertia, with what tension makes of it in h seconds.
  void place_joints(const Joint* joints, const BodyTable& table, double h);

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(members, nodes, rows); }
};

}  // namespace atl::solver
