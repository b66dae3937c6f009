#include <gtest/gtest.h>
#include <jobs/compact_array.h>

#include <string>

namespace atl::jobs {
namespace {

TEST(CompactArray, AnEntryMayBeAppendedToItsOwnArray) {
  CompactArray<std::string> names;
  names.push_back("a name that is too long to be kept within a string");
  while (names.size() < 100) names.push_back(names.front());
  for (const std::string& name : names) EXPECT_EQ(name, names[0]);
}

}  // namespace
}  // namespace atl::jobs
