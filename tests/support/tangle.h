#pragma once

#include <vector>

#include "support/bodies.h"

namespace atl::test {

/// Chains of all kinds of joints that fall on the ground and on each other.
struct Tangle {
  World& world;
  std::vector<BodyId> bodies;
  std::vector<JointId> joints;

  explicit Tangle(World& filled) : world(filled) {
    world.add_body(ground());
    const BodyId post = world.add_body(static_box({0, 0, 6}, {0.2, 0.2, 0.2}));
    const std::vector<JointKind> kinds = {
        BallJoint{.friction = 0.5},
        HingeJoint{{.range = {-0.5, 0.5}, .motor = JointMotor{2, 5}}},
        SliderJoint{{.range = {-0.1, 0.1, 0.7}, .spring = JointSpring{.hertz = 3}, .armature = 2}},
        HingeJoint{{.range = {-0.6, 0.4, 0.5}, .motor = JointMotor{0, 5, JointServo{0.2, 40, 2}}, .armature = 0.1}},
        FixedJoint{},
        UniversalJoint{.first = {.range = {-1, 1}}},
        ConeTwistJoint{.swing_limit = 0.4, .twist = {.range = {-0.3, 0.3}}},
        SixDofJoint{.offset = {JointAxis{}, JointAxis{.range = {0, 0}}, JointAxis{.range = {0, 0}}}},
    };
    for (int chain = 0; chain < 12; ++chain) {
      BodyId before = post;
      for (std::size_t i = 0; i < kinds.size(); ++i) {
        const JointKind& kind = kinds[(i + static_cast<std::size_t>(chain)) % kinds.size()];
        const double x = 0.5 + 0.6 * static_cast<double>(i);
        const BodyId next = world.add_body(box({x, 0.45 * chain, 3 + 0.3 * chain}, {0.25, 0.1, 0.1}));
        bodies.push_back(next);
        if (before != post || chain == 0) {
          joints.push_back(world.add_joint({.kind = kind,
                                            .first = before,
                                            .second = next,
                                            .frame_first = {{0.3, 0, 0}, Quaternion::Identity()},
                                            .frame_second = {{-0.3, 0, 0}, Quaternion::Identity()},
                                            .break_force = i == 5 ? 400 : unlimited}));
        }
        before = next;
      }
    }
  }
};

}  // namespace atl::test
