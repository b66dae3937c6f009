// The coordinates of joints in lanes: those of constraints/joint_coordinates.h, of differences within a step, which
// single precision is enough for. Included once for each instruction set.

#if defined(ATOLL_SOLVER_JOINT_COORDINATES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATOLL_SOLVER_JOINT_COORDINATES_INL_H_
#undef ATOLL_SOLVER_JOINT_COORDINATES_INL_H_
#else
#define ATOLL_SOLVER_JOINT_COORDINATES_INL_H_
#endif

#include <solver/constraints/joint.h>

#include "sweep/joint_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atl::solver {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace jobs::HWY_NAMESPACE;

// The frames of joints: where they are, and how the second are turned against the first.
struct FrameLanes {
  V3 axes[3];    // of the first frame, world axes
  Q turn;        // w >= 0
  V3 second[3];  // axes of the second frame, in the first
  PointLanes point;
  V3 offset;
};

HWY_INLINE void set_axes(const Q& q, V3 (&axes)[3]) {
  const auto twice = [](V a, V b) { return hn::Mul(hn::Add(a, a), b); };
  const V3& v = q.vector;
  const V xx = twice(v.x, v.x), yy = twice(v.y, v.y), zz = twice(v.z, v.z);
  const V xy = twice(v.x, v.y), xz = twice(v.x, v.z), yz = twice(v.y, v.z);
  const V wx = twice(v.x, q.scalar), wy = twice(v.y, q.scalar), wz = twice(v.z, q.scalar);
  const V one = splat(1);
  axes[0] = {hn::Sub(one, hn::Add(yy, zz)), hn::Add(xy, wz), hn::Sub(xz, wy)};
  axes[1] = {hn::Sub(xy, wz), hn::Sub(one, hn::Add(xx, zz)), hn::Add(yz, wx)};
  axes[2] = {hn::Add(xz, wy), hn::Sub(yz, wx), hn::Sub(one, hn::Add(xx, yy))};
}

// The turn now is the one at the start of the step, after that of the bodies against each other since, in the first
// frame: bodies that haven't turned leave it as it was, to the last bit.
HWY_INLINE FrameLanes frames_now(const JointKernelData& data, const JointBlock& block, const JointFrameBlock& start,
                                 std::size_t lane, const JointLanes& c) {
  const auto load_q = [lane](const float(*rows)[block_lanes]) { return Q{load3(rows, lane), load(rows[3] + lane)}; };
  FrameLanes frames;
  const PointMotion moved = point_motion(data, block, lane, c);
  frames.point = moved.point;
  frames.offset = moved.offset;
  const Q first = load_q(start.axes_first), turned_first = load_rotation(data.bodies, c.first.index);
  const Q against = conjugate(turned_first) * load_rotation(data.bodies, c.second.index);
  const Q turn = Q{turned(conjugate(first), against.vector), against.scalar} * load_q(start.turn);
  const M opposed = hn::Lt(turn.scalar, zero());
  frames.turn = {select(opposed, splat(-1) * turn.vector, turn.vector), hn::Abs(turn.scalar)};
  set_axes(turned_first * first, frames.axes);
  set_axes(frames.turn, frames.second);
  return frames;
}

// (arctan(r) / r - 1) / r^2 for |r| <= tan(pi/12), by Taylor's series: the first term left out is below 2e-9 of
// arctan(r) / r.
HWY_INLINE V arctangent_series(V r2) {
  V sum = zero();
  for (int n = 6; n >= 0; --n) sum = hn::Add(hn::Mul(sum, r2), splat((n % 2 == 0 ? -1.0f : 1.0f) / (2 * n + 3)));
  return sum;
}

// The angle of (x, y), by the method of arctangent() in integrate/trigonometry.h, in single precision.
HWY_INLINE V arctangent(V y, V x) {
  constexpr float tangent_of_twelfth = 0.26794919f, root_three = 1.7320508f, sixth_of_pi = 0.52359878f;
  constexpr float half_pi = 1.5707963f;
  const V across = hn::Abs(y), along = hn::Abs(x);
  const M steep = hn::Gt(across, along);
  const V larger = hn::Max(across, along);
  const V t = hn::IfThenElseZero(hn::Gt(larger, zero()), hn::Div(hn::Min(across, along), larger));
  const M turns = hn::Gt(t, splat(tangent_of_twelfth));
  const V back = hn::Div(hn::Sub(hn::Mul(t, splat(root_three)), splat(1)), hn::Add(t, splat(root_three)));
  const V r = hn::IfThenElse(turns, back, t);
  const V r2 = hn::Mul(r, r);
  V angle = hn::Add(r, hn::Mul(r, hn::Mul(r2, arctangent_series(r2))));
  angle = hn::IfThenElse(turns, hn::Add(splat(sixth_of_pi), angle), angle);
  angle = hn::IfThenElse(steep, hn::Sub(splat(half_pi), angle), angle);
  angle = hn::IfThenElse(hn::Lt(x, zero()), hn::Sub(splat(2 * half_pi), angle), angle);
  return hn::CopySign(angle, y);
}

