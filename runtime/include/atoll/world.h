#pragma once

#include <atoll/body.h>
#include <atoll/body_hash.h>
#include <atoll/contact_problem.h>
#include <atoll/error.h>
#include <atoll/joint.h>
#include <atoll/memory.h>
#include <atoll/quarantine.h>
#include <atoll/recording.h>
#include <atoll/report.h>
#include <atoll/settings.h>
#include <atoll/types.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace atl {

struct WorldDef {
  Vector3 gravity = {0, 0, -9.81};  ///< m/s^2
  int threads = 1;                  ///< workers, the caller among them; in [1, 1024]
  /// While other programs take the cores, works on the caller's thread alone, which is faster then: workers that don't
  /// run are waited for. No bit of the result depends on it.
  bool dynamic_threads = true;
  Settings settings = {};
};

/// Force that body a's surface exerts on body b at one manifold point, in the last substep: an impact before that is
/// not in it. ContactEvent::impulse is of the whole step.
struct ContactForce {
  BodyId a;
  BodyId b;
  Vector3 position;     ///< m, world frame
  Vector3 normal;       ///< unit, from a to b
  double normal_force;  ///< N, >= 0
  Vector3 friction;     ///< N, tangential, on b: the point's share of the manifold's friction by normal force
  double separation;    ///< m, negative where the shapes overlap, as the step started
  std::uint64_t feature_id;
  std::uint32_t child_a;  ///< in a compound, else 0
  std::uint32_t child_b;
};

/// A force and a torque about a body's centre of mass, on that body, world frame.
struct Wrench {
  Vector3 force = Vector3::Zero();   ///< N
  Vector3 torque = Vector3::Zero();  ///< N m
};

/// Two bodies that press on each other, and what all of their contact points carry together.
struct PairForce {
  BodyId a;
  BodyId b;
  Vector3 force = Vector3::Zero();  ///< N, on b, friction with it
  double normal_force = 0;          ///< N, sum of the points', > 0
  double separation = 0;            ///< m, of the deepest of them, as the step started
};

/// Two bodies that began or ceased to touch in the last step: to press on each other, or overlap. Whatever touches
/// within a step begins in it, however it has parted by its end: then it ceases in the next. Where it is asked for, it
/// tells of what goes on touching, too: see Settings::contact_event_force. What sleeps tells nothing.
struct ContactEvent {
  BodyId a;
  BodyId b;
  bool began;
  bool persists = false;  ///< they touched a step ago and still do; neither this nor `began`: they ceased to touch
  // Values at the end of the step; zero if the bodies no longer touch.
  Vector3 point = Vector3::Zero();   ///< m, world frame: the mean of their manifold points, by force if there is any
  Vector3 normal = Vector3::Zero();  ///< unit, from a to b, the same mean
  double normal_force = 0;           ///< N, of all of them, in the last substep: 0 where they parted before
  // These count all of the step, whether or not they still touch at its end; zero where they ceased to.
  double impulse = 0;         ///< N s, along the normals of all of them
  double approach_speed = 0;  ///< m/s, the fastest that a manifold point closed at before it was solved
  std::uint32_t child_a = 0;  ///< in a compound, else 0: of the two shapes that pushed each other most
  std::uint32_t child_b = 0;
};

/// A body that got into a sensor, or out of it, in the last step. The poses at its end count. What a continuous sensor
/// sees pass through within the step gets in and out of it.
struct SensorEvent {
  BodyId sensor;
  BodyId body;
  bool entered;                    ///< else it left, or one of the two was removed
  std::uint32_t child_sensor = 0;  ///< in a compound, of two children that met the lowest; 0 of what left
  std::uint32_t child_body = 0;
};

/// A body that fell asleep or woke, by the last step or by calls before it.
struct SleepEvent {
  BodyId body;
  bool asleep;  ///< else it woke
};

/// An island whose contacts carry more than the settings' sweeps can hold up, and what a step did about it. See
/// Settings::contact_solver.
struct SolverChoice {
  BodyId lowest;  ///< of its bodies
  std::size_t bodies = 0;
  std::size_t contacts = 0;
  bool direct = false;   ///< solved at once; else swept, in finer substeps if that is what it was chosen for
  bool gave_up = false;  ///< to solve it at once was tried in vain in this step: it bounced, tumbled or didn't converge
  int iterations = 0;    ///< of its method, beyond the first solve
  const char* why = "";  ///< it was chosen; static storage
  const char* why_not = "";  ///< it was not solved at once, though it was to be; static storage
  double ms = 0;             ///< with Settings::profile: on the worker that solved it
};

