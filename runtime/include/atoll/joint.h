#pragma once

#include <atoll/types.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace atl {

/// Names a joint for its lifetime, as BodyId does a body.
struct JointId {
  std::uint32_t index = std::numeric_limits<std::uint32_t>::max();
  std::uint32_t generation = 0;

  friend auto operator<=>(const JointId&, const JointId&) = default;
};

inline constexpr double unlimited = std::numeric_limits<double>::infinity();

/// The range of a coordinate, in m or rad; lower <= upper. Infinite where there is none; locked where both are equal:
/// then a spring and a motor along it have nothing to do, and are left out.
struct JointRange {
  double lower = -unlimited;
  double upper = unlimited;
  /// In [0, 1]: the part of its rate with which the coordinate comes back from an end, once bounces last longer than a
  /// substep. Newton's law.
  double restitution = 0;

  bool operator==(const JointRange&) const = default;
};

/// A damped spring that pulls a coordinate to its rest. Any stiffness is stable where joints are solved at once, and of
/// a swept joint alone. Without damping no energy is lost; but among swept joints, a spring that would close more than
/// 0.3 of its way in a substep is damped until it doesn't, and chains of three and more whose springs are stiff for all
/// that they carry want more substeps, or JointSolver::Auto. Given either as a frequency, with the two bodies'
/// effective mass along the coordinate as they are at the time, as if nothing else held them; or, with `stiffness` or
/// `damping`, as a force linear in offset and speed.
struct JointSpring {
  double hertz = 1;                      ///< > 0
  double damping_ratio = 1;              ///< >= 0; 1 is critical
  double rest = 0;                       ///< m or rad, finite
  std::optional<double> stiffness = {};  ///< N/m or N m/rad, >= 0; with it or `damping`, the first two do nothing
  std::optional<double> damping = {};    ///< N s/m or N m s/rad, >= 0

  bool is_linear() const { return stiffness || damping; }

  bool operator==(const JointSpring&) const = default;
};

/// Turns a motor into a servo. At least one gain must be > 0; the servo is stable for any gains.
struct JointServo {
  double target = 0;     ///< m or rad, finite
  double stiffness = 0;  ///< N/m or N m/rad, finite and >= 0
  double damping = 0;    ///< N s/m or N m s/rad, finite and >= 0

  bool operator==(const JointServo&) const = default;
};

/// Drives a coordinate at a speed, by no more than so much force or torque. At speed 0 it is friction, or a brake.
///
/// With a servo it drives it to a position instead, by stiffness * (target - position) + damping * (speed - rate), cut
/// off where that is more force than it has.
struct JointMotor {
  double speed = 0;                      ///< m/s or rad/s, finite
  std::optional<double> max_force = {};  ///< N or N m, >= 0, or unlimited. To be given: there is none that suits all.
  std::optional<JointServo> servo = {};

  bool operator==(const JointMotor&) const = default;
};

/// A coordinate of a joint, and what acts along it. Range, spring, motor and friction may all be there.
struct JointAxis {
  JointRange range = {};
  std::optional<JointSpring> spring = {};
  std::optional<JointMotor> motor = {};
  /// kg or kg m^2, finite and >= 0: inertia that moves with the coordinate and with nothing else, as of the rotor of a
  /// motor (its own, times the square of the gear ratio). It has no weight, and does nothing where the range is locked.
  double armature = 0;
  /// N or N m, finite and >= 0: dry friction, which holds the coordinate where it is until more than that acts along
  /// it, and acts against its rate then. Nothing where the range is locked.
  double friction = 0;

  bool operator==(const JointAxis&) const = default;
};

// Each kind below says which coordinates it locks, a row of constraints each, and which it leaves free. Ends of
// ranges are checked where a coordinate has natural bounds. Frames that start apart are pulled together.