// A coordinate: its value and its row, along the axes of the first frame. Of those that only turn `first` and `second`
// are all; of others these are beside what `linear` does at its arms.
struct CoordinateLanes {
  V3 linear, first, second;
  V value;
  V share;
};

HWY_INLINE V3 unit(int axis) {
  return {splat(axis == 0 ? 1.0f : 0.0f), splat(axis == 1 ? 1.0f : 0.0f), splat(axis == 2 ? 1.0f : 0.0f)};
}
HWY_INLINE V component(const V3& v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }
HWY_INLINE V length(const V3& v) { return hn::Sqrt(dot(v, v)); }
HWY_INLINE V3 over(const V3& v, V by) { return hn::Div(splat(1), by) * v; }
HWY_INLINE CoordinateLanes angular(const V3& axis, V value) {
  return {{zero(), zero(), zero()}, axis, axis, value, splat(1)};
}

HWY_INLINE CoordinateLanes turn_about(const FrameLanes& frames, int axis) {
  const V3 along = unit(axis);
  const V part = component(frames.turn.vector, axis);
  return angular(frames.turn.scalar * along + cross(frames.turn.vector, along), hn::Add(part, part));
}

HWY_INLINE CoordinateLanes rotation_about(const FrameLanes& frames, int axis) {
  const V3& v = frames.turn.vector;
  const V3 across = unit(axis);
  const V sine = length(v);
  // Below, what the series leave out is less than rounding.
  const M turns = hn::Gt(sine, splat(1e-2f));
  const V half = arctangent(sine, frames.turn.scalar);
  const V square = hn::Mul(sine, sine);
  const V series = hn::Add(splat(1), hn::Mul(square, splat(1.0f / 6)));
  const V over_sine = hn::IfThenElse(turns, hn::Div(half, hn::Max(sine, splat(1e-2f))), series);
  const V along = hn::Mul(over_sine, frames.turn.scalar);
  const V rest =
      hn::IfThenElse(turns, hn::Div(hn::Sub(splat(1), along), hn::Max(square, splat(1e-4f))), splat(1.0f / 3));
  const V part = component(v, axis);
  return angular(along * across + over_sine * cross(v, across) + hn::Mul(rest, part) * v,
                 hn::Mul(hn::Add(over_sine, over_sine), part));
}

HWY_INLINE CoordinateLanes swing_along(const FrameLanes& frames, int axis) {
  const V3& b = frames.second[0];
  const V3& along = frames.second[axis];
  const V part = along.x, other = frames.second[3 - axis].x;
  const V opposed = hn::Div(hn::Add(hn::Mul(part, part), hn::Mul(other, other)), hn::Sub(splat(1), b.x));
  const V both = hn::IfThenElse(hn::Gt(b.x, zero()), hn::Add(splat(1), b.x), opposed);
  const M has = hn::Gt(both, splat(1e-30f));
  const V scale = hn::Sqrt(hn::Div(splat(2), both));
  const V3 a = unit(0);
  const V3 row = scale * (cross(along, a) - hn::Div(part, hn::Add(both, both)) * cross(b, a));
  return angular(select(has, row, along), hn::IfThenElse(has, hn::Mul(scale, part), splat(axis == 1 ? 2.0f : 0.0f)));
}

HWY_INLINE CoordinateLanes skew_between(const FrameLanes& frames, AxisPair axes, float sign) {
  const V3 a = unit(axes.first);
  const V3& b = frames.second[axes.second];
  const V3 across = cross(b, a);
  const V sine = length(across);
  const V3 axis = select(hn::Gt(sine, zero()), over(across, sine), unit((axes.first + 1) % 3));
  return angular(splat(sign) * axis, hn::Mul(splat(sign), arctangent(component(b, axes.first), sine)));
}

