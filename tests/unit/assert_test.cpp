#include <gtest/gtest.h>
#include <jobs/assert.h>

#include <cstddef>

namespace atl::jobs {
namespace {

TEST(Assert, TellsTheConditionAndItsValues) {
  const std::size_t slot = 12;
  const int count = 8;
  EXPECT_DEATH(assertion_failed("contacts.cpp", 7, "slot < count", "slot, count, 0.5", {slot, count, 0.5}),
               "contacts.cpp:7: atoll asserts slot < count; \\[slot, count, 0.5\\] = \\[12, 8, 0.5\\]");
}

TEST(Assert, StopsOrCostsNothing) {
  int evaluations = 0;
  const auto holds = [&evaluations](bool value) {
    ++evaluations;
    return value;
  };
  ATL_ASSERT(holds(true));
  EXPECT_EQ(evaluations, with_asserts ? 1 : 0);
  if constexpr (with_asserts) {
    EXPECT_DEATH(ATL_ASSERT(holds(false), evaluations), "atoll asserts holds\\(false\\); \\[evaluations\\] = \\[2\\]");
  }
}

}  // namespace
}  // namespace atl::jobs
