/// The same scene in a build with everything and in one without all that can be left out: the same bits.
///
/// `write FILE` writes the hashes of its states to a file, `check FILE` compares them with one.

#include <atoll/world.h>

#include <cstdint>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "left_out.h"

namespace {

// Boxes in stacks, askew, that balls roll into; some are pushed.
std::vector<std::uint64_t> hashes() {
  atl::World world({.threads = 2});
  std::vector<std::uint64_t> result;
  world.add_body({.type = atl::BodyType::Static, .shape = atl::HalfSpace{}});
  for (int stack = 0; stack < 20; ++stack) {
    const double x = 2.5 * (stack % 5);
    const double y = 2.5 * (stack / 5);
    for (int level = 0; level < 3; ++level) {
      world.add_body({.position = {x + 0.02 * ((stack + level) % 5 - 2), y, 0.51 + 1.01 * level}});
    }
    world.add_body({.shape = atl::Sphere{.radius = 0.3}, .position = {x + 1, y, 0.3}, .velocity = {-2, 0.1, 0}});
  }
  const atl::BodyId lift = world.add_body({.type = atl::BodyType::Kinematic, .position = {-1.2, 0, 0.5}});
  world.set_velocity(lift, {0.2, 0, 0}, {0, 0, 0});
  for (int step = 0; step < 120; ++step) {
    world.step(1.0 / 60);
    if (step % 20 == 19) result.push_back(world.state_hash());
  }
  return result;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const std::vector<std::uint64_t> found = hashes();
  if (std::string(argv[1]) == "write") {
    std::ofstream out(argv[2]);
    for (const std::uint64_t hash : found) out << hash << '\n';
    return out.good() ? 0 : 1;
  }
  std::ifstream in(argv[2]);
  bool same = in.good();
  for (const std::uint64_t hash : found) {
    std::uint64_t expected = 0;
    in >> expected;
    if (hash != expected) std::cerr << "a state hashes to " << hash << "; expected " << expected << '\n';
    same &= hash == expected;
  }
  return same && everything_throws() ? 0 : 1;
}
