#pragma once
/// The substeps of joints that are solved at once: of an island by itself, or stage by stage where contacts are swept
/// in between.

#include <solver/direct/island_motions.h>
#include <solver/direct/moving_bodies.h>
#include <solver/direct/solve_input.h>

#include <vector>

#include "direct/conservation.h"
#include "direct/island_joints.h"
#include "direct/joint_leapfrog.h"

namespace atl::solver {

class Substeps {
 public:
  /// Works on an island whose bodies and joints have been loaded.
  Substeps(const SolveInput& input, std::vector<MovingBody>& bodies, IslandMotions& motions, const RowKinds& rows)
      : input_(input),
        bodies_(bodies),
        motions_(motions),
        problem_(motions.problem),
        rows_(rows),
        alone_(motions.problem.contacts.empty()),
        by_bodies_(motions.search.matrix.joints() == nullptr),
        h_(input.substep()) {}

  /// Takes all substeps of an island. Returns false if a search doesn't converge.
  bool solve();

  /// Prepares the first substep.
  void begin();
  /// Finds where springs crowd, as if nothing touched: without kicks nothing else is weighed.
  void weigh_crowded();
  /// Rows at the poses of now, `time` seconds into the step.
  void place(double time);
  /// Laws, from the rates that were noted.
  void begin_substep();
  /// Finds how locks bend at the free velocities in the substep that ends at `time`.
  void foresee_bends(double time);
  /// Solves the joints alone, from the free velocities. `finds_impacts` also finds which coordinates bounce, and how;
  /// otherwise the last finding is used again.
  bool find_joint_velocities(bool finds_impacts);
  /// Finds velocities at which locks hold what the free ones leave open, and nothing else acts but rotors, on bodies of
  /// the inertia that they have. Returns false if there are none.
  bool hold();
  /// Moves the coordinates by the velocities of bodies.
  void advance_coordinates();
  /// Projects the lasting velocities to ones that keep the joints, and changes nothing at contacts that rest: both have
  /// had their impulses, and answer only to the rest. Returns false if there are none.
  bool project();
  /// Velocities and impulses of joints alone, from the free velocities. Returns false if there are none.
  bool solve_rows();

 private:
  void give_up_what_locks_forbid();
  void kick(int sign);
  bool find_velocities(double time);
  void even_out_dampers();
  bool find_impacts();
  bool find_row_velocities();
  bool find_passive_velocities();
  bool makes_energy(const std::vector<double>& velocity, Rotors rotors) const;
  bool go_back();
  void advance();
  bool solve_held_rows();
  bool limit_bounces();
  bool solve_linear();

  const SolveInput& input_;
  std::vector<MovingBody>& bodies_;
  IslandMotions& motions_;
  IslandProblem& problem_;
  const RowKinds& rows_;
  // True if nothing presses on the joints in this system. If nothing does at all, velocities are half a substep behind
  // positions, as in a leapfrog.
  const bool alone_;
  const bool by_bodies_;    // the matrix has a node a body, else a joint
  const double h_;          // s
  double swing_ = 0;        // rad, by which an arm has turned in a substep
  Conservation conserved_;  // of an island that is alone
};

}  // namespace atl::solver
