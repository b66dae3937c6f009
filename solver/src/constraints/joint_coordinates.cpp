#include <solver/constraints/joint_coordinates.h>
#include <solver/integrate/trigonometry.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

namespace atl::solver {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

// A coordinate that changes at axis . (w_B - w_A).
JointRow angular_row(const Vector3d& axis, double value) {
  return {.linear = Vector3d::Zero(), .angular_first = axis, .angular_second = axis, .value = value};
}

// Across both x axes, which it takes from the first to the second by the shorter way.
Vector3d swing_axis(const JointFrames& frames) {
  const Vector3d across = frames.axes_first.col(0).cross(frames.axes_second.col(0));
  const double sine = across.norm();
  return sine > 0 ? Vector3d(across / sine) : Vector3d(frames.axes_first.col(1));
}

}  // namespace

void JointFrames::set_turn(const Quaterniond& first, const Quaterniond& second) {
  turn = first.conjugate() * second;
  if (turn.w() < 0) turn.coeffs() = -turn.coeffs();
}

// d/dt (a . offset), with a fixed to the first body: its turning adds (w_A x a) . offset = w_A . (a x offset).
JointRow offset_along(const JointFrames& frames, int axis) {
  const Vector3d a = frames.axes_first.col(axis);
  return {.linear = a,
          .angular_first = (frames.arm_first + frames.offset).cross(a),
          .angular_second = frames.arm_second.cross(a),
          .value = a.dot(frames.offset)};
}

JointRow distance(const JointFrames& frames) {
  const double length = frames.offset.norm();
  const Vector3d direction = length > 0 ? Vector3d(frames.offset / length) : Vector3d(frames.axes_first.col(0));
  return {.linear = direction,
          .angular_first = frames.arm_first.cross(direction),
          .angular_second = frames.arm_second.cross(direction),
          .value = length};
}

// For q = (s, v), q' = (0, w) q / 2 with w the relative spin in the first frame, so (2 v)' = s w + w x v, of which row
// k is (s e_k + v x e_k) . w.
JointRow turn_about(const JointFrames& frames, int axis) {
  const Quaterniond& turn = frames.turn;
  const Vector3d unit = Vector3d::Unit(axis);
  return angular_row(frames.axes_first * (turn.w() * unit + turn.vec().cross(unit)), 2 * turn.vec()[axis]);
}

// For the rotation vector p of angle 2 f, p' = (1 - [p] / 2 + (1 - h) [p]^2 / (2 f)^2) w with w the relative spin in
// the first frame, [p] v = p x v and h = f / tan(f). Of the relative rotation q = (s, v), p = 2 f v / |v|.
JointRow rotation_about(const JointFrames& frames, int axis) {
  const Vector3d v = frames.turn.vec();
  const double sine = v.norm();
  const double half = arctangent(sine, frames.turn.w());
  // Below, what the series leave out is less than rounding.
  const bool turns = sine > 1e-5;
  const double over_sine = turns ? half / sine : 1;
  const double along = over_sine * frames.turn.w();
  const double rest = turns ? (1 - along) / (sine * sine) : 1.0 / 3;
  const Vector3d unit = Vector3d::Unit(axis);
  return angular_row(frames.axes_first * (along * unit + over_sine * v.cross(unit) + rest * v[axis] * v),
                     2 * over_sine * v[axis]);
}

// With a and b the x axes, c = a . b and r = a . b_k, the part along axis k is r sqrt(2 / (1 + c)). Its derivative
// follows from (a . n)' = (n x a) . (w_B - w_A) of any axis n of the second frame.
JointRow swing_along(const JointFrames& frames, int axis_second) {
  const Vector3d a = frames.axes_first.col(0);
  const Vector3d b = frames.axes_second.col(0);
  const Vector3d along = frames.axes_second.col(axis_second);
  const double cosine = a.dot(b);
  const double part = a.dot(along);
  const double other = a.dot(frames.axes_second.col(3 - axis_second));
  // 1 + c, without the cancellation that there is where the axes are almost opposed.
  const double both = cosine > 0 ? 1 + cosine : (part * part + other * other) / (1 - cosine);
  // Nearer to opposed than rounding tells axes apart, one direction is as good as another.
  constexpr double min = 1e-30;
  if (!(both > min)) return angular_row(along, axis_second == 1 ? 2 : 0);
  const double scale = std::sqrt(2 / both);
  return angular_row(scale * (along.cross(a) - part / (2 * both) * b.cross(a)), scale * part);
}

// asin(a . b), of which the cosine is |a x b|.
JointRow skew_between(const JointFrames& frames, AxisPair axes, double sign) {
  const Vector3d a = frames.axes_first.col(axes.first);
  const Vector3d b = frames.axes_second.col(axes.second);
  const Vector3d across = b.cross(a);
  const double sine = across.norm();
  const Vector3d axis = sine > 0 ? Vector3d(across / sine) : Vector3d(frames.axes_first.col((axes.first + 1) % 3));
  return angular_row(sign * axis, sign * arctangent(a.dot(b), sine));
}

// For q = (s, v), the relative rotation as a quaternion, the twist is 2 atan2(v_x, s). Its rate is the relative spin's
// part about the direction halfway between the two x axes, over the cosine of half the swing: (a + b) . w / (1 + a .
// b).
JointRow twist(const JointFrames& frames) {
  const Quaterniond& turn = frames.turn;
  const Vector3d a = frames.axes_first.col(0);
  const Vector3d b = frames.axes_second.col(0);
  const double both = 1 + a.dot(b);
  const Vector3d axis = both > 0 ? Vector3d((a + b) / both) : a;
  return angular_row(axis, 2 * arctangent(turn.x(), turn.w()));
}

