// An armature has momentum of its own: it pays for every change of its coordinate's rate, also for those that come of
// tumbling and of rows that turn with their bodies.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <tuple>
#include <variant>

#include "support/random_assembly.h"

namespace atl::test {
namespace {

struct Case {
  std::string name;
  JointKind kind;
  std::size_t position;  // of the coordinate with the armature, among those of JointState
};

constexpr double armature = 0.1;  // kg m^2 or kg

Case hinge() { return {"hinge", HingeJoint{.angle = {.armature = armature}}, 0}; }
Case slider() {
  // Between stops that bounce, or the two would part.
  return {"slider", SliderJoint{.offset = {.range = {-0.1, 0.1, 1}, .armature = armature}}, 0};
}
Case cross() { return {"universal", UniversalJoint{.first = {.armature = armature}}, 0}; }
Case wheel() {
  WheelJoint joint{.suspension = {.range = {0, 0}}, .steering = {.armature = armature}};
  return {"wheel", joint, 1};
}

struct Pair {
  World world;
  std::vector<BodyId> bodies;
  JointId joint;
  std::size_t position;

  Pair(const Case& of, const Settings& settings, bool touching)
      : world({.gravity = Vector3::Zero(), .settings = settings}), position(of.position) {
    BodyDef box{.shape = Box{{0.25, 0.2, 0.3}}, .mass = 1};
    box.material.friction = 0;
    box.angular_velocity = {3, 5, 2};
    bodies.push_back(world.add_body(box));
    box.position = {0.5, 0, 0};
    box.velocity = Vector3(3, 5, 2).cross(box.position);
    box.angular_velocity = {-1, 5, 2};
    bodies.push_back(world.add_body(box));
    JointDef def{.kind = of.kind, .first = bodies[0], .second = bodies[1]};
    def.frame_first.position = {0.25, 0, 0};
    def.frame_second.position = {-0.25, 0, 0};
    def.collide = touching;
    joint = world.add_joint(def);
  }

  // J, with that of the armature.
  double energy() const {
    const double rate = world.joint_state(joint).speed[position];
    return mechanical_energy(world, bodies) + 0.5 * armature * rate * rate;
  }
};

using Mode = std::tuple<int, JointSolver, ContactSolver>;

class Armature : public testing::TestWithParam<Mode> {};

TEST_P(Armature, TakesAndGivesItsEnergy) {
  const auto [which, joint_solver, contact_solver] = GetParam();
  const Case of = std::vector{hinge(), slider(), cross(), wheel()}[static_cast<std::size_t>(which)];
  const Settings settings{.contact_solver = contact_solver, .joint_solver = joint_solver};
  // Faces that turn on each other make an island of contacts and joints, which is solved at once.
  const bool touching = contact_solver == ContactSolver::Direct;
  Pair pair(of, settings, touching);
  pair.world.step(dt);
  const double start = pair.energy();
  double rotor_least = 1e300, rotor_most = 0;
  for (int i = 0; i < 120; ++i) {
    pair.world.step(dt);
    const double rate = std::abs(pair.world.joint_state(pair.joint).speed[pair.position]);
    rotor_least = std::min(rotor_least, rate);
    rotor_most = std::max(rotor_most, rate);
    ASSERT_NEAR(pair.energy(), start, 0.05 * start) << of.name << ", step " << i;
  }
  EXPECT_GT(rotor_most, 1.01 * rotor_least) << of.name;
}

INSTANTIATE_TEST_SUITE_P(All, Armature,
                         testing::Values(Mode{0, JointSolver::Iterative, ContactSolver::Auto},
                                         Mode{0, JointSolver::Direct, ContactSolver::Auto},
                                         Mode{0, JointSolver::Direct, ContactSolver::Direct},
                                         Mode{1, JointSolver::Direct, ContactSolver::Auto},
                                         Mode{2, JointSolver::Iterative, ContactSolver::Auto},
                                         Mode{2, JointSolver::Direct, ContactSolver::Auto},
                                         Mode{3, JointSolver::Direct, ContactSolver::Auto}));

}  // namespace
}  // namespace atl::test
