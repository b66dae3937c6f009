// Queries of a world: answers against closed forms, and what is refused. Random programs have filters and batches.

#include <atoll/queries.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "support/bodies.h"
#include "support/expect_error.h"
#include "support/random.h"

namespace atl::test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

// Along x: a ball, a static box, a kinematic capsule upright, a compound of two boxes, over a half-space at z = -1.
class QueriesTest : public testing::Test {
 protected:
  QueriesTest() {
    floor_ = world_.add_body({.type = BodyType::Static, .shape = HalfSpace{.offset = -1}});
    ball_ = world_.add_body({.shape = Sphere{0.5}, .position = {2, 0, 0}, .filter = {.category = 2}});
    wall_ = world_.add_body({.type = BodyType::Static, .shape = Box{{0.1, 1, 1}}, .position = {4, 0, 0}});
    post_ = world_.add_body({.type = BodyType::Kinematic, .shape = Capsule{0.25, 0.5}, .position = {6, 0, 0}});
    const Box side{{0.5, 0.5, 0.5}};
    const Compound pair{{{.shape = side, .position = {-1, 0, 0}}, {.shape = side, .position = {1, 0, 0}}}};
    pair_ = world_.add_body({.shape = pair, .position = {9, 0, 0}});
  }

  World world_{{.gravity = Vector3::Zero(), .threads = 2}};
  Queries queries_{world_};
  BodyId floor_, ball_, wall_, post_, pair_;
  const Ray along_x_{.origin = Vector3::Zero(), .direction = {3, 0, 0}};
};

TEST_F(QueriesTest, RayMeetsBodiesInTurn) {
  const std::vector<RayHit> hits = queries_.cast_ray_through(along_x_);
  ASSERT_EQ(hits.size(), 5u);
  const BodyId bodies[] = {ball_, wall_, post_, pair_, pair_};
  const double distances[] = {1.5, 3.9, 5.75, 7.5, 9.5};
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(hits[i].body, bodies[i]);
    EXPECT_NEAR(hits[i].distance, distances[i], 1e-12);
    EXPECT_LT((hits[i].point - Vector3(distances[i], 0, 0)).norm(), 1e-12);
    EXPECT_LT((hits[i].normal + Vector3::UnitX()).norm(), 1e-12);
    EXPECT_EQ(hits[i].child, i == 4 ? 1u : 0u);
    EXPECT_FALSE(hits[i].triangle);
    EXPECT_FALSE(hits[i].started_inside);
  }
  const std::optional<RayHit> first = queries_.cast_ray(along_x_);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->body, ball_);
  EXPECT_EQ(first->distance, hits[0].distance);
  EXPECT_TRUE(queries_.is_blocked(along_x_));
  EXPECT_FALSE(queries_.cast_ray({.origin = Vector3::Zero(), .direction = {1, 0, 0}, .max_distance = 1.49}));
  EXPECT_FALSE(queries_.is_blocked({.origin = Vector3::Zero(), .direction = {1, 0, 0}, .max_distance = 1.49}));
  const std::optional<RayHit> down = queries_.cast_ray({.origin = {-5, 2, 3}, .direction = {0, 0, -1}});
  ASSERT_TRUE(down);
  EXPECT_EQ(down->body, floor_);
  EXPECT_NEAR(down->distance, 4, 1e-12);
  const std::optional<RayHit> inside = queries_.cast_ray({.origin = {2.1, 0, 0}, .direction = {0, 1, 0}});
  ASSERT_TRUE(inside);
  EXPECT_TRUE(inside->started_inside);
  EXPECT_EQ(inside->distance, 0);
}

