// Every case of the suite of physical laws is right, but for what is known not to be, which still isn't.

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "checks/physics/suite.h"
#include "support/long_tests.h"
#include "support/scenes.h"

namespace atl::physics {

// Prints a case for GoogleTest.
void PrintTo(const PhysicsCase& test, std::ostream* out) { *out << test.name; }

}  // namespace atl::physics

namespace atl::test::physics_suite_test {
namespace {

using physics::PhysicsCase;
using physics::PhysicsResult;

class PhysicsSuite : public testing::TestWithParam<PhysicsCase> {};

// Flows of thousands of grains, which take tens of seconds of a core.
const std::set<std::string> long_cases = {"beverloo", "janssen", "force-tail"};

TEST_P(PhysicsSuite, IsRight) {
  const PhysicsCase& test = GetParam();
  if (long_cases.contains(test.name) && !long_tests()) GTEST_SKIP() << "a test of --long";
  const PhysicsResult result = run_case(test);
  const auto found = testing::Message() << test.name << " (" << test.what << "): " << result.value << " " << test.unit
                                        << ", right is " << test.right << ", error " << result.error;
  if (test.known_failure.empty()) {
    EXPECT_TRUE(result.holds(test)) << found;
  } else {
    EXPECT_FALSE(result.holds(test)) << found << ": no longer fails, so it is to be taken off the known failures ("
                                     << test.known_failure << ")";
  }
}

INSTANTIATE_TEST_SUITE_P(All, PhysicsSuite, testing::ValuesIn(physics::physics_cases()),
                         [](const auto& test) { return case_name(test.param.name); });

// Takes a minute.
TEST(PhysicsCases, GetNoWorseInFinerSteps) {
  if (!long_tests()) GTEST_SKIP() << "a test of --long";
  for (const PhysicsCase& test : physics::physics_cases()) {
    if (test.statistical) continue;
    const PhysicsResult runs[] = {run_case(test), run_case(test, test.dt / 64)};
    EXPECT_TRUE(expected(test, runs)) << test.name << ": " << runs[0].error << ", at a 64th of its step "
                                      << runs[1].error << ". " << test.known_growth;
  }
}

TEST(PhysicsCases, HaveNamesSourcesAndLimits) {
  std::set<std::string> names;
  for (const PhysicsCase& test : physics::physics_cases()) {
    EXPECT_TRUE(names.insert(test.name).second) << test.name << " is there twice";
    EXPECT_FALSE(test.what.empty()) << test.name;
    EXPECT_FALSE(test.source.empty()) << test.name;
    EXPECT_GT(test.limit, 0) << test.name;
    EXPECT_GT(test.scale, 0) << test.name;
  }
}

}  // namespace
}  // namespace atl::test::physics_suite_test
