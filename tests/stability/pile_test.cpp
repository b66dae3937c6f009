// A pile of random boxes dropped into a container comes to rest inside it.

#include <gtest/gtest.h>

#include <algorithm>
#include <variant>
#include <vector>

#include "support/scene_run.h"

namespace atl::test {
namespace {

/// How far a point lies beyond the container's walls and floor, its half-spaces; 0 inside.
double beyond_container(const Scene& scene, const Vector3& point) {
  double beyond = 0;
  for (const SceneBody& body : scene.bodies) {
    if (!std::holds_alternative<HalfSpace>(body.def.shape)) continue;
    const PlacedShape wall{.type = body.def.type,
                           .shape = body.def.shape,
                           .pose = {.position = body.def.position, .orientation = body.def.orientation}};
    beyond = std::max(beyond, overlap(wall, {.shape = Sphere{1e-9}, .pose = {.position = point}}));
  }
  return beyond;
}

TEST(Pile, ComesToRestInsideItsContainer) {
  SceneRun pile("pile:bodies=300");
  const std::vector<BodyId> bodies = dynamic_bodies(pile.world, pile.ids);
  ASSERT_EQ(bodies.size(), 300u);
  double max_energy = 0;
  for (int i = 0; i < 600; ++i) {
    ASSERT_EQ(pile.world.step(dt).first_quarantined, -1) << "step " << i;
    max_energy = std::max(max_energy, kinetic_energy(pile.world, bodies));
  }
  for (BodyId id : bodies) {
    EXPECT_LE(beyond_container(pile.scene, pile.world.pose(id).position), 0) << "body " << id.index;
  }
  EXPECT_LT(kinetic_energy(pile.world, bodies), 1e-3 * max_energy);
  EXPECT_LT(pile.penetration().p99, 0.1);
}

TEST(Pile, HasAContainerAtAll) {
  const Scene scene = load_scene("pile:bodies=300");
  EXPECT_EQ(beyond_container(scene, {0, 0, 5}), 0);
  for (const Vector3& outside :
       {Vector3(100, 0, 1), Vector3(-100, 0, 1), Vector3(0, 100, 1), Vector3(0, -100, 1), Vector3(0, 0, -1)}) {
    EXPECT_GT(beyond_container(scene, outside), 0) << outside.transpose();
  }
}

}  // namespace
}  // namespace atl::test
