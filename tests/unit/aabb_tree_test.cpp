// The tree's queries against brute force, and boxes that round outwards.

#include <collision/aabb_tree.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "random.h"

namespace atl::collision {
namespace {

using test::Random;

Aabb random_box(Random& random, double reach, double largest) {
  const Vector3 lower = random.vector(reach);
  const Vector3 size(random.real(0, largest), random.real(0, largest), random.real(0, largest));
  return Aabb::around(lower, lower + size);
}

struct Entry {
  std::int32_t leaf;
  Aabb box;
};
using Entries = std::map<std::uint32_t, Entry>;  // by item

std::vector<std::uint32_t> found_in(const AabbTree& tree, const Aabb& box) {
  std::vector<std::uint32_t> found;
  tree.query(box, [&](std::uint32_t item) { found.push_back(item); });
  std::sort(found.begin(), found.end());
  return found;
}

std::vector<std::uint32_t> expected_in(const Entries& entries, const Aabb& box) {
  std::vector<std::uint32_t> expected;
  for (const auto& [item, entry] : entries) {
    if (entry.box.overlaps(box)) expected.push_back(item);
  }
  return expected;
}

TEST(AabbTree, EmptyFindsNothing) {
  const AabbTree tree;
  EXPECT_TRUE(found_in(tree, {{-1, -1, -1}, {1, 1, 1}}).empty());
}

TEST(AabbTree, MatchesBruteForceUnderRandomChanges) {
  Random random(1);
  AabbTree tree;
  Entries entries;
  std::uint32_t next_item = 0;
  for (int change = 0; change < 20'000; ++change) {
    const double what = random.real(0, 1);
    // Grows for a while, then shrinks to nothing, and again.
    const double insert_share = change / 4000 % 2 == 0 ? 0.5 : 0.1;
    if (entries.empty() || what < insert_share) {
      const Aabb box = random_box(random, 10, 2);
      entries[next_item] = {tree.insert(next_item, box), box};
      ++next_item;
    } else {
      auto entry = entries.lower_bound(random.below(next_item));
      if (entry == entries.end()) entry = entries.begin();
      if (what < 0.7) {
        entry->second.box = random_box(random, 10, 2);
        tree.move(entry->second.leaf, entry->second.box);
      } else {
        tree.remove(entry->second.leaf);
        entries.erase(entry);
      }
    }
    if (random.chance(0.02)) tree.rebuild_if_worn();
    ASSERT_EQ(tree.size(), entries.size());
    if (change % 20 != 0) continue;
    const Aabb probe = random_box(random, 10, 4);
    ASSERT_EQ(found_in(tree, probe), expected_in(entries, probe)) << "change " << change;
  }
}

// Orders of insertion that make naive trees as deep as they are large; a traversal's stack holds 128 nodes.
TEST(AabbTree, SurvivesSortedNestedAndEqualBoxes) {
  const auto expect_all_found = [](std::uint32_t count, auto&& box_of) {
    AabbTree tree;
    Entries entries;
    for (std::uint32_t item = 0; item < count; ++item) entries[item] = {tree.insert(item, box_of(item)), box_of(item)};
    for (std::uint32_t item = 0; item < count; item += 97) {
      EXPECT_EQ(found_in(tree, box_of(item)), expected_in(entries, box_of(item)));
    }
    // From one end, so that what is left hangs from one side.
    for (std::uint32_t item = 0; item < count - 5; ++item) tree.remove(entries[item].leaf);
    entries.erase(entries.begin(), std::prev(entries.end(), 5));
    const Aabb last = box_of(count - 1);
    EXPECT_EQ(found_in(tree, last), expected_in(entries, last));
  };
  expect_all_found(20'000, [](std::uint32_t i) {
    const auto x = static_cast<float>(i);
    return Aabb{{x, 0, 0}, {x + 1.5f, 1, 1}};
  });
  expect_all_found(200, [](std::uint32_t i) {
    const float half = std::ldexp(1.0f, static_cast<int>(i) - 100);
    return Aabb{{-half, -half, -half}, {half, half, half}};
  });
  expect_all_found(200, [](std::uint32_t i) {
    const float x = std::ldexp(1.0f, static_cast<int>(i) - 100);
    return Aabb{{x, 0, 0}, {1.1f * x, 1, 1}};
  });
  expect_all_found(3000, [](std::uint32_t) { return Aabb{{0, 0, 0}, {1, 1, 1}}; });
}

TEST(AabbTree, SurvivesBoxesThatAreNotFinite) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  constexpr float infinity = std::numeric_limits<float>::infinity();
  Random random(2);
  AabbTree tree;
  Entries entries;
  for (std::uint32_t item = 0; item < 500; ++item) {
    Aabb box = random_box(random, 10, 1);
    if (item % 7 == 0) box = {{nan, nan, nan}, {nan, nan, nan}};
    if (item % 11 == 0) box = {{-infinity, -infinity, -infinity}, {infinity, infinity, infinity}};
    entries[item] = {tree.insert(item, box), box};
  }
  for (int round = 0; round < 3; ++round) {
    for (const auto& [item, entry] : entries) tree.move(entry.leaf, entry.box);
    tree.rebuild_if_worn();
  }
  EXPECT_EQ(tree.size(), entries.size());
  for (const auto& [item, entry] : entries) tree.remove(entry.leaf);
  EXPECT_EQ(tree.size(), 0u);
}

