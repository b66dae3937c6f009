#pragma once
/// A joint between two bodies at random places, and where they are a little later.

#include <solver/constraints/joint.h>

#include <array>
#include <cmath>

#include "support/random.h"

namespace atl::test {

// But for the length of a tendon, which is of more than two bodies.
inline constexpr std::array all_coordinates = {
    solver::Coordinate::OffsetX,   solver::Coordinate::OffsetY,     solver::Coordinate::OffsetZ,
    solver::Coordinate::Distance,  solver::Coordinate::TurnX,       solver::Coordinate::TurnY,
    solver::Coordinate::TurnZ,     solver::Coordinate::SwingAlongY, solver::Coordinate::SwingAlongZ,
    solver::Coordinate::SkewXY,    solver::Coordinate::SkewZY,      solver::Coordinate::Twist,
    solver::Coordinate::Swing,     solver::Coordinate::AngleX,      solver::Coordinate::AngleSecondY,
    solver::Coordinate::Steer,     solver::Coordinate::Roll,        solver::Coordinate::SpinX,
    solver::Coordinate::SpinY,     solver::Coordinate::SpinZ,       solver::Coordinate::Orbit,
    solver::Coordinate::Gear,      solver::Coordinate::Rack,        solver::Coordinate::BetweenZ,
    solver::Coordinate::BetweenY,  solver::Coordinate::AngleXOfZ,   solver::Coordinate::AngleSecondZ,
    solver::Coordinate::RotationX, solver::Coordinate::RotationY,   solver::Coordinate::RotationZ};

static_assert(all_coordinates.size() == static_cast<std::size_t>(solver::Coordinate::Rack));

struct JointPose {
  struct Body {
    Eigen::Vector3d position;
    solver::Quaternion orientation;
    Eigen::Vector3d velocity;
    Eigen::Vector3d spin;
  };

  solver::Joint joint;
  Body first, second;

  JointPose(Random& random, solver::Coordinate coordinate) : first(any(random)), second(any(random)) {
    joint.anchor_first = random.vector(1);
    joint.anchor_second = random.vector(1);
    joint.axes_first = random.rotation();
    joint.axes_second = random.rotation();
    joint.ratio = random.real(-3, 3);
    joint.rows = 1;
    joint.coordinate[0] = coordinate;
  }

  static Body any(Random& random) {
    const Eigen::Vector3d position = random.vector(3);
    const solver::Quaternion orientation = random.rotation();
    const Eigen::Vector3d velocity = random.vector(2);
    return {position, orientation, velocity, random.vector(2)};
  }

  /// After moving on at their velocities for a while, exactly.
  JointPose at(double time) const {
    JointPose moved = *this;
    for (Body* body : {&moved.first, &moved.second}) {
      body->position += time * body->velocity;
      const double speed = body->spin.norm();
      if (speed == 0) continue;
      const Eigen::AngleAxisd turn(speed * time, body->spin / speed);
      body->orientation = solver::Quaternion(turn) * body->orientation;
    }
    return moved;
  }

  solver::JointFrames frames() const {
    return joint_frames(joint, first.position, first.orientation, second.position, second.orientation);
  }
  solver::JointRow row() const { return joint_row(joint, 0, frames()); }
  double rate() const { return rate_of(row()); }
  double rate_of(const solver::JointRow& row) const {
    return row.rate(first.velocity, first.spin, second.velocity, second.spin);
  }
};

}  // namespace atl::test
