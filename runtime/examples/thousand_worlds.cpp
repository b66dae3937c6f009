// A thousand worlds at once: how far a box slides, for a thousand coefficients of friction. Worlds are independent, so
// each thread has its own, and what they come to doesn't depend on how many threads there are.

#include <atoll/atoll.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <iostream>
#include <thread>
#include <vector>

namespace {

constexpr std::size_t worlds = 1000;
constexpr double speed = 4;  // m/s, at the start
constexpr double gravity = 9.81;

double friction_of(std::size_t number) { return 0.2 + 0.6 * static_cast<double>(number) / worlds; }

double slide(double friction) {
  atl::World world({.gravity = {0, 0, -gravity}});
  const atl::Material material = {.friction = friction};
  world.add_body({.type = atl::BodyType::Static, .shape = atl::HalfSpace{.normal = {0, 0, 1}}, .material = material});
  const atl::BodyId box = world.add_body({.shape = atl::Box{.half_extents = {0.5, 0.5, 0.1}},
                                          .position = {0, 0, 0.1},
                                          .velocity = {speed, 0, 0},
                                          .material = material});
  for (int i = 0; i < 240; ++i) world.step(1.0 / 60);
  return world.pose(box).position.x();
}

}  // namespace

int main() {
  std::vector<double> distances(worlds);
  std::atomic<std::size_t> next = 0;
  std::vector<std::jthread> threads;
  for (unsigned i = 0; i < std::max(1u, std::thread::hardware_concurrency()); ++i) {
    threads.emplace_back([&] {
      for (std::size_t number = next++; number < worlds; number = next++)
        distances[number] = slide(friction_of(number));
    });
  }
  threads.clear();  // waits

  double worst = 0;
  for (std::size_t number = 0; number < worlds; ++number) {
    const double exact = speed * speed / (2 * friction_of(number) * gravity);
    worst = std::max(worst, std::abs(distances[number] - exact) / exact);
  }
  std::cout << worlds << " worlds: with friction " << friction_of(0) << " the box slides " << distances[0]
            << " m; of all, v^2 / (2 mu g) is missed by " << 100 * worst << "% at most\n";
  return worst < 0.01 ? 0 : 1;
}