/// The errors that Settings::target can limit.
enum class TargetError { Penetration, JointGap, Residual, Motion };

/// An error of an island beyond its target; see Settings::target. Penetrations and gaps are those with which the step
/// began, as the one before had left them; a residual and an error of motion are the step's own.
struct MissedTarget {
  BodyId lowest;  ///< of its bodies
  std::size_t bodies = 0;
  std::size_t contacts = 0;
  std::size_t joints = 0;
  TargetError error = {};
  double measured = 0;   ///< in the target's unit
  int substeps = 0;      ///< that the island got in this step
  const char* why = "";  ///< what keeps it beyond; static storage
};

/// A box along the world's axes: m, world frame.
struct BoundingBox {
  Vector3 lower = Vector3::Zero();
  Vector3 upper = Vector3::Zero();
};

class Snapshot;

struct ContactCandidate;  // see contact_callbacks.h
struct ModifiableContact;

/// Tells if two shapes may touch: see World::set_contact_filter().
using ContactFilter = std::function<bool(const ContactCandidate&)>;

/// Changes how two shapes touch in a step: see World::set_contact_modifier().
using ContactModifier = std::function<void(ModifiableContact&)>;

class Forces;  // see forces.h

/// Adds the forces of a moment to those that bodies feel: see World::step().
using ForceLaw = std::function<void(Forces&)>;

class World;

/// Is told of a step of dt seconds, and says whether to go on being told: see World::add_step_observer().
using StepObserver = std::function<bool(const World&, const StepReport&, double dt)>;

/// A world of rigid bodies. Independent worlds may be used from different threads; one world may be used
/// from one thread at a time. A call that changes, saves, hashes or queries a world while another thread steps it
/// throws Error, in every build, as far as a flag can tell; what only looks up a body's state is not held up by that.
/// Same calls, same bits: whatever the threads, vector width or machine.
///
/// A call that runs out of memory throws std::bad_alloc. If a change was half done by then, calls throw Error from there
/// on, until the world is restored from a snapshot: of its own, or of any bodies.
class World {
 public:
  /// Throws Error on a setting out of range, or an instruction set that this machine lacks.
  explicit World(const WorldDef& def = {});
  ~World();
  /// Throws Error if either is one of a Batch: these can't leave it, nor can another take the place of one.
  World(World&& other);
  World& operator=(World&& other);

  /// Throws Error naming the field and the value if the definition is unusable.
  BodyId add_body(const BodyDef& def);
  /// Wakes what touched it, and removes its joints. Throws Error on a stale id, as do all calls below that take one.
  void remove_body(BodyId id);
  bool contains(BodyId id) const;
  std::size_t body_count() const;
  /// All bodies, in order of their indices.
  std::vector<BodyId> bodies() const;
  /// The body with this name, the lowest index if several have it; none for an empty name. Looks through all names.
  std::optional<BodyId> find_body(std::string_view name) const;

  /// Pose of the body's frame, in which its shape was given; the centre of mass may lie elsewhere.
  Pose pose(BodyId id) const;
  Vector3 velocity(BodyId id) const;  ///< m/s, of the centre of mass
  Vector3 angular_velocity(BodyId id) const;
  double mass(BodyId id) const;  ///< kg; infinite for static and kinematic bodies
  BodyType type(BodyId id) const;
  bool is_asleep(BodyId id) const;

  /// m, world frame, as positions() has them; the frame's origin where there is no mass. pose() and origins() are of
  /// the frame.
  Vector3 centre_of_mass(BodyId id) const;

  /// The smallest box along the world's axes around all shapes of the body as it is placed now. Half-spaces have
  /// infinite sides.
  BoundingBox bounds(BodyId id) const;

  /// A definition of the body as it is now, that makes another like it: with its present pose, velocities, filter and
  /// whatever was changed of it, and for dynamic bodies mass and inertia, whatever these once followed from.
  BodyDef definition(BodyId id) const;

