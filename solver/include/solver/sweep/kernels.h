#pragma once

#include <solver/constraints/surface_contact.h>
#include <solver/integrate/solver_bodies.h>
#include <solver/solver_settings.h>
#include <solver/sweep/contact_block.h>
#include <solver/sweep/joint_block.h>

#include <cstddef>
#include <string_view>
#include <vector>

namespace atl::solver {

/// The kind of joints on a body: swept, or solved at once. The latter close any gap within a substep.
enum class Joined : std::uint8_t { No, Swept, Direct };

/// The data of the contact kernels.
struct ContactKernelData {
  SolverBodies& bodies;
  ContactBlock* blocks;
  BounceBlock* bounces;                   ///< one a block, or null if nothing bounces
  collision::ContactManifold* manifolds;  ///< by contact slot
  const SubstepConstants& constants;
  SurfaceBlock* surface_blocks = nullptr;      ///< one a block, or null if all surfaces are plain
  SurfaceContact* surface_contacts = nullptr;  ///< by contact slot, with them
  const float* rises = nullptr;                ///< m, by contact slot, or null: see ContactCache
  SplitBlock* split_blocks = nullptr;          ///< one a block, or null where nothing asks
  PlanarBlock* planar_blocks = nullptr;        ///< one a block, or null if no body has motion locks
  TurningBlock* turning_blocks = nullptr;      ///< one a block, or null if bodies turn too little for it to matter
  RimBlock* rim_blocks = nullptr;              ///< one a block, or null if no body rolls
  const std::uint8_t* joined = nullptr;        ///< by index into SolverBodies, what joints hold it (Joined); or null
  bool leaves_out = true;                      ///< kernels skip features that a block lacks
};

/// The way a sweep treats overlap.
enum class Push {
  None,   ///< nothing: it only stops approach
  Bias,   ///< asks for a speed that gets bodies apart
  Split,  ///< the same, in SolverBodies::correction and impulses of its own, and nothing else
};

/// A sweep of projected Gauss-Seidel over blocks.
struct Sweep {
  Push push;
  bool refresh;           ///< recompute separations from the bodies' displacements first
  Friction friction;      ///< None with Push::Split
  bool twice = false;     ///< goes over the points of each contact twice: some may be new
  bool measures = false;  ///< tell the residual
  /// Goes over the points of each contact from the last to the first. One order alone pushes what stands towards where
  /// it ends: by turns they cancel.
  bool backwards = false;
  /// For surfaces that bend under sliding bodies (SurfaceBlock::rise): the part of their end speed that they have in
  /// this sweep, and the time (s) by which that speed is multiplied for the displacement so far.
  float rise_part = 0;
  float rise_time = 0;
  bool relaxes = false;  ///< takes back what pushed bodies apart
};

/// The data of the joint kernels.
struct JointKernelData {
  SolverBodies& bodies;
  JointBlock* blocks;
  JointRowBlock* rows;
  SplitRowBlock* split_rows;          ///< one a row, or null where nothing asks
  const JointFrameBlock* frames;      ///< one a block, of groups that have rows
  JointCoordinateBlock* coordinates;  ///< one a row
  const SubstepConstants& constants;
};

/// A sweep over the blocks of joints.
struct JointSweep {
  Push push = Push::None;  ///< of what joints are off by; without, they are rigid and look at rates alone
  bool refresh = false;    ///< recompute arms, offsets and masses from the bodies' displacements first
  bool carries = false;    ///< the first sweep after impulses were carried over from the substep before
  bool moved = false;      ///< positions have moved by the velocities: springs pull from where they did before
  bool measures = false;   ///< tell the residual
  float relaxation = 1;    ///< factor of the impulses that hold points, in [1, 2)
};

/// J, of a body whose velocity impulses have changed: its kinetic energy before, and what is added to that if they are
/// scaled by s: linear s + square s^2. kg: half its mass.
struct alignas(16) WorkRow {
  float before, linear, square, half_mass;
};

/// The wide kernels for one instruction set. Each runs over [begin, end): of blocks, or of body indices in
/// multiples of block_lanes; null if this build leaves out what it is for. The same operations in the same order in
/// every lane on each set, without fused multiply-add or approximations, so all give the same bits.
struct Kernels {
  const char* name;
  std::size_t lanes;