// Among hits at the same distance the lowest body comes first, in whatever order they are found.
TEST_F(QueriesTest, WhatIsMetAtTheSameTimeComesInOrder) {
  const std::vector<double> flat(9, 0.0);
  const Shape shapes[] = {Sphere{0.5}, Box{}, Cylinder{}, HeightField(3, 3, 1, 1, flat)};
  for (const Shape& shape : shapes) {
    World world;
    std::vector<BodyId> same;
    for (int i = 0; i < 6; ++i) {
      same.push_back(world.add_body({.type = BodyType::Static, .shape = shape, .position = {0.013, 0.007, 0.4}}));
    }
    const Queries queries(world);
    for (const ShapeCast& cast :
         {ShapeCast{.shape = Sphere{0.2}, .position = {0.3, 0.2, 4}, .translation = {0.1, 0.05, -7}},
          ShapeCast{.shape = Cone{0.3, 0.3}, .position = {0.5, 0.4, 5}, .translation = {0.03, 0, -9}},
          ShapeCast{.shape = Box{{0.1, 0.2, 0.3}}, .position = {0.5, 0.4, 5}, .translation = {0.03, 0, -9}}}) {
      const std::vector<ShapeHit> all = queries.cast_shape_through(cast);
      ASSERT_EQ(all.size(), same.size());
      for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(all[i].body, same[i]);
      const std::optional<ShapeHit> first = queries.cast_shape(cast);
      ASSERT_TRUE(first);
      EXPECT_EQ(first->body, same.front());
      EXPECT_EQ(first->distance, all.front().distance);
    }
    const std::optional<RayHit> ray = queries.cast_ray({.origin = {0.2, 0.1, 5}, .direction = {0.01, 0, -1}});
    ASSERT_TRUE(ray);
    EXPECT_EQ(ray->body, same.front());
  }
}

TEST_F(QueriesTest, APlaneThatIsTooFarForANumberIsNotHit) {
  World world;
  world.add_body({.type = BodyType::Static, .shape = HalfSpace{}});
  const Queries queries(world);
  const Ray ray{.origin = {0, 0, 1e15}, .direction = {1, 0, -1e-300}};
  EXPECT_FALSE(queries.cast_ray(ray));
  EXPECT_FALSE(queries.is_blocked(ray));
  EXPECT_TRUE(queries.cast_ray_through(ray).empty());
  EXPECT_TRUE(queries.cast_ray({.origin = {0, 0, 1e15}}));
}

TEST_F(QueriesTest, ShapeCastStopsAtContact) {
  const ShapeCast cast{.shape = Sphere{0.25}, .position = {0, 0, 0}, .translation = {20, 0, 0}};
  const std::vector<ShapeHit> hits = queries_.cast_shape_through(cast);
  ASSERT_EQ(hits.size(), 5u);
  const double distances[] = {1.25, 3.65, 5.5, 7.25, 9.25};
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(hits[i].distance, distances[i], 1e-7);
    EXPECT_LE(hits[i].distance, distances[i]);
    EXPECT_LT((hits[i].point - Vector3(distances[i] + 0.25, 0, 0)).norm(), 1e-6);
    EXPECT_LT((hits[i].normal + Vector3::UnitX()).norm(), 1e-6);
  }
  const std::optional<ShapeHit> first = queries_.cast_shape(cast);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->body, ball_);
  EXPECT_EQ(first->distance, hits[0].distance);
  // A box that is turned by 45 degrees comes down on its edge.
  const Quaternion turned(Eigen::AngleAxisd(EIGEN_PI / 4, Vector3::UnitX()));
  const std::optional<ShapeHit> edge =
      queries_.cast_shape({.shape = Box{}, .position = {-3, 0, 5}, .orientation = turned, .translation = {0, 0, -10}});
  ASSERT_TRUE(edge);
  EXPECT_EQ(edge->body, floor_);
  EXPECT_NEAR(edge->distance, 6 - std::sqrt(0.5), 1e-6);
  // Nothing in the way, or overlapping at the start.
  EXPECT_FALSE(queries_.cast_shape({.shape = Box{}, .position = {-3, 0, 5}, .translation = {0, 0, 10}}));
  const std::optional<ShapeHit> stuck = queries_.cast_shape({.position = {4, 0, 0}, .translation = {0, 1, 0}});
  ASSERT_TRUE(stuck);
  EXPECT_TRUE(stuck->started_overlapping);
  EXPECT_EQ(stuck->body, wall_);
  EXPECT_EQ(stuck->distance, 0);
}

