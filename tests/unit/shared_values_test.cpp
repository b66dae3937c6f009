// Values that are alike are kept once, whatever comes and goes.

#include <gtest/gtest.h>
#include <jobs/shared_values.h>

#include <array>
#include <cmath>
#include <vector>

#include "support/random.h"

namespace atl::jobs {
namespace {

using Value = std::array<double, 3>;

TEST(SharedValues, AreThoseThatWereSet) {
  test::Random random(1);
  SharedValues<Value> shared({1, 2, 3});
  std::vector<Value> plain;
  for (int change = 0; change < 20'000; ++change) {
    if (plain.size() < 300 && random.chance(0.1)) {
      plain.push_back({1, 2, 3});
      shared.resize(plain.size());
      continue;
    }
    if (plain.empty()) continue;
    // Few kinds for a while, then nearly all different.
    const std::uint32_t kinds = change / 5000 % 2 == 0 ? 10 : 100'000;
    const Value value = {1.0 * random.below(kinds), 2, 3};
    const std::size_t entry = random.below(static_cast<std::uint32_t>(plain.size()));
    plain[entry] = value;
    shared.set(entry, value);
    if (change % 50 != 0) continue;
    for (std::size_t i = 0; i < plain.size(); ++i) ASSERT_EQ(shared[i], plain[i]);
  }
}

TEST(SharedValues, DifferInTheirBits) {
  SharedValues<Value> shared;
  shared.resize(3);
  shared.set(0, {0.0, 0, 0});
  shared.set(1, {-0.0, 0, 0});
  shared.set(2, {std::nan(""), 0, 0});
  EXPECT_FALSE(std::signbit(shared[0][0]));
  EXPECT_TRUE(std::signbit(shared[1][0]));
  EXPECT_TRUE(std::isnan(shared[2][0]));
}

// An entry takes its number; what no entry has any more makes room.
TEST(SharedValues, TakeRoomByWhatIsInUse) {
  SharedValues<Value> shared;
  shared.resize(1000);
  for (std::size_t i = 0; i < 1000; ++i) shared.set(i, {1.0 * (i % 4), 0, 0});
  EXPECT_LT(bytes_of(shared), 5000u);
  const std::size_t before = bytes_of(shared);
  for (int i = 0; i < 100'000; ++i) shared.set(500, {1.0 * i, 1, 0});
  EXPECT_LE(bytes_of(shared), before + 500);
}

}  // namespace
}  // namespace atl::jobs
