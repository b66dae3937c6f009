// Bodies that slide.

#include "cases.h"

namespace atl::physics {
namespace {

// m, from where Coulomb friction stops a body that was thrown along x.
double off_stopping_place(const Resolution& at, const Shape& shape, double height, double friction, double speed) {
  World world = make_world(at);
  const Material material{.friction = friction};
  add_ground(world, material);
  const BodyId body = world.add_body({.shape = shape,
                                      .position = {0, 0, height},
                                      .orientation = turn_about(Vector3::UnitZ(), pi / 4),
                                      .velocity = {speed, 0, 0},
                                      .material = material});
  run(world, at, speed / (friction * g) + 0.5);
  const Vector3 stopped = world.pose(body).position;
  return std::hypot(stopped.x() - speed * speed / (2 * friction * g), stopped.y());
}

Compound three_balls() {
  Compound compound;
  for (const Vector3& at : {Vector3(0.5, 0, 0), Vector3(-0.3, 0.4, 0), Vector3(-0.2, -0.4, 0)}) {
    compound.children.push_back({.shape = Sphere{0.2}, .position = at});
  }
  return compound;
}

// rad/s of yaw that friction makes of nothing.
double yaw_of_balls(const Resolution& at) {
  World world = make_world(at);
  const Material material{.friction = 0.3};
  add_ground(world, material);
  const BodyId body =
      world.add_body({.shape = three_balls(), .position = {0, 0, 0.2}, .velocity = {5, 0, 0}, .material = material});
  double max = 0;
  run(world, at, 1.5, [&](double) { max = std::max(max, std::abs(world.angular_velocity(body).z())); });
  return max;
}

}  // namespace

void add_sliding(std::vector<PhysicsCase>& cases) {
  const double distance = 25 / (2 * 0.3 * g);
  cases.push_back({.name = "slide-turned-box",
                   .what = "a box of 1 x 0.4 x 0.4 m, 45 degrees to its way, 5 m/s, friction 0.3: off where it stops",
                   .unit = "m",
                   .source = "Coulomb: v^2 / (2 mu g) ahead",
                   .scale = distance,
                   .measure = [](const Resolution& at) {
                     return off_stopping_place(at, Box{{0.5, 0.2, 0.2}}, 0.2, 0.3, 5);
                   }});
  cases.push_back({.name = "slide-three-balls",
                   .what = "three balls as one body, 5 m/s, friction 0.3: off where it stops",
                   .unit = "m",
                   .source = "Coulomb: v^2 / (2 mu g) ahead",
                   .scale = distance,
                   .measure = [](const Resolution& at) { return off_stopping_place(at, three_balls(), 0.2, 0.3, 5); }});
  cases.push_back({.name = "slide-three-balls-yaw",
                   .what = "the same: the most that it turns about the vertical",
                   .unit = "rad/s",
                   .source = "friction's resultant passes under the centre of mass",
                   .scale = 5,
                   .measure = yaw_of_balls});
}

}  // namespace atl::physics