TEST_F(QueriesTest, OverlapsAndClosestPoints) {
  const QueryShape slab{.shape = Box{{1.2, 0.2, 0.2}}, .position = {3.2, 0, 0}};
  EXPECT_EQ(queries_.overlapping(slab), (std::vector<BodyId>{ball_, wall_}));
  // Both parts of the compound, but the body once.
  const QueryShape across{.shape = Cylinder{0.3, 3},
                          .position = {9, 0, 0},
                          .orientation = Quaternion(Eigen::AngleAxisd(EIGEN_PI / 2, Vector3::UnitY()))};
  EXPECT_EQ(queries_.overlapping(across), (std::vector<BodyId>{post_, pair_}));
  EXPECT_TRUE(queries_.overlapping(QueryShape{.shape = Sphere{0.4}, .position = {0, 0, 3}}).empty());

  const std::optional<ClosestPoint> near = queries_.closest_point({.position = {2, 0, 3}}, 10);
  ASSERT_TRUE(near);
  EXPECT_EQ(near->body, ball_);
  EXPECT_NEAR(near->distance, 2.5, 1e-12);
  EXPECT_LT((near->on_body - Vector3(2, 0, 0.5)).norm(), 1e-12);
  EXPECT_LT((near->on_shape - Vector3(2, 0, 3)).norm(), 1e-12);
  EXPECT_LT((near->normal - Vector3::UnitZ()).norm(), 1e-12);
  EXPECT_FALSE(queries_.closest_point({.position = {2, 0, 3}}, 2.4));
  EXPECT_FALSE(queries_.closest_point({.position = {2, 0, 3}}, 5e-324));  // of which a thousandth is nothing
  const std::optional<ClosestPoint> hull =
      queries_.closest_point({.shape = Cone{0.5, 0.5}, .position = {0, 30, 1}}, 100);
  ASSERT_TRUE(hull);
  EXPECT_EQ(hull->body, floor_);
  EXPECT_NEAR(hull->distance, 1.5, 1e-9);
  const std::optional<ClosestPoint> part = queries_.closest_point({.position = {10, 0, 0.75}}, 1);
  ASSERT_TRUE(part);
  EXPECT_EQ(part->child, 1u);
  EXPECT_NEAR(part->distance, 0.25, 1e-12);
}

// However the body is turned, and wherever it is.
TEST(QueriesOfPoints, FindWhatTheyAreWithin) {
  const std::vector<Vector3> corners = {{2, 0, -1.5}, {-2, 2, -1.5}, {-2, -2, -1.5}, {0, 0, 2}};
  const ConvexHull hull(corners);
  const Compound pair{
      {{.shape = Box{{1, 1, 1}}, .position = {-0.4, 0, 0}}, {.shape = Sphere{1}, .position = {0.4, 0, 0}}}};
  const Shape shapes[] = {Box{{1, 2, 3}},
                          Cylinder{1, 2},
                          Cone{2, 2},
                          Capsule{1, 1},
                          Sphere{1.5},
                          hull,
                          pair,
                          Ellipsoid{{1, 2, 1.5}},
                          TaperedCapsule{{1, 1.5}, 1}};
  Random random(3);
  for (const Shape& shape : shapes) {
    for (int i = 0; i < 200; ++i) {
      const Quaternion turn = random.rotation();
      const Vector3 place = random.vector(100);
      World world;
      const BodyId body =
          world.add_body({.type = BodyType::Static, .shape = shape, .position = place, .orientation = turn});
      const Queries queries(world);
      // Within a ball of 0.3 m about its centre, or a cone's.
      const Vector3 point = place + turn * (random.real(0, 0.3) * random.direction() - Vector3(0, 0, 0.4));
      EXPECT_EQ(queries.overlapping({.position = point}), std::vector<BodyId>{body}) << shape.index();
      const std::optional<ClosestPoint> closest = queries.closest_point({.position = point}, 10);
      ASSERT_TRUE(closest);
      EXPECT_LT(closest->distance, 0) << shape.index();
      EXPECT_LT((closest->on_shape - point).norm(), 1e-12);
      if (shape.index() == Shape(Compound{}).index()) continue;  // the way out of one child leads into the other
      // The way out ends at the surface, and nothing is nearer.
      const double depth = -closest->distance;
      EXPECT_LT((point + depth * closest->normal - closest->on_body).norm(), 1e-9);
      EXPECT_TRUE(queries.overlapping({.position = point + 0.999 * depth * closest->normal}).size() == 1);
      EXPECT_TRUE(queries.overlapping({.position = point + 1.001 * depth * closest->normal}).empty());
      for (int k = 0; k < 20; ++k) {
        EXPECT_EQ(queries.overlapping({.position = point + 0.999 * depth * random.direction()}).size(), 1u);
      }
      const std::optional<RayHit> ray = queries.cast_ray({.origin = point, .direction = random.direction()});
      ASSERT_TRUE(ray && ray->started_inside);
      EXPECT_EQ(ray->depth, depth);
      EXPECT_EQ(ray->normal, closest->normal);
    }
  }
}

