#pragma once

#include <solver/constraints/joint_coordinates.h>
#include <solver/integrate/body_table.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

namespace atl::solver {

/// The coordinates that joints lock, limit and drive: see joint_coordinates.h. Axes are the first frame's where not
/// said otherwise.
enum class Coordinate : std::uint8_t {
  OffsetX,
  OffsetY,
  OffsetZ,
  Distance,
  TurnX,  ///< 2 sin(angle / 2) about an axis
  TurnY,
  TurnZ,
  RotationX,  ///< parts of the rotation vector, of at most half a turn
  RotationY,
  RotationZ,
  SwingAlongY,  ///< 2 sin(angle / 2) of the swing between the x axes, its part along the second y axis
  SwingAlongZ,
  SkewXY,  ///< by which the first x and the second y axis fall short of a right angle
  SkewZY,
  BetweenZ,  ///< SkewXY the other way: of three turns about x, z and y one after another, the one about z
  BetweenY,  ///< of three turns about x, y and z, the one about y
  Twist,     ///< about the x axes
  Swing,
  AngleX,        ///< about the first x axis, of the second y axis
  AngleSecondY,  ///< about the second y axis, of the first x axis
  AngleXOfZ,     ///< about the first x axis, of the second z axis
  AngleSecondZ,  ///< about the second z axis, of the first x axis
  Steer,         ///< about the first z axis, of the second y axis
  Roll,          ///< about the second y axis, of the first z axis
  Length,        ///< of a tendon, the sum of its terms: see tendon.h
  SpinX,         ///< a rate only
  SpinY,
  SpinZ,
  Orbit,  ///< a rate only: of the second x axis at right angles to its swing
  Gear,   ///< a rate only: of the first about its x axis, and ratio times the second about its own
  Rack,   ///< likewise, and ratio times the second along its x axis
};

/// Tells parts of the relative quaternion, as which a turn is locked or limited.
constexpr bool is_turn(Coordinate of) { return of >= Coordinate::TurnX && of <= Coordinate::TurnZ; }
/// Tells what comes from the relative quaternion, which others need not find.
constexpr bool asks_for_turn(Coordinate of) {
  return of == Coordinate::Twist || (of >= Coordinate::TurnX && of <= Coordinate::RotationZ);
}
/// The axes of the two hinges, of a coordinate from SkewXY to BetweenY or from AngleX to Roll.
constexpr AxisPair hinges_of(Coordinate of) {
  const bool from_z = of == Coordinate::SkewZY || of == Coordinate::Steer || of == Coordinate::Roll;
  const bool to_z = of == Coordinate::BetweenY || of == Coordinate::AngleXOfZ || of == Coordinate::AngleSecondZ;
  return {from_z ? 2 : 0, to_z ? 2 : 1};
}
/// Tells angles about one of two hinges, of which the other one can come to lie along it.
constexpr bool is_hinged(Coordinate of) { return of >= Coordinate::AngleX && of <= Coordinate::Roll; }
/// Tells angles that go on over full turns.
constexpr bool counts_turns(Coordinate of) { return of == Coordinate::Twist || is_hinged(of); }
/// Tells what has a rate only, and no value.
constexpr bool is_rate(Coordinate of) { return of >= Coordinate::SpinX; }
/// Tells rates that are summed up over the substeps.
constexpr bool is_geared(Coordinate of) { return of >= Coordinate::Gear; }
/// 0, 1 or 2, of three coordinates of which `x` is the first.
constexpr int axis_of(Coordinate of, Coordinate x) { return static_cast<int>(of) - static_cast<int>(x); }

/// The law along a coordinate: impulse as a function of rate. Range, spring, motor and friction add up.
struct Law {
  static constexpr double unlimited = std::numeric_limits<double>::infinity();