/// Turns a ball joint to an orientation, by the shortest way: with a torque of stiffness * (the rotation vector to the
/// target) + damping * (angular_velocity - the rate of that vector), cut off about each axis of the target where that
/// is more than max_torque. At most half a turn is left at any time; beyond, the other way is shorter. At least one
/// gain must be > 0; the servo is stable for any gains. A moment of inertia I (kg m^2) about the joint comes to the
/// target with frequency f (Hz) and damping ratio z by a stiffness of I (2 pi f)^2 and a damping of 2 z I (2 pi f).
struct BallServo {
  Quaternion target = Quaternion::Identity();  ///< of the second frame in the first; of any length but 0
  Vector3 angular_velocity = Vector3::Zero();  ///< rad/s, about the axes of the target
  double stiffness = 0;                        ///< N m/rad, finite and >= 0
  double damping = 0;                          ///< N m s/rad, finite and >= 0
  double max_torque = unlimited;               ///< N m, >= 0, or unlimited

  bool operator==(const BallServo& other) const {
    return target.coeffs() == other.target.coeffs() && angular_velocity == other.angular_velocity &&
           stiffness == other.stiffness && damping == other.damping && max_torque == other.max_torque;
  }
};

/// The origins of the frames stay together: 3 rows.
struct BallJoint {
  /// N m, finite and >= 0: the torque that holds back turning, about each axis of the first frame, or of the target of
  /// a servo.
  double friction = 0;
  std::optional<BallServo> servo = {};

  bool operator==(const BallJoint&) const = default;
};

/// Origins together and x axes parallel: 5 rows. The free coordinate is the angle about x by which the second frame has
/// turned from the first, rad. It starts with the turn nearest to its range, and is counted over full turns as long as
/// it has a range, a spring or a motor; without these nobody counts, and it is in (-pi, pi].
struct HingeJoint {
  JointAxis angle = {};

  bool operator==(const HingeJoint&) const = default;
};

/// The second frame slides along the x axis of the first, without turning: 5 rows. The free coordinate is the offset,
/// m.
struct SliderJoint {
  JointAxis offset = {};

  bool operator==(const SliderJoint&) const = default;
};

/// The frames stay together: 6 rows.
struct FixedJoint {
  bool operator==(const FixedJoint&) const = default;
};

/// The distance of the origins, which must be more than 1 nm to start with: 1 row. A rod with equal ends of the range,
/// a rope with a lower end of 0, at which nothing stops. Neither end is negative, and the upper one is not 0: that is a
/// BallJoint.
struct DistanceJoint {
  JointAxis distance = {.range = {1, 1}};

  bool operator==(const DistanceJoint&) const = default;
};

/// Origins together, the first x axis at right angles to the second y axis: 4 rows, as a cross of two hinges. Angles
/// are counted over full turns as a hinge's is.
struct UniversalJoint {
  JointAxis first = {};   ///< angle about the first frame's x axis, rad
  JointAxis second = {};  ///< angle about the second frame's y axis, rad

  bool operator==(const UniversalJoint&) const = default;
};

/// Origins together: 3 rows, and limits of the swing between the x axes and of the twist about them. JointState tells
/// of the swing, and then of the twist. At a swing of half a turn there is no twist: what acts along it fades from 120
/// degrees of swing on, and is gone there.
struct ConeTwistJoint {
  double swing_limit = unlimited;  ///< rad, in (0, pi), or unlimited
  JointAxis twist = {};            ///< rad; the ends of a range in [-pi, pi]
  double swing_friction = 0;       ///< N m, >= 0: torque against turning with the swing, and as much across it

  bool operator==(const ConeTwistJoint&) const = default;
};

