/// A program of a user of the package: a crate falls 2.5 m onto the ground and comes to rest there.

#include <atoll/atoll.h>

#include <cmath>
#include <iostream>

int main() {
  atl::World world({.gravity = {0, 0, -9.81}, .threads = 2});
  world.add_body({.type = atl::BodyType::Static, .shape = atl::HalfSpace{.normal = {0, 0, 1}}});
  const atl::BodyId crate = world.add_body({.shape = atl::Box{.half_extents = {0.5, 0.5, 0.5}},
                                            .position = {0, 0, 3},
                                            .density = 600,
                                            .material = {.friction = 0.6}});
  for (int i = 0; i < 300; ++i) world.step(1.0 / 60);

  double weight = 0;
  for (const atl::ContactForce& contact : world.contact_forces()) weight += contact.normal_force;
  const double height = world.pose(crate).position.z();
  std::cout << "height " << height << " m, weight " << weight << " N\n";
  const bool rests = std::abs(height - 0.5) < 1e-3 && std::abs(weight / (600 * 9.81) - 1) < 1e-2;
  return rests && !atl::builtin_scenes().empty() ? 0 : 1;
}
