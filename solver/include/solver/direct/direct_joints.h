#pragma once

#include <jobs/arrays.h>
#include <solver/direct/island_members.h>
#include <solver/direct/island_motions.h>
#include <solver/direct/moving_bodies.h>
#include <solver/direct/solve_input.h>
#include <solver/integrate/solver_bodies.h>

#include <cstdint>
#include <span>
#include <vector>

namespace atl::solver {

/// Joints that hang together and are solved at once. Where nothing touches them that is all of a step (see
/// solve_substeps()).
///
/// In an island whose contacts are swept they are one block of its sweeps, as Gauss and Seidel have them: a substep is
/// that of joints alone, cut into stages between which contacts are swept. Each solution starts from the velocities
/// that bodies would have without the joints' impulses, so it may be found over and over, with the same factor.
class DirectJoints {
 public:
  /// Takes the joints in. Returns false if loops would fill the factor to more than a few blocks a body.
  bool analyse(std::span<const JointLink> links, std::span<const Joint> joints, const BodyTable& table);

  /// Moves bodies through the step, where nothing touches them. Returns false, and changes nothing, where that ends
  /// nowhere.
  bool solve(const SolveInput& input);

  /// Looks up the bodies of the joints among the solver's, by `place(body)`, before a step.
  template <typename Place>
  void locate(const Place& place) {
    for (std::size_t i = 0; i < places_.size(); ++i) places_[i] = place(members_.bodies[i]);
  }
  void begin_step(const SolveInput& input);
  void begin_substep(const SolveInput& input);
  /// Finds, after forces, the velocities that keep the joints at the present poses, with springs, motors and limits.
  void solve_velocities(const SolveInput& input, int substep, SolverBodies& bodies);
  /// Moves bodies, after their motion, back to where the joints hold, and corrects velocities accordingly.
  void solve_positions(const SolveInput& input, int substep, SolverBodies& bodies);
  /// Finds, after that, the velocities that keep the joints at the new poses.
  void relax(const SolveInput& input, int substep, SolverBodies& bodies);
  /// Loads bodies and joints as they are in a substep, where joints are otherwise swept.
  void load(const SolveInput& input, const SolverBodies& bodies);
  /// Takes bodies to where they are at an instant of a substep, `time` seconds into the step, `by` so much from where
  /// it began, and makes their velocities (six numbers each) such as keep the joints there: locks hold, and rotors turn
  /// along, by themselves. Returns false if there are none. end_impacts() is to follow, either way.
  bool begin_impacts(const SolveInput& input, double time, std::span<const BodyPose> by,
                     std::vector<double>& velocities);
  /// Replaces momenta of bodies by what these make of velocities at that instant.
  void respond(std::span<double> momenta) const { motions_.search.matrix.solve(motions_.problem, momenta); }
  /// The end of its range (Joint::limit) that a coordinate is at or beyond.
  int end_at(const SolveInput& input, std::size_t joint, std::size_t row) const;
  /// Takes bodies to where impacts have the substep begin, with velocities.
  void end_impacts(const SolveInput& input, double time, std::span<const BodyPose> by,
                   const std::vector<double>& velocities);

  /// Changes velocities, at the end of a step of one substep in which nothing touched the bodies, by what half of it
  /// makes of a change of forces from those of the table. Returns false, and changes nothing, where that ends nowhere.
  bool follow_forces(const SolveInput& input, const ForceChange& change);

  const IslandProblem& problem() const { return motions_.problem; }
  /// Places of its bodies among the solver's.
  std::span<const std::uint32_t> places() const { return places_; }

  /// Closes the joints once poses have been written back, writes impulses, forces and limits to the joints, and records
  /// how the bodies moved.
  void finish(const SolveInput& input);

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(members_, places_, motions_, bodies_, answer_); }

 private:
  void load_poses(const SolverBodies& bodies);
  void take_to(const SolveInput& input, double time, std::span<const BodyPose> by);
  void load_velocities(const SolverBodies& bodies);
  void store_velocities(const std::vector<double>& velocities, SolverBodies& bodies);
  void begin_last_kick(const SolveInput& input);
  void keep_projected(const SolveInput& input, bool found, SolverBodies& bodies);

  IslandMembers members_;              // without contacts
  std::vector<std::uint32_t> places_;  // of bodies among the solver's
  IslandMotions motions_;
  std::vector<MovingBody> bodies_;
  std::vector<double> answer_;  // m/s, rad/s: what the joints' impulses in this substep have made of velocities
  RowKinds rows_;
  bool solved_ = false;  // once in this substep
  bool kicked_ = false;  // the problem is that of the last kick of a step of one substep
};

}  // namespace atl::solver
