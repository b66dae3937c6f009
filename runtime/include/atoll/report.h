#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace atl {

/// The phases of World::step, in order.
enum class Phase {
  Plan,
  FindPairs,
  UpdateContacts,
  BuildIslands,
  SolveIslands,
  SweepFastBodies,
  Finish,
};
inline constexpr int phase_count = 7;

/// "plan", "find_pairs", "update_contacts", ...
const char* phase_name(Phase phase);

/// Optional parts of a step, which run only if the scene calls for them, in order.
enum class Feature {
  Broadphase,
  Narrowphase,
  RecycledManifolds,
  ContactFilter,    ///< World::set_contact_filter()
  ContactModifier,  ///< World::set_contact_modifier()
  ContactSolver,
  SeveralPoints,     ///< what contacts of one point don't need
  TwoMovableBodies,  ///< what contacts with a fixed body don't need
  Friction,
  RollingAndBelts,  ///< rolling and torsional friction, and surfaces that run
  Restitution,
  WarmStarting,
  Relaxation,
  SplitImpulses,
  EarlyEnd,  ///< of sweeps, by Settings::tolerance
  DirectContacts,
  RefinedSubsteps,
  ErrorTarget,
  JointSolver,  ///< of joints that are swept
  DirectJoints,
  MotionLocks,
  GyroscopicTorque,
  FreeFlight,
  KinematicBodies,
  ContinuousCollision,
  Sleeping,
  ContactEvents,
  Sensors,
  ContactProblem,
  Recording,
};
inline constexpr std::size_t feature_count = 30;

/// "broadphase", "narrowphase", ...
const char* feature_name(Feature feature);

/// One feature of the step plan: whether this step ran it, and why or why not, in words. What was left out got no call
/// and no memory.
struct FeatureReport {
  const char* name = "";
  bool run = false;
  const char* why = "";
  /// How many contacts, bodies or whatever `unit` says it was run on: those that need it, and what shares a block of
  /// eight with them. 0 if it was left out.
  std::int64_t items = 0;
  const char* unit = "";
  double ms = 0;  ///< 0 for features within the solver's tasks, which share the time of contact_solver
};

/// Phases of the contact solver within a step.
enum class SolverPhase {
  Colour,       ///< bodies and contacts are gathered and coloured
  Prepare,      ///< bodies and constraints are loaded
  WarmStart,    ///< the last step's impulses are applied
  Solve,        ///< sweeps with the position bias
  Relax,        ///< sweeps without it
  Integrate,    ///< velocities and positions
  Restitution,  ///< bounces
  Store,        ///< impulses and states are written back
};
inline constexpr std::size_t solver_phase_count = 8;

/// "colour", "prepare", ...
const char* solver_phase_name(SolverPhase phase);

struct StepCounts {
  std::int64_t active_bodies = 0;         ///< awake, or kinematic with a velocity: no other is looked at
  std::int64_t active_contacts = 0;       ///< of pairs with one of these: no other is looked at
  std::int64_t aabb_updates = 0;          ///< of shapes that left, or will leave, the fat bounds they had, or are new
  std::int64_t pairs = 0;                 ///< of bodies whose fat bounds overlap
  std::int64_t filtered_pairs = 0;        ///< of shapes, of which a contact filter was asked
  std::int64_t asked_contacts = 0;        ///< manifolds of which a contact modifier was asked
  std::int64_t contacts = 0;              ///< pairs with at least one manifold point, among awake bodies
  std::int64_t points = 0;                ///< manifold points of these
  std::int64_t joints = 0;                ///< that act on awake bodies
  std::int64_t direct_joints = 0;         ///< of these, those that are solved directly
  std::int64_t direct_islands = 0;        ///< whose contacts are solved at once, because sweeps get nowhere
  std::int64_t unsolved_islands = 0;      ///< which that was tried for in vain, and swept instead
  std::int64_t refused_islands = 0;       ///< which that was asked or due for, and not tried: see SolverChoice::why_not
  std::int64_t refined_islands = 0;       ///< that get more substeps: they sag, or a body lands that leans
  std::int64_t missed_targets = 0;        ///< with an error beyond its target: see World::missed_targets()
  std::int64_t body_substeps = 0;         ///< with a target: substeps that islands got, times their bodies
  std::int64_t island_bodies = 0;         ///< with a target: bodies of these islands
  std::int64_t max_substeps = 0;          ///< with a target: that an island got
  std::int64_t newton_iterations = 0;     ///< of what is solved at once, beyond the first solve
  std::int64_t discarded_iterations = 0;  ///< of these, those of islands that were tried in vain
  std::int64_t islands = 0;               ///< awake islands with at least one contact or joint
  std::int64_t groups = 0;                ///< island groups, each one task
  std::int64_t colours = 0;               ///< of the group with the most
  std::int64_t recycled_manifolds = 0;    ///< pairs that kept their features (or their having none)
  std::int64_t recomputed_manifolds = 0;  ///< pairs that the narrowphase looked at anew
  std::int64_t fcl_calls = 0;             ///< pairs of these for which FCL ran; see collision/README.md
  std::int64_t fcl_repairs = 0;           ///< of its answers, those that their own axis refutes and were replaced
  std::int64_t id_matches = 0;            ///< points of fresh manifolds that inherited an impulse by feature id
  std::int64_t id_misses = 0;             ///< points of such manifolds, of pairs that touched before, that did not
  std::int64_t sweeps = 0;   ///< over an island group's contacts and joints, all groups and substeps together
  std::int64_t asleep = 0;   ///< bodies
  std::int64_t swept = 0;    ///< bodies that continuous collision looked at
  std::int64_t stopped = 0;  ///< bodies that met something and were put back, and with them what they are joined to
};

/// Report of one step: its work and its times.
struct StepReport {
  double ms = 0;  ///< wall time of the whole step
  std::array<double, phase_count> phase_ms = {};
  StepCounts counts = {};
  std::array<FeatureReport, feature_count> features = {};  ///< by Feature
  /// With Settings::profile: ms on the worker that solves it, summed over island groups.
  std::array<double, solver_phase_count> solver_ms = {};
  std::int64_t quarantined = 0;  ///< bodies that this step took out of the world: see World::quarantined()
  /// The lowest-numbered of these: its state was, or was about to become, not finite or absurd. -1 if there is none.
  std::int64_t first_quarantined = -1;

  const FeatureReport& feature(Feature feature) const { return features[static_cast<std::size_t>(feature)]; }
};

}  // namespace atl
