#pragma once
/// The laws of an assembly's rows beside points, within a substep of h seconds.

#include <solver/direct/joint_assembly.h>

namespace atl::solver {

/// Finds the effective masses along rows.
void weigh_rows(JointAssembly& assembly);

/// Starts the laws where rows are. The pieces of their laws that rows were on still hold as a guess.
void begin_laws(JointAssembly& assembly, const Joint* joints, double h);

/// Starts a kick: half a substep in which positions stay. `sign` as RowLaw::of_kick() has it.
void begin_kick(JointAssembly& assembly, const Joint* joints, double h, int sign);

/// Once a kick has been solved: makes springs' part of it exact to the next order, by the accelerations that it made.
void correct_kick(JointAssembly& assembly, const Joint* joints, double h, int sign);

/// Keeps the rates at the velocities that are loaded, before forces change them.
void note_rates(JointAssembly& assembly);

/// Gives springs, servos and bounces the rates before the substep's forces, at the velocities that are loaded.
void start_laws(JointAssembly& assembly, const Joint* joints);

/// Adds so many times the momentum of armatures at the velocities that are loaded to AssemblyRow::unpaid.
void add_armature(JointAssembly& assembly, const Joint* joints, double times);

/// How fast rows that bounce would come to the ends of their ranges, if nothing held them there: with what accelerates
/// them along the way.
void note_impacts(JointAssembly& assembly, const Joint* joints, double h);

/// What the rows' bending makes of their rates by the end of the substep, on the mean: points that go round are pulled
/// inwards, and what tumbles turns otherwise than it spins. Rates that are asked for with it bring positions onto the
/// constraint to third order, before bodies have moved: impulses that come later act on spins that have gone another
/// way. Not where arms swing farther in a substep than that is true for.
void note_bends(JointAssembly& assembly, const Joint* joints, const BodyTable& table, double h);

/// Asks for no rates beside those of the laws.
void forget_bends(JointAssembly& assembly);

/// Moves rows to the pieces of their laws that a solution belongs on. Returns whether any has moved.
bool update_laws(JointAssembly& assembly);

/// Holds what an impact has pushed beyond its range, h seconds on at the velocities that are loaded. Returns whether
/// there is such a row.
bool catch_limits(JointAssembly& assembly, const Joint* joints, double h);

/// The same of what closing other gaps has turned beyond its range, where bodies are now.
bool catch_limits_here(JointAssembly& assembly, const Joint* joints);

/// The position of a row's coordinate at the frames, after h seconds at the velocities that are loaded.
double position_of(const JointAssembly& assembly, const JointNode& node, std::uint32_t row, const Joint& joint,
                   const JointFrames& frames, double h);

}  // namespace atl::solver
