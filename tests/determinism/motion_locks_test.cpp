// Worlds with motion locks: the same bits on any number of threads and lanes, restored, recorded and with nothing left
// out, next to bodies without as alone.

#include <atoll/scene.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "support/scene_run.h"
#include "support/variants.h"

namespace atl::test::motion_locks_test {
namespace {

// Heaps in a plane, along rails, of bodies that don't turn, and of free ones; of balls that roll hard, too.
std::string heap(const std::string& locks, double x, const std::string& shape, const std::string& material) {
  return R"({"body": {"shape": )" + shape + R"(, "material": )" + material + R"(, "position": [)" + std::to_string(x) +
         R"(, 0, 0.8])" + locks + R"(}, "count": [4, 1, 5], "spacing": [1.05, 1, 1.1],
           "stagger": [0.4, 0], "jitter": [0.05, 0.1, 0.05], "random_orientation": true})";
}

Scene locked_scene(bool with_free_bodies = true) {
  const std::string boxes = R"({"type": "box", "half_extents": [0.5, 0.4, 0.3]})";
  const std::string balls = R"({"type": "sphere", "radius": 0.4})";
  const std::string rough = R"({"friction": 0.7})";
  const std::string lively = R"({"friction": 0.3, "restitution": 0.6, "rolling_friction": 0.01})";
  const std::string plane = R"(, "locks": {"plane": "y"})";
  std::string generators =
      heap(plane, 0, boxes, rough) + "," + heap(R"(, "locks": {"linear": ["y"]})", 8, boxes, rough) + "," +
      heap(R"(, "locks": {"angular": ["x", "y", "z"]})", 16, boxes, rough) + "," + heap(plane, 24, balls, lively) +
      "," + heap(R"(, "locks": {"angular": ["x"]})", 32, boxes, rough);
  // Far enough that they never meet the others.
  if (with_free_bodies) generators += "," + heap("", 140, boxes, rough) + "," + heap("", 160, balls, lively);
  Scene scene = parse_scene(R"({"format": "atoll-scene", "version": 1, "steps": 150,
    "bodies": [{"type": "static", "shape": {"type": "half_space"}}], "generators": [)" +
                                generators + "]}",
                            "locks.json", 5);
  return scene;
}

// Expects the same bits of all threads and lanes, and restored.
void expect_same_in_every_variant(const Scene& scene) {
  const divergence::Variant plain;
  const std::vector<std::uint64_t> trail = divergence::follow(scene, plain);
  for (const Simd simd : divergence::supported_simds()) {
    for (const int threads : {1, 3}) expect_same(trail, scene, plain, {.threads = threads, .simd = simd});
  }
  expect_same(trail, scene, plain, {.restore = divergence::Restore::SameWorld});
  expect_same(trail, scene, plain, {.restore = divergence::Restore::FreshWorld});
}

TEST(MotionLocksBits, AreTheSameInEveryVariant) { expect_same_in_every_variant(locked_scene()); }

TEST(MotionLocksBits, LeavingOutChangesNone) {
  for (const double tolerance : {0.0, 1e-3}) {
    for (const Stabilisation how : {Stabilisation::Soft, Stabilisation::SplitImpulse}) {
      for (const FrictionModel friction : {FrictionModel::Cone, FrictionModel::Pyramid}) {
        Scene scene = locked_scene();
        scene.settings.tolerance = tolerance;
        scene.settings.stabilisation = how;
        scene.settings.friction = friction;
        const std::vector<std::uint64_t> trail = divergence::follow(scene, {});
        scene.settings.run_everything = true;
        EXPECT_EQ(divergence::follow(scene, {}), trail);
      }
    }
  }
}

// Bodies of one group share lanes: the free ones' neighbours must not show in the locked ones, nor the other way.
TEST(MotionLocksBits, NeighboursDontShow) {
  const Scene scene = locked_scene(), without = locked_scene(false);
  World world, smaller;
  const std::vector<BodyId> ids = build_scene(scene, world), fewer = build_scene(without, smaller);
  ASSERT_LT(fewer.size(), ids.size());
  for (int i = 0; i < scene.steps; ++i) {
    world.step(scene.dt);
    smaller.step(scene.dt);
    for (std::size_t k = 0; k < fewer.size(); ++k) {
      ASSERT_EQ(world.pose(ids[k]).position, smaller.pose(fewer[k]).position) << "step " << i << ", body " << k;
      ASSERT_EQ(world.angular_velocity(ids[k]), smaller.angular_velocity(fewer[k]));
    }
  }
}

// A cart on rails with a pole, a mechanism in its plane that hangs and touches the ground, a rotor in place that
// carries a rod, and a wheel with a motor: by each solver, next to what has no locks.
Scene joined_scene(JointSolver solver, Stabilisation stabilisation) {
  Scene scene;
  scene.steps = 90;
  scene.dt = 1.0 / 60;
  scene.settings.joint_solver = solver;
  scene.settings.stabilisation = stabilisation;
  const auto add = [&](const Vector3& position, const Vector3& half_extents, const MotionLocks& locks) {
    scene.bodies.push_back({.def = {.shape = Box{half_extents}, .position = position, .locks = locks}});
    return static_cast<std::uint32_t>(scene.bodies.size() - 1);
  };
  const auto join = [&](const JointKind& kind, std::uint32_t first, std::uint32_t second, const Vector3& point) {
    const auto frame = [&](std::uint32_t body) {
      return Pose{point - scene.bodies[body].def.position, Quaternion(Eigen::AngleAxisd(1.5, Vector3::UnitZ()))};
    };
    scene.joints.push_back({.def = {.kind = kind, .frame_first = frame(first), .frame_second = frame(second)},
                            .first = first,
                            .second = second});
  };
  scene.bodies.push_back({.def = {.type = BodyType::Static, .shape = HalfSpace{}, .position = {0, 0, -1.2}}});
  for (const MotionLocks& plane : {MotionLocks::plane(Axis::Y), MotionLocks{}}) {
    const double y = plane == MotionLocks{} ? 10 : 0;
    const std::uint32_t cart = add({0, y, 0}, {0.3, 0.1, 0.1}, {{false, true, true}, {true, true, true}});
    join(BallJoint{}, cart, add({0.5, y, 0}, {0.5, 0.05, 0.05}, {}), {0, y, 0});
    std::uint32_t last = 0;
    for (int i = 0; i < 4; ++i) {
      const std::uint32_t next = add({3 + i + 0.5, y, 0}, {0.5, 0.1, 0.1}, plane);
      join(HingeJoint{{.motor = JointMotor{.speed = 1, .max_force = 5}}}, last, next, {3.0 + i, y, 0});
      last = next;
    }
    const std::uint32_t rotor = add({9, y, 0}, {0.5, 0.1, 0.1}, {.linear = {true, true, true}});
    join(UniversalJoint{}, rotor, add({9.9, y, 0}, {0.4, 0.1, 0.1}, {.linear = {false, false, true}}), {9.5, y, 0});
  }
  return scene;
}

TEST(MotionLocksBits, WithJointsAreTheSameInEveryVariant) {
  for (const JointSolver solver : {JointSolver::Auto, JointSolver::Direct, JointSolver::Iterative}) {
    for (const Stabilisation how : all_stabilisations) {
      Scene scene = joined_scene(solver, how);
      expect_same_in_every_variant(scene);
      const std::vector<std::uint64_t> trail = divergence::follow(scene, {});
      scene.settings.run_everything = true;
      EXPECT_EQ(divergence::follow(scene, {}), trail);
    }
  }
}

}  // namespace
}  // namespace atl::test::motion_locks_test
