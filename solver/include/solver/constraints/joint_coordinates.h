#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace atl::solver {

/// One coordinate of two bodies against each other, and the row of the Jacobian that turns their velocities into its
/// rate:
///   rate = linear . (v_B - v_A) + angular_second . w_B - angular_first . w_A
/// Rows are exact derivatives at any pose. World axes throughout.
struct JointRow {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_first = Eigen::Vector3d::Zero();   ///< m for a coordinate in m, 1 for one in rad
  Eigen::Vector3d angular_second = Eigen::Vector3d::Zero();  ///< likewise
  double value = 0;                                          ///< m or rad
  /// The ratio of the coordinate's rate to the rate of turning about its axis, for a coordinate that fades; see
  /// law_row().
  double share = 1;

  double rate(const Eigen::Vector3d& v_first, const Eigen::Vector3d& w_first, const Eigen::Vector3d& v_second,
              const Eigen::Vector3d& w_second) const {
    return linear.dot(v_second - v_first) + angular_second.dot(w_second) - angular_first.dot(w_first);
  }

  /// J M^-1 J^T: what a unit of impulse along the row makes of its rate, with the sum of the two inverse masses and
  /// each body's inverse inertia in world axes.
  double response(double inverse_mass, const Eigen::Matrix3d& inverse_inertia_first,
                  const Eigen::Matrix3d& inverse_inertia_second) const {
    return inverse_mass * linear.squaredNorm() + angular_first.dot(inverse_inertia_first * angular_first) +
           angular_second.dot(inverse_inertia_second * angular_second);
  }
};

/// The two frames of a joint, each fixed to its body. A joint asks that some of the coordinates between them be zero,
/// stay in a range or move as a motor or a spring wants.
struct JointFrames {
  Eigen::Vector3d arm_first;   ///< m, of the first frame's origin from the first body's centre of mass
  Eigen::Vector3d arm_second;  ///< m
  Eigen::Vector3d offset;      ///< m, from the first frame's origin to the second's
  Eigen::Matrix3d axes_first;  ///< columns: the frame's x, y, z
  Eigen::Matrix3d axes_second;
  Eigen::Quaterniond turn;  ///< orientation of the second frame in the first, w >= 0: for turn_about() and twist()

  void set_turn(const Eigen::Quaterniond& first, const Eigen::Quaterniond& second);  ///< from the frames' orientations
};

/// Two axes, one of each frame.
struct AxisPair {
  int first, second;
};

/// The offset along axis `axis` of the first frame, m.
JointRow offset_along(const JointFrames& frames, int axis);

/// The distance of the origins, m. Where they coincide it has no direction: then along the first frame's x axis.
JointRow distance(const JointFrames& frames);

/// Twice the sine of half the angle by which the frames are turned against each other, about each axis of the first:
/// zero for all three if they are parallel, and of size up to 2 (the vector of their relative quaternion, twice;
/// Shabana, "Computational Dynamics", 2010, 8.5).
JointRow turn_about(const JointFrames& frames, int axis);

/// The rotation vector from the first frame to the second along an axis of either, rad, of at most half a turn: what
/// acts along the three is a torque along their sum (Chirikjian, "Stochastic Models, Information Theory, and Lie Groups
/// 2", 2012, 10.7.3). At half a turn it changes its sign.
JointRow rotation_about(const JointFrames& frames, int axis);

/// The swing between the x axes, as twice the sine of half of it: its parts along the second y axis (1) and z axis (2).
/// Both are zero where the x axes are parallel, and nowhere else: where they are opposed the two are of size 2, and
/// where just so, the first of them is. (Cosines of an x axis against the other y and z axes are zero there, too.)
JointRow swing_along(const JointFrames& frames, int axis_second);

/// Angle by which an axis of the first and one of the second frame fall short of a right angle, rad in [-pi/2, pi/2],
/// times `sign`. Of three turns, each about an axis at right angles to the one before, it is the one in the middle. If
/// the two are parallel the row has no direction of its own, and is taken about the first frame's next axis.
JointRow skew_between(const JointFrames& frames, AxisPair axes, double sign);

/// Angle of the twist of the second frame about the x axes, rad in (-pi, pi], and of the swing between the x axes, rad
/// in [0, pi]: the relative rotation as a twist about x and then a swing about an axis across it (Dobrowolski,
/// "Swing-twist decomposition in Clifford algebra", 2015). The twist has no value, and the row no meaning, at a swing
/// of pi; nor has the swing's row at a swing of 0 or pi, where it is about the y axis of the first frame.
JointRow twist(const JointFrames& frames);
JointRow swing(const JointFrames& frames);

/// Makes of a twist one that is 0 at a swing of pi, a smooth function of the pose: near there times s^2 (3 - 2 s), with
/// s the cosine of half the swing by tuning::fading_twist. Its value may be continued over full turns.
void fade_twist(const JointFrames& frames, JointRow& twist);

/// Fades a row of turn_about() to 0 at a half turn, where it would change its sign. The factor is that of fade_twist(),
/// with s the cosine of half the turn by tuning::fading_turn.
void fade_turn(const JointFrames& frames, int axis, JointRow& turn);

/// Angle about the first of two hinges, an axis of the first frame, by which the other one has turned from where the
/// first frame has that axis, rad in (-pi, pi]. Where the two are parallel it has no value: then 0, and the row is
/// about the first of them.
JointRow angle_about_first(const JointFrames& frames, AxisPair hinges);

/// Angle about the second of two hinges, an axis of the second frame, by which that frame's own axis has turned from
/// the first hinge, likewise.
JointRow angle_about_second(const JointFrames& frames, AxisPair hinges);

/// Fades the angle about one of two hinges to 0 where they are parallel. The factor is that of fade_twist(), with s the
/// sine between them by tuning::fading_turn. Its value may be continued over full turns.
void fade_angle(const JointFrames& frames, AxisPair hinges, JointRow& angle);

/// Rate of turning about an axis of the first frame, rad/s: of no coordinate, so the value is 0.
JointRow spin_about(const JointFrames& frames, int axis);

/// Rate at which the second x axis moves at right angles to its swing, rad/s: the angle between the x axes stays. As
/// the swing's row at a swing of 0 or pi. The value is 0.
JointRow orbit(const JointFrames& frames);

/// Rate of the first about its x axis plus `ratio` times that of the second about its own, both in space; as a rack, of
/// the second along its x axis, against the first. The value is 0.
JointRow gear(const JointFrames& frames, double ratio);
JointRow rack(const JointFrames& frames, double ratio);

}  // namespace atl::solver
