#pragma once
/// Makes substeps of joints alone a leapfrog of second order, and keeps them from making energy.

#include <solver/direct/island_problem.h>
#include <solver/direct/moving_bodies.h>
#include <solver/direct/solve_input.h>

#include <cstdint>
#include <span>
#include <vector>

namespace atl::solver {

/// By how much faster than its row says a coordinate moves while bodies turn on in a substep of h seconds that ends
/// `time` seconds into the step: a locked one, where impulses then stop that at once, so that little is left to be
/// closed; and one with an armature, whose rate is that of the substep's middle. Nothing where arms turn by more than
/// tuning::max_bend. Returns by how much one does, rad.
double find_bends(const SolveInput& input, double time, double h, std::span<MovingBody> bodies, IslandProblem& problem);
/// Locks stop what is noted, too, and armatures resist it.
void answer_bends(const Joint* joints, IslandProblem& problem);
/// Rates before a substep are those of velocities that keep the joints at its first poses, and rates after it those of
/// velocities that lead along the bends: by as much as `along`, which ask for the bends, off those that keep the
/// joints. The mean of the two, by which dampers are of second order, is that of rates that are told alike.
void damp_by_like_rates(const Joint* joints, const std::vector<double>& along, IslandProblem& problem);
/// Takes back what locks and armatures answer.
void forget_bends(const Joint* joints, IslandProblem& problem);

/// True if the rates that were noted are notably other than a joint's locks allow.
bool is_against_locks(const IslandProblem& problem, const DirectJoint& joint);
/// The laws of rows where nothing acts but locks, beside the inertia of armatures at the rates that were noted.
void hold_locks_alone(const Joint* joints, IslandProblem& problem);

/// Finds which servos are at their bounds, at the rates that were noted: targets may have changed since the last step.
void bound_servos(const Joint* joints, std::vector<DirectJoint>& all);

/// The laws of rows over a kick, from the rates that were noted: see RowLaw::of_kick().
void begin_kick(const Joint* joints, double h, int sign, IslandProblem& problem);
/// Adds the further impulses of springs and servos in a kick, after a solution; see kick_correction().
void correct_kick(const Joint* joints, double h, int sign, IslandProblem& problem);

/// The rates of rotors before and after impulses.
enum class Rotors : std::uint8_t {
  Turn,  ///< at the rates before the substep, and with the bodies and how they bend
  Keep,  ///< at the rates that armatures have kept, and with what bodies gain
  Pay,   ///< at these before, and after with the bodies
};

/// J: what bodies that move and don't respond give to the others by such impulses along rows.
double work_of_bases(const IslandProblem& problem, DirectJoint::Rows<double> DirectJoint::*impulses);

/// True if the kinetic energy of bodies and armatures grows from one set of velocities to another by more than is
/// given, J, and by more than the work of springs, servos and motors, with the problem's impulses, plus the part
/// tuning::energy_tolerance of it.
bool gains_energy(const Joint* joints, const IslandProblem& problem, std::span<const MovingBody> bodies, double given,
                  const std::vector<double>& before, const std::vector<double>& after, Rotors rotors);

/// Leaves out what tension adds to inertia.
void leave_out_tension(std::span<const MovingBody> bodies, IslandProblem& problem);

}  // namespace atl::solver
