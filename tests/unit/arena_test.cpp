// The arena cuts a loop into the same chunks on any number of threads, and numbers its workers.

#include <gtest/gtest.h>
#include <jobs/arena.h>
#include <jobs/scratch.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace atl::jobs {
namespace {

using Chunk = std::pair<std::size_t, std::size_t>;

std::vector<Chunk> chunks_of(Arena& arena, std::size_t count, std::size_t grain) {
  std::vector<Chunk> chunks;
  std::mutex mutex;
  arena.parallel_for(count, grain, [&](std::size_t begin, std::size_t end) {
    const std::lock_guard lock(mutex);
    chunks.emplace_back(begin, end);
  });
  std::sort(chunks.begin(), chunks.end());
  return chunks;
}

class ArenaOf : public testing::TestWithParam<int> {};

TEST_P(ArenaOf, CoversALoopWithTheSameChunks) {
  Arena arena(GetParam());
  for (std::size_t count : {0u, 1u, 63u, 64u, 65u, 1000u}) {
    for (std::size_t grain : {1u, 7u, 64u, 2000u}) {
      std::vector<Chunk> expected;
      for (std::size_t begin = 0; begin < count; begin += grain) {
        expected.emplace_back(begin, std::min(begin + grain, count));
      }
      EXPECT_EQ(chunks_of(arena, count, grain), expected) << count << " by " << grain;
      EXPECT_EQ(Arena::chunk_count(count, grain), expected.size());
    }
  }
}

TEST_P(ArenaOf, LoopsNest) {
  Arena arena(GetParam());
  std::vector<int> counts(32 * 32, 0);
  arena.parallel_for(32, 1, [&](std::size_t outer, std::size_t) {
    arena.parallel_for(32, 4, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) ++counts[outer * 32 + i];
    });
  });
  EXPECT_EQ(counts, std::vector<int>(32 * 32, 1));
}

// Two chunks at once never get the same scratch, or they would find it in use.
TEST_P(ArenaOf, WorkersHaveScratchOfTheirOwn) {
  struct Item {
    std::atomic<int> users{0};
  };
  Arena arena(GetParam());
  Scratch<Item> scratch(GetParam());
  std::atomic<int> shared{0};
  arena.parallel_for(2000, 1, [&](std::size_t, std::size_t) {
    Item& item = scratch.local();
    if (item.users.fetch_add(1) != 0) ++shared;
    std::this_thread::yield();
    item.users.fetch_sub(1);
  });
  EXPECT_EQ(shared, 0);
}

INSTANTIATE_TEST_SUITE_P(Threads, ArenaOf, testing::Values(1, 2, 4, 8),
                         [](const auto& threads) { return std::to_string(threads.param); });

// A caller may itself be the task of another, bigger arena, as when a program steps many worlds at once: the
// number of its worker there says nothing about its number here.
TEST(Scratch, OfOneWorkerServesACallerInsideAnotherArena) {
  std::atomic<int> strangers{0};
  tbb::task_arena outer(4);
  const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, 4);
  outer.execute([&] {
    tbb::parallel_for(0, 200, [&](int) {
      Arena one(1);
      Scratch<int> scratch(1);
      int* const only = &scratch.local();
      const auto check = [&](std::size_t, std::size_t) {
        if (&scratch.local() != only) ++strangers;
        std::this_thread::sleep_for(std::chrono::microseconds(10));  // so that others get chunks too
      };
      one.parallel_for(4, 1, check);
    });
  });
  EXPECT_EQ(strangers, 0);
}

}  // namespace
}  // namespace atl::jobs
