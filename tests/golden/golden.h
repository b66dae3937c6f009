#pragma once
/// State hashes that every build must come to: what is run, and the file that they are kept in.

#include <atoll/atoll.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "checks/divergence/variant_run.h"

namespace atl::test {

/// A scene that is small enough to be run many times, and settings by name.
struct GoldenCase {
  std::string scene;
  std::string settings;
};

/// All built-in scenes with default settings and some with others.
const std::vector<GoldenCase>& golden_cases();

/// With the case's settings.
Scene golden_scene(const GoldenCase& golden);

/// Steps after which hashes are kept, in order; the last is the length of a run.
inline constexpr std::int64_t golden_steps[] = {1, 60, 240};

/// Hashes by line but for the hash: "60 defaults wall:base=12".
using GoldenHashes = std::map<std::string, std::uint64_t>;

std::string golden_key(const GoldenCase& golden, std::int64_t step);
std::string golden_path();
/// Throws std::runtime_error naming the line that can't be read.
GoldenHashes read_golden_hashes(const std::string& path);

}  // namespace atl::test
