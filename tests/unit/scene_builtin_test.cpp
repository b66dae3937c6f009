// What all built-in scenes keep to at the start, and how their parameters are read.

#include <atoll/scene.h>
#include <gtest/gtest.h>

#include <bit>
#include <set>
#include <sstream>
#include <string>

#include "support/expect_error.h"

namespace atl {
namespace {

// FNV-1a over the bits of all poses and sizes.
std::uint64_t bits_of(const Scene& scene) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  const auto mix = [&](double x) { hash = (hash ^ std::bit_cast<std::uint64_t>(x)) * 0x100000001b3u; };
  for (const SceneBody& body : scene.bodies) {
    for (const double x : body.def.position) mix(x);
    for (const double x : body.def.orientation.coeffs()) mix(x);
    if (const auto* box = std::get_if<Box>(&body.def.shape)) {
      for (const double x : box->half_extents) mix(x);
    }
  }
  return hash;
}

TEST(SceneBuiltin, NamesAreUnique) {
  for (const BuiltinScene& builtin : builtin_scenes()) {
    std::set<std::string> names;
    for (const SceneBody& body : load_scene(builtin.name).bodies) {
      EXPECT_TRUE(names.insert(body.name).second) << builtin.name << ": " << body.name;
    }
  }
}

TEST(SceneBuiltin, NoneOverlapsAtTheStart) {
  for (const BuiltinScene& builtin : builtin_scenes()) {
    const Scene scene = load_scene(builtin.name);
    EXPECT_EQ(measure_penetration(placed_shapes(scene), may_touch(scene)).pairs, 0u) << builtin.name;
  }
}

TEST(SceneBuiltin, JointsHoldAtTheStart) {
  for (const BuiltinScene& builtin : builtin_scenes()) {
    const Scene scene = load_scene(builtin.name);
    std::vector<BodyState> states;
    for (const SceneBody& body : scene.bodies) {
      states.push_back({{body.def.position, body.def.orientation.normalized()}, body.def.velocity, {}});
    }
    const JointDriftReport drift = measure_joint_drift(placed_joints(scene), states);
    EXPECT_LT(drift.max, 1e-9) << builtin.name;
    EXPECT_LT(drift.angle_max, 1e-9) << builtin.name;
    EXPECT_LT(drift.excess_max, 1e-9) << builtin.name;
    EXPECT_LT(drift.angle_excess_max, 1e-9) << builtin.name;
  }
}

// Each can be made as small as its parameters go.
TEST(SceneBuiltin, AreBuiltFromTheLeastOfEachParameter) {
  for (const BuiltinScene& scene : builtin_scenes()) {
    std::string min;
    for (const SceneParameter& parameter : scene.parameters) {
      if (!parameter.integer) continue;
      std::ostringstream value;
      value << parameter.min;
      min += (min.empty() ? ":" : ",") + parameter.name + "=" + value.str();
    }
    EXPECT_FALSE(load_scene(scene.name + min).bodies.empty()) << scene.name << min;
  }
}

TEST(SceneBuiltin, RandomContentDependsOnTheSeedAlone) {
  EXPECT_EQ(bits_of(load_scene("pile:bodies=100", 7)), bits_of(load_scene("pile:bodies=100", 7)));
  EXPECT_NE(bits_of(load_scene("pile:bodies=100", 7)), bits_of(load_scene("pile:bodies=100", 8)));
  EXPECT_EQ(bits_of(load_scene("wall:base=10", 7)), bits_of(load_scene("wall:base=10", 8)));
  // The same on every compiler and machine.
  EXPECT_EQ(bits_of(load_scene("pile:bodies=100")), 11881013477538282964u);
}

TEST(SceneBuiltin, NameGivesTheSceneAgain) {
  EXPECT_EQ(load_scene("islands:base=3").name, "islands:count=400,base=3");
  EXPECT_EQ(load_scene("stack:ratio=0.25").name, "stack:height=10,ratio=0.25");
  EXPECT_EQ(load_scene("pile:bodies=1e2").name, "pile:bodies=100");
}

TEST(SceneBuiltin, RefusesWhatItDoesNotKnow) {
  const struct {
    const char* scene;
    std::initializer_list<std::string_view> words;
  } cases[] = {
      {"stak",
       {"unknown scene \"stak\"",
        "pyramid3d, wall, islands, pile, marbles, rocks, mixed, drum, terrain, hopper, stack, conveyor, chain",
        "or catenary", "did you mean \"stack\"?"}},
      {"pyramid", {"did you mean \"pyramid3d\"?"}},
      {"", {"unknown scene \"\""}},
      {"wall:bse=3", {"wall", "unknown parameter \"bse\"", "expected base", "did you mean \"base\"?"}},
      {"wall:", {"wall", "expected parameter=value"}},
      {"wall:base", {"\"base\"", "expected parameter=value"}},
      {"wall:base=", {"base: found \"\"", "an integer in [1, 4000]"}},
      {"wall:base=ten", {"base: found \"ten\"", "an integer in [1, 4000]"}},
      {"wall:base=3x", {"base: found \"3x\"", "an integer in [1, 4000]"}},
      {"wall:base=2.5", {"base: found \"2.5\"", "an integer in [1, 4000]"}},
      {"wall:base=0", {"base: found \"0\"", "an integer in [1, 4000]"}},
      {"wall:base=1e99", {"base: found \"1e99\"", "an integer in [1, 4000]"}},
      {"wall:base=3,base=4", {"\"base\" is given twice"}},
      {"wall:base=3,", {"found \"\"", "expected parameter=value"}},
      {"stack:ratio=nan", {"ratio: found \"nan\"", "a number in [1e-06, 1000000]"}},
      {"stack:ratio=-1", {"ratio: found \"-1\""}},
      {"islands:count=1000000,base=100", {"islands:count=1000000,base=100", "25.2 TB of memory"}},
  };
  for (const auto& refused : cases) {
    SCOPED_TRACE(refused.scene);
    EXPECT_THROW(load_scene(refused.scene), SceneError);
    test::expect_error([&] { load_scene(refused.scene); }, refused.words);
  }
}

}  // namespace
}  // namespace atl
