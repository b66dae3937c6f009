#pragma once

#include <atoll/joint.h>

#include <vector>

namespace atl::scene {

/// The axes of a joint that its definition tells something about.
inline std::vector<JointAxis> axes_of(const JointKind& kind) {
  struct Visitor {
    std::vector<JointAxis> operator()(const BallJoint&) const { return {}; }
    std::vector<JointAxis> operator()(const HingeJoint& joint) const { return {joint.angle}; }
    std::vector<JointAxis> operator()(const SliderJoint& joint) const { return {joint.offset}; }
    std::vector<JointAxis> operator()(const FixedJoint&) const { return {}; }
    std::vector<JointAxis> operator()(const DistanceJoint& joint) const { return {joint.distance}; }
    std::vector<JointAxis> operator()(const UniversalJoint& joint) const { return {joint.first, joint.second}; }
    std::vector<JointAxis> operator()(const ConeTwistJoint& joint) const { return {joint.twist}; }
    std::vector<JointAxis> operator()(const SixDofJoint& joint) const {
      std::vector<JointAxis> axes(joint.offset.begin(), joint.offset.end());
      axes.insert(axes.end(), joint.turn.begin(), joint.turn.end());
      return axes;
    }
    std::vector<JointAxis> operator()(const GearJoint&) const { return {}; }
    std::vector<JointAxis> operator()(const TendonJoint& joint) const { return {joint.length}; }
    std::vector<JointAxis> operator()(const WheelJoint& joint) const {
      return {joint.suspension, joint.steering, joint.spin};
    }
  };
  return std::visit(Visitor{}, kind);
}

}  // namespace atl::scene
