// A sheet of balls, each joined to its neighbours, that hangs by the middle of its upper edge. After the benchmark of
// that name in Box2D and Box3D.

#include <cstdlib>

#include "builtin.h"
#include "joined_scene.h"

namespace atl::scene {
namespace joint_grid {

constexpr double radius = 0.4;  // m; neighbours are 1 m apart
constexpr int reach = 3;        // columns to either side of the middle that hold the sheet

}  // namespace joint_grid

Scene build_joint_grid(const ParameterValues& values, std::uint64_t) {
  using namespace joint_grid;
  const int n = values.integer("n");
  Scene scene;
  scene.steps = 100;
  const auto held = [n](int column) { return std::abs(column - n / 2) <= reach; };
  const auto place = [n](int column, int row) { return static_cast<std::size_t>(column * n + row); };
  const auto join = [&](std::size_t first, std::size_t second) {
    const Vector3 middle = (scene.bodies[first].def.position + scene.bodies[second].def.position) / 2;
    scene.joints.push_back(joined(scene, "joint_" + std::to_string(scene.joints.size()), BallJoint{}, first, second,
                                  {middle, Quaternion::Identity()}));
  };
  for (int column = 0; column < n; ++column) {
    for (int row = 0; row < n; ++row) {
      SceneBody ball;
      ball.name = "ball_" + std::to_string(place(column, row));
      ball.def = {.shape = Sphere{radius}, .position = Vector3(column, 0, -row), .density = 1};
      if (row == 0 && held(column)) ball.def.type = BodyType::Static;
      scene.bodies.push_back(untouched(ball));
      if (row > 0) join(place(column, row - 1), place(column, row));
      if (column > 0 && (row > 0 || !held(column) || !held(column - 1))) {
        join(place(column - 1, row), place(column, row));
      }
    }
  }
  return scene;
}

}  // namespace atl::scene