/// The coordinates that the three turns of a SixDofJoint are.
enum class SixDofTurns : std::uint8_t {
  /// Twice the vector part of the relative quaternion: the axis times twice the sine of half the angle, which is the
  /// rotation vector in rad to second order (0.4% less at 18 degrees, 10% less at 90), and grows up to half a turn,
  /// where it is 2. Ends of ranges are in [-2, 2]. What acts along a turn that isn't locked at 0 fades from 151 degrees
  /// on, and is gone at half a turn, where the turn would change its sign. A motor's speed is that of turning about the
  /// axis, rad/s, and JointState::speed that of the coordinate.
  Vector,
  /// Angles of three hinges, each of which carries the next, rad: about the first frame's x axis, the y axis as turned
  /// by that, and the z axis as turned by both, which is the second frame's (Cardan angles, a gimbal). The one in the
  /// middle is in [-pi/2, pi/2], as ends of its range are, and the others are counted over full turns as a hinge's is.
  /// Forces along those fade within 14 degrees of the ends of the middle one, where the two are about one axis, and are
  /// gone there.
  AnglesXYZ,
  AnglesXZY,  ///< likewise, about x, then z, and then y: turn[2] is the one in the middle
};

/// Each of six coordinates is locked (a range of equal ends), limited or free: offsets along the axes of the first
/// frame, m, and turns about them.
struct SixDofJoint {
  std::array<JointAxis, 3> offset = {};
  std::array<JointAxis, 3> turn = {};  ///< about x, y and z, in whatever order they follow one another
  SixDofTurns turns = SixDofTurns::Vector;

  bool operator==(const SixDofJoint&) const = default;
};

/// The turning of the first body about its frame's x axis, plus `ratio` times that of the second about its own, stays
/// as it was: 1 row. As a rack, the second moves along its x axis instead, and the ratio is in rad/m. What carries the
/// gears is up to other joints. JointState tells of the sum of the two, which is to be 0.
struct GearJoint {
  double ratio = 1;  ///< finite and not 0
  bool rack = false;

  bool operator==(const GearJoint&) const = default;
};

/// A wheel, the second body, at a chassis: it moves along the z axis of the first frame against the suspension, turns
/// about that axis to steer, and spins about the y axis of its own frame: 3 rows, and 1 where steering is locked.
/// Angles are counted over full turns as a hinge's is.
///
/// A spring of the suspension that is given as a frequency is that of a dynamic chassis on it: its stiffness counts by
/// the mass that the chassis shows at the wheel, along the suspension, as the joint is added or set. It is replaced by
/// that stiffness and damping in the joint's definition. At 2 Hz a box on a wheel at each corner sinks by about 0.1 m.
/// An axis that is given replaces all of the default one. So a range of the suspension whose ends differ needs a spring
/// or a motor beside it, else Error: the chassis would drop onto its end.
struct WheelJoint {
  JointAxis suspension = {.spring = JointSpring{.hertz = 2, .damping_ratio = 0.7}};  ///< m
  JointAxis steering = {.range = {0, 0}};                                            ///< rad
  JointAxis spin = {};                                                               ///< rad

  bool operator==(const WheelJoint&) const = default;
};

/// A coordinate q of another joint, by a polynomial: a part of the length of a tendon.
struct TendonTerm {
  JointId joint = {};            ///< not a tendon
  std::uint32_t coordinate = 0;  ///< one that the joint's kind names, as World::joint_axis() numbers them
  /// Finite factors of q^0 to q^4, in m, or rad, by powers of that of q; not all of those after the first are 0.
  std::array<double, 5> polynomial = {0, 1};

  bool operator==(const TendonTerm&) const = default;
};

/// Couples coordinates of other joints: its length, the sum of its terms, is a coordinate as any other. Locked at 0, it
/// makes one joint mimic another: q1 - p(q2) = 0. Free, with a spring, range, motor or friction, it is a tendon that
/// runs over several joints, and acts on each by what acts along it times the slope of the term. 1 row.
///
/// Its bodies are those of the joints of its terms, and JointDef::first, second and collide follow from them: what is
/// given is replaced; frames do nothing. It acts while all these joints do, and goes with the first of them that is
/// removed. JointState tells of its length and rate, and of the force (N, or N m) along it as the x of `force`.
///
/// Joints that hang together with it are solved at once, unless the settings say that all are solved one after another,
/// or they make so many loops that they are. Then it comes to rest at the ends of its range, whatever the restitution.
struct TendonJoint {
  static constexpr std::size_t max_terms = 4;

