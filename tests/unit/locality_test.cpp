// Extra work for one body's need is done for its island, or at most for its block of eight, not for the world.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "support/bodies.h"

namespace atl::test {
namespace {

constexpr int block = 8;
constexpr int stacks = 100;

struct Guest {
  const char* name;
  Feature feature;
  std::function<void(World& world, BodyDef def)> add;
};

void PrintTo(const Guest& guest, std::ostream* out) { *out << guest.name; }

class Locality : public testing::TestWithParam<Guest> {};

TEST_P(Locality, AStageIsRunForTheIslandThatNeedsIt) {
  World world({.gravity = {0, 0, -9.81}});
  world.add_body({.type = BodyType::Static, .shape = HalfSpace{}});
  for (int stack = 0; stack < stacks; ++stack) {
    for (int level = 0; level < 2 + stack % 4; ++level) {
      world.add_body({.position = {2.0 * (stack % 10), 2.0 * (stack / 10), 0.5 + level}});
    }
  }
  for (int i = 0; i < 20; ++i) world.step(dt);
  const FeatureReport before = world.step(dt).feature(GetParam().feature);
  EXPECT_FALSE(before.run);
  EXPECT_EQ(before.items, 0);

  GetParam().add(world, {.position = {-10, -10, 0.5}});
  const StepReport report = world.step(dt);
  EXPECT_TRUE(report.feature(GetParam().feature).run);
  EXPECT_GE(report.feature(GetParam().feature).items, 1);
  EXPECT_LE(report.feature(GetParam().feature).items, block);
  EXPECT_GT(report.counts.contacts, 3 * stacks);
}

const Guest guests[] = {
    {"Bouncy", Feature::Restitution,
     [](World& world, BodyDef def) {
       def.material.restitution = 0.5;
       world.add_body(def);
     }},
    {"Fast", Feature::ContinuousCollision,
     [](World& world, BodyDef def) {
       def.continuous = true;
       def.velocity = {-1, 0, 0};
       world.add_body(def);
     }},
    {"Tumbling", Feature::GyroscopicTorque,
     [](World& world, BodyDef def) {
       def.shape = Box{.half_extents = {0.5, 0.4, 0.5}};
       world.add_body(def);
     }},
    {"Jointed", Feature::JointSolver,
     [](World& world, BodyDef def) {
       const BodyId first = world.add_body(def);
       def.position.x() -= 2;
       const BodyId second = world.add_body(def);
       world.add_joint({.first = first, .second = second, .frame_first = {{-1, 0, 0}}, .frame_second = {{1, 0, 0}}});
     }},
};

INSTANTIATE_TEST_SUITE_P(Guests, Locality, testing::ValuesIn(guests),
                         [](const testing::TestParamInfo<Guest>& guest) { return std::string(guest.param.name); });

// A swept joint that bounces is swept more often, and with it none of another island, whose bits that would change.
TEST(JointBounce, ChangesNoOtherIsland) {
  const auto swing = [](double restitution) {
    World world({.settings = {.joint_solver = JointSolver::Iterative}});
    const BodyId base = world.add_body(static_box({0, 0, 0}, {0.1, 0.1, 0.1}));
    const BodyId pendulum = world.add_body(sphere({1.5, 0, -1}, 0.2));
    world.add_joint(joint_at(world, HingeJoint{}, base, pendulum, {0, 0, 0}, Vector3::UnitY()));
    const BodyId slide = world.add_body(sphere({5, 0, 0}, 0.2));
    const SliderJoint down = {.offset = {.range = {-0.3, 0.3, restitution}}};
    world.add_joint(joint_at(world, down, base, slide, {5, 0, 0}, Vector3::UnitZ()));
    run(world, 60);
    return std::pair(world.body_hash(pendulum).velocity, world.velocity(slide).z());
  };
  const auto [resting, rest] = swing(0);
  const auto [bouncing, bounce] = swing(0.9);
  ASSERT_GT(std::abs(bounce), std::abs(rest) + 0.1);
  EXPECT_EQ(bouncing, resting);
}

// Separations of shapes with a rim take part in their rolling. Lanes beside them hold a stack of boxes.
TEST(Rolling, ChangesNoOtherIsland) {
  const auto stack_beside = [](const Shape* rolling) {
    World world({.settings = {.contact_solver = ContactSolver::Iterative}});
    world.add_body(ground());
    std::vector<BodyId> stack;
    for (int level = 0; level < 3; ++level) {
      BodyDef above = box({10 + 0.05 * level, 0.03 * level, 0.5 + level});
      above.angular_velocity = {0.3, -0.2, 0.1 * level};
      stack.push_back(world.add_body(above));
    }
    if (rolling != nullptr) {
      world.add_body(
          {.shape = *rolling, .position = {0, 0, 0.6}, .velocity = {2.8, -1.4, 0}, .angular_velocity = {3, 2, 1}});
    }
    for (int i = 0; i < 40; ++i) world.step(dt);
    std::vector<BodyHash> hashes;
    for (const BodyId id : stack) hashes.push_back(world.body_hash(id));
    return hashes;
  };
  const std::vector<BodyHash> alone = stack_beside(nullptr);
  const Shape shapes[] = {Capsule{0.3, 0.3}, Cylinder{0.3, 0.3}, Cone{0.3, 0.3}, Ellipsoid{{0.2, 0.3, 0.4}},
                          TaperedCapsule{{0.2, 0.4}, 0.3}};
  for (const Shape& shape : shapes) EXPECT_EQ(stack_beside(&shape), alone) << shape.index();
}

}  // namespace
}  // namespace atl::test
