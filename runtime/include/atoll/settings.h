#pragma once

#include <optional>

namespace atl {

enum class FrictionModel {
  Cone,     ///< |tangential impulse| <= mu * normal impulse, isotropic
  Pyramid,  ///< each of two tangential components clamped alone: cheaper in theory, wrong off the axes
};

/// How contacts get bodies out of each other, and iterative joints close. Rigid ones, the last two, want four
/// iterations or more where bodies are stacked.
enum class Stabilisation {
  /// Each is a stiff damped spring, and sweeps without it take the speed back with which it pushed.
  Soft,
  /// Each is rigid and asks for a part of the overlap or gap as speed, which bodies keep: it adds energy (Baumgarte,
  /// "Stabilization of constraints and integrals of motion in dynamical systems", 1972).
  Baumgarte,
  /// The same part, in velocities of their own that only move bodies and are then forgotten (Catto, "Modeling and
  /// Solving Constraints", GDC 2009).
  SplitImpulse,
};

/// How contacts are solved. With Soft stabilisation.
enum class ContactSolver {
  /// By sweeps where these are predicted to stay within an error budget: contacts overlap by up to 1.5% of half the
  /// bodies' thickness at rest, 0.43% in columns. Islands beyond it are solved at once if they are columns or
  /// a body is deep in another, and have up to 400 bodies, with their joints where something heavy lies on these.
  /// Others
  /// get finer substeps where a quarter of their bodies is beyond it. So does, for the step in which it lands, a body
  /// alone that leans on something else. In a build without ATOLL_WITH_DIRECT_CONTACTS as Iterative.
  Auto,
  Iterative,  ///< by sweeps, whatever they carry
  /// At once, in all islands of up to 400 bodies without motion locks whose factor is not too large, contacts and
  /// joints
  /// in one system, as long as nothing bounces or tumbles fast in them. Exact, for 1 to 50 times the time: least where
  /// things stand, most where heaps move. Others by sweeps: World::solver_choices() tells which, and why.
  Direct,
};

/// How joints are solved.
enum class JointSolver {
  /// Directly where joints lead to a static body, have servos, armatures or springs that are stiffer than substeps can
  /// follow, make long chains, or hold a body that is light, or turns easily, between others.
  Auto,
  Iterative,  ///< one after the other, as contacts are: cheapest, and stretches under load
  Direct,     ///< those that hang together at once: exact, also for chains of any length and ratio of masses
};

/// The vector instruction set of the solver's kernels. The result is the same, bit for bit, on each.
enum class Simd { Auto, Portable, Sse4, Avx2, Avx512, Neon };

/// Error targets of islands: each island gets the fewest substeps that meet them, judged by the measurements of the
/// last steps. Needs Soft stabilisation. The error of an island is the value that more than one in a hundred of its
/// contacts, joints or bodies exceeds. World::missed_targets() lists the islands that missed a target.
struct ErrorTarget {
  std::optional<double> penetration = {};  ///< m, > 0: overlap after the step
  std::optional<double> joint_gap = {};    ///< m, > 0: what locked offsets of joints are open by after the step
  /// > 0, relative, as measure_contact_residual(): of the step's contact problem. Takes about a step's time to measure,
  /// so it is measured in one step of eight.
  std::optional<double> residual = {};
  /// m/s, > 0: how far bodies get from their paths in a second, by an estimate: see solver/select/motion_error.h.
  /// Bodies that touch nothing, and are not joined, move exactly or by Settings::substeps.
  std::optional<double> motion = {};
  int min_substeps = 1;    ///< in [1, 1024]
  int max_substeps = 128;  ///< the most that a step of an island may cost, in [min_substeps, 1024]