TEST(Aabb, RoundsOutwardsToTheNextFloat) {
  Random random(3);
  for (double scale : {1e-3, 1.0, 1e3, 1e7, 1e12}) {
    for (int i = 0; i < 2000; ++i) {
      const Vector3 lower = random.vector(scale);
      const Vector3 upper = lower + Vector3::Constant(1e-3 * scale);
      const Aabb box = Aabb::around(lower, upper);
      for (std::size_t k = 0; k < 3; ++k) {
        const auto axis = static_cast<Eigen::Index>(k);
        ASSERT_LE(box.lower[k], lower[axis]);
        ASSERT_GE(box.upper[k], upper[axis]);
        // The next float inwards would not contain it.
        ASSERT_GT(std::nextafter(box.lower[k], INFINITY), lower[axis]);
        ASSERT_LT(std::nextafter(box.upper[k], -INFINITY), upper[axis]);
      }
    }
  }
  const Aabb exact = Aabb::around({1, -2, 0}, {1, -2, 0});
  EXPECT_EQ(exact, (Aabb{{1, -2, 0}, {1, -2, 0}}));
  const Aabb beyond = Aabb::around(Vector3::Constant(-1e39), Vector3::Constant(1e39));
  EXPECT_LE(beyond.lower[0], -3e38f);
  EXPECT_GE(beyond.upper[0], 3e38f);
}

TEST(Aabb, BoundsTouchTheShapesFarthestPoints) {
  Random random(4);
  for (int i = 0; i < 200; ++i) {
    const Vector3 half(random.real(0.1, 2), random.real(0.1, 2), random.real(0.1, 2));
    const Vector3 position = random.vector(100);
    const Matrix3 rotation = random.rotation().toRotationMatrix();
    Vector3 lower = Vector3::Constant(INFINITY);
    Vector3 upper = -lower;
    for (int corner = 0; corner < 8; ++corner) {
      const Vector3 sign(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
      const Vector3 p = position + rotation * sign.cwiseProduct(half);
      lower = lower.cwiseMin(p);
      upper = upper.cwiseMax(p);
    }
    const Bounds box = bounds_of(Shape::box(half), position, rotation);
    EXPECT_LT((box.lower - lower).norm() + (box.upper - upper).norm(), 1e-12);
    const Bounds ball = bounds_of(Shape::sphere(0.7), position, rotation);
    EXPECT_LT((ball.lower - position + Vector3::Constant(0.7)).norm(), 1e-12);
    EXPECT_LT((ball.upper - position - Vector3::Constant(0.7)).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace atl::collision