// Any solid in any other: moved along the normal by the depth it is free, and no direction of many is a shorter way
// out.
TEST(QueriesOfSolids, SayHowDeepTheyOverlapAndWhichWayIsOut) {
  const std::vector<Vector3> corners = {{0.5, 0, -0.4}, {-0.5, 0.5, -0.4}, {-0.5, -0.5, -0.4}, {0, 0, 0.6}};
  const ConvexShape solids[] = {Box{{0.3, 0.5, 0.4}},
                                Cylinder{0.4, 0.5},
                                Cone{0.5, 0.5},
                                Capsule{0.3, 0.4},
                                Sphere{0.5},
                                ConvexHull(corners),
                                Ellipsoid{{0.3, 0.5, 0.4}},
                                TaperedCapsule{{0.3, 0.15}, 0.4}};
  const auto is_smooth = [](const ConvexShape& solid) {
    return std::holds_alternative<Ellipsoid>(solid) || std::holds_alternative<TaperedCapsule>(solid);
  };
  std::vector<std::pair<ConvexShape, ConvexShape>> pairs;
  for (const bool smooth : {false, true}) {
    for (const ConvexShape& one : solids) {
      for (const ConvexShape& other : solids) {
        if ((is_smooth(one) || is_smooth(other)) == smooth) pairs.emplace_back(one, other);
      }
    }
  }
  Random random(7);
  for (const auto& [one, other] : pairs) {
    for (int i = 0; i < 30; ++i) {
      World world;
      const Shape still = std::visit([](const auto& solid) -> Shape { return solid; }, other);
      world.add_body({.type = BodyType::Static, .shape = still, .orientation = random.rotation()});
      const Queries queries(world);
      QueryShape moved{one, random.real(0, 0.5) * random.direction(), random.rotation()};
      const std::vector<ClosestPoint> found = queries.nearby(moved, 0);
      if (found.empty()) {
        EXPECT_TRUE(queries.overlapping(moved).empty());
        continue;
      }
      // The search for the best axis is local where a capsule's segment is deep in the other solid, or the core of
      // an ellipsoid or a tapered capsule.
      const bool is_local = std::holds_alternative<Capsule>(one) || std::holds_alternative<Capsule>(other) ||
                            is_smooth(one) || is_smooth(other);
      const std::string what = std::to_string(one.index()) + " in " + std::to_string(other.index());
      const double depth = -found[0].distance;
      ASSERT_GE(depth, 0) << what;
      EXPECT_EQ(queries.closest_point(moved, 1)->distance, -depth);
      EXPECT_NEAR((found[0].on_body - found[0].on_shape).dot(found[0].normal), depth, 1e-9) << what;
      const Vector3 start = moved.position;
      const auto overlaps_at = [&](const Vector3& shift) {
        moved.position = start + shift;
        return !queries.overlapping(moved).empty();
      };
      EXPECT_FALSE(overlaps_at((depth + 1e-4) * found[0].normal)) << what << ", depth " << depth;
      for (int k = 0; k < 30; ++k) {
        const double shorter = depth - (is_local ? 0.03 : 2e-4);
        EXPECT_TRUE(shorter < 1e-4 || overlaps_at(shorter * random.direction())) << what << ", depth " << depth;
      }
      const std::optional<ShapeHit> cast = queries.cast_shape({one, start, moved.orientation, {1, 0, 0}});
      if (depth < 1e-6) continue;
      ASSERT_TRUE(cast && cast->started_overlapping) << what;
      EXPECT_EQ(cast->depth, depth);
      EXPECT_EQ(cast->normal, found[0].normal);
    }
  }
}

