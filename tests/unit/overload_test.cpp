// Which contacts count as carrying too much.

#include <gtest/gtest.h>
#include <solver/constraints/load_check.h>
#include <solver/integrate/body_table.h>

#include <vector>

namespace atl::solver {
namespace {

// Between bodies 3, below, and 5, of 2 and 1 kg.
std::vector<OverloadedBody> noted(const Vector3& arm, double give, Build build) {
  collision::ContactManifold manifold = {};
  manifold.normal[2] = 1;
  manifold.anchor_first[2] = 10;
  for (int k = 0; k < 3; ++k) manifold.anchor_second[k] = static_cast<float>(arm[k]);
  std::vector<OverloadedBody> overloaded;
  check_load({.manifold = manifold, .first = 3, .second = 5, .inverse_first = 0.5, .inverse_second = 1}, give / 1.5,
             build, overloaded);
  return overloaded;
}

TEST(OverloadedBody, IsOfTheLighterBody) {
  ASSERT_EQ(noted({0, 0, -0.5}, 0.01, Build::Any).size(), 1u);
  EXPECT_EQ(noted({0, 0, -0.5}, 0.01, Build::Any)[0].body, 5u);
}

TEST(OverloadedBody, ColumnsMayGiveLess) {
  EXPECT_TRUE(noted({0, 0, -0.5}, 0.0074, Build::Any).empty());
  EXPECT_FALSE(noted({0, 0, -0.5}, 0.0076, Build::Any).empty());
  EXPECT_TRUE(noted({0, 0, -0.5}, 0.0021, Build::Columns).empty());
  EXPECT_FALSE(noted({0, 0, -0.5}, 0.0022, Build::Columns).empty());
}

TEST(OverloadedBody, IsMeasuredAgainstThickness) {
  EXPECT_FALSE(noted({0.3, 0, -0.1}, 0.0016, Build::Any).empty());
  EXPECT_TRUE(noted({0.3, 0, -0.1}, 0.0014, Build::Any).empty());
  // At a rim a tenth of the arm counts.
  EXPECT_FALSE(noted({0.3, 0, -0.001}, 0.00046, Build::Any).empty());
  EXPECT_TRUE(noted({0.3, 0, -0.001}, 0.00044, Build::Any).empty());
}

TEST(OverloadedBody, CrushesByPartsOfTheArm) {
  EXPECT_FALSE(noted({0.3, 0, -0.4}, 0.059, Build::Any)[0].deep);
  EXPECT_TRUE(noted({0.3, 0, -0.4}, 0.061, Build::Any)[0].deep);
}

TEST(OverloadedBody, JoinedBodiesAreCrushedByWhatIsMuchHeavier) {
  collision::ContactManifold manifold = {};
  manifold.normal[2] = 1;
  manifold.anchor_first[2] = 0.5f;
  manifold.anchor_second[2] = -0.5f;
  const auto crushed = [&](double inverse_first) {
    std::vector<OverloadedBody> overloaded;
    check_load({.manifold = manifold, .first = 3, .second = 5, .inverse_first = inverse_first, .inverse_second = 1},
               0.04, Build::Joined, overloaded);
    return overloaded.at(0).deep;
  };
  EXPECT_TRUE(crushed(1.0 / 65));
  EXPECT_FALSE(crushed(1.0 / 63));
  EXPECT_FALSE(crushed(0));  // the ground holds it up
}

TEST(OverloadedBody, WhatDoesNotRespondIsStifferAndHasNoSize) {
  collision::ContactManifold manifold = {};
  manifold.normal[2] = 1;
  manifold.anchor_first[2] = 1e-3f;
  manifold.anchor_second[2] = -0.5f;
  const auto noted_on_ground = [&](double give) {
    std::vector<OverloadedBody> overloaded;
    check_load({.manifold = manifold, .first = 0, .second = 5, .inverse_first = 0, .inverse_second = 1}, give,
               Build::Any, overloaded);
    return overloaded;
  };
  EXPECT_TRUE(noted_on_ground(0.029).empty());
  ASSERT_EQ(noted_on_ground(0.031).size(), 1u);
  EXPECT_EQ(noted_on_ground(0.031)[0].body, 5u);
}

}  // namespace
}  // namespace atl::solver
