// The built-in scenes' counts and geometry, and how their parameters are read.

#include <atoll/scene.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <map>
#include <set>
#include <sstream>
#include <string>

#include "support/expect_error.h"

namespace atl {
namespace {

std::vector<SceneBody> dynamic_bodies(const Scene& scene) {
  std::vector<SceneBody> bodies;
  for (const SceneBody& body : scene.bodies) {
    if (body.def.type == BodyType::Dynamic) bodies.push_back(body);
  }
  return bodies;
}

// Positions of unit boxes by layer, which are exactly 1 m apart.
std::map<int, std::vector<Vector3>> layers_of(const Scene& scene) {
  std::map<int, std::vector<Vector3>> layers;
  for (const SceneBody& body : dynamic_bodies(scene)) {
    const double layer = body.def.position.z() - 0.5;
    EXPECT_EQ(layer, std::trunc(layer));
    layers[static_cast<int>(layer)].push_back(body.def.position);
  }
  return layers;
}

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

TEST(SceneBuiltin, AllHaveWhatTheyShare) {
  for (const BuiltinScene& builtin : builtin_scenes()) {
    SCOPED_TRACE(builtin.name);
    const Scene scene = load_scene(builtin.name);
    EXPECT_EQ(scene.dt, 1.0 / 60);
    if (scene.closed_form) continue;      // those are as simple as their formula wants them
    if (!scene.joints.empty()) continue;  // and those in scene_joint_builtin_test.cpp
    EXPECT_EQ(scene.gravity, Vector3(0, 0, -9.81));
    const std::set<std::string> dropped = {"pile",  "marbles", "hopper", "conveyor",
                                           "rocks", "mixed",   "drum",   "terrain"};
    EXPECT_EQ(scene.starts_at_rest, !dropped.contains(builtin.name));
    EXPECT_EQ(scene.bodies.front().name, "ground");
    EXPECT_EQ(scene.bodies.front().def.type, BodyType::Static);
    std::set<std::string> names;
    for (const SceneBody& body : scene.bodies) {
      names.insert(body.name);
      EXPECT_EQ(body.def.material.friction, builtin.name == "hopper" ? 0 : 0.6);
      EXPECT_EQ(body.def.material.restitution, 0);
      if (body.def.type == BodyType::Dynamic) {
        EXPECT_EQ(body.def.density, 1000);
      }
    }
    const std::map<std::string, std::string> others = {
        {"marbles", "marble_0"}, {"rocks", "rock_0"}, {"mixed", "solid_0"}, {"terrain", "burr_0"}};
    EXPECT_TRUE(names.contains(others.contains(builtin.name) ? others.at(builtin.name) : "box_0"));
  }
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

TEST(SceneBuiltin, CountsAndSteps) {
  const struct {
    const char* scene;
    std::size_t bodies;
    int steps;
  } cases[] = {{"pyramid3d", 2109, 300}, {"pyramid3d:layers=1", 1, 300},
               {"wall", 5050, 200},      {"wall:base=3", 6, 200},
               {"islands", 22000, 100},  {"islands:count=7,base=2", 21, 100},
               {"pile", 5000, 600},      {"pile:bodies=17", 17, 600},
               {"stack", 10, 600},       {"stack:height=3,ratio=100", 3, 600},
               {"conveyor", 12, 600},    {"conveyor:boxes=3", 3, 600},
               {"marbles", 5000, 600},   {"marbles:bodies=40", 40, 600},
               {"hopper", 2000, 600},    {"hopper:bodies=30,friction=0.2", 30, 600},
               {"rocks", 5000, 600},     {"rocks:bodies=40", 40, 600},
               {"mixed", 3000, 600},     {"mixed:bodies=40", 40, 600},
               {"drum", 3000, 600},      {"drum:boxes=40", 40, 600},
               {"terrain", 100, 600},    {"terrain:bodies=3,triangles=800", 3, 600}};
  for (const auto& expected : cases) {
    const Scene scene = load_scene(expected.scene);
    EXPECT_EQ(dynamic_bodies(scene).size(), expected.bodies) << expected.scene;
    EXPECT_EQ(scene.steps, expected.steps) << expected.scene;
  }
}

// Each can be made as small as its parameters go.
TEST(SceneBuiltin, AreBuiltFromTheLeastOfEachParameter) {
  for (const BuiltinScene& scene : builtin_scenes()) {
    std::string least;
    for (const SceneParameter& parameter : scene.parameters) {
      if (!parameter.integer) continue;
      std::ostringstream value;
      value << parameter.min;
      least += (least.empty() ? ":" : ",") + parameter.name + "=" + value.str();
    }
    EXPECT_FALSE(load_scene(scene.name + least).bodies.empty()) << scene.name << least;
  }
}

TEST(SceneBuiltin, PyramidLayersAreCentredSquares) {
  const auto layers = layers_of(load_scene("pyramid3d:layers=6"));
  ASSERT_EQ(layers.size(), 6u);
  for (const auto& [layer, boxes] : layers) {
    const int side = 6 - layer;
    ASSERT_EQ(boxes.size(), static_cast<std::size_t>(side * side));
    Vector3 sum = Vector3::Zero();
    for (const Vector3& box : boxes) sum += box;
    EXPECT_NEAR(sum.x(), 0, 1e-12);
    EXPECT_NEAR(sum.y(), 0, 1e-12);
    if (side > 1) {
      EXPECT_NEAR(boxes[1].x() - boxes[0].x(), 1.02, 1e-12);
    }
  }
}

TEST(SceneBuiltin, WallRowsTouchInRunningBond) {
  const auto rows = layers_of(load_scene("wall:base=8"));
  ASSERT_EQ(rows.size(), 8u);
  for (const auto& [row, boxes] : rows) {
    ASSERT_EQ(boxes.size(), static_cast<std::size_t>(8 - row));
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      EXPECT_EQ(boxes[i].x(), rows.at(0)[0].x() + 0.5 * row + static_cast<double>(i));
      EXPECT_EQ(boxes[i].y(), 0);
    }
  }
}

TEST(SceneBuiltin, IslandsStayApart) {
  constexpr int count = 11, base = 4, boxes = 10;
  const std::vector<SceneBody> bodies = dynamic_bodies(load_scene("islands:count=11,base=4"));
  ASSERT_EQ(bodies.size(), static_cast<std::size_t>(count * boxes));
  std::vector<Eigen::AlignedBox3d> bounds(count);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Vector3& centre = bodies[i].def.position;
    bounds[i / boxes].extend(Eigen::AlignedBox3d(centre.array() - 0.5, centre.array() + 0.5));
  }
  for (int i = 0; i < count; ++i) {
    EXPECT_EQ(bounds[i].sizes(), Vector3(base, 1, base));
    for (int j = 0; j < i; ++j) EXPECT_GE(bounds[i].exteriorDistance(bounds[j]), 1.0) << i << " and " << j;
  }
}

TEST(SceneBuiltin, StackIsHeavyAtTheTop) {
  const std::vector<SceneBody> bodies = dynamic_bodies(load_scene("stack:height=4,ratio=2.5"));
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(bodies[i].def.position, Vector3(0, 0, 0.5 + i));
    EXPECT_EQ(bodies[i].def.density, i == 3 ? 2500 : 1000);
  }
}

