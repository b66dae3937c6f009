// What one body needs is done for its island, or at most for the block of eight that it shares, not for the world.

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
  Stage stage;
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
  const StageReport before = world.step(dt).stage(GetParam().stage);
  EXPECT_FALSE(before.run);
  EXPECT_EQ(before.items, 0);

  GetParam().add(world, {.position = {-10, -10, 0.5}});
  const StepReport report = world.step(dt);
  EXPECT_TRUE(report.stage(GetParam().stage).run);
  EXPECT_GE(report.stage(GetParam().stage).items, 1);
  EXPECT_LE(report.stage(GetParam().stage).items, block);
  EXPECT_GT(report.counts.contacts, 3 * stacks);
}

const Guest guests[] = {
    {"Bouncy", Stage::Restitution,
     [](World& world, BodyDef def) {
       def.material.restitution = 0.5;
       world.add_body(def);
     }},
    {"Fast", Stage::ContinuousCollision,
     [](World& world, BodyDef def) {
       def.continuous = true;
       def.velocity = {-1, 0, 0};
       world.add_body(def);
     }},
    {"Tumbling", Stage::GyroscopicTorque,
     [](World& world, BodyDef def) {
       def.shape = Box{.half_extents = {0.5, 0.4, 0.5}};
       world.add_body(def);
     }},
    {"Jointed", Stage::JointSolver,
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
