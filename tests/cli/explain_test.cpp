// Output of atoll explain for scenes, in words and as JSON.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "cli/command.h"

namespace atl::test {
namespace {

// The part of a text from a line on, up to an empty one.
std::string section(const std::string& text, const std::string& title) {
  const std::size_t begin = text.find("\n" + title + "\n");
  if (begin == std::string::npos) return "";
  return text.substr(begin + 1, text.find("\n\n", begin + 1) - begin - 1);
}

std::string explain(const std::string& scene, const std::string& steps) {
  const CommandResult result = run_atoll({"explain", scene, "--steps", steps});
  EXPECT_EQ(result.status, 0) << result.err;
  return result.out;
}

void expect_has(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "no \"" << part << "\" in:\n" << text;
}

TEST(CommandExplain, PyramidNeedsFrictionAndNoBounces) {
  const std::string text = explain("pyramid3d:layers=4", "20");
  expect_has(text, "pyramid3d:layers=4: 30 dynamic, 1 static, 0 kinematic bodies, 20 steps\n");
  const std::string needed = section(text, "needed in every step");
  expect_has(needed, "  friction                touching materials have friction (");
  expect_has(needed, "  several points          bodies touch with edges or faces (");
  const std::string left = section(text, "left out");
  expect_has(left, "  restitution             no contact bounces\n");
  expect_has(left, "  gyroscopic torque       no body in an island has unequal moments of inertia\n");
  expect_has(left, "  joint solver            there are no joints\n");
  expect_has(text, "\nmemory");
}

TEST(CommandExplain, FallingBallNeedsContactsInSomeSteps) {
  const std::string text = explain("bouncing-ball:height=1", "60");
  const std::string some = section(text, "needed in some steps");
  expect_has(some, "  restitution             in ");
  expect_has(some, "touching materials bounce (contacts a step: 1, 1 at most); else no contact bounces\n");
  expect_has(some, "  free flight             in ");
  expect_has(section(text, "left out"), "  several points          whatever touches does so in one point\n");
}

TEST(CommandExplain, WallInAPlaneNeedsMotionLocks) {
  const std::string text = explain("wall:base=10,planar=1", "20");
  const std::string needed = section(text, "needed in every step");
  expect_has(needed, "  motion locks            bodies in islands are locked along or about axes (bodies a step: 55, ");
}

TEST(CommandExplain, ChainIsSolvedAtOnceAndTouchesNothing) {
  const std::string text = explain("chain:links=12", "20");
  expect_has(
      section(text, "needed in every step"),
      "  direct joints           some joints that hang together are solved at once (joints a step: 13, 13 at most)\n");
  const std::string left = section(text, "left out");
  expect_has(left, "  contact solver          nothing touches\n");
  expect_has(left, "  joint solver            all joints are solved at once\n");
}

TEST(CommandExplain, JsonSaysTheSame) {
  const CommandResult result = run_atoll({"explain", "stack:height=3", "--steps", "10", "--format", "json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const auto json = nlohmann::ordered_json::parse(result.out);
  EXPECT_EQ(json["steps"], 10);
  bool found = false;
  for (const auto& feature : json["features"]) {
    if (feature["name"] != "contact_solver") continue;
    found = true;
    EXPECT_EQ(feature["steps"], 10);
    EXPECT_EQ(feature["items_mean"], 3);
    EXPECT_EQ(feature["unit"], "contacts");
  }
  EXPECT_TRUE(found);
  EXPECT_GT(json["memory"][0]["bytes"], 0);
}

TEST(CommandExplain, SceneThatIsNotThereIsRefused) {
  EXPECT_EQ(run_atoll({"explain", "no-such-scene"}).status, 3);
  EXPECT_EQ(run_atoll({"explain"}).status, 2);
}

}  // namespace
}  // namespace atl::test
