#include <atoll/error.h>
#include <atoll/errors.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

namespace atl {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double full_turn = 2 * pi;

/// A joint's frame in the world.
struct Frame {
  Vector3 origin;
  Matrix3 axes;  ///< columns: x, y, z
};

Frame frame_of(const BodyState& body, const Pose& local) {
  const Quaternion turn = body.pose.orientation.normalized();
  return {body.pose.position + turn * local.position, (turn * local.orientation.normalized()).toRotationMatrix()};
}

double angle_between(const Vector3& a, const Vector3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

/// Angle about a unit vector by which one vector has turned from another, in (-pi, pi]; by their parts across it.
double angle_about(const Vector3& axis, const Vector3& from, const Vector3& to) {
  return std::atan2(axis.dot(from.cross(to)), from.dot(to) - axis.dot(from) * axis.dot(to));
}

/// By how much a value lies outside a range.
double beyond(const JointRange& range, double value) {
  return std::max({0.0, range.lower - value, value - range.upper});
}

/// The same of an angle, which is known up to full turns: of the turn that lies best.
double beyond_turning(const JointRange& range, double angle) {
  if (!std::isfinite(range.lower) || !std::isfinite(range.upper)) {
    // Some turn satisfies a range that is open to one side.
    return 0;
  }
  const double middle = range.lower + (range.upper - range.lower) / 2;
  const double nearest = angle + full_turn * std::round((middle - angle) / full_turn);
  return beyond(range, nearest);
}

bool limits(const JointRange& range) { return std::isfinite(range.lower) || std::isfinite(range.upper); }
bool locks(const JointRange& range) { return range.lower == range.upper; }

/// The drift of one joint.
struct Drift {
  Vector3 gap = Vector3::Zero();  ///< m, of what is locked, along axes at right angles
  double angle = 0;               ///< rad, the largest of the locked ones
  double excess = 0;              ///< m
  double angle_excess = 0;        ///< rad
  bool has_angle = false;
  bool has_range = false;
  bool has_angle_range = false;

  void locked_angle(double error) {
    has_angle = true;
    angle = std::max(angle, std::abs(error));
  }
  void offset(const JointRange& range, int axis, double value) {
    if (locks(range)) {
      gap[axis] = value - range.lower;
    } else if (limits(range)) {
      has_range = true;
      excess = std::max(excess, beyond(range, value));
    }
  }
  void turn(const JointRange& range, double value) { turn_beyond(range, beyond_turning(range, value)); }
  void bounded_turn(const JointRange& range, double value) { turn_beyond(range, beyond(range, value)); }

  void turn_beyond(const JointRange& range, double error) {
    if (locks(range)) {
      locked_angle(error);
    } else if (limits(range)) {
      has_angle_range = true;
      angle_excess = std::max(angle_excess, error);
    }
  }
};

/// Measures by kind. Gears hold a sum of turns that poses do not tell, and tendons coordinates of other joints.
class Gauge {
 public:
  Gauge(const Frame& first, const Frame& second)
      : a_(first), b_(second), offset_(second.origin - first.origin), turn_(first.axes.transpose() * second.axes) {
    if (turn_.w() < 0) turn_.coeffs() = -turn_.coeffs();
  }

  Drift operator()(const BallJoint&) const { return {.gap = offset_}; }

  Drift operator()(const HingeJoint& joint) const {
    Drift drift{.gap = offset_};
    drift.locked_angle(angle_between(x(a_), x(b_)));
    drift.turn(joint.angle.range, angle_about(x(a_), y(a_), y(b_)));
    return drift;
  }

  Drift operator()(const SliderJoint& joint) const {
    Drift drift{.gap = local_offset()};
    drift.gap.x() = 0;
    drift.offset(joint.offset.range, 0, local_offset().x());
    drift.locked_angle(angle());
    return drift;
  }

  Drift operator()(const FixedJoint&) const {
    Drift drift{.gap = offset_};
    drift.locked_angle(angle());
    return drift;
  }

  Drift operator()(const DistanceJoint& joint) const {
    Drift drift;
    drift.offset(joint.distance.range, 0, offset_.norm());
    return drift;
  }

  Drift operator()(const UniversalJoint& joint) const {
    Drift drift{.gap = offset_};
    drift.locked_angle(angle_between(x(a_), y(b_)) - pi / 2);
    drift.turn(joint.first.range, angle_about(x(a_), y(a_), y(b_)));
    drift.turn(joint.second.range, angle_about(y(b_), x(a_), x(b_)));
    return drift;
  }

  Drift operator()(const ConeTwistJoint& joint) const {
    Drift drift{.gap = offset_};
    if (std::isfinite(joint.swing_limit)) {
      drift.has_angle_range = true;
      drift.angle_excess = std::max(0.0, angle_between(x(a_), x(b_)) - joint.swing_limit);
    }
    drift.turn(joint.twist.range, 2 * std::atan2(turn_.x(), turn_.w()));
    return drift;
  }

  Drift operator()(const SixDofJoint& joint) const {
    Drift drift;
    for (int axis = 0; axis < 3; ++axis) {
      drift.offset(joint.offset[static_cast<std::size_t>(axis)].range, axis, local_offset()[axis]);
      // Twice the sine of half the angle, which has no full turns.
      if (joint.turns != SixDofTurns::Vector) continue;
      drift.bounded_turn(joint.turn[static_cast<std::size_t>(axis)].range, 2 * turn_.vec()[axis]);
    }
    if (joint.turns == SixDofTurns::Vector) return drift;
    const int last = joint.turns == SixDofTurns::AnglesXYZ ? 2 : 1, middle = 3 - last;
    const Vector3 hinge = a_.axes.col(0), carried = b_.axes.col(last);
    const double between = (middle == 1 ? 1 : -1) * (pi / 2 - angle_between(hinge, carried));
    drift.turn(joint.turn[0].range, angle_about(hinge, a_.axes.col(last), carried));
    drift.bounded_turn(joint.turn[static_cast<std::size_t>(middle)].range, between);
    drift.turn(joint.turn[static_cast<std::size_t>(last)].range, angle_about(carried, hinge, b_.axes.col(0)));
    return drift;
  }

  Drift operator()(const GearJoint&) const { return {}; }
  Drift operator()(const TendonJoint&) const { return {}; }

  Drift operator()(const WheelJoint& joint) const {
    Drift drift{.gap = local_offset()};
    drift.gap.z() = 0;
    drift.offset(joint.suspension.range, 2, local_offset().z());
    drift.locked_angle(angle_between(z(a_), y(b_)) - pi / 2);
    drift.turn(joint.steering.range, angle_about(z(a_), y(a_), y(b_)));
    drift.turn(joint.spin.range, angle_about(y(b_), z(a_), z(b_)));
    return drift;
  }

 private:
  static Vector3 x(const Frame& frame) { return frame.axes.col(0); }
  static Vector3 y(const Frame& frame) { return frame.axes.col(1); }
  static Vector3 z(const Frame& frame) { return frame.axes.col(2); }

  Vector3 local_offset() const { return a_.axes.transpose() * offset_; }

  /// The angle of the relative rotation, rad.
  double angle() const { return 2 * std::atan2(turn_.vec().norm(), turn_.w()); }

  Frame a_;
  Frame b_;
  Vector3 offset_;
  Quaternion turn_;  ///< of the second frame in the first, w >= 0
};

Drift drift_of(const PlacedJoint& joint, std::span<const BodyState> states, std::size_t place) {
  for (const std::size_t body : {joint.first, joint.second}) {
    if (body >= states.size()) {
      throw Error("measure_joint_drift: joint " + std::to_string(place) + " joins body " + std::to_string(body) +
                  ", expected one of the " + std::to_string(states.size()) + " states");
    }
  }
  const Gauge gauge(frame_of(states[joint.first], joint.frame_first),
                    frame_of(states[joint.second], joint.frame_second));
  return std::visit(gauge, joint.kind);
}

}  // namespace

JointDriftReport measure_joint_drift(std::span<const PlacedJoint> joints, std::span<const BodyState> states) {
  JointDriftReport report;
  double squares = 0;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const Drift drift = drift_of(joints[i], states, i);
    const double gap = drift.gap.norm();
    if (gap > report.max) {
      report.max = gap;
      report.worst = i;
    }
    report.mean += gap;
    squares += gap * gap;
    report.angle_max = std::max(report.angle_max, drift.angle);
    report.excess_max = std::max(report.excess_max, drift.excess);
    report.angle_excess_max = std::max(report.angle_excess_max, drift.angle_excess);
    report.angles += drift.has_angle ? 1u : 0u;
    report.ranges += drift.has_range ? 1u : 0u;
    report.angle_ranges += drift.has_angle_range ? 1u : 0u;
  }
  if (!joints.empty()) {
    const auto count = static_cast<double>(joints.size());
    report.mean /= count;
    report.rms = std::sqrt(squares / count);
  }
  return report;
}

}  // namespace atl