namespace {

// The factor by which a coordinate fades, and its derivative by the cosine.
struct Fading {
  double part = 1;
  double slope = 0;

  Fading(double cosine, double from) {
    const double s = cosine / from;
    if (!(s < 1)) return;
    part = s * s * (3 - 2 * s);
    slope = 6 * s * (1 - s) / from;
  }
};

}  // namespace

// The cosine of half the swing is sqrt((1 + a . b) / 2), and (a . b)' = (b x a) . w. Times that cosine squared, the
// twist's row and the change of the cosine are smooth where the axes are opposed.
void fade_twist(const JointFrames& frames, JointRow& twist) {
  const Vector3d a = frames.axes_first.col(0);
  const Vector3d b = frames.axes_second.col(0);
  const double cosine = std::sqrt(std::max(0.5 * (1 + a.dot(b)), 0.0));
  if (!(cosine < tuning::fading_twist)) return;
  const Fading fading(cosine, tuning::fading_twist);
  const double over_square = (3 - 2 * cosine / tuning::fading_twist) / (tuning::fading_twist * tuning::fading_twist);
  const double over_cosine = 6 * (1 - cosine / tuning::fading_twist) / (tuning::fading_twist * tuning::fading_twist);
  twist = angular_row(0.5 * over_square * (a + b) + 0.25 * twist.value * over_cosine * b.cross(a),
                      fading.part * twist.value);
  twist.share = fading.part;
}

// The row follows from s' = -v . w / 2 in the first frame, for the relative rotation q = (s, v).
void fade_turn(const JointFrames& frames, int axis, JointRow& turn) {
  const Quaterniond& relative = frames.turn;
  const Fading fading(relative.w(), tuning::fading_turn);
  const Vector3d row =
      fading.part * turn.angular_first - 0.5 * turn.value * fading.slope * (frames.axes_first * relative.vec());
  turn = angular_row(row, fading.part * turn.value);
  turn.share = row.dot(frames.axes_first.col(axis));
}

JointRow swing(const JointFrames& frames) {
  const Vector3d a = frames.axes_first.col(0);
  const Vector3d b = frames.axes_second.col(0);
  return angular_row(swing_axis(frames), arctangent(a.cross(b).norm(), a.dot(b)));
}

namespace {

// Angle about `axis`, which is fixed with `from` to one body, by which `to` of the other has turned from `from`:
// atan2(s, c) with s = m . (a x r) and c = m . r, both cosines of an axis of each frame, so (atan2(s, c))' = (c s' - s
// c') / (s^2 + c^2). Where both are 0, as of an axis that is parallel to the one it should turn about, the row is of
// turning about that. `sign` of the angle: -1 where it is the other body's that counts.
JointRow angle_about(const Vector3d& axis, const Vector3d& from, const Vector3d& to, double sign) {
  const Vector3d across = axis.cross(from);
  const double sine = to.dot(across);
  const double cosine = to.dot(from);
  const double square = sine * sine + cosine * cosine;
  if (!(square > 0)) return angular_row(axis, 0);
  return angular_row((cosine * to.cross(across) - sine * to.cross(from)) / square, sign * arctangent(sine, cosine));
}

}  // namespace

JointRow angle_about_first(const JointFrames& frames, AxisPair hinges) {
  return angle_about(frames.axes_first.col(hinges.first), frames.axes_first.col(hinges.second),
                     frames.axes_second.col(hinges.second), 1);
}

// The second frame's turning is the first's against it, the other way round, and so is its row.
JointRow angle_about_second(const JointFrames& frames, AxisPair hinges) {
  return angle_about(frames.axes_second.col(hinges.second), frames.axes_second.col(hinges.first),
                     frames.axes_first.col(hinges.first), -1);
}

// The sine is |b x a|, and (a . b)' = (b x a) . w. The row has one over the square of the sine in it.
void fade_angle(const JointFrames& frames, AxisPair hinges, JointRow& angle) {
  const Vector3d a = frames.axes_first.col(hinges.first);
  const Vector3d b = frames.axes_second.col(hinges.second);
  const Vector3d across = b.cross(a);
  const double sine = across.norm();
  const Fading fading(sine, tuning::fading_turn);
  if (!(sine < tuning::fading_turn)) return;
  Vector3d row = fading.part * angle.angular_first;
  if (sine > 0) row -= angle.value * fading.slope * (a.dot(b) / sine) * across;
  angle = angular_row(row, fading.part * angle.value);
  angle.share = fading.part;
}

JointRow spin_about(const JointFrames& frames, int axis) { return angular_row(frames.axes_first.col(axis), 0); }

// (w x b) . n = (b x n) . w, with n the axis of the swing.
JointRow orbit(const JointFrames& frames) {
  return angular_row(frames.axes_second.col(0).cross(swing_axis(frames)), 0);
}

JointRow gear(const JointFrames& frames, double ratio) {
  return {.linear = Vector3d::Zero(),
          .angular_first = -frames.axes_first.col(0),
          .angular_second = ratio * frames.axes_second.col(0),
          .value = 0};
}

JointRow rack(const JointFrames& frames, double ratio) {
  return {.linear = ratio * frames.axes_second.col(0),
          .angular_first = -frames.axes_first.col(0),
          .angular_second = Vector3d::Zero(),
          .value = 0};
}

}  // namespace atl::solver
