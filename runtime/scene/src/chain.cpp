// A chain that swings down with a ball at its end, up to a million times as heavy as a link.

#include "building_blocks.h"
#include "builtin.h"
#include "joined_scene.h"

namespace atl::scene {
namespace chain {

constexpr double ball_radius = 0.5;  // m

}  // namespace chain

Scene build_chain(const ParameterValues& values, std::uint64_t) {
  using namespace chain;
  const int links = values.integer("links");
  Scene scene;
  scene.steps = 600;
  // The chain starts level, as high as it is long.
  const Vector3 hook(0, 0, links * chain_link_length);
  scene.bodies.push_back(untouched(fixed_ball("anchor", hook, chain_link_radius)));
  for (int i = 0; i < links; ++i) {
    scene.bodies.push_back(chain_link(i, hook + (i + 0.5) * chain_link_length * Vector3::UnitX(), Vector3::UnitX()));
    join_last_two(scene, BallJoint{}, hook + i * chain_link_length * Vector3::UnitX());
  }
  const Vector3 end = hook + links * chain_link_length * Vector3::UnitX();
  SceneBody ball;
  ball.name = "ball";
  ball.def = {.shape = Sphere{ball_radius}, .position = end + ball_radius * Vector3::UnitX(), .mass = values["ratio"]};
  scene.bodies.push_back(untouched(ball));
  join_last_two(scene, BallJoint{}, end);
  return scene;
}

}  // namespace atl::scene
