// The team runs every index of every loop once and shows the caller what was written, whatever its helpers do.

#include <gtest/gtest.h>
#include <jobs/worker_team.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace atl::jobs {
namespace {

class Team : public testing::TestWithParam<int> {};

// Plain counters: two loops that write the same one from different threads would lose counts if a loop could
// end before its writes are visible, or a late helper ran a chunk again.
TEST_P(Team, RunsEachIndexOfManyShortLoopsOnce) {
  Arena arena(GetParam());
  WorkerTeam team(arena);
  constexpr std::size_t loops = 100'000;
  constexpr std::size_t longest = 41;
  std::array<std::uint32_t, longest> counts = {};
  std::array<std::uint32_t, longest> expected = {};
  for (std::size_t loop = 0; loop < loops; ++loop) {
    const std::size_t count = loop * 7 % (longest + 1);
    const std::size_t grain = 1 + loop % 5;
    team.parallel_for(count, grain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) ++counts[i];
    });
    for (std::size_t i = 0; i < count; ++i) ++expected[i];
  }
  EXPECT_EQ(counts, expected);
}

// Each loop reads its neighbours' results of the loop before: a stencil comes out as it does on one thread.
TEST_P(Team, LoopSeesWhatTheLoopBeforeItWrote) {
  Arena arena(GetParam());
  WorkerTeam team(arena);
  constexpr std::size_t cells = 64;
  const auto next = [](const std::vector<std::uint64_t>& from, std::size_t i) {
    return from[(i + 1) % cells] * 3 + (from[(i + cells - 1) % cells] ^ i);
  };
  std::vector<std::uint64_t> cell(cells, 1), fresh(cells), expected(cells, 1), expected_fresh(cells);
  for (int loop = 0; loop < 5000; ++loop) {
    team.parallel_for(cells, 4, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) fresh[i] = next(cell, i);
    });
    cell.swap(fresh);
    for (std::size_t i = 0; i < cells; ++i) expected_fresh[i] = next(expected, i);
    expected.swap(expected_fresh);
  }
  EXPECT_EQ(cell, expected);
}

// Helpers may come after the last loop, or never: most of these teams are gone before one arrives.
TEST_P(Team, ShortLivesEndWell) {
  Arena arena(GetParam());
  for (int life = 0; life < 300; ++life) {
    WorkerTeam team(arena);
    std::array<int, 16> counts = {};
    for (int loop = 0; loop < life % 3; ++loop) {
      team.parallel_for(counts.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) ++counts[i];
      });
    }
    for (int count : counts) ASSERT_EQ(count, life % 3);
  }
}

// The arena's own loops run while helpers spin in its slots, and two teams may share it.
TEST_P(Team, SharesItsArenaWithLoopsAndTeams) {
  Arena arena(GetParam());
  WorkerTeam one(arena);
  WorkerTeam other(arena);
  std::vector<int> counts(256, 0);
  const auto count_up = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) ++counts[i];
  };
  for (int round = 0; round < 100; ++round) {
    one.parallel_for(counts.size(), 8, count_up);
    arena.parallel_for(counts.size(), 16, count_up);
    other.parallel_for(counts.size(), 8, count_up);
  }
  EXPECT_EQ(counts, std::vector<int>(256, 300));
}

TEST(Congestion, LastsAWhileAfterAStall) {
  using std::chrono::milliseconds;
  const Congestion::Clock::time_point start(std::chrono::hours(1));
  Congestion congestion(true);
  EXPECT_FALSE(congestion.is_on());
  congestion.record_stall();
  EXPECT_TRUE(congestion.is_on_at(start));
  EXPECT_TRUE(congestion.is_on_at(start + milliseconds(39)));
  EXPECT_FALSE(congestion.is_on_at(start + milliseconds(41)));
}

TEST(Congestion, ThatComesBackLastsLonger) {
  using std::chrono::milliseconds;
  Congestion::Clock::time_point now(std::chrono::hours(1));
  Congestion congestion(true);
  for (const int pause : {40, 160, 640, 2000, 2000}) {
    congestion.record_stall();
    EXPECT_TRUE(congestion.is_on_at(now));
    EXPECT_TRUE(congestion.is_on_at(now + milliseconds(pause - 1)));
    now += milliseconds(pause + 1);
    EXPECT_FALSE(congestion.is_on_at(now));
  }
  now += std::chrono::seconds(20);
  congestion.record_stall();
  EXPECT_TRUE(congestion.is_on_at(now));
  EXPECT_FALSE(congestion.is_on_at(now + milliseconds(41))) << "what was long ago is forgotten";
}

TEST(Congestion, IsNotWatchedForWhereThreadsAreFixed) {
  Congestion congestion(false);
  congestion.record_stall();
  EXPECT_FALSE(congestion.is_on());
}

INSTANTIATE_TEST_SUITE_P(Threads, Team, testing::Values(1, 2, 4, 8),
                         [](const auto& threads) { return std::to_string(threads.param); });

}  // namespace
}  // namespace atl::jobs
