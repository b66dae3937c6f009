// Extra work for one body's need is done for its island, or at most for its block of eight, not for the world.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <functional>

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

}  // namespace
}  // namespace atl::test