TEST(QueriesOfSolids, ArePushedOutByFrontsOfSurfaces) {
  World world;
  const BodyId plane = world.add_body({.type = BodyType::Static, .shape = HalfSpace{}, .position = {0, 0, -5}});
  const std::vector<Vector3> corners = {{-20, -20, 0}, {20, -20, 0}, {20, 20, 0}, {-20, 20, 0}};
  const std::vector<TriangleMesh::Indices> triangles = {{0, 1, 2}, {0, 2, 3}};
  const BodyId mesh = world.add_body({.type = BodyType::Static, .shape = TriangleMesh(corners, triangles)});
  const Queries queries(world);
  const ConvexShape solids[] = {Box{{0.5, 0.5, 0.5}},
                                Cylinder{0.4, 0.5},
                                Cone{0.5, 0.5},
                                Capsule{0.2, 0.3},
                                Sphere{0.5},
                                Ellipsoid{{0.4, 0.6, 0.5}},
                                TaperedCapsule{{0.3, 0.2}, 0.2}};
  for (const ConvexShape& solid : solids) {
    for (const auto& [body, height] : {std::pair(mesh, 0.0), std::pair(plane, -5.0)}) {
      const std::vector<ClosestPoint> found = queries.nearby({.shape = solid, .position = {1, 2, height + 0.4}}, 0.2);
      ASSERT_EQ(found.size(), 1u);
      EXPECT_EQ(found[0].body, body);
      EXPECT_NEAR(found[0].distance, -0.1, 1e-9) << solid.index();
      EXPECT_LT((found[0].normal - Vector3::UnitZ()).norm(), 1e-9);
      EXPECT_NEAR(found[0].on_shape.z(), height - 0.1, 1e-9);
      EXPECT_NEAR(found[0].on_body.z(), height, 1e-9);
    }
  }
}

TEST_F(QueriesTest, SurfacesNameTheirTriangles) {
  const HeightField field(3, 3, 1, 1, std::vector<double>(9, 0.0));
  const BodyId ground = world_.add_body({.type = BodyType::Static, .shape = field, .position = {100, 0, 5}});
  const std::optional<RayHit> hit = queries_.cast_ray({.origin = {101.7, 0.2, 9}, .direction = {0, 0, -1}});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->body, ground);
  EXPECT_EQ(hit->triangle, 2u);  // below the diagonal of the second cell
  EXPECT_NEAR(hit->distance, 4, 1e-12);
  const Ray from_below{.origin = {101.7, 0.2, 2}, .direction = {0, 0, 1}};
  EXPECT_FALSE(queries_.cast_ray(from_below));
  Ray both = from_below;
  both.both_sides = true;
  ASSERT_TRUE(queries_.cast_ray(both));
  EXPECT_LT((queries_.cast_ray(both)->normal + Vector3::UnitZ()).norm(), 1e-12);
  const std::optional<ClosestPoint> near = queries_.closest_point({.position = {100.2, 1.7, 6}}, 5);
  ASSERT_TRUE(near);
  EXPECT_EQ(near->triangle, 5u);
  EXPECT_NEAR(near->distance, 1, 1e-12);
}

// Answers follow the bodies, wherever steps and calls put them.
TEST(QueriesAfterSteps, FindBodiesWhereTheyAre) {
  World world;
  world.add_body(ground());
  const BodyId falling = world.add_body(sphere({0, 0, 10}));
  const BodyId pushed = world.add_body(sphere({5, 0, 0.5}));
  const Queries queries(world);
  for (int i = 0; i < 100; ++i) {
    world.step(dt);
    if (i == 50) world.set_velocity(pushed, {60, 0, 0}, Vector3::Zero());
    const Pose pose = world.pose(falling);
    const std::optional<RayHit> hit = queries.cast_ray({.origin = {0, 0, 20}, .direction = {0, 0, -1}});
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->body, falling);
    EXPECT_NEAR(hit->distance, 20 - pose.position.z() - 0.5, 1e-9);
    const Vector3 at = world.pose(pushed).position;
    EXPECT_EQ(queries.overlapping(QueryShape{.position = at}), std::vector<BodyId>{pushed});
  }
  world.set_pose(falling, {{40, 40, 3}, Quaternion::Identity()});
  EXPECT_EQ(queries.overlapping(QueryShape{.position = {40.2, 40.2, 3.3}}), std::vector<BodyId>{falling});
}

