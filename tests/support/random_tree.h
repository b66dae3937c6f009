#pragma once
/// Random trees of joints and bodies that touch nothing, and what any formula of their dynamics is held against.

#include <atoll/atoll.h>

#include <cstdint>
#include <utility>
#include <vector>

#include "support/random.h"

namespace atl::test {

struct RandomTree {
  World world;
  std::vector<BodyId> bodies;  // dynamic
  BodyId base;                 // what the tree hangs on, or its first body
  Random random;

  explicit RandomTree(std::uint32_t seed, bool floating, int count = 8)
      : world({.gravity = {0.5, -1, -9.81}, .settings = {.joint_solver = JointSolver::Direct}}), random(seed) {
    if (!floating) base = world.add_body({.type = BodyType::Static, .position = {0.3, -2, 1}, .filter = {.mask = 0}});
    for (int i = 0; i < count; ++i) {
      bodies.push_back(world.add_body(random_body()));
      if (i == 0 && floating) base = bodies[0];
      const auto carriers = static_cast<std::uint32_t>(i) + (floating ? 0 : 1);
      if (carriers == 0) continue;
      const std::uint32_t carrier = random.below(carriers);
      const bool on_base = !floating && carrier == static_cast<std::uint32_t>(i);
      join(on_base ? base : bodies[carrier], bodies.back(), i);
    }
  }

  /// Angles within half a turn, of a gimbal within 1.2 rad, offsets within 0.3 m, rates within 1 rad/s or m/s.
  std::pair<Eigen::VectorXd, Eigen::VectorXd> random_state(const Mechanism& mechanism) {
    Eigen::VectorXd q = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(mechanism.nq()));
    for (const MechanismJoint& joint : mechanism.joints()) {
      const auto first = static_cast<Eigen::Index>(joint.q);
      const bool turns = joint.joint == JointId{} || std::holds_alternative<BallJoint>(world.joint(joint.joint).kind) ||
                         joint.q_count == 7;
      const auto numbers = static_cast<Eigen::Index>(joint.q_count);
      for (Eigen::Index i = 0; i < numbers; ++i) {
        const bool slides = joint.joint != JointId{} &&
                            (std::holds_alternative<SliderJoint>(world.joint(joint.joint).kind) || joint.q_count == 7);
        q[first + i] = slides ? random.real(-0.3, 0.3) : random.real(-3, 3);
        if (is_gimbal(joint.joint)) q[first + i] *= 0.4;
      }
      if (turns) q.segment<4>(first + numbers - 4) = random.rotation().coeffs();
    }
    return {q, random_vector(mechanism.nv(), 1)};
  }

  Eigen::VectorXd random_vector(std::size_t size, double reach) {
    Eigen::VectorXd vector(static_cast<Eigen::Index>(size));
    for (double& number : vector) number = random.real(-reach, reach);
    return vector;
  }

  MassProperties mass_of(BodyId body) const { return body_mass(world.definition(body)); }

  /// kg m^2, in the world's axes.
  Matrix3 inertia_of(BodyId body) const {
    const Matrix3 axes = world.pose(body).orientation.toRotationMatrix();
    return axes * mass_of(body).inertia * axes.transpose();
  }

  Vector3 centre_in_frame(BodyId body) const { return *world.definition(body).centre_of_mass; }

  /// By v; only hinges have one here.
  Eigen::VectorXd armature(const Mechanism& mechanism) const {
    Eigen::VectorXd armature = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(mechanism.nv()));
    for (const MechanismJoint& joint : mechanism.joints()) {
      if (joint.joint == JointId{}) continue;
      const auto* hinge = std::get_if<HingeJoint>(&world.joint(joint.joint).kind);
      if (hinge != nullptr) armature[static_cast<Eigen::Index>(joint.v)] = hinge->angle.armature;
    }
    return armature;
  }

 private:
  bool is_gimbal(JointId joint) const {
    const auto* six = joint == JointId{} ? nullptr : std::get_if<SixDofJoint>(&world.joint(joint).kind);
    return six != nullptr && six->turns != SixDofTurns::Vector;
  }

  BodyDef random_body() {
    const Vector3 sides = Vector3::Constant(0.1) + random.vector(0.05);
    const double mass = random.real(0.5, 3);
    const Matrix3 axes = random.rotation().toRotationMatrix();
    const Vector3 squares = sides.cwiseAbs2();
    const Vector3 moments =
        mass / 3 * Vector3(squares.y() + squares.z(), squares.z() + squares.x(), squares.x() + squares.y());
    Matrix3 inertia = axes * moments.asDiagonal() * axes.transpose();
    inertia = (0.5 * (inertia + inertia.transpose())).eval();
    return {.shape = Box{sides},
            .position = random.vector(1),
            .orientation = random.rotation(),
            .mass = mass,
            .inertia = inertia,
            .centre_of_mass = random.vector(0.1),
            .gravity_scale = random.chance(0.3) ? random.real(0, 2) : 1,
            .filter = {.mask = 0}};
  }

  void join(BodyId carrier, BodyId body, int number) {
    const JointKind kinds[] = {HingeJoint{.angle = {.range = {-3.1, 3.1}, .armature = 0.05}},
                               SliderJoint{},
                               BallJoint{},
                               FixedJoint{},
                               UniversalJoint{},
                               WheelJoint{.suspension = {}, .steering = {}},
                               WheelJoint{.suspension = {.range = {0.1, 0.1}}},
                               SixDofJoint{},
                               SixDofJoint{.turns = SixDofTurns::AnglesXYZ},
                               SixDofJoint{.offset = {JointAxis{.range = {0.1, 0.1}}},
                                           .turns = SixDofTurns::AnglesXZY},
                               HingeJoint{}};
    const bool reversed = random.chance(0.4);
    JointDef def{.kind = kinds[static_cast<std::size_t>(number) % std::size(kinds)],
                 .first = reversed ? body : carrier,
                 .second = reversed ? carrier : body,
                 .frame_first = {random.vector(0.4), random.rotation()},
                 .frame_second = {random.vector(0.4), random.rotation()}};
    world.add_joint(def);
  }
};

}  // namespace atl::test
