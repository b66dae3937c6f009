// Bodies on lattices, from scene files.

#include <atoll/scene.h>
#include <gtest/gtest.h>

#include <set>

namespace atl {
namespace {

std::string row_generator(const std::string& members) {
  return R"({"body": {"name": "b", "shape": {"type": "sphere", "radius": 0.1}, "position": [10, 20, 30]}, )" + members +
         "}";
}

std::vector<SceneBody> generate(const std::string& members, std::uint64_t seed = 1, const std::string& before = "") {
  return parse_scene(
             R"({"format": "atoll-scene", "version": 1, "generators": [)" + before + row_generator(members) + "]}",
             "test.json", seed)
      .bodies;
}

std::vector<Vector3> positions(const std::vector<SceneBody>& bodies) {
  std::vector<Vector3> result;
  for (const SceneBody& body : bodies) result.push_back(body.def.position);
  return result;
}

using Points = std::vector<Vector3>;

TEST(SceneGenerator, GridIsCentredOnTheBody) {
  const auto bodies = generate(R"("count": [3, 2, 1], "spacing": [2, 4, 1])");
  EXPECT_EQ(positions(bodies),
            (Points{{8, 18, 30}, {10, 18, 30}, {12, 18, 30}, {8, 22, 30}, {10, 22, 30}, {12, 22, 30}}));
  EXPECT_EQ(bodies.front().name, "b_0");
  EXPECT_EQ(bodies.back().name, "b_5");
}

TEST(SceneGenerator, StackGrowsUpwards) {
  EXPECT_EQ(positions(generate(R"("count": [1, 1, 3], "spacing": [1, 1, 0.5])")),
            (Points{{10, 20, 30}, {10, 20, 30.5}, {10, 20, 31}}));
}

TEST(SceneGenerator, TaperMakesWallsAndPyramids) {
  EXPECT_EQ(positions(generate(R"("count": [3, 1, 3], "taper": [1, 0])")),
            (Points{{9, 20, 30}, {10, 20, 30}, {11, 20, 30}, {9.5, 20, 31}, {10.5, 20, 31}, {10, 20, 32}}));
  EXPECT_EQ(generate(R"("count": [4, 4, 4], "taper": [1, 1])").size(), 16u + 9 + 4 + 1);
}

TEST(SceneGenerator, StaggerShiftsEverySecondLayer) {
  EXPECT_EQ(positions(generate(R"("count": [1, 1, 3], "spacing": [2, 2, 1], "stagger": [0.5, -0.25])")),
            (Points{{10, 20, 30}, {11, 19.5, 31}, {10, 20, 32}}));
}

TEST(SceneGenerator, CopiesRepeatTheWhole) {
  const auto bodies = generate(R"("count": [1, 1, 2], "copies": {"count": [2, 1, 1], "spacing": [6, 0, 0]})");
  EXPECT_EQ(positions(bodies), (Points{{7, 20, 30}, {7, 20, 31}, {13, 20, 30}, {13, 20, 31}}));
  EXPECT_EQ(bodies.back().name, "b_3");
}

TEST(SceneGenerator, RandomContentStaysInItsRange) {
  const auto bodies = generate(R"("count": [20, 20, 1], "jitter": [0.3, 0, 0.1], "random_orientation": true)");
  const auto exact = generate(R"("count": [20, 20, 1])");
  Vector3 largest = Vector3::Zero();
  std::set<double> orientations;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    largest = largest.cwiseMax((bodies[i].def.position - exact[i].def.position).cwiseAbs());
    orientations.insert(bodies[i].def.orientation.w());
    EXPECT_NEAR(bodies[i].def.orientation.norm(), 1, 1e-12);
  }
  EXPECT_LE(largest.x(), 0.3 + 1e-12);
  EXPECT_GT(largest.x(), 0.29);
  EXPECT_EQ(largest.y(), 0);
  EXPECT_GT(largest.z(), 0.09);
  EXPECT_EQ(orientations.size(), bodies.size());
}

TEST(SceneGenerator, RandomContentFollowsSeedAndPlace) {
  const std::string members = R"("count": [5, 5, 1], "jitter": [0.3, 0.3, 0.3])";
  EXPECT_EQ(positions(generate(members, 3)), positions(generate(members, 3)));
  EXPECT_NE(positions(generate(members, 3)), positions(generate(members, 4)));

  // How much the first generator draws does not change the second.
  const std::string one = R"({"body": {"shape": {"type": "sphere", "radius": 1}}, "count": [1, 1, 1]},)";
  const std::string two = R"({"body": {"shape": {"type": "sphere", "radius": 1}}, "count": [2, 1, 1]},)";
  Points after_one = positions(generate(members, 3, one)), after_two = positions(generate(members, 3, two));
  after_one.erase(after_one.begin());
  after_two.erase(after_two.begin(), after_two.begin() + 2);
  EXPECT_EQ(after_one, after_two);
  EXPECT_NE(after_one, positions(generate(members, 3)));
}

}  // namespace
}  // namespace atl
