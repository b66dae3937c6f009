#pragma once

#include <jobs/bytes.h>
#include <solver/constraints/joint.h>
#include <solver/constraints/law_mode.h>
#include <solver/direct/block_ldlt.h>
#include <solver/integrate/body_table.h>
#include <solver/integrate/motion.h>
#include <solver/integrate/solver_bodies.h>
#include <solver/islands/islands.h>

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

/// Joints that hang together, solved at once: J M^-1 J^T, a block-sparse system with a node a joint, is factored in
/// double at the poses of every substep, in linear time where joints make no loop (Baraff, "Linear-time dynamics using
/// Lagrange multipliers", SIGGRAPH 1996).
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
    for (Member& member : members_) member.local = local(member.body);
  }
  void begin_step(const DirectInput& input);

  /// Springs' share of the half substep by which velocities are behind positions in the substeps of a step: takes it
  /// away before (-1), gives it back after (1).
  void kick_springs(const DirectInput& input, int sign);
  /// Once the velocities that a substep starts with are there.
  void note_rates(const DirectInput& input);
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

  /// Memory held.
  std::size_t bytes() const {
    return jobs::bytes_of(members_, nodes_, rows_, couplings_, node_rows_, b_, tears_) + system_.bytes();
  }

 private:
  struct Member {
    std::uint32_t body;
    std::uint32_t local;
    double inverse_mass;
    bool dynamic;
    Vector3 start, position;                    // m
    Quaternion start_turn, turn;                // orientations
    Matrix3 stiffness;                          // N m, geometric
    Matrix3 inverse_inertia = Matrix3::Zero();  // 1/(kg m^2), world frame, with a share of the stiffness
    Vector3 velocity, spin;                     // m/s, rad/s
    Quaternion next_turn;                       // as it would be at the substep's end
    Vector3 velocity_before, spin_before;
    Vector3 impulse, angular_impulse;  // N s, N m s
  };

  // A row of a joint beside its point.
  struct Row {
    JointRow at;
    LawMode mode;
    double impulse;          // N s or N m s, in this substep
    double position;         // m or rad
    double mass;             // kg or kg m^2, effective
    double bend;             // m/s or rad/s, see note_bends()
    double rate_before = 0;  // m/s or rad/s, as the substep begins, before its forces
    LimitImpact impact;
    bool bounces = false;  // at that end, in this substep
  };

  // A joint, a node of the system.
  struct Node {
    std::uint32_t joint;
    std::uint32_t first, second;  // members
    bool point;
    std::uint32_t begin, end;  // in rows_
    bool is_point_only() const { return point && begin == end; }
    Vector3 arm_first, arm_second;
    Vector3 bend;                             // m/s, see note_bends()
    Vector3 offset;                           // m, of the origins, as the substep begins
    Vector3 impulse;                          // of the point, in this substep
    std::size_t block;                        // of the system, diagonal
    Matrix3 response_first, response_second;  // of a point alone: its arms' cross matrix times the inverse inertia
    Vector3 tension;                          // N, followed over some substeps
  };

  // Two joints at one member.
  struct Coupling {
    std::uint32_t row, column;  // nodes
    std::uint32_t member;
    bool row_second, column_second;  // the member is the second body of the node
    bool transposed;                 // in the system
    std::size_t block;
  };

  // A node's rows of the Jacobian, and what the inverse inertia makes of them.
  struct NodeRows {
    std::size_t count = 0;
    double linear[BlockLdlt::max_size][3];
    double first[BlockLdlt::max_size][3], second[BlockLdlt::max_size][3];                // angular
    double answer_first[BlockLdlt::max_size][3], answer_second[BlockLdlt::max_size][3];  // 1/(kg m^2) times these
  };

  void place_members(const DirectInput& input);
  void place_frames(const Joint* joints);
  void place_inertia(const BodyTable& table, double h);
  void begin_laws(const Joint* joints, double h);
  void note_bends(const DirectInput& input);
  bool update_laws();
  void note_impacts(const Joint* joints, double h);
  void prepare(const DirectInput& input);
  void factor();
  bool catch_limits(const Joint* joints, double h);
  bool catch_limits_here(const Joint* joints);
  JointFrames frames_of(const Joint& joint, const Node& node) const;
  double position_of(const Joint& joint, const JointFrames& frames, const Node& node, std::uint32_t r, double h) const;
  void close_gaps(const DirectInput& input);
  bool set_tears_aside(const Joint* joints, double h);
  bool moves_far(double h, double far) const;
  void take_back();
  void move_members(const DirectInput& input);
  static double bound(const Row& row, const Law& law) { return row.mode.limit() > 0 ? law.upper : law.lower; }
  void measure(const Joint& joint, const Node& node, double* b, double h) const;
  void fill_diagonal(const Node& node, const NodeRows& rows);
  void fill_coupling(const Coupling& coupling);
  void fill_rows(const Node& node, NodeRows& rows) const;
  void load_velocities(const SolverBodies& bodies);
  void load_no_velocities();
  void store_velocities(SolverBodies& bodies) const;
  Vector3 point_speed(const Node& node) const;
  double row_speed(const Node& node, const Row& row) const;
  void apply(const Node& node, const JointRow& row, double impulse);
  void solve_and_apply();

  std::vector<Member> members_;
  std::vector<Node> nodes_;
  std::vector<Row> rows_;
  std::vector<Coupling> couplings_;
  BlockLdlt system_;
  std::vector<NodeRows> node_rows_;  // by node, where there are rows
  std::vector<double> b_;
  std::vector<double> tears_;
  double redundancy_ = 0;
  bool assigns_all_ = false;
  bool solvable_ = false;
  bool looks_back_ = false;  // some row's impulse depends on the rate before
  bool bounces_ = false;     // some row may, at an end of its range
  bool late_ = false;        // velocities are half a substep behind positions
  bool torn_ = false;        // something was apart as the substep began
};

}  // namespace atl::solver
