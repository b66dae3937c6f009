#pragma once
/// How far a run has strayed from a scene's ideal rest pose.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <string_view>
#include <utility>
#include <vector>

#include "support/bodies.h"

namespace atl::test {

inline constexpr Stabilisation all_stabilisations[] = {Stabilisation::Soft, Stabilisation::Baumgarte,
                                                       Stabilisation::SplitImpulse};

/// A world with the bodies of a scene.
struct SceneRun {
  Scene scene;
  World world;
  std::vector<BodyId> ids;

  explicit SceneRun(std::string_view text, const WorldDef& def = {}) : SceneRun(load_scene(text), def) {}
  SceneRun(Scene from, WorldDef def) : scene(std::move(from)), world((def.gravity = scene.gravity, def)) {
    ids = build_scene(scene, world);
  }

  PenetrationReport penetration() const {
    return measure_penetration(placed_shapes(scene, world, ids), may_touch(scene));
  }
  RestReport rest() const {
    return measure_rest(placed_shapes(scene), placed_shapes(scene, world, ids), -scene.gravity.normalized());
  }
};

/// Steps and fails at the first step that leaves something not finite.
inline void run_finite(World& world, int steps, double step = dt) {
  for (int i = 0; i < steps; ++i) {
    ASSERT_EQ(world.step(step).first_quarantined, -1) << "step " << i;
  }
  ASSERT_TRUE(world.positions().allFinite());
  ASSERT_TRUE(world.velocities().allFinite());
  ASSERT_TRUE(world.angular_velocities().allFinite());
}

/// Shapes of boxes at their current poses, for measure_penetration.
inline PlacedShape placed(const World& world, BodyId id, const Shape& shape) {
  return {.type = world.type(id), .shape = shape, .pose = world.pose(id)};
}

/// A body's rotation since it stood upright, rad.
inline double tilt(const World& world, BodyId id) {
  return world.pose(id).orientation.angularDistance(Quaternion::Identity());
}

}  // namespace atl::test
