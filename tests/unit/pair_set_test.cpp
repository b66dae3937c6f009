// PairSet against std::set.

#include <collision/broadphase/pair_set.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <vector>

#include "support/random.h"

namespace atl::collision {
namespace {

void expect_same_as_std_set(std::uint32_t bodies, int operations, double insert_chance) {
  test::Random random(bodies);
  PairSet set;
  std::set<Pair> expected;
  for (int i = 0; i < operations; ++i) {
    const std::uint32_t a = random.below(bodies);
    const std::uint32_t b = (a + 1 + random.below(bodies - 1)) % bodies;
    const Pair pair = Pair::of(a, b);
    const bool present = expected.count(pair) != 0;
    ASSERT_EQ(set.contains(pair), present) << "operation " << i;
    if (!present && random.chance(insert_chance)) {
      set.insert(pair);
      expected.insert(pair);
    } else if (present && !random.chance(insert_chance)) {
      set.erase(pair);
      expected.erase(pair);
    }
    ASSERT_EQ(set.size(), expected.size());
  }
  for (std::uint32_t a = 0; a < bodies; ++a) {
    for (std::uint32_t b = a + 1; b < bodies && bodies < 1000; ++b) {
      ASSERT_EQ(set.contains({a, b}), expected.count({a, b}) != 0) << a << ", " << b;
    }
  }
}

TEST(PairSet, EmptyContainsNothing) { EXPECT_FALSE(PairSet().contains({0, 1})); }

// Few bodies: pairs come and go, and long runs of neighbours form and are cut.
TEST(PairSet, DenseUseMatchesStdSet) { expect_same_as_std_set(40, 100'000, 0.5); }

TEST(PairSet, GrowingUseMatchesStdSet) { expect_same_as_std_set(5000, 100'000, 0.9); }

TEST(PairSet, ErasingAllLeavesNone) {
  PairSet set;
  constexpr std::uint32_t count = 20'000;
  for (std::uint32_t i = 0; i < count; ++i) set.insert({i, i + 1});
  for (std::uint32_t i = 0; i < count; ++i) set.erase({i, i + 1});
  EXPECT_EQ(set.size(), 0u);
  for (std::uint32_t i = 0; i < count; ++i) EXPECT_FALSE(set.contains({i, i + 1}));
}

// Highest numbers: the key of no pair is the one that marks a vacant slot.
TEST(PairSet, TakesTheHighestNumbers) {
  PairSet set;
  const Pair last = Pair::of(0xffffffffu, 0xfffffffeu);
  set.insert(last);
  EXPECT_TRUE(set.contains(last));
  EXPECT_FALSE(set.contains({0, 0xffffffffu}));
  set.erase(last);
  EXPECT_FALSE(set.contains(last));
}

TEST(PairSet, DropsContainedPairsInPlace) {
  test::Random random(8);
  PairSet set;
  std::set<Pair> expected_set;
  for (int i = 0; i < 3000; ++i) {
    const Pair pair = Pair::of(random.below(100), 100 + random.below(100));
    if (expected_set.insert(pair).second) set.insert(pair);
  }
  std::vector<Pair> pairs, expected;
  for (int i = 0; i < 5000; ++i) {
    const Pair pair = Pair::of(random.below(100), 100 + random.below(100));
    pairs.push_back(pair);
    if (i < 1000 || expected_set.count(pair) == 0) expected.push_back(pair);
  }
  PairSet().drop_contained(pairs, 0);
  EXPECT_EQ(pairs.size(), 5000u);
  set.drop_contained(pairs, 1000);
  EXPECT_EQ(pairs, expected);
}

// Few and many, of small numbers and of any.
TEST(Pair, SortsAsStdSortDoes) {
  test::Random random(9);
  std::vector<Pair> scratch;
  for (const std::uint32_t largest : {1u, 200u, 70'000u, 0xffffffffu}) {
    for (const std::size_t count : {0u, 1u, 2u, 299u, 300u, 5000u}) {
      std::vector<Pair> pairs;
      for (std::size_t i = 0; i < count; ++i) pairs.push_back(Pair::of(random.below(largest), random.below(largest)));
      std::vector<Pair> expected = pairs;
      std::sort(expected.begin(), expected.end());
      sort_pairs(pairs, scratch);
      EXPECT_EQ(pairs, expected) << count << " pairs, numbers below " << largest;
    }
  }
}

TEST(Pair, IsOrderedByFirstThenSecond) {
  EXPECT_EQ(Pair::of(7, 3), (Pair{3, 7}));
  EXPECT_LT((Pair{1, 9}), (Pair{2, 3}));
  EXPECT_LT((Pair{2, 3}), (Pair{2, 0xffffffffu}));
}

}  // namespace
}  // namespace atl::collision