// A body in uniform motion stays for several steps in a box that is stretched along its motion, even if each step moves
// it by more than the margin.
TEST(QueriesAfterSteps, BoxesAlongTheMotionLast) {
  World world({.gravity = Vector3::Zero()});
  constexpr int count = 100, steps = 60;
  for (int i = 0; i < count; ++i) {
    BodyDef body = box(Vector3(3 * i, 0, 0));
    body.velocity = {0, 12, -9};  // m/s: 0.25 m a step, and the longest stretch is 1 m
    world.add_body(body);
  }
  world.step(dt);
  std::int64_t made = 0;
  for (int i = 0; i < steps; ++i) made += world.step(dt).counts.aabb_updates;
  EXPECT_GT(made, count * steps / 6);
  EXPECT_LE(made, count * steps / 4);
}

TEST_F(QueriesTest, BadQuestionsAreRefusedByName) {
  expect_error([&] { queries_.cast_ray({.origin = {0, nan, 0}}); }, {"ray.origin", "nan"});
  expect_error([&] { queries_.cast_ray({.direction = {0, 0, 0}}); }, {"ray.direction", "zero"});
  expect_error([&] { queries_.is_blocked({.direction = {0, infinity, 0}}); }, {"ray.direction", "inf"});
  expect_error([&] { queries_.cast_ray_through({.max_distance = -1}); }, {"ray.max_distance", "-1"});
  expect_error([&] { queries_.cast_ray({.max_distance = nan}); }, {"ray.max_distance", "nan"});
  expect_error([&] { queries_.cast_shape({.shape = Sphere{-2}}); }, {"cast.shape", "Sphere.radius", "-2"});
  expect_error([&] { queries_.cast_shape({.translation = {0, 0, nan}}); }, {"cast.translation", "nan"});
  expect_error([&] { queries_.overlapping(QueryShape{.orientation = {0, 0, 0, 0}}); }, {"shape.orientation", "0"});
  expect_error([&] { queries_.closest_point({}, infinity); }, {"max_distance", "inf", "finite"});
  expect_error([&] { queries_.closest_point({.position = {nan, 0, 0}}, 1); }, {"shape.position", "nan"});
  std::vector<Ray> rays(3);
  rays[2].direction = {0, nan, 0};
  expect_error([&] { queries_.cast_rays(rays); }, {"rays[2].direction", "nan"});
  EXPECT_TRUE(queries_.cast_ray({.direction = {1e-200, 0, 0}}));
  EXPECT_TRUE(queries_.cast_ray({.direction = {1e200, 0, 0}}));
}

// A body is as deep as its deepest child, whichever comes first.
TEST(Queries, ThatStartInSeveralChildrenTellTheDeepest) {
  World world;
  world.add_body({.type = BodyType::Static,
                  .shape = Compound{{{.shape = Sphere{0.3}, .position = {0.2, 0, 0}}, {.shape = Sphere{0.5}}}}});
  const Queries queries(world);
  const Ray ray{.origin = {0, 0.1, 0}, .direction = {1, 0, 0}, .max_distance = 5};
  const ShapeCast cast{.shape = Sphere{0.05}, .position = ray.origin, .translation = {1, 0, 0}};
  const auto hit = queries.cast_ray(ray);
  const auto swept = queries.cast_shape(cast);
  ASSERT_TRUE(hit && swept);
  EXPECT_EQ(hit->child, 1u);
  EXPECT_NEAR(hit->depth, 0.4, 1e-9);
  EXPECT_LT((hit->normal - Vector3::UnitY()).norm(), 1e-9);
  EXPECT_EQ(queries.cast_ray_through(ray).front().child, 1u);
  EXPECT_EQ(swept->child, 1u);
  EXPECT_NEAR(swept->depth, 0.45, 1e-6);
  EXPECT_NEAR(queries.closest_point({.position = ray.origin}, 5)->distance, -hit->depth, 1e-9);
}

}  // namespace
}  // namespace atl::test
