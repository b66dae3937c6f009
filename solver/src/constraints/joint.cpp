#include <jobs/assert.h>
#include <solver/constraints/joint.h>

#include <cmath>

namespace atl::solver {
namespace {

bool has_turn(const Joint& joint) {
  for (std::size_t row = 0; row < joint.rows; ++row) {
    if (asks_for_turn(joint.coordinate[row])) return true;
  }
  return false;
}

}  // namespace

JointRow coordinate_row(Coordinate coordinate, const JointFrames& frames, double ratio) {
  const AxisPair hinges = hinges_of(coordinate);
  switch (coordinate) {
    case Coordinate::OffsetX:
      return offset_along(frames, 0);
    case Coordinate::OffsetY:
      return offset_along(frames, 1);
    case Coordinate::OffsetZ:
      return offset_along(frames, 2);
    case Coordinate::Distance:
      return distance(frames);
    case Coordinate::TurnX:
      return turn_about(frames, 0);
    case Coordinate::TurnY:
      return turn_about(frames, 1);
    case Coordinate::TurnZ:
      return turn_about(frames, 2);
    case Coordinate::RotationX:
    case Coordinate::RotationY:
    case Coordinate::RotationZ:
      return rotation_about(frames, axis_of(coordinate, Coordinate::RotationX));
    case Coordinate::SwingAlongY:
      return swing_along(frames, 1);
    case Coordinate::SwingAlongZ:
      return swing_along(frames, 2);
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
      return angle_about_first(frames, hinges);
    case Coordinate::AngleSecondY:
    case Coordinate::AngleSecondZ:
    case Coordinate::Roll:
      return angle_about_second(frames, hinges);
    case Coordinate::Length:
      return {};
    case Coordinate::SpinX:
      return spin_about(frames, 0);
    case Coordinate::SpinY:
      return spin_about(frames, 1);
    case Coordinate::SpinZ:
      return spin_about(frames, 2);
    case Coordinate::Orbit:
      return orbit(frames);
    case Coordinate::Gear:
      return gear(frames, ratio);
    case Coordinate::Rack:
      break;
  }
  return rack(frames, ratio);
}

JointRow joint_row(const Joint& joint, std::size_t row, const JointFrames& frames) {
  ATL_ASSERT(row < joint.rows, row, joint.rows);
  return coordinate_row(joint.coordinate[row], frames, joint.ratio);
}

double continued(Coordinate coordinate, double value, double before) {
  // rad: beyond, turns are closer to each other than what a number can tell. A prediction may be there, or nowhere.
  constexpr double max = 1e15;
  if (!(std::abs(before) <= max)) before = 0;
  if (is_rate(coordinate)) return before;
  if (!counts_turns(coordinate)) return value;
  constexpr double turn = 2 * 3.14159265358979323846;
  return value + turn * std::round((before - value) / turn);
}

LawRow law_row(const Joint& joint, std::size_t row, const JointFrames& frames, double before) {
  const Coordinate coordinate = joint.coordinate[row];
  LawRow law{joint_row(joint, row, frames), 0};
  law.at.value = law.position = continued(coordinate, law.at.value, before);
  const Law& of = joint.law[row];
  fade(coordinate, frames, !(of.locked() && of.lower == 0), law.at);
  return law;
}

void fade(Coordinate coordinate, const JointFrames& frames, bool fades_turn, JointRow& row) {
  if (coordinate == Coordinate::Twist) {
    fade_twist(frames, row);
  } else if (is_hinged(coordinate)) {
    fade_angle(frames, hinges_of(coordinate), row);
  } else if (is_turn(coordinate) && fades_turn) {
    fade_turn(frames, axis_of(coordinate, Coordinate::TurnX), row);
  }
}

JointFrames joint_frames(const Joint& joint, const Vector3& position_first, const Quaternion& orientation_first,
                         const Vector3& position_second, const Quaternion& orientation_second) {
  ATL_ASSERT(std::abs(joint.axes_first.squaredNorm() - 1) < 1e-6, joint.first, joint.second, joint.axes_first.norm());
  ATL_ASSERT(std::abs(joint.axes_second.squaredNorm() - 1) < 1e-6, joint.first, joint.second, joint.axes_second.norm());
  JointFrames frames;
  frames.arm_first = orientation_first * joint.anchor_first;
  frames.arm_second = orientation_second * joint.anchor_second;
  frames.offset = (position_second - position_first) + (frames.arm_second - frames.arm_first);
  const Eigen::Quaterniond first(orientation_first * joint.axes_first);
  const Eigen::Quaterniond second(orientation_second * joint.axes_second);
  frames.axes_first = first.toRotationMatrix();
  frames.axes_second = second.toRotationMatrix();
  if (has_turn(joint)) frames.set_turn(first, second);
  return frames;
}

JointFrames joint_frames(const Joint& joint, const BodyTable& bodies) {
  return joint_frames(joint, bodies.position(joint.first), bodies.orientation(joint.first),
                      bodies.position(joint.second), bodies.orientation(joint.second));
}

}  // namespace atl::solver