HWY_INLINE V3 swing_axis(const FrameLanes& frames, V& sine) {
  const V3 across = cross(unit(0), frames.second[0]);
  sine = length(across);
  return select(hn::Gt(sine, zero()), over(across, sine), unit(1));
}
HWY_INLINE CoordinateLanes swing(const FrameLanes& frames) {
  V sine;
  const V3 axis = swing_axis(frames, sine);
  return angular(axis, arctangent(sine, frames.second[0].x));
}
HWY_INLINE CoordinateLanes orbit(const FrameLanes& frames) {
  V sine;
  return angular(cross(frames.second[0], swing_axis(frames, sine)), zero());
}

HWY_INLINE CoordinateLanes twist(const FrameLanes& frames) {
  const V both = hn::Add(splat(1), frames.second[0].x);
  const V3 halfway = over(unit(0) + frames.second[0], both);
  const V half = arctangent(frames.turn.vector.x, frames.turn.scalar);
  return angular(select(hn::Gt(both, zero()), halfway, unit(0)), hn::Add(half, half));
}

// `twist` is the whole of it, over full turns.
HWY_INLINE void fade_twist(const FrameLanes& frames, CoordinateLanes& twist) {
  constexpr float from = static_cast<float>(tuning::fading_twist);
  const V cosine = frames.turn.scalar;
  const V across = frames.turn.vector.x;
  // The cosine of half the swing; w and x of the quaternion are it times those of half the twist.
  const V half_swing = hn::Sqrt(hn::Add(hn::Mul(cosine, cosine), hn::Mul(across, across)));
  const V s = hn::Mul(half_swing, splat(1 / from));
  const M fades = hn::Lt(s, splat(1));
  const V slope = hn::Sub(splat(3), hn::Add(s, s));
  const V part = hn::Mul(hn::Mul(s, s), slope);
  const V over_square = hn::Mul(slope, splat(1 / (from * from)));
  const V over_cosine = hn::Mul(hn::Sub(splat(1), s), splat(6 / (from * from)));
  const V3 a = unit(0);
  const V3 row = hn::Mul(splat(0.5f), over_square) * (a + frames.second[0]) +
                 hn::Mul(hn::Mul(splat(0.25f), twist.value), over_cosine) * cross(frames.second[0], a);
  twist.first = twist.second = select(fades, row, twist.first);
  twist.value = hn::IfThenElse(fades, hn::Mul(part, twist.value), twist.value);
  twist.share = hn::IfThenElse(fades, part, twist.share);
}

HWY_INLINE void fade_turn(const FrameLanes& frames, int axis, M may, CoordinateLanes& turn) {
  constexpr float from = static_cast<float>(tuning::fading_turn);
  const V s = hn::Mul(frames.turn.scalar, splat(1 / from));
  const M fades = hn::And(may, hn::Lt(s, splat(1)));
  const V part = hn::Mul(hn::Mul(s, s), hn::Sub(splat(3), hn::Add(s, s)));
  const V slope = hn::Mul(hn::Mul(splat(6 / from), s), hn::Sub(splat(1), s));
  const V3 row = part * turn.first - hn::Mul(hn::Mul(splat(0.5f), turn.value), slope) * frames.turn.vector;
  turn.first = turn.second = select(fades, row, turn.first);
  turn.value = hn::IfThenElse(fades, hn::Mul(part, turn.value), turn.value);
  turn.share = hn::IfThenElse(may, component(turn.first, axis), turn.share);
}

HWY_INLINE CoordinateLanes angle_about(const V3& axis, const V3& from, const V3& to, float sign) {
  const V3 across = cross(axis, from);
  const V sine = dot(to, across), cosine = dot(to, from);
  const V square = hn::Add(hn::Mul(sine, sine), hn::Mul(cosine, cosine));
  const M has = hn::Gt(square, zero());
  const V3 row = over(cosine * cross(to, across) - sine * cross(to, from), square);
  return angular(select(has, row, axis), hn::IfThenElseZero(has, hn::Mul(splat(sign), arctangent(sine, cosine))));
}