  double lower = -unlimited;  ///< m or rad; locked where both are equal
  double upper = unlimited;
  double spring_hertz = 0;  ///< with the effective mass along the coordinate, as the damping ratio
  double damping_ratio = 0;
  double stiffness = 0;  ///< N/m or N m/rad; of a spring that has no frequency of its own
  double damping = 0;    ///< N s/m or N m s/rad, likewise
  double rest = 0;
  double motor_speed = 0;
  double motor_force = 0;      ///< N or N m; 0: no motor
  double servo_target = 0;     ///< m or rad, of a motor that is a servo
  double servo_stiffness = 0;  ///< N/m or N m/rad, likewise
  double servo_damping = 0;    ///< N s/m or N m s/rad, likewise: against other speeds than the motor's
  double friction = 0;         ///< N or N m, dry
  double armature = 0;         ///< kg or kg m^2, that moves with the coordinate
  double restitution = 0;      ///< at the ends of the range

  bool locked() const { return lower == upper; }
  bool limited() const { return lower > -unlimited || upper < unlimited; }
  bool springs() const { return spring_hertz > 0 || stiffness > 0 || damping > 0; }
  bool drives() const { return motor_force > 0; }
  bool is_servo() const { return drives() && (servo_stiffness > 0 || servo_damping > 0); }
  bool damps() const { return damping > 0 || (spring_hertz > 0 && damping_ratio > 0) || servo_damping > 0; }
  /// True if the impulse of a substep depends on the rate before it.
  bool looks_back() const { return springs() || is_servo() || armature > 0; }
  /// Returns true for a spring, servo, motor or armature: forces that add to the constraint's own impulse.
  bool acts_as_force() const { return drives() || looks_back(); }
  bool acts() const { return limited() || drives() || springs() || friction > 0 || armature > 0; }
};

inline constexpr std::size_t max_joint_rows = 6;
inline constexpr std::size_t max_tendon_terms = 4;

/// A polynomial of a coordinate q of another joint: a part of the length of a tendon.
struct TendonTerm {
  std::uint32_t joint = 0;
  Coordinate coordinate = Coordinate::Twist;
  std::array<double, 5> polynomial = {};  ///< of q^0 to q^4
  double position = 0;                    ///< q, m or rad, as of the end of the step; angles over full turns

  double value_at(double q) const {
    const auto& [c0, c1, c2, c3, c4] = polynomial;
    return c0 + q * (c1 + q * (c2 + q * (c3 + q * c4)));
  }
  double slope_at(double q) const {
    const auto& [c0, c1, c2, c3, c4] = polynomial;
    return c1 + q * (2 * c2 + q * (3 * c3 + q * (4 * c4)));
  }
};

/// A joint as the solver sees it: the coordinates of two frames, each with its law. The kinds of joints that users know
/// are combinations of these (runtime's make_joint).
struct alignas(64) Joint {
  std::uint32_t first = 0;  ///< bodies
  std::uint32_t second = 0;
  bool point = false;     ///< the origins stay together: 3 rows along the world's axes, ahead of the others
  bool bounces = false;   ///< some coordinate does, at the ends of its range
  std::uint8_t rows = 0;  ///< others; with those of the point at most max_joint_rows
  std::array<std::int8_t, max_joint_rows> limit = {};  ///< -1 at the lower, 1 at the upper end of the range, else 0
  Vector3 anchor_first = Vector3::Zero();              ///< m, the frame's origin from the centre of mass, body frame
  Vector3 anchor_second = Vector3::Zero();

  // State, that lasts from step to step.
  Vector3 point_impulse = Vector3::Zero();  ///< N s, of a substep, on the second body
  Vector3 tension = Vector3::Zero();        ///< N, on the second body, followed over some substeps

  // Results of the last step.
  Vector3 force = Vector3::Zero();   ///< N, on the second body, in the last substep
  Vector3 torque = Vector3::Zero();  ///< N m, about the second frame's origin