  std::vector<TendonTerm> terms = {};  ///< 1 to 4
  JointAxis length = {};               ///< m, or rad

  bool operator==(const TendonJoint&) const = default;
};

/// Coordinates of kinds that have several, as JointState and calls of World number them. Of other kinds it is 0.
struct UniversalCoordinate {
  enum Number : std::uint32_t { First, Second };
};
struct ConeTwistCoordinate {
  enum Number : std::uint32_t { Swing, Twist };
};
struct SixDofCoordinate {
  enum Number : std::uint32_t { OffsetX, OffsetY, OffsetZ, TurnX, TurnY, TurnZ };
};
struct WheelCoordinate {
  enum Number : std::uint32_t { Suspension, Steering, Spin };
};

using JointKind = std::variant<BallJoint, HingeJoint, SliderJoint, FixedJoint, DistanceJoint, UniversalJoint,
                               ConeTwistJoint, SixDofJoint, GearJoint, WheelJoint, TendonJoint>;

/// Everything a joint starts with.
struct JointDef {
  JointKind kind = BallJoint{};
  BodyId first = {};  ///< of two different bodies; a joint of which neither is dynamic does nothing
  BodyId second = {};
  Pose frame_first = {};  ///< where the joint is, in the first body's frame
  Pose frame_second = {};
  /// True if the two bodies may touch. If it is false, they don't touch even if another of their joints allows it; they
  /// may touch again once no such joint is enabled, if filters and World::set_collision_enabled let them.
  bool collide = false;
  double break_force = unlimited;   ///< N, > 0: it breaks after a step at whose end it had to hold more
  double break_torque = unlimited;  ///< N m, > 0
  std::string name = {};            ///< for people, and World::find_joint(): as a body's. Joints may share one.
  std::uint64_t user_data = 0;      ///< yours: World keeps it, and saves it with the joint, and never looks at it

  bool operator==(const JointDef&) const = default;
};

/// The state of a joint at the end of the last step.
struct JointState {
  bool enabled = true;
  bool broken = false;                  ///< it is not enabled then, until it is again, and keeps what broke it
  Vector3 force = Vector3::Zero();      ///< N, on the second body, world frame; in the last substep. See TendonJoint.
  Vector3 torque = Vector3::Zero();     ///< N m, on the second body, about its frame's origin, world frame
  std::array<double, 6> position = {};  ///< of the coordinates that its kind names, in that order, as of now; m or rad
  std::array<double, 6> speed = {};     ///< m/s or rad/s
  /// N or N m, by coordinate: the part of `force` and `torque` that its motor or servo exerts along it. A servo's is
  /// that of its law at this position and speed. A motor's is what springs and friction leave of all that acts along
  /// the coordinate; all it has, where it pushes at an end of the range.
  std::array<double, 6> motor = {};
};

enum class JointEventKind {
  Broke,
  ReachedLimit,  ///< some coordinate is at an end of its range at which it was not a step ago
  LeftLimit,     ///< some coordinate is no longer at an end of its range at which it was
};

struct JointEvent {
  JointId joint;
  JointEventKind kind;
  Vector3 force = Vector3::Zero();   ///< N, as JointState has it: of one that broke, what broke it
  Vector3 torque = Vector3::Zero();  ///< N m
};

}  // namespace atl

/// For unordered containers.
template <>
struct std::hash<atl::JointId> {
  std::size_t operator()(const atl::JointId& id) const noexcept {
    return std::hash<std::uint64_t>()(std::uint64_t{id.generation} << 32 | id.index);
  }
};