  void set_pose(BodyId id, const Pose& pose);  ///< of the body's frame, as pose() tells it
  /// Along what BodyDef::locks locks there is none, whatever is asked for.
  void set_velocity(BodyId id, const Vector3& linear, const Vector3& angular);
  /// Gives a kinematic body the velocities that take it to a pose in a step of dt seconds, turning the shorter way:
  /// what it carries or pushes goes with it, as it would not with set_pose(). It keeps them until they are set again.
  /// dt in [1e-12, 1], else Error; Error on a body of another type.
  void move_to(BodyId id, const Pose& pose, double dt);
  /// How fast the surface runs along the body, m/s and rad/s, body frame: see BodyDef::surface_velocity and
  /// surface_angular_velocity. Wakes what touches it.
  void set_surface_velocity(BodyId id, const Vector3& velocity, const Vector3& angular = Vector3::Zero());
  /// Adds to the force (N) through the centre of mass and the torque (N m) of the next step only.
  void apply_force(BodyId id, const Vector3& force, const Vector3& torque = Vector3::Zero());
  /// Changes the velocities at once by an impulse (N s) at a world-frame point (m). Error, and nothing done, where they
  /// would not be finite after it.
  void apply_impulse(BodyId id, const Vector3& impulse, const Vector3& point);
  void wake(BodyId id);
  /// Lets a dynamic body sleep at once, however fast it is, with all dynamic bodies that touched it in the last step or
  /// are joined to it, directly or through others, as they would fall asleep together by themselves: their velocities
  /// become zero, and forces for the next step are dropped. They wake together, by what wakes any sleeper: an awake or
  /// moving body that touches one of them, or a call that changes one. Nothing happens to a body that sleeps already or
  /// is out of the world, or if one of the others may not sleep. Throws Error on a static or kinematic body, on one
  /// that may not sleep, and where Settings::sleeping is false.
  void sleep(BodyId id);
  void set_filter(BodyId id, const CollisionFilter& filter);

  // Changes to a body's definition: each throws Error as add_body() does, and wakes the body and what touches it.
  // Existing contacts follow in the next step.
  void set_material(BodyId id, const Material& material);
  /// kg, > 0, of a dynamic body. Its inertia changes by the same factor, its centre of mass stays.
  void set_mass(BodyId id, double mass);
  void set_gravity_scale(BodyId id, double scale);
  void set_damping(BodyId id, double linear, double angular);  ///< 1/s, >= 0
  /// Its frame, mass and rigid motion stay; inertia and centre of mass become those of the new shape at this mass,
  /// whatever the definition gave. What touched it is found anew, without warm start.
  void set_shape(BodyId id, const Shape& shape);
  /// Gives a body's HeightField other heights (m; NaN: a hole) in a rectangle of samples, of so many columns, from that
  /// sample on, row after row. What touches it near there is found anew and wakes, all else goes on as it was. Takes
  /// time linear in the samples of the field, a copy of which it makes: other bodies of the shape keep theirs. Throws
  /// Error if the body has another shape, the rectangle is not within the field, or a height is infinite.
  void set_heights(BodyId id, std::uint32_t column, std::uint32_t row, std::uint32_t columns,
                   std::span<const double> heights);
  /// Makes a body, under its id, what a definition says: another type, sensor or not, continuous or not, other
  /// locks, mass, inertia, centre of mass, materials of a compound's children, or anything else that add_body() takes.
  /// Begin with definition(): what is as there stays to the bit, rounding of a mass that goes with other changes aside.
  /// A body that moves as it did keeps the rigid motion of its frame; one that becomes static stops. Static and
  /// kinematic bodies have no mass, so one that becomes dynamic weighs what its definition says. What touched it is
  /// found anew, without warm start, where its type, shapes, centre of mass, `sensor` or `continuous` change, and only
  /// there. Throws Error as add_body() does: nothing is changed then.
  void set_definition(BodyId id, const BodyDef& def);
  /// Takes a body out of the simulation, or lets it take part again. A disabled body keeps its id, pose and velocities.
  /// It doesn't move, touches nothing, is found by no query and feels no force, also none that is applied meanwhile;
  /// its joints are suspended. What touched it or is joined to it wakes, as the body does when it is back, where it was
  /// or has been put since. Bodies are enabled as they are added. Throws Error on a body in quarantine.
  void set_enabled(BodyId id, bool enabled);
  bool is_enabled(BodyId id) const;
  Material material(BodyId id) const;
  /// BodyDef::user_data. Changing it wakes nobody.
  std::uint64_t user_data(BodyId id) const;
  void set_user_data(BodyId id, std::uint64_t data);
  /// BodyDef::name. Valid until the next call that isn't const. Changing it wakes nobody.
  std::string_view name(BodyId id) const;
  void set_name(BodyId id, std::string_view name);

