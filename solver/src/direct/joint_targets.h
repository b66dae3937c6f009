#pragma once
/// The right-hand sides of an assembly's system: the changes of rates that its rows are asked for. b has the rows of
/// JointMatrix.

#include <solver/direct/joint_matrix.h>

#include <vector>

namespace atl::solver {

/// To the rates of the rows' laws, from the velocities that are loaded.
void set_velocity_targets(const JointAssembly& assembly, const JointMatrix& matrix, std::vector<double>& b);

/// To the rates at which rows stay where they are held, from the velocities that are loaded. Springs and motors have
/// had their impulse, and answer to changes only. What bounces leaves, `late` half a substep behind positions.
void set_projection_targets(const JointAssembly& assembly, const JointMatrix& matrix, bool late,
                            std::vector<double>& b);

/// By the rates that take rows from where members are to where they should be in h seconds.
void set_position_targets(const JointAssembly& assembly, const JointMatrix& matrix, const Joint* joints, double h,
                          std::vector<double>& b);

/// The same at the poses that rows were placed at. Returns whether all are closed there.
bool set_position_targets_here(const JointAssembly& assembly, const JointMatrix& matrix, const Joint* joints, double h,
                               std::vector<double>& b);

/// What was apart when the substep began, as no substep leaves it, was put apart from outside. It is closed, too, but
/// by no velocity: bodies would fly. Takes it out of b, and leaves in `tears` the rates that close it. Returns whether
/// there is any.
bool set_tears_aside(const JointAssembly& assembly, const JointMatrix& matrix, const Joint* joints, double h,
                     std::vector<double>& b, std::vector<double>& tears);

}  // namespace atl::solver
