// Everything at once, whatever the threads and vectors: stacks that fall asleep and are knocked over, islands that
// merge and split, bullets, joints that break, belts, bodies that come and go, and the events of it all.

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <string>
#include <tuple>
#include <vector>

#include "support/bodies.h"
#include "support/long_tests.h"
#include "support/variants.h"

namespace atl::test::matrix_test {
namespace {

class Playground {
 public:
  explicit Playground(const WorldDef& def) : world_(def) {
    world_.add_body(ground());
    for (int i = 0; i < 16; ++i) {
      stacks_.push_back(add_stack(world_, 3, {1.5 * (i % 4), 1.5 * (i / 4), 0}));
    }
    add_belt();
    add_chains();
    for (int i = 0; i < 24; ++i) {  // faster than their size, through the stacks
      BodyDef bullet = sphere({-30.0 - 8 * i, 0.31 * i - 1, 0.4 + 0.1 * (i % 20)}, 0.06);
      bullet.velocity = {160.0 + i, 0, 1};
      bullet.continuous = i % 2 == 0;
      world_.add_body(bullet);
    }
    BodyDef ram = box({-4, 2, 1}, {0.3, 0.3, 0.3});
    ram.type = BodyType::Kinematic;
    ram_ = world_.add_body(ram);
  }

  // Hashes of the state and of the events after each step.
  std::vector<std::uint64_t> run(int steps) {
    std::vector<std::uint64_t> trail;
    for (int i = 0; i < steps; ++i) {
      act(i);
      const StepReport report = world_.step(dt);
      asleep_ = std::max(asleep_, report.counts.asleep);
      stopped_ += report.counts.stopped;
      islands_changed_ += report.counts.islands != islands_;
      islands_ = report.counts.islands;
      trail.push_back(world_.state_hash());
      for (const ContactEvent& event : world_.contact_events()) {
        trail.push_back(std::uint64_t{event.a.index} << 33 | std::uint64_t{event.b.index} << 1 | event.began);
        trail.push_back(std::bit_cast<std::uint64_t>(event.impulse));
        pressing_ += event.persists;
      }
      for (const JointEvent& event : world_.joint_events()) {
        broken_ += event.kind == JointEventKind::Broke;
        trail.push_back(std::uint64_t{event.joint.index} << 8 | static_cast<std::uint64_t>(event.kind));
      }
      for (const ContactForce& force : world_.contact_forces()) trail.push_back(force.feature_id);
    }
    return trail;
  }

  // A run in which nothing of this happens would test nothing.
  void expect_that_all_happened() const {
    EXPECT_GT(asleep_, 10);
    EXPECT_GT(stopped_, 5);
    EXPECT_GT(islands_changed_, 10);
    EXPECT_GT(broken_, 0);
    EXPECT_GT(pressing_, 10);
  }

 private:
  void add_belt() {
    BodyDef belt = static_box({3, 12, 0.25}, {6, 1, 0.25});
    belt.surface_velocity = {1.5, 0, 0};
    world_.add_body(belt);
    for (int i = 0; i < 5; ++i) world_.add_body(box({-2 + 1.2 * i, 12, 1}, {0.3, 0.3, 0.3}));
  }

  void add_chains() {
    for (int chain = 0; chain < 4; ++chain) {
      const double y = -4.0 - 1.5 * chain;
      BodyId before = world_.add_body(static_box({0, y, 5}, {0.1, 0.1, 0.1}));
      for (int i = 0; i < 6; ++i) {
        const BodyId next = world_.add_body(box({0.5 + 0.6 * i, y, 5}, {0.25, 0.08, 0.08}));
        JointDef def{.first = before,
                     .second = next,
                     .frame_first = {{i == 0 ? 0.2 : 0.3, 0, 0}, Quaternion::Identity()},
                     .frame_second = {{-0.3, 0, 0}, Quaternion::Identity()},
                     .break_force = i == 3 ? 60 + 200.0 * chain : unlimited};
        if (i % 2 == 1) def.kind = HingeJoint{{.range = {-0.4, 0.4}}};
        world_.add_joint(def);
        before = next;
      }
    }
  }

  void act(int step) {
    if (step == 30) world_.set_velocity(ram_, {3, 0, 0}, Vector3::Zero());
    if (step == 60) world_.remove_body(stacks_[5][0]);
    if (step == 70) {
      BodyDef heavy = sphere({0.2, 0.1, 9}, 0.8);
      heavy.density = 4000;
      heavy.velocity = {0, 3, -12};
      world_.add_body(heavy);
    }
    if (step == 90) world_.apply_impulse(stacks_[10][2], {500, 900, 0}, world_.pose(stacks_[10][2]).position);
    if (step == 110) world_.set_velocity(ram_, Vector3::Zero(), Vector3::Zero());
  }

  World world_;
  std::vector<std::vector<BodyId>> stacks_;
  BodyId ram_;
  std::int64_t asleep_ = 0, stopped_ = 0, islands_ = -1, islands_changed_ = 0, broken_ = 0, pressing_ = 0;
};

int steps() { return long_tests() ? 900 : 150; }

class Matrix : public testing::TestWithParam<std::tuple<JointSolver, bool>> {};

TEST_P(Matrix, NeitherThreadsNorVectorsChangeABit) {
  const auto settings = [](Simd simd) {
    return Settings{.target = std::get<1>(GetParam()) ? all_targets() : ErrorTarget{},
                    .joint_solver = std::get<0>(GetParam()),
                    .sleeping = true,
                    .time_to_sleep = 0.2,
                    .contact_events = true,
                    .contact_event_force = 5000,
                    .simd = simd};
  };
  Playground first({.settings = settings(Simd::Auto)});
  const std::vector<std::uint64_t> expected = first.run(steps());
  first.expect_that_all_happened();
  // 8 are more than many machines have cores.
  for (const divergence::Variant& variant : variants_of({2, 1, 3, 4, 8})) {
    Playground other({.threads = variant.threads, .settings = settings(variant.simd)});
    EXPECT_TRUE(other.run(steps()) == expected) << variant.threads << " threads on " << name_of(variant.simd);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Joints, Matrix, testing::Combine(testing::Values(JointSolver::Iterative, JointSolver::Direct), testing::Bool()),
    [](const auto& of) {
      const bool direct = std::get<0>(of.param) == JointSolver::Direct;
      return std::string(direct ? "Direct" : "Iterative") + (std::get<1>(of.param) ? "ToTargets" : "");
    });

}  // namespace
}  // namespace atl::test::matrix_test
