#include "golden/golden.h"

#include <algorithm>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace atl::test {
namespace {

Scene with(Scene scene, const std::string& settings) {
  if (settings == "varied") {
    scene.settings.substeps = 3;
    scene.settings.iterations = 3;
    scene.settings.tolerance = 1e-3;
    scene.settings.friction = FrictionModel::Pyramid;
    scene.settings.stabilisation = Stabilisation::SplitImpulse;
    scene.settings.joint_solver = JointSolver::Iterative;
    scene.settings.sleeping = true;
  } else if (settings == "sleeping") {
    scene.settings.sleeping = true;
    scene.settings.time_to_sleep = 0.2;
  } else if (settings != "defaults") {
    throw std::runtime_error("no settings named " + settings);
  }
  return scene;
}

}  // namespace

const std::vector<GoldenCase>& golden_cases() {
  static const std::vector<GoldenCase> cases = {
      {"pyramid3d:layers=4", "defaults"},
      {"wall:base=12", "defaults"},
      {"wall:base=12,planar=1", "defaults"},
      {"islands:count=6,base=4", "defaults"},
      {"pile:bodies=60", "defaults"},
      {"marbles:bodies=60", "defaults"},
      {"hopper:bodies=40", "defaults"},
      {"rocks:bodies=60", "defaults"},
      {"mixed:bodies=60", "defaults"},
      {"drum:boxes=60", "defaults"},
      {"terrain:bodies=3,triangles=2000", "defaults"},
      {"stack:height=12", "defaults"},
      {"conveyor:boxes=4,speed=3", "defaults"},
      {"chain:links=12", "defaults"},
      {"joint-grid:n=6", "defaults"},
      {"ragdolls:count=2", "defaults"},
      {"bridge:planks=8", "defaults"},
      {"vehicle", "defaults"},
      {"free-flight", "defaults"},
      {"spinning-top", "defaults"},
      {"heavy-top", "defaults"},
      {"sliding-blocks:headings=12", "defaults"},
      {"incline", "defaults"},
      {"tipping-block", "defaults"},
      {"rolling-sphere:headings=4", "defaults"},
      {"rolling-resistance:headings=4", "defaults"},
      {"torsion", "defaults"},
      {"incline-sphere", "defaults"},
      {"pushed-box", "defaults"},
      {"bouncing-ball", "defaults"},
      {"elastic-ball", "defaults"},
      {"elastic-pair", "defaults"},
      {"stack-forces:height=6", "defaults"},
      {"rocking-block", "defaults"},
      {"cradle", "defaults"},
      {"pendulum", "defaults"},
      {"double-pendulum", "defaults"},
      {"slider-crank", "defaults"},
      {"spring-damper", "defaults"},
      {"hanging-chain:links=8", "defaults"},
      {"catenary:links=12", "defaults"},
      {"stack:height=10,ratio=1000", "defaults"},  // solved at once
      {"wall:base=20", "varied"},
      {"pile:bodies=60", "varied"},
      {"ragdolls:count=2", "varied"},
      {"vehicle", "varied"},
      {"islands:count=6,base=4", "sleeping"},
      {"bridge:planks=8", "sleeping"},
      {ATOLL_SOURCE_DIR "/runtime/scene/examples/shapes.json", "defaults"},  // every kind of shape
      {ATOLL_SOURCE_DIR "/runtime/scene/examples/mixer.json", "defaults"},
  };
  return cases;
}

Scene golden_scene(const GoldenCase& golden) { return with(load_scene(golden.scene), golden.settings); }

std::string golden_key(const GoldenCase& golden, std::int64_t step) {
  const std::string source = ATOLL_SOURCE_DIR "/";
  const std::string scene = golden.scene.starts_with(source) ? golden.scene.substr(source.size()) : golden.scene;
  return std::to_string(step) + " " + golden.settings + " " + scene;
}

std::string golden_path() { return ATOLL_SOURCE_DIR "/tests/determinism/golden_hashes.txt"; }

GoldenHashes read_golden_hashes(const std::string& path) {
  GoldenHashes hashes;
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  int number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    if (line.empty() || line.front() == '#') continue;
    const std::size_t space = line.find(' ');
    std::istringstream text(line.substr(0, space));
    std::uint64_t hash = 0;
    if (space == std::string::npos || !(text >> std::hex >> hash)) {
      throw std::runtime_error(path + ":" + std::to_string(number) + ": found \"" + line +
                               "\", expected hash, step, settings and scene");
    }
    hashes[line.substr(space + 1)] = hash;
  }
  return hashes;
}

}  // namespace atl::test