  bool is_set() const { return penetration || joint_gap || residual || motion; }
};

/// How a step is solved. The defaults suit 60 Hz and metre-sized bodies at any density.
struct Settings {
  int substeps = 4;  ///< in [1, 1024]; overlap falls with its square, cost rises linearly
  /// In place of `substeps`, from which islands then start. Not with contact_hertz and joint_hertz, which say
  /// themselves how far contacts and joints give.
  ErrorTarget target = {};
  int iterations = 1;        ///< sweeps over contacts and joints with the position bias, a substep; in [1, 1024]
  int relax_iterations = 1;  ///< sweeps without it after the positions moved; in [0, 1024]; with Soft only
  /// m/s, >= 0: an island whose sweep changed no relative speed at a contact or joint by more than this is done with
  /// the sweeps of that kind in the substep. 0 never stops early.
  double tolerance = 0;
  FrictionModel friction = FrictionModel::Cone;
  bool warm_starting = true;

  Stabilisation stabilisation = Stabilisation::Soft;
  /// Part of an overlap, or of an iterative joint's gap, that Baumgarte and SplitImpulse remove a substep, in (0, 1].
  double correction = 0.2;
  /// m, >= 0: overlap that these leave alone, so that points at rest neither come nor go. Far below the size of bodies,
  /// and some times what falls in a substep: g h^2 is 0.17 mm at the defaults.
  double slop = 5e-4;

  /// With Soft: stiffness of a contact as a damped spring, Hz, > 0. Limited to a quarter of the substep rate, and
  /// doubled against static and kinematic bodies. Left out, it is an eighth of the substep rate: as stiff as the
  /// substeps can well follow (30 Hz at the defaults), so that more substeps mean less overlap. A contact between
  /// bodies that move and have no joints is stiffer, up to 8 times, by as much as it would else give by more than a
  /// hundredth of half the smaller one's thickness.
  std::optional<double> contact_hertz = {};
  double contact_damping_ratio = 10;  ///< >= 0; 1 is critical
  /// m/s, > 0: the fastest that overlap is pushed apart. Of contacts farther than 1 m from the centres of mass of the
  /// bodies that move, or under more gravity, times the root of distance by gravity over 1 m by 9.81 m/s^2.
  double contact_push_speed = 3;
  /// m/s, >= 0: slower impacts don't bounce. Left out, it is twice the speed that gravity gives in a substep (0.08 m/s
  /// at the defaults), so that large and small worlds bounce alike, and all impacts do where there is no gravity.
  std::optional<double> restitution_threshold = {};

  ContactSolver contact_solver = ContactSolver::Auto;

  JointSolver joint_solver = JointSolver::Auto;
  /// With iterative joints and Soft: stiffness as a damped spring, Hz, > 0. Limited to, and if left out, 0.28 of the
  /// substep rate.
  std::optional<double> joint_hertz = {};
  double joint_damping_ratio = 2;  ///< >= 0

  bool sleeping = false;
  double sleep_speed = 0.05;   ///< m/s (and rad/s times the bounding radius): below it a body is at rest
  double time_to_sleep = 0.5;  ///< s at rest after which an island falls asleep

  bool contact_events = false;  ///< World::contact_events() has something to tell
  /// N, >= 0: contact events tell of contacts that go on, too, while the mean over a step of what they carry along
  /// their normals is at least this. BodyDef::contact_event_force asks for the same of one body's contacts.
  std::optional<double> contact_event_force = {};

  bool accelerations = false;  ///< World::accelerations() has something to tell

  bool keep_contact_problem = false;  ///< World::contact_problem() has something to tell

  /// Leave nothing out: each feature and kernel is run on all contacts and bodies of an island, needed or not; contact
  /// events and the contact problem are found, though not told. Choices between methods, and sleeping, stay. No bit of
  /// the result changes; the time says what leaving out saves. See StepReport::features. (Where a body's numbers stop
  /// being finite, which of those that touch it break with it may depend on this; a recording keeps it for that
  /// reason.)
  bool run_everything = false;

  bool profile = false;  ///< StepReport::solver_ms has something to tell; no bit of the result changes

  Simd simd = Simd::Auto;
};

}  // namespace atl
