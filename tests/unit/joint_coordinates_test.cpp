// Coordinates of joints against finite differences, and at poses where they are known.

#include <gtest/gtest.h>
#include <solver/constraints/joint.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "joint_pose.h"

namespace atl::solver {
namespace {

using std::numbers::pi;
using test::JointPose;
using test::Random;

// A central difference of fourth order: of a quantity that is smooth within a few milliseconds.
template <class Function>
double derivative(const Function& value) {
  constexpr double step = 3e-4;
  return (8 * (value(step) - value(-step)) - (value(2 * step) - value(-2 * step))) / (12 * step);
}

Eigen::Quaterniond relative_turn(const JointFrames& frames) {
  return Eigen::Quaterniond(Eigen::Matrix3d(frames.axes_first.transpose() * frames.axes_second));
}

// Away from where a coordinate has no derivative, as its docstring says.
bool is_smooth(Coordinate coordinate, const JointFrames& frames) {
  const Eigen::Matrix3d cosines = frames.axes_first.transpose() * frames.axes_second;
  switch (coordinate) {
    case Coordinate::Distance:
      return frames.offset.norm() > 0.1;
    case Coordinate::TurnX:
    case Coordinate::TurnY:
    case Coordinate::TurnZ:
    case Coordinate::RotationX:
    case Coordinate::RotationY:
    case Coordinate::RotationZ:  // of the shorter way round: it changes sign at half a turn
      return std::abs(relative_turn(frames).w()) > 0.02;
    case Coordinate::Twist:
    case Coordinate::SwingAlongY:
    case Coordinate::SwingAlongZ:
      return cosines(0, 0) > -0.95;
    case Coordinate::SkewXY:
    case Coordinate::SkewZY:
    case Coordinate::BetweenY:
    case Coordinate::BetweenZ:
    case Coordinate::AngleX:
    case Coordinate::AngleSecondY:
    case Coordinate::AngleXOfZ:
    case Coordinate::AngleSecondZ:
    case Coordinate::Steer:
    case Coordinate::Roll: {
      const AxisPair hinges = hinges_of(coordinate);
      return std::abs(cosines(hinges.first, hinges.second)) < 0.95;
    }
    case Coordinate::Swing:
    case Coordinate::Orbit:
      return std::abs(cosines(0, 0)) < 0.95;
    default:
      return true;
  }
}

// The rate of each coordinate by its definition: the derivative of its value, or, for a coordinate without a value, of
// the quantity that it counts.
double defined_rate(const JointPose& pose) {
  const JointFrames now = pose.frames();
  // How far a body has turned about its own x axis, as seen in itself: the twist of its turn since now.
  const auto own_turning = [&](const JointPose::Body& body, const JointPose::Body& later, const Quaternion& axes) {
    const Quaternion turn = (body.orientation * axes).conjugate() * (later.orientation * axes);
    return 2 * std::atan2(turn.x(), turn.w());
  };
  const auto second_against_first = [&](double time, int axis) {
    const JointFrames later = pose.at(time).frames();
    const Eigen::Quaterniond turn = relative_turn(later) * relative_turn(now).conjugate();
    return 2 * turn.vec()[axis] * (turn.w() < 0 ? -1 : 1);
  };
  switch (const Coordinate coordinate = pose.joint.coordinate[0]) {
    case Coordinate::SpinX:
    case Coordinate::SpinY:
    case Coordinate::SpinZ: {
      const int axis = static_cast<int>(coordinate) - static_cast<int>(Coordinate::SpinX);
      return derivative([&](double time) { return second_against_first(time, axis); });
    }
    case Coordinate::Orbit: {
      // In the first frame, along what is at right angles to both x axes now.
      const Vector3 second_x = (now.axes_first.transpose() * now.axes_second).col(0);
      const Vector3 across = Vector3::UnitX().cross(second_x).normalized();
      return derivative([&](double time) {
        const JointFrames later = pose.at(time).frames();
        return across.dot(later.axes_first.transpose() * later.axes_second.col(0));
      });
    }
    case Coordinate::Gear:
      return derivative([&](double time) {
        const JointPose later = pose.at(time);
        return own_turning(pose.first, later.first, pose.joint.axes_first) +
               pose.joint.ratio * own_turning(pose.second, later.second, pose.joint.axes_second);
      });
    case Coordinate::Rack:
      return derivative([&](double time) {
        const JointPose later = pose.at(time);
        return own_turning(pose.first, later.first, pose.joint.axes_first) +
               pose.joint.ratio * now.axes_second.col(0).dot(later.second.position - later.first.position);
      });
    default: {
      const double value = pose.row().value;
      return derivative([&](double time) { return continued(coordinate, pose.at(time).row().value, value); });
    }
  }
}

class JointCoordinates : public testing::TestWithParam<Coordinate> {};

TEST_P(JointCoordinates, RateIsTheDerivative) {
  Random random(3);
  double largest = 0;
  for (int checked = 0; checked < 1000;) {
    const JointPose pose(random, GetParam());
    if (!is_smooth(GetParam(), pose.frames())) continue;
    ++checked;
    const double rate = pose.rate();
    ASSERT_NEAR(rate, defined_rate(pose), 1e-6 * std::abs(rate) + 1e-9) << "pose " << checked;
    largest = std::max(largest, std::abs(rate));
  }
  EXPECT_GT(largest, 1);
}

// The second derivative jumps at the start of the fading range and at half a turn, or where hinges are parallel, so the
// test leaves these poses out.
bool is_smooth_law(Coordinate coordinate, const JointFrames& frames) {
  double fades_by = std::abs(relative_turn(frames).w());
  if (is_hinged(coordinate)) {
    const AxisPair hinges = hinges_of(coordinate);
    fades_by = frames.axes_first.col(hinges.first).cross(frames.axes_second.col(hinges.second)).norm();
  }
  return fades_by > 0.005 && std::abs(fades_by - tuning::fading_turn) > 0.005;
}

// The direction of a law is smooth at every pose, with its position continued: also at a swing of 180 degrees, at half
// a turn, and where two hinges are parallel.
TEST(JointLaws, FadeWhereTheirCoordinateHasNoValue) {
  for (const Coordinate coordinate : {Coordinate::TurnX, Coordinate::TurnY, Coordinate::TurnZ, Coordinate::Twist,
                                      Coordinate::AngleX, Coordinate::AngleSecondY, Coordinate::AngleXOfZ}) {
    Random random(5);
    int faded = 0;
    for (int i = 0; i < 20000; ++i) {
      const JointPose pose(random, coordinate);
      const LawRow now = law_row(pose.joint, 0, pose.frames(), pose.row().value);
      const auto later = [&](double time) { return law_row(pose.joint, 0, pose.at(time).frames(), now.position); };
      const auto fades = [&](double time) { return later(time).at.share != 1; };
      if (coordinate == Coordinate::Twist ? fades(-0.001) != fades(0.001) : !is_smooth_law(coordinate, pose.frames())) {
        continue;
      }
      if (now.at.value != now.position) ++faded;
      const double rate = pose.rate_of(now.at);
      ASSERT_NEAR(rate, derivative([&](double time) { return later(time).at.value; }), 1e-5 * (1 + std::abs(rate)))
          << "pose " << i;
      ASSERT_LT(now.at.angular_first.norm(), 25);
    }
    EXPECT_GT(faded, 300);
  }
}

TEST(JointLaws, DoNotFadeWhereTheyLockAtZero) {
  Random random(6);
  for (int i = 0; i < 1000; ++i) {
    JointPose pose(random, Coordinate::TurnY);
    pose.joint.law[0].lower = pose.joint.law[0].upper = 0;
    const LawRow now = law_row(pose.joint, 0, pose.frames(), 0);
    EXPECT_EQ(now.at.value, pose.row().value);
    EXPECT_EQ(now.at.angular_first, pose.row().angular_first);
  }
}

INSTANTIATE_TEST_SUITE_P(All, JointCoordinates, testing::ValuesIn(test::all_coordinates));

JointFrames frames_of(const Eigen::Matrix3d& first, const Eigen::Matrix3d& relative) {
  JointFrames frames{Vector3::Zero(), Vector3::Zero(), Vector3::Zero(), first, first * relative, {}};
  frames.set_turn(Eigen::Quaterniond(frames.axes_first), Eigen::Quaterniond(frames.axes_second));
  return frames;
}

Eigen::Matrix3d about(const Vector3& axis, double angle) { return Eigen::AngleAxisd(angle, axis).toRotationMatrix(); }

double value(Coordinate coordinate, const JointFrames& frames) {
  Joint joint;
  joint.rows = 1;
  joint.coordinate[0] = coordinate;
  return joint_row(joint, 0, frames).value;
}

TEST(JointCoordinate, TwistAndSwingTellATurnApart) {
  Random random(7);
  for (int i = 0; i < 200; ++i) {
    const double twisted = random.real(-3, 3);
    const double swung = random.real(0.01, 2.5);
    const double heading = random.real(-3, 3);
    const Vector3 across(0, std::cos(heading), std::sin(heading));
    const JointFrames frames =
        frames_of(random.rotation().toRotationMatrix(), about(across, swung) * about(Vector3::UnitX(), twisted));
    EXPECT_NEAR(value(Coordinate::Swing, frames), swung, 1e-12);
    EXPECT_NEAR(value(Coordinate::Twist, frames), twisted, 1e-12);
  }
}

// A hinge's two are zero for parallel axes alone: their size is that of twice the sine of half the swing, up to
// opposed.
TEST(JointCoordinate, SwingsAreZeroForParallelAxesAlone) {
  Random random(8);
  for (int i = 0; i < 200; ++i) {
    const double swung = i == 0 ? pi : random.real(0, pi);
    const double heading = random.real(-3, 3);
    const Vector3 across(0, std::cos(heading), std::sin(heading));
    const JointFrames frames = frames_of(random.rotation().toRotationMatrix(),
                                         about(across, swung) * about(Vector3::UnitX(), random.real(-3, 3)));
    const double size = std::hypot(value(Coordinate::SwingAlongY, frames), value(Coordinate::SwingAlongZ, frames));
    EXPECT_NEAR(size, 2 * std::sin(swung / 2), 1e-12);
  }
}

// A cross turns about the first x axis and then the second y axis; a wheel steers about the first z axis and then rolls
// about its own y axis. Each angle is told apart from the other, and the axes stay at right angles.
TEST(JointCoordinate, AnglesOfCrossesGimbalsAndWheelsAreToldApart) {
  Random random(9);
  for (int i = 0; i < 200; ++i) {
    const double before = random.real(-3.1, 3.1), after = random.real(-3.1, 3.1);
    const Eigen::Matrix3d base = random.rotation().toRotationMatrix();
    const JointFrames cross = frames_of(base, about(Vector3::UnitX(), before) * about(Vector3::UnitY(), after));
    EXPECT_NEAR(value(Coordinate::AngleX, cross), before, 1e-13);
    EXPECT_NEAR(value(Coordinate::AngleSecondY, cross), after, 1e-13);
    EXPECT_NEAR(value(Coordinate::SkewXY, cross), 0, 1e-15);
    // A gimbal: three hinges one after another, in either order.
    const double between = random.real(-1.5, 1.5);
    const JointFrames xyz = frames_of(
        base, about(Vector3::UnitX(), before) * about(Vector3::UnitY(), between) * about(Vector3::UnitZ(), after));
    EXPECT_NEAR(value(Coordinate::AngleXOfZ, xyz), before, 1e-12);
    EXPECT_NEAR(value(Coordinate::BetweenY, xyz), between, 1e-13);
    EXPECT_NEAR(value(Coordinate::AngleSecondZ, xyz), after, 1e-12);
    const JointFrames xzy = frames_of(
        base, about(Vector3::UnitX(), before) * about(Vector3::UnitZ(), between) * about(Vector3::UnitY(), after));
    EXPECT_NEAR(value(Coordinate::AngleX, xzy), before, 1e-12);
    EXPECT_NEAR(value(Coordinate::BetweenZ, xzy), between, 1e-13);
    EXPECT_NEAR(value(Coordinate::AngleSecondY, xzy), after, 1e-12);
    const JointFrames wheel = frames_of(base, about(Vector3::UnitZ(), before) * about(Vector3::UnitY(), after));
    EXPECT_NEAR(value(Coordinate::Steer, wheel), before, 1e-13);
    EXPECT_NEAR(value(Coordinate::Roll, wheel), after, 1e-13);
    EXPECT_NEAR(value(Coordinate::SkewZY, wheel), 0, 1e-15);
  }
}

TEST(JointCoordinate, RotationsAreTheAxisTimesTheAngle) {
  Random random(11);
  for (int i = 0; i < 200; ++i) {
    const Vector3 axis = random.vector(1).normalized();
    const double angle = i < 20 ? 1e-6 * i : random.real(0, 3.1);
    const JointFrames frames = frames_of(random.rotation().toRotationMatrix(), about(axis, angle));
    for (int part = 0; part < 3; ++part) {
      const JointRow row = rotation_about(frames, part);
      EXPECT_NEAR(row.value, angle * axis[part], 1e-12);
      // Forces along the three add up to a torque along their sum.
      EXPECT_NEAR(row.angular_first.dot(frames.axes_first * axis), axis[part], 1e-9);
    }
  }
}

// Counted over turns, there and back, in steps of up to just under half a one.
TEST(JointCoordinate, AnglesContinueOverFullTurns) {
  const struct {
    Coordinate coordinate;
    Vector3 axis;
  } angles[] = {{Coordinate::Twist, Vector3::UnitX()},
                {Coordinate::AngleX, Vector3::UnitX()},
                {Coordinate::AngleSecondY, Vector3::UnitY()},
                {Coordinate::Steer, Vector3::UnitZ()},
                {Coordinate::Roll, Vector3::UnitY()}};
  for (const auto& [coordinate, axis] : angles) {
    Random random(10);
    const Eigen::Matrix3d base = random.rotation().toRotationMatrix();
    double angle = 0, counted = 0;
    for (int i = 0; i < 1000; ++i) {
      angle += i < 500 ? random.real(0, 3.1) : random.real(-3.1, 0);
      const double within = value(coordinate, frames_of(base, about(axis, angle)));
      EXPECT_LE(std::abs(within), pi);
      counted = continued(coordinate, within, counted);
      ASSERT_NEAR(counted, angle, 1e-9);
      if (i == 499) {
        EXPECT_GT(angle, 100 * pi);
      }
    }
  }
}

// Only angles continue over whole turns; coordinates that have a rate alone keep the position they have.
TEST(JointCoordinate, OnlyAnglesContinue) {
  for (const Coordinate coordinate : test::all_coordinates) {
    const bool angle =
        coordinate == Coordinate::Twist || (coordinate >= Coordinate::AngleX && coordinate <= Coordinate::Roll);
    const bool rate_only = coordinate >= Coordinate::SpinX;
    EXPECT_NEAR(continued(coordinate, -3, 16), rate_only ? 16 : angle ? 6 * pi - 3 : -3, 1e-14);
    for (const double nowhere : {6e40, -1e16, std::numeric_limits<double>::infinity(), std::nan("")}) {
      EXPECT_EQ(continued(coordinate, -3, nowhere), rate_only ? 0 : -3);
    }
    EXPECT_EQ(continued(coordinate, 0.5, 0.25), rate_only ? 0.25 : 0.5);
  }
}

void expect_row(const JointRow& row, double expected, const Vector3& axis) {
  EXPECT_EQ(row.value, expected);
  EXPECT_EQ(row.angular_first, axis);
  EXPECT_EQ(row.angular_second, axis);
}

// Exactly where there is no derivative: each row as its docstring says, and none without a direction.
TEST(JointCoordinate, AreDefinedWhereTheyHaveNoDirection) {
  const Eigen::Matrix3d parallel = Eigen::Matrix3d::Identity();
  JointFrames frames = frames_of(parallel, parallel);
  EXPECT_EQ(distance(frames).linear, Vector3::UnitX());
  EXPECT_EQ(distance(frames).value, 0);
  expect_row(swing(frames), 0, Vector3::UnitY());

  // Half a turn about y: x axes opposite.
  frames.axes_second = Eigen::Vector3d(-1, 1, -1).asDiagonal();
  frames.set_turn(Eigen::Quaterniond(frames.axes_first), Eigen::Quaterniond(frames.axes_second));
  EXPECT_EQ(swing(frames).value, pi);
  EXPECT_EQ(swing(frames).angular_first, Vector3::UnitY());
  EXPECT_EQ(twist(frames).angular_first, Vector3::UnitX());
  EXPECT_EQ(std::abs(turn_about(frames, 1).value), 2);
  EXPECT_TRUE(turn_about(frames, 1).angular_first.allFinite());

  // A quarter turn about z takes the y axis to the first's -x: a cross that is folded; about x, to its z: a wheel that
  // lies flat.
  frames.axes_second.col(0) = Vector3::UnitY();
  frames.axes_second.col(1) = -Vector3::UnitX();
  frames.axes_second.col(2) = Vector3::UnitZ();
  expect_row(angle_about_first(frames, {0, 1}), 0, Vector3::UnitX());
  expect_row(angle_about_second(frames, {0, 1}), 0, -Vector3::UnitX());
  frames.axes_second.col(0) = Vector3::UnitX();
  frames.axes_second.col(1) = Vector3::UnitZ();
  frames.axes_second.col(2) = -Vector3::UnitY();
  expect_row(angle_about_first(frames, {2, 1}), 0, Vector3::UnitZ());
  expect_row(angle_about_second(frames, {2, 1}), 0, Vector3::UnitZ());
}

}  // namespace
}  // namespace atl::solver
