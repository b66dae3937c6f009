// The tree's queries against brute force, and boxes that round outwards.

#include <collision/broadphase/aabb_tree.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <vector>

#include "support/random.h"

namespace atl::collision {
namespace {

using test::Random;

Aabb random_box(Random& random, double reach, double largest) {
  const Vector3 lower = random.vector(reach);
  const Vector3 size(random.real(0, largest), random.real(0, largest), random.real(0, largest));
  return Aabb::around(lower, lower + size);
}

using Entries = std::map<std::uint32_t, Aabb>;  // by item

std::vector<std::uint32_t> found_in(const AabbTree& tree, const Aabb& box) {
  std::vector<std::uint32_t> found;
  tree.query(box, [&](std::uint32_t item) { found.push_back(item); });
  std::sort(found.begin(), found.end());
  return found;
}

std::vector<std::uint32_t> expected_in(const Entries& entries, const Aabb& box) {
  std::vector<std::uint32_t> expected;
  for (const auto& [item, box_of_item] : entries) {
    if (box_of_item.overlaps(box)) expected.push_back(item);
  }
  return expected;
}

// New boxes wait in a list; later the tree takes them in, a few by insertion and many by a build in parts.
TEST(AabbTree, FindsWhatIsInsertedLater) {
  Random random(2);
  jobs::Arena one(1), three(3);
  for (jobs::Arena* arena : {static_cast<jobs::Arena*>(nullptr), &one, &three}) {
    AabbTree tree;
    Entries entries;
    std::uint32_t next_item = 0;
    const auto check = [&] {
      ASSERT_EQ(tree.size(), entries.size());
      for (int i = 0; i < 20; ++i) {
        const Aabb probe = random_box(random, 30, 4);
        ASSERT_EQ(found_in(tree, probe), expected_in(entries, probe));
      }
    };
    for (const int count : {1, 2, 5, 40'000, 300, 1}) {
      for (int i = 0; i < count; ++i) {
        entries[next_item] = random_box(random, 30, 1);
        tree.insert_later(next_item, entries[next_item]);
        ++next_item;
      }
      check();
      for (int i = 0; i < count / 4; ++i) {
        const auto entry = entries.lower_bound(random.below(next_item));
        if (entry == entries.end()) continue;
        if (random.chance(0.5)) {
          entry->second = random_box(random, 30, 1);
          tree.move(entry->first, entry->second);
        } else {
          tree.remove(entry->first);
          entries.erase(entry);
        }
      }
      check();
      tree.take_in(arena);
      EXPECT_FALSE(tree.is_behind());
      check();
    }
    while (!entries.empty()) {
      tree.remove(entries.begin()->first);
      entries.erase(entries.begin());
      if (entries.size() % 4096 == 0) check();
    }
  }
}

// Orders of insertion that make naive trees as deep as they are large; a traversal's stack holds 128 nodes.
TEST(AabbTree, SurvivesSortedNestedAndEqualBoxes) {
  const auto expect_all_found = [](std::uint32_t count, auto&& box_of) {
    AabbTree tree;
    Entries entries;
    for (std::uint32_t item = 0; item < count; ++item) tree.insert(item, entries[item] = box_of(item));
    for (std::uint32_t item = 0; item < count; item += 97) {
      EXPECT_EQ(found_in(tree, box_of(item)), expected_in(entries, box_of(item)));
    }
    // From one end, so that what is left hangs from one side.
    for (std::uint32_t item = 0; item < count - 5; ++item) tree.remove(item);
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

struct Ray {
  Vector3 origin, direction;
  double max_t;
  Vector3 half_extents;
};

// In long double, whose rounding is 2000 times finer: clearly hit, clearly missed or too close to tell.
enum class Verdict { Hit, Missed, Close };
Verdict verdict(const Ray& ray, const Aabb& box) {
  long double enter = 0, leave = ray.max_t, scale = 1e-30L;
  bool inside_slabs = true;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    const long double lower = static_cast<long double>(box.lower[axis]) - ray.half_extents[i] - ray.origin[i];
    const long double upper = static_cast<long double>(box.upper[axis]) + ray.half_extents[i] - ray.origin[i];
    const long double d = ray.direction[i];
    if (d == 0) {
      inside_slabs &= lower <= 0 && upper >= 0;
      continue;
    }
    enter = std::max(enter, std::min(lower / d, upper / d));
    leave = std::min(leave, std::max(lower / d, upper / d));
    scale = std::max({scale, std::abs(lower / d), std::abs(upper / d)});
  }
  if (!inside_slabs) return Verdict::Missed;
  if (enter <= leave) return Verdict::Hit;
  return enter - leave < 1e-13L * scale ? Verdict::Close : Verdict::Missed;
}

TEST(AabbTree, RaysMissNothing) {
  Random random(6);
  AabbTree tree;
  Entries entries;
  for (std::uint32_t item = 0; item < 500; ++item) {
    // Many have faces at whole numbers, where rays then graze them.
    Aabb box = random_box(random, 10, 3);
    for (std::size_t axis = 0; axis < 3 && item % 2 == 0; ++axis) {
      box.lower[axis] = std::floor(box.lower[axis]);
      box.upper[axis] = std::ceil(box.upper[axis]);
    }
    tree.insert(item, entries[item] = box);
  }
  std::size_t hits = 0;
  for (int i = 0; i < 3000; ++i) {
    Ray ray{random.vector(12), random.real(0.01, 10) * random.direction(), random.real(0, 4), Vector3::Zero()};
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      if (random.chance(0.3)) ray.origin[axis] = std::round(ray.origin[axis]);
      if (random.chance(0.2)) ray.direction[axis] = random.chance(0.8) ? 0 : random.chance(0.5) ? 1e-310 : -1e-305;
    }
    if (random.chance(0.1)) ray.direction = ray.origin.array().round().matrix() - ray.origin.array().floor().matrix();
    if (random.chance(0.3)) ray.half_extents = {random.real(0, 1), 0.1, random.real(0, 1)};
    if (random.chance(0.1)) ray.max_t = std::numeric_limits<double>::infinity();
    std::set<std::uint32_t> found;
    const double left = tree.ray_query(
        ray.origin, ray.direction, ray.max_t,
        [&](std::uint32_t item, double t_enter) {
          EXPECT_TRUE(found.insert(item).second);
          EXPECT_TRUE(t_enter >= 0 && t_enter <= ray.max_t);
          return ray.max_t;
        },
        ray.half_extents);
    EXPECT_EQ(left, ray.max_t);
    for (const auto& [item, box] : entries) {
      const Verdict expected = verdict(ray, box);
      if (expected == Verdict::Hit) {
        ASSERT_TRUE(found.count(item)) << "ray " << i << ", item " << item;
      }
      // A component too small to invert thickens the slab without a bound if the ray has no end.
      if (expected == Verdict::Missed && ray.max_t < 1e9) {
        ASSERT_FALSE(found.count(item)) << "ray " << i << ", item " << item;
      }
      hits += expected == Verdict::Hit;
    }
  }
  EXPECT_GT(hits, 5000u);
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

}  // namespace
}  // namespace atl::collision
