#pragma once

#include <solver/constraints/contact_arm.h>
#include <solver/constraints/contact_law.h>
#include <solver/constraints/joint.h>
#include <solver/constraints/row_law.h>
#include <solver/constraints/tendon.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace atl::solver {

/// The parts of one body in a vector of six numbers a body.
inline auto linear_part(const std::vector<double>& of, std::size_t body) {
  return Eigen::Map<const Vector3>(&of[6 * body]);
}
inline auto linear_part(std::vector<double>& of, std::size_t body) { return Eigen::Map<Vector3>(&of[6 * body]); }
inline auto angular_part(const std::vector<double>& of, std::size_t body) {
  return Eigen::Map<const Vector3>(&of[6 * body + 3]);
}
inline auto angular_part(std::vector<double>& of, std::size_t body) { return Eigen::Map<Vector3>(&of[6 * body + 3]); }

/// A body as a direct solve sees it.
struct DirectBody {
  std::uint32_t body = 0;
  std::uint8_t locks = 0;   ///< see motion_locks.h
  double mass = 0;          ///< kg
  double radius = 0;        ///< m, of gyration
  Vector3 inverse_mass;     ///< 1/kg, along the world's axes: 0 along those that are locked
  Matrix3 inertia;          ///< kg m^2, world frame
  Matrix3 inverse_inertia;  ///< likewise, on the axes that it may turn about
  Vector3 spin;             ///< rad/s, half way through the step, as far as it is foreseen
  Vector3 half_turn;        ///< rad, until then; zero where contacts don't move with the body

  /// Sets the mass, and its inverse along the axes that are free.
  void weigh(double mass_now, double inverse);

  /// N s and N m s: M times six numbers of velocity, linear and angular.
  std::array<double, 6> momentum(const double* velocity) const {
    const Vector3 linear = mass * Eigen::Map<const Vector3>(velocity);
    const Vector3 angular = inertia * Eigen::Map<const Vector3>(velocity + 3);
    return {linear[0], linear[1], linear[2], angular[0], angular[1], angular[2]};
  }
};

inline constexpr std::uint32_t no_body = ~std::uint32_t{0};  ///< a body without response

/// A contact between two bodies of a direct solve: its frame, and its law at the state of the solve. Velocities are six
/// numbers a body of the problem, linear and angular.
struct DirectContact {
  using Points = std::array<double, collision::max_points>;

  std::uint32_t slot;
  std::uint32_t first_body, second_body;  ///< of the world
  std::uint32_t first, second;            ///< bodies of the problem, or no_body
  std::array<Vector3, 3> axes;            ///< normal, tangents
  Vector3 arm_first, arm_second;          ///< m, from the centres of mass, half way through what is solved for
  ContactArm on_first, on_second;         ///< as the step begins
  Vector3 middle;                         ///< m, from that of its points: where it carries, of what rolls on a rim
  double line_turn;                       ///< rad, until the middle of the step, of what touches along a line
  double friction, rolling, torsional;    ///< of what the points push with: 1, m, m
  double radius;                          ///< m, at which friction acts about the normal
  ContactLaw law;
  Points mass;              ///< kg, effective, of each point
  Points separation;        ///< m
  Points start_separation;  ///< m, as the step began
  Six given;                ///< motion by what doesn't respond
  double approach;          ///< m/s, along the normal, of velocities and arms as the step begins
  Vector3 ahead;            ///< m/s, what arms come to make of the motion until the step's end
  Vector3 last_spin;        ///< rad/s, of the bodies against each other at the step's end, as far as it is foreseen
  bool lands;               ///< a point closes by more in the step than it is apart
  Six motion;               ///< at the velocities of the problem
  Six change;               ///< along its search direction
  ContactAnswer answer;
  ContactAnswer lasting;            ///< at the velocities that bodies keep
  ContactPieces factored;           ///< the pieces that the matrix was factored for
  bool factored_in_motion = false;  ///< it slid or rolled then: its stiffness holds for that motion alone

  void add_motion(double sign, const Vector3& arm, const Vector3& v, const Vector3& w, Six& to) const;
  /// The part of the motion at the contact that velocities of the problem's bodies cause.
  Six motion_by(const std::vector<double>& velocities) const;
  /// The motion at velocities, with what doesn't respond.
  Six motion_at(const std::vector<double>& velocities) const;
  /// Adds `sign` times an impulse on the second body, in the contact's frame, to the momenta of both.
  void add_impulse(const Six& impulse, double sign, std::vector<double>& to) const;
  /// Adds a velocity at the contact, world frame, to what doesn't respond.
  void give(const Vector3& velocity);
  bool fixed() const { return first == no_body || second == no_body; }  ///< against something of infinite mass
  void bound_friction(double load);
  Six motion_after(double t) const;  ///< of the way along the search direction
  Vector3 in_plane(const std::array<double, 2>& along_tangents) const {
    return along_tangents[0] * axes[1] + along_tangents[1] * axes[2];
  }
};

