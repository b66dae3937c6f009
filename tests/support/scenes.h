#pragma once
/// All built-in scenes, the large ones made small, and one whose bodies are locked to a plane.

#include <atoll/scene.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <string_view>
#include <vector>

namespace atl::test {

inline std::vector<std::string> small_scenes() {
  constexpr std::array<std::string_view, 18> small = {"pyramid3d:layers=5",
                                                      "wall:base=10",
                                                      "islands:count=6,base=4",
                                                      "pile:bodies=60",
                                                      "marbles:bodies=60",
                                                      "rocks:bodies=60",
                                                      "mixed:bodies=60",
                                                      "drum:boxes=60",
                                                      "terrain:bodies=10,triangles=2000",
                                                      "hopper:bodies=40",
                                                      "chain:links=12",
                                                      "joint-grid:n=6",
                                                      "ragdolls:count=4",
                                                      "bridge:planks=10",
                                                      "conveyor:boxes=12",
                                                      "sliding-blocks:headings=9",
                                                      "catenary:links=12",
                                                      "hanging-chain:links=8"};
  std::vector<std::string> scenes;
  for (const BuiltinScene& scene : builtin_scenes()) {
    const auto address = std::find_if(small.begin(), small.end(), [&](std::string_view text) {
      return text.substr(0, text.find(':')) == scene.name;
    });
    scenes.emplace_back(address != small.end() ? *address : std::string_view(scene.name));
  }
  scenes.emplace_back("wall:base=10,planar=1");
  return scenes;
}

/// Turns a text into a valid gtest case name.
inline std::string case_name(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
  return text;
}

}  // namespace atl::test
