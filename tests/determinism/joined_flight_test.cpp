// Assemblies that are put back to where they met something: the same bits whatever the threads and vectors, after a
// snapshot in mid-flight, and from a recording.

#include <gtest/gtest.h>

#include "support/long_tests.h"
#include "support/scene_run.h"
#include "support/temporary_file.h"
#include "support/thrown.h"
#include "support/variants.h"

namespace atl::test::joined_flight_test {
namespace {

class JoinedFlight : public testing::TestWithParam<JointSolver> {
 protected:
  // So that some of each kind meet the wall, each other or themselves in most of the steps.
  Scene scene_ = [] {
    Scene scene = before_a_wall(0.02);
    scene.steps = 40;
    scene.settings.joint_solver = GetParam();
    for (int i = 0; i < 6; ++i) {
      const double y = 1.5 * i;
      throw_pair(scene, i % 2 == 0 ? JointKind{BallJoint{}} : JointKind{FixedJoint{}}, {-9.0 + i, y, 0},
                 Quaternion::Identity(), {90, 0, 3});
      throw_chain(scene, {-12, y, 1}, Vector3(1, 0.3 * i, 1).normalized(), 10, {60.0 + 3 * i, 0, 0});
      throw_ragdoll(scene, static_cast<std::uint64_t>(i + 1), {-5, 2.5 * i, -4}, {40, 0, 0});
      swing_flail(scene, {-0.5, y, 6}, -1.5, 40);
    }
    return scene;
  }();
};

TEST_P(JoinedFlight, IsTheSameOnAnyThreadsAndAfterSnapshots) {
  using divergence::Restore;
  const divergence::Variant first{};
  const std::vector<std::uint64_t> trail = divergence::follow(scene_, first);
  for (const divergence::Variant& other : variants_of({2, 1, 4})) expect_same(trail, scene_, first, other);
  for (divergence::Variant other : long_tests() ? variants_of({2, 1, 4}) : std::vector{first}) {
    for (const Restore restore : {Restore::SameWorld, Restore::FreshWorld}) {
      other.restore = restore;
      expect_same(trail, scene_, first, other);
    }
  }
}

TEST_P(JoinedFlight, IsReplayed) {
  const TemporaryFile file(".recording");
  SceneRun run(scene_, {.threads = 2, .settings = scene_.settings});
  std::int64_t put_back = 0;
  for (int step = 0; step < scene_.steps; ++step) {
    if (step == 8) run.world.record(file.path());
    const std::int64_t stopped = run.world.step(scene_.dt).counts.stopped;
    if (step >= 8) put_back += stopped;
  }
  const std::uint64_t hash = run.world.state_hash();
  run.world.stop_recording();
  EXPECT_GT(put_back, 200);
  for (const int threads : {1, 4}) {
    const ReplayResult result = replay(file.path(), {.threads = threads});
    EXPECT_FALSE(result.divergence.has_value());
    EXPECT_EQ(result.hash, hash);
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, JoinedFlight, testing::Values(JointSolver::Iterative, JointSolver::Direct),
                         [](const auto& test) { return test.param == JointSolver::Direct ? "Direct" : "Iterative"; });

}  // namespace
}  // namespace atl::test::joined_flight_test