/// A term of a tendon of a direct solve: a coordinate of a joint between two bodies.
struct DirectTerm {
  std::uint32_t first_body, second_body;  ///< of the world
  std::uint32_t first, second;            ///< bodies of the problem, or no_body
  TermRow row;

  /// m/s or rad/s: what velocities, of bodies that respond, make of the coordinate.
  double rate_by(const double* velocities) const;
};

/// A joint between two bodies of a direct solve: its rows, those of the point first. Velocities are as in
/// DirectContact. The only row of a tendon acts on the bodies of its terms; its `at` has the length and no axes.
struct DirectJoint {
  template <typename Number>
  using Rows = std::array<Number, max_joint_rows>;

  std::uint32_t joint;
  std::uint32_t first_body, second_body;  ///< of the world
  std::uint32_t first, second;            ///< bodies of the problem, or no_body
  bool point;                             ///< the first three rows are those of a point, along the world's axes
  std::size_t rows;
  std::uint8_t locks;   ///< by row, a bit where its law does nothing but hold it
  std::uint8_t still;   ///< likewise where motion locks of bodies let nothing move: see find_still()
  Rows<JointRow> at;    ///< but for those of the point, which its arms tell: see row()
  Rows<double> mass;    ///< kg or kg m^2, effective; of locks where the matrix is by bodies
  Rows<double> joined;  ///< kg or kg m^2, of springs' coordinates with all that is joined, or 0: see weigh_joined()
  Rows<double> share;   ///< of the mass, that the coordinate's own springs move: see RowMass
  Vector3 arm_first, arm_second;
  Rows<double> position;  ///< m or rad
  Rows<double> gap;       ///< m or rad, from where it is held
  Rows<double> beyond;    ///< m or rad, out of its range, that is left to later substeps
  Rows<double> back;      ///< m/s or rad/s, at which bodies go back into a range, and don't keep it; else 0
  Rows<RowLaw> law;
  Rows<double> given;        ///< rate by what doesn't respond
  Rows<double> rate_before;  ///< at the start of the substep, before its forces
  Rows<double> bend;         ///< m/s or rad/s, of what is locked or has an armature: see find_bends()
  Rows<double> kept;         ///< rate that armatures have, whose bodies have moved since
  Rows<LimitImpact> impact;
  Rows<double> rate;       ///< at the velocities of the problem
  Rows<double> kept_rate;  ///< at the velocities which bodies keep, where they move by others
  Rows<double> change;     ///< along its search direction
  Rows<double> impulse;    ///< N s or N m s
  Rows<double> lasting;    ///< of the velocities which bodies keep
  Rows<double> closing;    ///< kg m or kg m^2, of the motion that closes gaps
  Rows<std::uint8_t> factored;
  Rows<std::int8_t> limit, motor_bound, friction_bound;  ///< see Joint
  Rows<bool> bounces;                                    ///< at that end, in this substep
  Vector3 tension;                                       ///< N, followed over some substeps
  std::array<DirectTerm, max_tendon_terms> term;
  std::size_t terms;

  bool is_tendon() const { return terms > 0; }
  /// The bodies of a tendon, by their numbers in the problem; those that don't respond are no_body.
  PulledBodies pulled() const;
  /// Moves the coordinates of its terms by `time` times their rates at these velocities.
  void move_terms(const std::vector<double>& velocities, double time);
  std::size_t point_rows() const { return point ? 3 : 0; }
  bool is_lock(std::size_t row) const { return (locks >> row & 1) != 0; }
  bool is_still(std::size_t row) const { return (still >> row & 1) != 0; }
  JointRow row(std::size_t r) const;
  RowMass row_mass(std::size_t r) const { return {mass[r], std::max(joined[r], mass[r]), share[r]}; }
  /// m/s or rad/s: what velocities add to the rate `start` of a row beside the point's.
  double rate_by(const std::vector<double>& velocities, std::size_t row, double start = 0) const;
  /// The rates of all rows at these velocities, of bodies that respond.
  void rates_by(const double* velocities, double* rates) const;
  /// The part of impulses along all rows, on the second body, that moves it.
  Vector3 linear_impulse(const Rows<double>& impulses) const;
  /// Adds impulses along all rows, on the second body, to the momenta of both.
  void add_impulses(const double* impulses, double* momenta) const;
  /// Sets all momenta to those of an impulse of 1 along a row alone.
  void set_momenta(std::size_t row, std::vector<double>& momenta) const;
};

/// The kinds of rows that occur among some joints.
struct RowKinds {
  bool all_locked = true;   ///< then none goes to another piece of its law
  bool acts = false;        ///< some row has a spring, a motor, friction or an armature
  bool looks_back = false;  ///< some row's impulse depends on the rate before
  bool damps = false;       ///< some row's force depends on its rate
  bool bounces = false;     ///< some row may, at an end of its range
};

}  // namespace atl::solver
