#pragma once

#include <jobs/bytes.h>
#include <solver/direct/balance_search.h>
#include <solver/direct/direct_island_input.h>
#include <solver/direct/island_problem.h>

#include <cstdint>
#include <span>
#include <vector>

namespace atl::solver {

/// What became of a direct solve.
struct DirectIslandReport {
  bool solved = false;  ///< if not, no state was changed
  int iterations = 0;   ///< of Newton's method, beyond the first solves
  // Contacts, and those of them that have more than one point, two bodies that can move, or friction.
  std::int64_t contacts = 0, several_points = 0, two_movable = 0, friction = 0;
  std::int64_t gyroscopic_bodies = 0;  ///< whose moments of inertia differ
  double ms = 0;                       ///< with SolverSettings::profile
};

/// An island whose contacts and joints are solved at once, as one system (IslandProblem): one so ill-conditioned (tall
/// columns, heavy bodies on light ones, loaded bridges) that sweeps get nowhere.
///
/// As with sweeps of soft contacts, velocities are solved for twice: bodies keep velocities at which contacts just
/// stop, and move by velocities at which overlap is parted, too. Contacts alone take one solve for a whole step. With
/// joints there is one for each substep, which is one of RATTLE (see DirectJoints) with the contacts in it.
///
/// The first solve takes each contact to be on the pieces that the impulses of the last step tell of, and at rest is
/// all there is to do. No state outlives a step, but the order of elimination, which the pairs determine.
class DirectIsland {
 public:
  /// Takes in an island. Returns false if its factor would be too large.
  bool analyse(const DirectIslandInput& input, const IslandGroup& group);
  /// Solves the island that was taken in last. Not solved is what bounces, tumbles fast or didn't converge.
  DirectIslandReport solve(const DirectIslandInput& input);

  /// Memory held.
  std::size_t bytes() const {
    return sizeof(*this) + problem_.bytes() + search_.bytes() +
           jobs::bytes_of(members_, pairs_, links_, states_, before_, lasting_, placed_, couplings_);
  }

 private:
  // A body as it moves through the step.
  struct State {
    Vector3 position, start;        // m
    Quaternion turn, start_turn;    // orientations
    Vector3 acceleration;           // m/s^2
    Matrix3 body_inertia, inertia;  // kg m^2, body and world frame
    Matrix3 stiffness;              // N m, geometric
    bool tumbles;                   // its moments of inertia differ
  };

  // Where the points of a contact were as the step began, against what they are refreshed.
  struct Placed {
    std::uint32_t first_body, second_body;  // of the world
    DirectContact::Points start_separation;
  };

  std::uint32_t local(const DirectIslandInput& input, std::uint32_t body) const;
  bool load_bodies(const DirectIslandInput& input);
  void free_velocities(const DirectIslandInput& input, double dt);
  void load_velocities(const DirectIslandInput& input);
  bool load_contacts(const DirectIslandInput& input);
  void load_contact(const DirectIslandInput& input, const TouchingPair& pair, double share, DirectContact& contact) const;
  void place(const DirectIslandInput& input, const TouchingPair& pair, DirectContact& contact) const;
  static void warm_start(const DirectIslandInput& input, double share, DirectContact& contact);
  void stop_contacts(double dt);
  void push_contacts_apart(const SolverSettings& settings, double dt);
  bool overlaps_notably(const SolverSettings& settings, double dt) const;
  bool find_motions(const SolverSettings& settings, double dt, double from_outside);
  bool find_velocities(double from_outside);
  void keep_velocities();

  bool solve_step(const DirectIslandInput& input);
  void write_back_step(const DirectIslandInput& input);

  bool solve_substeps(const DirectIslandInput& input);
  void load_joints(const DirectIslandInput& input);
  void place_inertia(const DirectIslandInput& input, double time, double h);
  void place_joints(const DirectIslandInput& input, double time);
  void place_contacts(const DirectIslandInput& input, double time);
  void begin_laws(const DirectIslandInput& input, double h);
  double drive(double h, const DirectIslandInput& input) const;
  void free_substep_velocities(const DirectIslandInput& input, double h);
  Vector3 free_spin(const State& state, const Vector3& spin, const Vector3& torque, double h) const;
  BodyPose pose_of(const DirectIslandInput& input, std::uint32_t local, std::uint32_t body, double time) const;
  void move(double h, std::span<const double> by);
  static double gap_of(const Joint& of, const DirectJoint& joint, std::size_t row, double position);
  void note_gaps(const DirectIslandInput& input, double time);
  double farthest() const;
  void push_gently(double push_speed);
  static const Law& law_of(const Joint& joint, std::size_t row);
  static double rate_of(std::span<const double> velocities, const DirectJoint& joint, std::size_t row);
  bool may_bounce(const DirectIslandInput& input) const;
  void note_tears(const DirectIslandInput& input);
  void close_joints(const DirectIslandInput& input, double h, double time);
  void close_tears(double h);
  double move_closer(const DirectIslandInput& input, double time, double gap_before);
  double widest_noted() const;
  double widest_gap(const DirectIslandInput& input, double time) const;
  DirectJoint::Rows<double> gaps_of(const DirectIslandInput& input, const DirectJoint& joint, double time) const;
  void settle_joints(const DirectIslandInput& input);
  bool project(double h);
  bool follow_tension(double h);
  void write_back_substeps(const DirectIslandInput& input);

  void write_impulses(const DirectIslandInput& input, double share) const;
  void capture(const DirectIslandInput& input, double step) const;
  void note_work(const DirectIslandInput& input, DirectIslandReport& report) const;
  void note_overloads(const DirectIslandInput& input) const;

  std::vector<std::uint32_t> members_;
  std::size_t island_ = 0;
  std::vector<TouchingPair> pairs_;
  std::vector<JointLink> links_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> couplings_;
  bool fits_ = false;
  bool all_locked_ = false;  // all rows of joints
  bool pushes_ = false;      // bodies move by other velocities than they keep
  bool tears_ = false;       // some row was apart as the step began
  std::uint32_t first_rank_ = 0;
  IslandProblem problem_;
  BalanceSearch search_;
  std::vector<State> states_, before_;
  std::vector<Placed> placed_;
  // m/s, rad/s: what bodies come with, and then what they keep; the problem's velocity is what they move by.
  std::vector<double> lasting_;
};

}  // namespace atl::solver
