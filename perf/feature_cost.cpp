/// Measures the cost of a capability that a build has, for scenes that use it and scenes that don't: perf/features.sh
/// runs this in builds with and without the capability, by the clock and by counted instructions.
///
/// Links the core alone. Every scene has the same boxes, in stacks of three on the ground; "plain" uses nothing else,
/// and each other scene uses the capability that it is named after.

#include <atoll/body.h>
#include <atoll/error.h>
#include <atoll/recording.h>
#include <atoll/snapshot.h>
#include <atoll/world.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <string>
#include <string_view>
#include <vector>

#include "allocation_count.h"

namespace {

constexpr int columns = 12;
constexpr int high = 3;
constexpr int warm_up_steps = 30;
constexpr double dt = 1.0 / 60;

atl::Shape ground_of(std::string_view scene) {
  if (scene != "meshes") return atl::HalfSpace{};
  const std::vector<atl::Vector3> corners = {{-50, -50, 0}, {50, -50, 0}, {50, 50, 0}, {-50, 50, 0}};
  const std::vector<atl::TriangleMesh::Indices> triangles = {{0, 1, 2}, {0, 2, 3}};
  return atl::TriangleMesh(corners, triangles);
}

// A box of 1 m.
atl::BodyDef body_of(std::string_view scene) {
  atl::BodyDef def;
  if (scene == "hulls") {
    std::vector<atl::Vector3> corners;
    for (int i = 0; i < 8; ++i) corners.emplace_back((i & 1) - 0.5, (i >> 1 & 1) - 0.5, (i >> 2 & 1) - 0.5);
    def.shape = atl::ConvexHull(corners);
  }
  if (scene == "surfaces") def.material.rolling_friction = 0.01;
  if (scene == "restitution") def.material.restitution = 0.5;
  if (scene == "continuous") def.continuous = true;
  return def;
}

atl::Settings settings_of(std::string_view scene) {
  return {.restitution_threshold = scene == "restitution" ? 0.01 : 1.0, .simd = atl::Simd::Avx2};
}

// Stacks stand a little askew and off the ground, so that all of them land and tilt.
void build(std::string_view scene, atl::World& world) {
  world.add_body({.type = atl::BodyType::Static, .shape = ground_of(scene)});
  const atl::BodyDef prototype = body_of(scene);
  const int height = scene == "direct_contacts" ? 4 * high : high;
  for (int stack = 0; stack < columns * columns * high / height; ++stack) {
    atl::BodyId below = {};
    for (int level = 0; level < height; ++level) {
      atl::BodyDef def = prototype;
      const double askew = 0.02 * ((stack + level) % 5 - 2);
      def.position = {2.5 * (stack % columns) + askew, 2.5 * (stack / columns), 0.51 + 1.01 * level};
      const atl::BodyId body = world.add_body(def);
      if (scene == "joints" && level > 0) {
        world.add_joint(
            {.first = below, .second = body, .frame_first = {{0, 0, 0.505}}, .frame_second = {{0, 0, -0.505}}});
      }
      below = body;
    }
  }
}

void run(std::string_view scene, int steps) {
  atl::World world({.settings = settings_of(scene)});
  build(scene, world);
  const std::filesystem::path recording = std::filesystem::temp_directory_path() / "atoll_feature_cost.recording";
  if (scene == "recording") world.record(recording);
  atl::Snapshot snapshot;
  std::vector<double> ms;
  std::int64_t before = 0;
  ms.reserve(static_cast<std::size_t>(steps));
  for (int i = 0; i < warm_up_steps + steps; ++i) {
    if (i == warm_up_steps) before = allocation_count();
    if (scene == "snapshots") world.save(snapshot);
    const double step_ms = world.step(dt).ms;
    if (i >= warm_up_steps) ms.push_back(step_ms);
  }
  const std::int64_t allocated = allocation_count() - before;
  if (scene == "recording") {
    world.stop_recording();
    std::filesystem::remove(recording);
  }
  std::nth_element(ms.begin(), ms.begin() + steps / 2, ms.end());
  std::cout << "0x" << std::hex << std::setw(16) << std::setfill('0') << world.state_hash() << std::dec << ' '
            << ms[static_cast<std::size_t>(steps) / 2] << ' ' << allocated << '\n';
}

}  // namespace

// Prints the state's hash, the median step's ms and the allocations of all steps after the first few.
int main(int argc, char** argv) {
  const int steps = argc == 3 ? std::atoi(argv[2]) : 0;
  if (steps < 1) {
    std::cerr << "usage: atoll_feature_cost SCENE STEPS\n";
    return 2;
  }
  try {
    run(argv[1], steps);
  } catch (const atl::Error& error) {
    std::cerr << "atoll_feature_cost: " << error.what() << '\n';
    return 1;
  }
}