  // Many bodies at once, a column each, as the calls for one do: all of it, or Error and nothing.
  /// Origins of the bodies' frames (m), and orientations as x, y, z, w.
  void set_poses(std::span<const BodyId> ids, const Eigen::Ref<const Eigen::Matrix3Xd>& positions,
                 const Eigen::Ref<const Eigen::Matrix4Xd>& orientations);
  void set_velocities(std::span<const BodyId> ids, const Eigen::Ref<const Eigen::Matrix3Xd>& linear,
                      const Eigen::Ref<const Eigen::Matrix3Xd>& angular);
  void apply_forces(std::span<const BodyId> ids, const Eigen::Ref<const Eigen::Matrix3Xd>& forces,
                    const Eigen::Ref<const Eigen::Matrix3Xd>& torques);

  /// Sets if two bodies may touch at all, regardless of their filters. Holds until either is removed. Joints that keep
  /// them apart do so either way.
  void set_collision_enabled(BodyId a, BodyId b, bool enabled);

  /// Sets friction and restitution between two materials, by Material::id, and wakes who touches by it. Replaces what
  /// was set for the two before; a pair that says neither takes that back. Throws Error on an id of 0 and on numbers
  /// out of range.
  void set_material_pair(const MaterialPair& pair);
  /// All of them, the lower id first, in order. Valid until the next call that isn't const.
  std::span<const MaterialPair> material_pairs() const;

  /// Sets a function that says whether two shapes may touch, for what masks and groups can't say; an empty one unsets
  /// it. Steps ask it, once, as the bounds of two shapes, with the margins that they have in the broadphase, come to
  /// overlap: pairs with a dynamic body that filters, disabled pairs and joints let touch. What it says holds until
  /// these bounds come apart, or one of the bodies is removed or gets another shape, and in continuous collision too.
  /// Earlier answers, and pairs that were near before it was set, are left as they are: refilter() has them asked
  /// again. Sensors go by filters alone, and queries by theirs: see QueryFilter::as.
  ///
  /// This function and the modifier are called on the thread that steps, one call after another: in each step, or each
  /// substep under a force law, first the filter of new pairs, in order of the lower body index, the higher one and the
  /// children's numbers; then the modifier of what touches, in that order and of the part, and after these, likewise,
  /// of what woke by that; then the filter of what continuous collision meets beyond bounds. They may look at the world
  /// as it is then, but not change, step, save or restore it, which throws Error. What the first of them throws goes
  /// through at the end of the step, which is taken as if that call had changed nothing and no other were made in it.
  ///
  /// Functions are no part of a world's state: snapshots, scene files and restore() leave them out, and alone. What the
  /// filter said that still holds is, so a world that is restored comes to the same bits if it has functions that do
  /// the same. A recording has what they said, and is replayed without them.
  void set_contact_filter(ContactFilter filter);
  /// Sets a function that may change what two touching shapes do to each other in a step: friction, restitution, how
  /// fast their surfaces run, and whether they, or points of theirs, push each other at all. An empty one unsets it.
  /// Steps ask it of each manifold with points, also of such that are a little apart yet, while one of the bodies is
  /// awake and dynamic; bodies that sleep stay as they are until they wake. When and in which order: see
  /// set_contact_filter(). Bodies that are switched off against each other neither wake nor stop each other; continuous
  /// collision stops what is fast at a shape that it doesn't touch yet, for the rest of that step.
  void set_contact_modifier(ContactModifier modifier);
  /// Has the contact filter asked again, in the next step, of all that is near the body, as set_contact_filter() says:
  /// for when it would say something else. What it says now is as before keeps its contacts and impulses. Without a
  /// filter all may touch again. Wakes the body and what touches it.
  void refilter(BodyId id);

  /// Bodies that are out of the world because their state was, or was about to become, not finite or absurd: see
  /// Quarantine for the bounds. In order of id. Valid until the next call that isn't const.
  ///
  /// A step checks each body that was added, moved or pushed since the last one before it meets anything; one that
  /// fails is taken out, and to all others that is as if it had been removed there and then, bit for bit. A body that
  /// breaks in the solve is taken out at the end of that step, in which it may have acted on what it touched. A body in
  /// quarantine keeps its id and has its last good pose and no velocity. It touches nothing, is found by no query and
  /// feels no force; joints to it are suspended. What touched or was joined to it wakes.
  std::span<const Quarantined> quarantined() const;
  bool is_quarantined(BodyId id) const;
  /// Lets a body in quarantine take part again, as it was or as set_pose and set_velocity have put it since; its joints
  /// act again. Throws Error on one that is not in quarantine, or whose pose and velocities are still out of bounds.
  void release(BodyId id);

