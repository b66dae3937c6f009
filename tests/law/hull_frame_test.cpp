// The frame that a hull's vertices are given in is no part of the problem: files give hulls in the frame of their body, or
// of a whole machine.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <vector>

namespace atl::test::hull_frame_test {
namespace {

constexpr double dt = 1.0 / 60;

std::vector<Vector3> wedge(const Vector3& at) {
  std::vector<Vector3> points;
  for (const double y : {-0.3, 0.3}) {
    for (const Vector3& corner : {Vector3(-0.4, y, -0.2), Vector3(0.5, y, -0.2), Vector3(-0.4, y, 0.3)}) {
      points.emplace_back(corner + at);
    }
  }
  return points;
}

// A wedge whose vertices are far from its own frame by `offset`, which its place on the body makes up for.
CompoundChild child(const Vector3& offset, const Vector3& place) {
  return {.shape = ConvexHull(wedge(offset)), .position = place - offset};
}

struct Outcome {
  std::vector<Vector3> positions;
  std::int64_t pairs = 0;
};

Outcome outcome_of(const Vector3& offset) {
  World world({.threads = 1});
  const std::vector<Vector3> corners = {{-20, -20, 0}, {20, -20, 0}, {20, 20, 0}, {-20, 20, 0}};
  const std::vector<TriangleMesh::Indices> triangles = {{0, 1, 2}, {0, 2, 3}};
  world.add_body({.type = BodyType::Static, .shape = TriangleMesh(corners, triangles)});
  for (int i = 0; i < 6; ++i) {
    world.add_body({.shape = Compound{{child(offset, {0, 0, 0}), child(-2 * offset, {1, 0, 0.1})}},
                    .position = {3.0 * i, 0, 0.5},
                    .orientation = Quaternion(Eigen::AngleAxisd(0.3 * i, Vector3(1, 2, 3).normalized()))});
  }
  Outcome result;
  // Until they have landed: what rolls on after that is as sensitive to rounding as dice are.
  for (int i = 0; i < 15; ++i) result.pairs += world.step(dt).counts.pairs;
  for (const BodyId body : world.bodies()) result.positions.push_back(world.pose(body).position);
  return result;
}

TEST(HullFrame, ChangesNeitherMotionNorPairs) {
  const Outcome here = outcome_of(Vector3::Zero());
  ASSERT_GT(here.pairs, 0);
  for (const double far : {1.0, 30.0}) {
    const Outcome there = outcome_of({far, -far, 0.5 * far});
    EXPECT_EQ(there.pairs, here.pairs) << far << " m away";
    for (std::size_t i = 0; i < here.positions.size(); ++i) {
      EXPECT_LT((there.positions[i] - here.positions[i]).norm(), 1e-6) << "body " << i << ", " << far << " m away";
    }
  }
}

TEST(HullFrame, ChangesNoAnswerOfAQuery) {
  const auto answers = [](const Vector3& offset) {
    World world({.threads = 1});
    world.add_body({.type = BodyType::Static, .shape = Compound{{child(offset, {2, 0, 0})}}});
    const ConvexHull probe(wedge(offset));
    const auto hit = Queries(world).cast_shape({.shape = probe, .position = -offset, .translation = {5, 0.1, 0}});
    const auto ray = Queries(world).cast_ray({.origin = {2, 0, 3}, .direction = {0, 0, -1}});
    EXPECT_TRUE(hit && ray);
    return hit && ray ? std::vector<double>{hit->distance, ray->distance} : std::vector<double>{0, 0};
  };
  const std::vector<double> here = answers(Vector3::Zero()), there = answers({40, -70, 20});
  for (std::size_t i = 0; i < here.size(); ++i) EXPECT_NEAR(here[i], there[i], 1e-9);
}

}  // namespace
}  // namespace atl::test::hull_frame_test