  /// Makes blocks, whose indices are filled in, from their manifolds.
  void (*prepare)(const ContactKernelData& data, std::size_t begin, std::size_t end);
  /// Applies the accumulated impulses.
  void (*warm_start)(const ContactKernelData& data, std::size_t begin, std::size_t end);
  /// Once impulses have been applied, finds by how much those of contacts at `struck` bodies (1, or 2 if they are
  /// joined; by index into SolverBodies) are to be scaled: see FittingBlock. Returns the least scale.
  float (*find_fitting)(const ContactKernelData& data, const std::uint8_t* struck, FittingBlock* fitting,
                        std::size_t begin, std::size_t end);
  /// Takes back what such scales leave of impulses and velocities.
  void (*fit_impulses)(const ContactKernelData& data, const FittingBlock* fitting, std::size_t begin, std::size_t end);
  /// Returns, if the sweep measures, its residual, m/s: the largest change that an impulse made to the relative speed
  /// which it is there for, at the time it was found. Spins count with the friction_radius they have at the contact.
  float (*sweep)(const ContactKernelData& data, const Sweep& sweep, std::size_t begin, std::size_t end);
  /// Finds, before the forces of a substep, the contacts with bouncy points that close faster than the threshold and
  /// may meet in it.
  void (*find_approaches)(const ContactKernelData& data, std::size_t begin, std::size_t end);
  /// Writes impulses back to the manifolds.
  void (*store)(const ContactKernelData& data, std::size_t begin, std::size_t end);

  /// Starts a substep: forces, then, if `carry_over`, what constraints changed in the
  /// last substep once more (their warm start).
  void (*integrate_velocities)(SolverBodies& bodies, const SubstepConstants& constants, bool carry_over,
                               std::size_t begin, std::size_t end);
  /// Starts the corrections of a substep at zero, where there are any.
  void (*clear_corrections)(SolverBodies& bodies, std::size_t begin, std::size_t end);
  /// Moves and turns; bodies with unequal moments of inertia tumble. The inertia that contacts assume stays that half
  /// way through the step.
  void (*integrate_positions)(SolverBodies& bodies, const SubstepConstants& constants, std::size_t begin,
                              std::size_t end);

  /// Completes blocks of joints whose start of the step, impulses and rows are filled in.
  void (*prepare_joints)(const JointKernelData& data, std::size_t begin, std::size_t end);
  /// Makes the rows of blocks anew where displacements have brought the bodies, but for springs: joint_rows-inl.h. Once
  /// bodies have `moved` by their velocities, tells what that made of impulses that are carried over.
  void (*refresh_rows)(const JointKernelData& data, bool moved, std::size_t begin, std::size_t end);
  /// Applies a part of the accumulated impulses, and keeps a part.
  void (*warm_start_joints)(const JointKernelData& data, float applied, float kept, std::size_t begin, std::size_t end);
  /// Returns, if the sweep measures, its residual as that over contacts does. Spins count with a friction_radius of 1
  /// m.
  float (*sweep_joints)(const JointKernelData& data, const JointSweep& sweep, std::size_t begin, std::size_t end);
  /// Tells what was done to bodies since the free velocities, and what was `forced` on them beside, or null.
  void (*find_work)(const SolverBodies& bodies, const VelocityRows* forced, WorkRow* work, std::size_t begin,
                    std::size_t end);
};

/// The sets that this machine runs, best first: of "avx512", "avx2", "sse4", "neon" and always "portable".
const std::vector<const Kernels*>& available_kernels();

/// Null if this machine lacks it.
const Kernels* find_kernels(std::string_view name);

}  // namespace atl::solver