  /// Joins two bodies, and wakes them. Throws Error naming the field and the value if the definition is unusable.
  JointId add_joint(const JointDef& def);
  /// Wakes its bodies. Throws Error on a stale id, as do all calls below that take one. A joint goes with its bodies.
  void remove_joint(JointId id);
  bool contains(JointId id) const;
  std::size_t joint_count() const;
  /// All joints, in order of their indices.
  std::vector<JointId> joints() const;
  /// Finds a joint by name, like find_body().
  std::optional<JointId> find_joint(std::string_view name) const;
  const JointDef& joint(JointId id) const;
  JointState joint_state(JointId id) const;
  // JointDef::user_data and name, as those of bodies.
  std::uint64_t user_data(JointId id) const;
  void set_user_data(JointId id, std::uint64_t data);
  std::string_view name(JointId id) const;
  void set_name(JointId id, std::string_view name);
  /// Changes a joint under its id: frames, what acts along its coordinates, `collide`, break limits, name, user_data.
  /// Throws Error as add_joint() does, and for a definition of another kind, or between other bodies, than the joint
  /// was made with: nothing is changed then. Wakes, if anything but name and user_data differs. What stays as it was
  /// keeps its bits and its warm start; an angle counts on as after set_pose(). Other numbers of ranges, motors and
  /// breaking cost nothing; other frames or springs, and what becomes free or is no longer, have islands made anew.
  void set_joint(JointId id, const JointDef& def);
  void set_joint(JointId id, const JointKind& kind);  ///< the same of the kind alone
  // The same for one of a joint's coordinates, numbered as in JointState; of a ConeTwistJoint the twist, 1, alone. Each
  // throws Error if the joint has no such coordinate, or no motor, servo, along it.
  const JointAxis& joint_axis(JointId id, std::size_t coordinate = 0) const;
  void set_joint_axis(JointId id, const JointAxis& axis, std::size_t coordinate = 0);
  void set_motor_speed(JointId id, double speed, std::size_t coordinate = 0);    ///< m/s or rad/s
  void set_servo_target(JointId id, double target, std::size_t coordinate = 0);  ///< m or rad
  /// A joint that is not enabled does nothing, nor keeps its bodies from touching. One that broke is whole again when
  /// it is. Wakes.
  void set_joint_enabled(JointId id, bool enabled);
  /// Says which of its full turns an angle is in: the one that brings it nearest to `angle`, rad. For after set_pose(),
  /// from which an angle counts on as if it had turned by less than half a turn. It has no effect on coordinates of
  /// which nobody counts turns: see HingeJoint. Wakes. Throws Error if the joint has no such coordinate, or on an angle
  /// that is not finite or beyond 1e15.
  void count_turns_from(JointId id, double angle, std::size_t coordinate = 0);

  void set_gravity(const Vector3& gravity);
  void set_settings(const Settings& settings);
  /// s, of all that was stepped since the world was made: the sum of dt, which snapshots hold and restore() sets back.
  double time() const;
  const Settings& settings() const;
  const Vector3& gravity() const;
  int threads() const;
  /// From the next step on; as WorldDef::threads. No bit of a result depends on it, so recordings don't have it. Throws
  /// Error for a world of a Batch.
  void set_threads(int threads);
  Simd simd() const;  ///< the instruction set in use, never Auto