// `angle` counts from `base`, and fades as a whole.
HWY_INLINE void fade_angle(const FrameLanes& frames, AxisPair hinges, V base, CoordinateLanes& angle) {
  constexpr float from = static_cast<float>(tuning::fading_turn);
  const V3& b = frames.second[hinges.second];
  const V3 across = cross(b, unit(hinges.first));
  const V s = hn::Mul(length(across), splat(1 / from));
  const M fades = hn::Lt(s, splat(1));
  const V part = hn::Mul(hn::Mul(s, s), hn::Sub(splat(3), hn::Add(s, s)));
  // The slope of the part over the sine.
  const V slope = hn::Mul(hn::Sub(splat(1), s), splat(6 / (from * from)));
  const V cosine = component(b, hinges.first);
  const V whole = hn::Add(angle.value, base);
  const V3 row = part * angle.first - hn::Mul(hn::Mul(whole, slope), cosine) * across;
  angle.first = angle.second = select(fades, row, angle.first);
  angle.value = hn::IfThenElse(fades, hn::Sub(hn::Mul(part, whole), base), angle.value);
  angle.share = hn::IfThenElse(fades, part, angle.share);
}

HWY_INLINE CoordinateLanes offset_along(const FrameLanes& frames, int axis) {
  const V3& a = frames.axes[axis];
  return {a, cross(frames.point.arm_first + frames.offset, a), cross(frames.point.arm_second, a), dot(a, frames.offset),
          splat(1)};
}
HWY_INLINE CoordinateLanes distance(const FrameLanes& frames) {
  const V far = length(frames.offset);
  const V3 direction = select(hn::Gt(far, zero()), over(frames.offset, far), frames.axes[0]);
  return {direction, cross(frames.point.arm_first, direction), cross(frames.point.arm_second, direction), far,
          splat(1)};
}

// The first about its x axis, and the second about or along its own.
HWY_INLINE CoordinateLanes geared(const FrameLanes& frames, V ratio, bool slides) {
  const V3 none{zero(), zero(), zero()};
  const V3 second = ratio * frames.second[0];
  return {slides ? second : none, splat(-1) * unit(0), slides ? none : second, zero(), splat(1)};
}

// One coordinate in all lanes. Offsets and distances are in world axes.
HWY_INLINE CoordinateLanes coordinate_in_lanes(Coordinate coordinate, const FrameLanes& frames, V ratio) {
  const AxisPair hinges = hinges_of(coordinate);
  switch (coordinate) {
    case Coordinate::OffsetX:
    case Coordinate::OffsetY:
    case Coordinate::OffsetZ:
      return offset_along(frames, axis_of(coordinate, Coordinate::OffsetX));
    case Coordinate::Distance:
      return distance(frames);
    case Coordinate::TurnX:
    case Coordinate::TurnY:
    case Coordinate::TurnZ:
      return turn_about(frames, axis_of(coordinate, Coordinate::TurnX));
    case Coordinate::RotationX:
    case Coordinate::RotationY:
    case Coordinate::RotationZ:
      return rotation_about(frames, axis_of(coordinate, Coordinate::RotationX));
    case Coordinate::SwingAlongY:
    case Coordinate::SwingAlongZ:
      return swing_along(frames, coordinate == Coordinate::SwingAlongY ? 1 : 2);
    case Coordinate::SkewXY:
    case Coordinate::SkewZY:
    case Coordinate::BetweenY:
      return skew_between(frames, hinges, 1);
    case Coordinate::BetweenZ:
      return skew_between(frames, hinges, -1);
    case Coordinate::Twist:
      return twist(frames);
    case Coordinate::Swing:
      return swing(frames);
    case Coordinate::AngleX:
    case Coordinate::AngleXOfZ:
    case Coordinate::Steer:
      return angle_about(unit(hinges.first), unit(hinges.second), frames.second[hinges.second], 1);
    case Coordinate::AngleSecondY:
    case Coordinate::AngleSecondZ:
    case Coordinate::Roll:
      return angle_about(frames.second[hinges.second], frames.second[hinges.first], unit(hinges.first), -1);
    case Coordinate::SpinX:
    case Coordinate::SpinY:
    case Coordinate::SpinZ:
      return angular(unit(axis_of(coordinate, Coordinate::SpinX)), zero());
    case Coordinate::Orbit:
      return orbit(frames);
    case Coordinate::Gear:
      return geared(frames, ratio, false);
    case Coordinate::Rack:
    case Coordinate::Length:  // which no joint has that is swept in lanes
      break;
  }
  return geared(frames, ratio, true);
}

}  // namespace HWY_NAMESPACE
}  // namespace atl::solver
HWY_AFTER_NAMESPACE();

#endif  // ATOLL_SOLVER_JOINT_COORDINATES_INL_H_