TEST(SceneBuiltin, PileFillsItsContainer) {
  const Scene scene = load_scene("pile:bodies=2000");
  Vector3 smallest = Vector3::Constant(1), largest = Vector3::Zero();
  for (const SceneBody& body : dynamic_bodies(scene)) {
    const Vector3 half = std::get<Box>(body.def.shape).half_extents;
    EXPECT_NEAR(body.def.orientation.norm(), 1, 1e-12);
    EXPECT_TRUE((half.array() >= 0.25).all() && (half.array() <= 0.75).all());
    smallest = smallest.cwiseMin(half);
    largest = largest.cwiseMax(half);
    const Vector3 bounds = body.def.orientation.toRotationMatrix().cwiseAbs() * half;
    EXPECT_GT(body.def.position.z(), bounds.z());
    EXPECT_LT(std::abs(body.def.position.x()) + bounds.x(), 10);
    EXPECT_LT(std::abs(body.def.position.y()) + bounds.y(), 10);
  }
  EXPECT_TRUE((smallest.array() < 0.26).all());
  EXPECT_TRUE((largest.array() > 0.74).all());
  EXPECT_EQ(std::count_if(scene.bodies.begin(), scene.bodies.end(),
                          [](const SceneBody& body) { return std::holds_alternative<HalfSpace>(body.def.shape); }),
            5);
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