  /// Advances by dt seconds. dt in [1e-12, 1], else Error; nothing else is ever thrown from a step but what functions
  /// of yours throw: see set_contact_filter(); and std::bad_alloc.
  StepReport step(double dt);
  /// The same under forces that depend on where bodies are, how fast they are, and the time: controllers, stiff
  /// springs, fields. The law is called on this thread as each of Settings::substeps begins, and as the last one ends,
  /// so that smooth forces on what touches nothing are of second order in the substep. They add to those of
  /// apply_force(), and like these they wake bodies.
  ///
  /// Each substep is a step of its own, whose contacts are found anew: it costs as much as one. Events are those of the
  /// whole step; of the report's counts, what was done is summed up, and what there is, is as of the last substep. A
  /// recording holds the forces, and is replayed without the law. What the law throws goes through: the world is then
  /// as the last whole substep left it.
  StepReport step(double dt, const ForceLaw& law);
  /// Adds a function that is called as each step ends, whoever asked for it, on the thread that steps, until it says
  /// false: to film, measure or log a run. It may look at the world and ask what a step came to, but not change, step,
  /// save or restore it, which throws Error. Several are called in the order in which they were added. What one throws
  /// goes through, and the others miss that step; the world is as the step left it. Observers are no part of a world's
  /// state. Throws Error on an empty one.
  void add_step_observer(StepObserver observer);

  /// After a step: one entry a manifold point that carries force, in order of body ids and features.
  std::span<const ContactForce> contact_forces() const;
  /// The contact forces of one body, in the same order.
  std::vector<ContactForce> contact_forces(BodyId id) const;
  /// One entry for two bodies that press on each other, in order of ids, of which a's is the lower: what
  /// contact_forces() adds up to, in less time. Valid until the next call or change.
  std::span<const PairForce> pair_forces() const;

  /// After a step: what all contacts of a body exert on it, in the last substep, with friction and what holds back
  /// rolling and spinning.
  Wrench contact_wrench(BodyId id) const;
  /// The same of all bodies, one column a body index: force (N) in 3 rows, torque (N m) in 3 more.
  Eigen::Matrix<double, 6, Eigen::Dynamic> contact_wrenches() const;

  /// After a step with Settings::accelerations: what the velocities changed by within it, by its length, one column a
  /// body index; of bodies added since it is zero. Changes by calls between steps don't count. Valid until the next
  /// call that isn't const. Throws Error where the setting is off, or without a step since it was set or the world was
  /// restored.
  Eigen::Map<const Eigen::Matrix3Xd> accelerations() const;          ///< m/s^2, of centres of mass
  Eigen::Map<const Eigen::Matrix3Xd> angular_accelerations() const;  ///< rad/s^2
  /// The reading of an accelerometer at a point (m) of the body's frame, m/s^2, along that frame's axes: the point's
  /// acceleration, less gravity. At rest that is 9.81 m/s^2 upwards, in free fall zero. From accelerations(), with the
  /// pose and spin at the step's end: a + a' x r + w x (w x r) - g. Throws Error as these do.
  Vector3 proper_acceleration(BodyId id, const Vector3& point = Vector3::Zero()) const;

  /// After a step with Settings::contact_events: what began, what ended and, where that is asked for, what goes on, in
  /// order of body ids. Throws Error where the setting is off.
  std::span<const ContactEvent> contact_events() const;

  /// After a step: what got into sensors and out of them, in order of the sensors' ids, then the bodies'. Sensors
  /// notice dynamic and kinematic bodies that their filters let them, and others if they are to: see
  /// BodyDef::notices_static and notices_sensors.
  std::span<const SensorEvent> sensor_events() const;
  /// Which bodies were in a sensor at the end of the last step, in order. Throws Error on a body that isn't one.
  std::vector<BodyId> bodies_in(BodyId sensor) const;

  /// After a step with Settings::sleeping: bodies that sleep and didn't as the step before ended, or the reverse, in
  /// order. Bodies that were added, removed or disabled since have none.
  std::span<const SleepEvent> sleep_events() const;

  /// After a step: joints that broke, and that left or reached the ends of their ranges, in order of ids. Those of a
  /// joint that sleeps, is not enabled or breaks have nothing to tell.
  std::span<const JointEvent> joint_events() const;

  /// After a step: islands whose contacts were not left to the sweeps of the settings, in order of their lowest bodies.
  std::span<const SolverChoice> solver_choices() const;

  /// After a step: islands with an error beyond its target, in order of their lowest bodies and of errors. Empty where
  /// Settings::target asks for nothing.
  std::span<const MissedTarget> missed_targets() const;

  /// Memory of this world by use, in a fixed order, without data that bodies share, such as hulls and meshes.
  std::vector<MemoryUse> memory() const;
  /// Asks for this world's memory, up to 128 kB of it, ahead of a step: for who steps many small worlds in turns, of
  /// the next one. Changes nothing but time. A Batch does it by itself.
  void prefetch() const;