  // The members from here on are unused by a joint that only holds a point.
  Quaternion axes_first = Quaternion::Identity();  ///< from the frame to the body's
  Quaternion axes_second = Quaternion::Identity();
  std::array<Coordinate, max_joint_rows> coordinate = {};
  std::array<Law, max_joint_rows> law = {};
  double ratio = 1;                                  ///< of gears
  std::array<double, max_joint_rows> impulse = {};   ///< N s or N m s
  std::array<double, max_joint_rows> position = {};  ///< at the end of the step; angles over full turns
  /// -1 where the motor pulled backwards with all it had, 1 forwards, else 0; the same for dry friction. Set for joints
  /// that are solved at once, which start the next step from there.
  std::array<std::int8_t, max_joint_rows> motor_bound = {}, friction_bound = {};
  /// Terms of a tendon; other joints have none. A tendon has one row along Coordinate::Length, no point and no frames;
  /// its bodies are those of the joints of its terms.
  std::array<TendonTerm, max_tendon_terms> term = {};
  std::uint8_t terms = 0;

  bool is_tendon() const { return terms > 0; }
  std::size_t row_count() const { return rows + (point ? 3u : 0u); }
  /// The row along a coordinate, or `rows` if there is none.
  std::size_t row_along(Coordinate along) const {
    return static_cast<std::size_t>(std::find(coordinate.begin(), coordinate.begin() + rows, along) -
                                    coordinate.begin());
  }
  /// The number of rows with springs, servos or armatures.
  std::ptrdiff_t looking_back() const {
    return std::count_if(law.begin(), law.begin() + rows, [](const Law& of) { return of.looks_back(); });
  }
  /// Tells a joint with springs, servos, motors or armatures.
  bool acts_as_force() const {
    return std::any_of(law.begin(), law.begin() + rows, [](const Law& of) { return of.acts_as_force(); });
  }
  /// Tells a machine's joint, which holds its place by a servo or has a rotor.
  bool is_actuated() const {
    return std::any_of(law.begin(), law.begin() + rows, [](const Law& of) { return of.is_servo() || of.armature > 0; });
  }
};

/// A coordinate of two frames, `ratio` that of gears. The value of a rate only is 0, that of an angle within half a
/// turn of zero. Nothing of a tendon's length, which is of more than two frames.
JointRow coordinate_row(Coordinate coordinate, const JointFrames& frames, double ratio = 1);
/// The same of a row of a joint.
JointRow joint_row(const Joint& joint, std::size_t row, const JointFrames& frames);

/// The value in m or rad as a continuation of the position before: of angles, the turn nearest to it; of what is a rate
/// only, that position itself. A position beyond 1e15, or that is none, counts as 0.
double continued(Coordinate coordinate, double value, double before);

/// The row along which a joint's law acts.
struct LawRow {
  JointRow at;      ///< with the value that the law sees
  double position;  ///< of the coordinate, continued
};

/// One row of a joint at the given frames, the coordinate's position before given. It is that of the coordinate, but
/// fades where the coordinate has no value: a twist where the x axes are nearly opposed, the angle of a hinge where the
/// other one is nearly along it, and a turn that is not locked at zero near a half turn. There the first two would
/// change without end, and the other from one sign to the other, and springs and ranges along them would get energy
/// from nowhere. What fades is a smooth function of the pose all the same, so a
/// spring on it keeps energy.
LawRow law_row(const Joint& joint, std::size_t row, const JointFrames& frames, double before);

/// Makes of a coordinate's row one that fades, with the value that it has been continued to. `fades_turn`: also of a
/// turn, see there.
void fade(Coordinate coordinate, const JointFrames& frames, bool fades_turn, JointRow& row);

/// The frames of a joint, for bodies with their centres of mass at these positions (m). Unit quaternions.
JointFrames joint_frames(const Joint& joint, const Vector3& position_first, const Quaternion& orientation_first,
                         const Vector3& position_second, const Quaternion& orientation_second);
/// The frames at the bodies' current poses.
JointFrames joint_frames(const Joint& joint, const BodyTable& bodies);

}  // namespace atl::solver
