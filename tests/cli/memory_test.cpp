// Scenes that need more memory than there is are refused before any is taken.

#include <gtest/gtest.h>

#include "cli/command.h"

namespace atl::test {
namespace {

// Sanitizers map terabytes for their own use.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool limits_hold = false;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
constexpr bool limits_hold = false;
#else
constexpr bool limits_hold = true;
#endif
#else
constexpr bool limits_hold = true;
#endif

// Within so many kB of address space, in which a scene of any size that was begun would end in std::bad_alloc.
CommandResult run_within(const std::string& kilobytes, const std::string& scene) {
  return run_program({"/bin/sh", "-c", "ulimit -v " + kilobytes + " && exec \"$0\" run \"$1\" --steps 1 --threads 1",
                      ATOLL_COMMAND_PATH, scene});
}

TEST(CommandMemory, HugeCountsAreToldInBytes) {
  for (const std::string& scene :
       words_of("pyramid3d:layers=1e9 wall:base=1e9 islands:count=1e9 pile:bodies=1e9 marbles:bodies=1e9 "
                "rocks:bodies=1e9 mixed:bodies=1e9 drum:boxes=1e9 terrain:bodies=1e9 terrain:triangles=1e12 "
                "hopper:bodies=1e9 stack:height=1e9 conveyor:boxes=1e9 chain:links=1e9 joint-grid:n=1e9 "
                "ragdolls:count=1e9 bridge:planks=1e9 sliding-blocks:headings=1e9 rolling-sphere:headings=1e9 "
                "rolling-resistance:headings=1e9 stack-forces:height=1e9 cradle:count=1e9 "
                "hanging-chain:links=1e9 catenary:links=1e9")) {
    SCOPED_TRACE(scene);
    expect_refused(
        run_atoll({"run", scene}), 2,
        {"too large", "expected an integer in [", "it would need about ", "B of memory, of which ", " are free"});
  }
  expect_refused(run_atoll({"explain", "pile:bodies=1e9"}), 2, {"it would need about 5 TB of memory"});
  expect_refused(run_atoll({"verify", "pile:bodies=1e9"}), 2, {"it would need about 5 TB of memory"});
}

TEST(CommandMemory, WhatIsAllowedButDoesNotFitIsRefused) {
  if (!limits_hold) GTEST_SKIP() << "no limit of address space with a sanitizer";
  // 20100 boxes: 100 MB, of 80 MB less what the program has.
  expect_refused(run_within("80000", "wall:base=200"), 2,
                 {"wall:base=200", "needs about 100 MB of memory", "are free"});
  EXPECT_EQ(run_within("2000000", "wall:base=200").status, 0);
  expect_refused(run_within("1000000", "rocks:bodies=100000"), 2, {"needs about 1.7 GB of memory"});
}

std::string file_of(const std::string& content) {
  return R"({"format": "atoll-scene", "version": 1, )" + content + "}";
}

TEST(CommandMemory, FilesAreCountedBeforeTheyAreBuilt) {
  const ScratchDirectory scratch;
  const auto generator = [&](const char* name, const std::string& more) {
    return scratch.write(
        name, file_of(R"("generators": [{"body": {"shape": {"type": "sphere", "radius": 1}}, )" + more + "}]"));
  };
  expect_refused(run_atoll({"run", generator("huge.json", R"("count": [1000, 1000, 1000])")}), 3,
                 {"/generators/0/count", "1000000000 bodies, which need about 5 TB of memory", "at most 10000000"});
  if (!limits_hold) GTEST_SKIP() << "no limit of address space with a sanitizer";
  const std::string layers = generator("layers.json", R"("count": [100, 100, 10], "copies": {"count": [1, 1, 5]})");
  expect_refused(run_within("1000000", layers), 3, {"layers.json", "its 500000 bodies need about 2.5 GB of memory"});
  // 1 + 4 + 9 + ... + 100 * 100
  const std::string pyramid = generator("pyramid.json", R"("count": [100, 100, 100], "taper": [1, 1])");
  expect_refused(run_within("1000000", pyramid), 3, {"its 338350 bodies need about 1.69 GB of memory"});

  std::string bodies;
  constexpr int hulls = 2000;
  for (int i = 0; i < hulls; ++i) {
    const std::string size = std::to_string(1 + 1e-3 * i);
    bodies += (i == 0 ? "" : ", ") + std::string(R"({"shape": {"type": "hull", "points": [)");
    for (int point = 0; point < 100; ++point) {
      const std::string x = std::to_string(point % 10), y = std::to_string(point / 10);
      bodies += "[" + x + ", " + y + ", " + (point % 2 == 0 ? "0" : size) + "], ";
    }
    bodies += "[0, 0, 1]]}}";
  }
  const std::string unique = scratch.write("hulls.json", file_of("\"bodies\": [" + bodies + "]"));
  expect_refused(run_within("150000", unique), 3, {"its 2000 bodies need about 90.8 MB of memory"});
}

}  // namespace
}  // namespace atl::test