  /// After a step with Settings::keep_contact_problem: what the last substep's sweeps had to solve, and their answer,
  /// before restitution. Empty after a step without it, or that lost a body in its solve, or once a body
  /// has been removed.
  ContactProblem contact_problem() const;

  /// Pose and velocities of one body.
  BodyState state(BodyId id) const;

  /// m, of the bodies' frames, a column a body index: positions() are of centres of mass, which in most bodies is the
  /// same place.
  Eigen::Matrix3Xd origins() const;

  /// Bulk views over all bodies, one column a body index (BodyId::index). Columns of removed bodies
  /// keep their last values until the index is used again. Valid until a body is added.
  Eigen::Map<const Eigen::Matrix3Xd> positions() const;           ///< m, of centres of mass
  Eigen::Map<const Eigen::Matrix4Xd> orientations() const;        ///< x, y, z, w
  Eigen::Map<const Eigen::Matrix3Xd> velocities() const;          ///< m/s, of centres of mass
  Eigen::Map<const Eigen::Matrix3Xd> angular_velocities() const;  ///< rad/s
  /// From here on the memory of these views stays, at most twice as much, until the world's end: one that was taken
  /// before bodies were added or others restored can still be read, and tells no more than it did then.
  void keep_views();

  /// Writes the state of the world to a snapshot, over what that holds, whose memory is used again: no allocation where
  /// it is large enough and no body came or went since the last save.
  void save(Snapshot& snapshot) const;
  /// Goes back, or on, to the state of a snapshot: of this world, whatever has been added, removed or changed since, or
  /// of another with the same bodies. From there on every step has the same bits as it has in the world that was saved,
  /// and every id given out is the same; threads, instruction set, profile, Settings::accelerations and
  /// keep_contact_problem stay this world's. What a step reports (forces, events) is empty until the next one.
  ///
  /// Bodies that the snapshot lacks are removed, those that only the snapshot has are added. Throws Error, and changes
  /// nothing, if the snapshot is empty; if it is another world's, or from a file, and a body with the same id is not of
  /// the same shape, mass or material; or if it is from a file and a hull, mesh or height field is on no body here.
  void restore(const Snapshot& snapshot);

  /// From here on notes down in a file every call that changes this world, with its arguments, and what every step
  /// comes to, as hashes, so that replay() can do it all again and tell where it comes to something else. Begins with
  /// the world's state and all geometry, each once. No bit of what the world does depends on it.
  ///
  /// Until stop_recording(), or the world's end at the latest, the recording is in a file with ".partial" after the
  /// name; it can be replayed even if the program ends otherwise. Throws Error if the file can't be written, an option
  /// is out of range or a recording is under way.
  void record(const std::string& path, const RecordingOptions& options = {});
  bool is_recording() const;
  /// Ends the recording, and gives its file its name. Throws Error if there is none; or if something of it could not be
  /// written, when there is no file, nor a recording any more.
  void stop_recording();

  /// 64-bit hash of everything that the future of this world depends on.
  std::uint64_t state_hash() const;

  /// The same by body, to find where two worlds part. One entry a body index; of removed bodies all parts are 0. Worlds
  /// with other hashes here have other state hashes; those whose bodies all have the same may still differ in settings,
  /// gravity or which ids come next.
  std::vector<BodyHash> body_hashes() const;
  /// The hash of one body, at the cost of looking at its own contacts and joints.
  BodyHash body_hash(BodyId id) const;

 private:
  friend struct QueryAccess;      // see queries.h
  friend struct MechanismAccess;  // see mechanism.h
  friend class Batch;
  friend class Snapshot;
  friend class Replay;
  friend class ForcedStep;

  /// From here on it isn't moved.
  void stay_in_batch();
  /// Has definitions of joints that are alike in memory that both worlds use.
  void share_definitions(const World& alike);
  /// Asks for what prefetch() reads, to be found in cache by it.
  void prefetch_places() const;

  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// A joint at one point (m) of the world, with the x axis of its frames along `axis`, as the bodies are placed now:
/// every coordinate of it starts at 0. Hinges turn about `axis`, sliders move along it, cones and universal joints
/// point along it. Throws Error on a stale id, or on an axis that is zero or not finite. The result is for
/// World::add_joint(), once what else is to be set is set.
JointDef joint_at(const World& world, JointKind kind, BodyId first, BodyId second, const Vector3& point,
                  const Vector3& axis = Vector3::UnitX());

}  // namespace atl
