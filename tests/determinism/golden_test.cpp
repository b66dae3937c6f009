// Every build comes to the same bits: state hashes after some steps against a file, with every instruction set of the
// machine.

#include "golden/golden.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include "state/hex.h"
#include "support/variants.h"

namespace atl::test::golden_test {
namespace {

const char* compiler() {
#ifdef __clang__
  return "clang " __clang_version__;
#else
  return "gcc " __VERSION__;
#endif
}

// Without optimisation a step takes a hundred times as long, so the first steps have to do.
#ifdef __OPTIMIZE__
constexpr std::size_t step_count = std::size(golden_steps);
const std::vector<int> thread_counts = {2, 1};
#else
constexpr std::size_t step_count = std::size(golden_steps) - 1;
const std::vector<int> thread_counts = {2};
#endif

class Golden : public testing::TestWithParam<GoldenCase> {};

TEST_P(Golden, HashesAreThoseOfTheFile) {
  const GoldenHashes expected = read_golden_hashes(golden_path());
  const Scene scene = golden_scene(GetParam());
  for (const divergence::Variant& variant : variants_of(thread_counts)) {
    divergence::VariantRun run(scene, variant);
    for (std::size_t i = 0; i < step_count; ++i) {
      while (run.steps() < golden_steps[i]) run.step();
      const std::string key = golden_key(GetParam(), golden_steps[i]);
      ASSERT_TRUE(expected.contains(key)) << golden_path() << " has no line for \"" << key << "\"";
      ASSERT_EQ(hash_text(run.hash()), hash_text(expected.at(key)))
          << "step " << golden_steps[i] << " of " << GetParam().scene << ", settings \"" << GetParam().settings
          << "\", differs from " << golden_path() << "\nwith " << variant.threads << " threads on "
          << name_of(variant.simd) << ", built by " << compiler()
          << ".\nIf results are meant to change, build and run atoll_write_golden; if not, something depends on "
             "threads, vectors or the compiler: atoll verify tells where.";
    }
  }
}

// Whatever the steps leave out would not have changed a bit.
TEST_P(Golden, HashesAreTheSameIfNothingIsLeftOut) {
  const GoldenHashes expected = read_golden_hashes(golden_path());
  Scene scene = golden_scene(GetParam());
  scene.settings.run_everything = true;
  for (const Simd simd : simds_to_try()) {
    divergence::VariantRun run(scene, {2, simd});
    for (std::size_t i = 0; i < step_count; ++i) {
      while (run.steps() < golden_steps[i]) run.step();
      ASSERT_EQ(hash_text(run.hash()), hash_text(expected.at(golden_key(GetParam(), golden_steps[i]))))
          << "step " << golden_steps[i] << " on " << name_of(simd);
    }
  }
}

std::string case_name(const testing::TestParamInfo<GoldenCase>& info) {
  std::string name = golden_key(info.param, static_cast<std::int64_t>(info.index));
  std::replace_if(
      name.begin(), name.end(), [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
  return name;
}
INSTANTIATE_TEST_SUITE_P(Cases, Golden, testing::ValuesIn(golden_cases()), case_name);

TEST(GoldenFile, HasEveryBuiltInSceneAndNothingElse) {
  std::set<std::string> scenes, keys;
  for (const GoldenCase& golden : golden_cases()) {
    scenes.insert(golden.scene.substr(0, golden.scene.find(':')));
    for (const std::int64_t step : golden_steps) keys.insert(golden_key(golden, step));
  }
  for (const BuiltinScene& scene : builtin_scenes()) EXPECT_TRUE(scenes.contains(scene.name)) << scene.name;
  for (const auto& [key, hash] : read_golden_hashes(golden_path())) EXPECT_TRUE(keys.contains(key)) << key;
}

}  // namespace
}  // namespace atl::test::golden_test
