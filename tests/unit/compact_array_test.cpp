#include <gtest/gtest.h>
#include <jobs/compact_array.h>

#include <random>
#include <string>
#include <utility>
#include <vector>

namespace atl::jobs {
namespace {

TEST(CompactArray, AnEntryMayBeAppendedToItsOwnArray) {
  CompactArray<std::string> names;
  names.push_back("a name that is too long to be kept within a string");
  while (names.size() < 100) names.push_back(names.front());
  for (const std::string& name : names) EXPECT_EQ(name, names[0]);
}

// The same random calls as of a vector, of entries that own memory.
TEST(CompactArray, DoesWhatAVectorDoes) {
  std::mt19937 random(7);
  CompactArray<std::string> array;
  std::vector<std::string> vector;
  const auto number = [&random](std::size_t below) { return random() % below; };
  for (int i = 0; i < 20000; ++i) {
    const std::string text = "entry number " + std::to_string(i) + " of all";
    const std::size_t size = vector.size();
    switch (number(10)) {
      case 0:
        array.resize(number(40));
        vector.resize(array.size());
        break;
      case 1:
        array.assign(size / 2, text);
        vector.assign(size / 2, text);
        break;
      case 2: {
        const auto at = static_cast<std::ptrdiff_t>(number(size + 1));
        array.insert(array.begin() + at, text);
        vector.insert(vector.begin() + at, text);
        break;
      }
      case 3: {
        const std::vector<std::string> more(number(5), text);
        const auto at = static_cast<std::ptrdiff_t>(number(size + 1));
        array.insert(array.begin() + at, more.begin(), more.end());
        vector.insert(vector.begin() + at, more.begin(), more.end());
        break;
      }
      case 4: {
        const auto end = static_cast<std::ptrdiff_t>(number(size + 1));
        const auto begin = static_cast<std::ptrdiff_t>(number(static_cast<std::size_t>(end) + 1));
        array.erase(array.begin() + begin, array.begin() + end);
        vector.erase(vector.begin() + begin, vector.begin() + end);
        break;
      }
      case 5: {
        const auto is_odd = [](const std::string& entry) { return entry.size() > 13 && entry[13] % 2 == 1; };
        EXPECT_EQ(erase_if(array, is_odd), std::erase_if(vector, is_odd));
        break;
      }
      case 6: {
        CompactArray<std::string> copy(array);
        array = std::move(copy);
        break;
      }
      default:
        array.push_back(text);
        vector.push_back(text);
    }
    ASSERT_TRUE(std::equal(array.begin(), array.end(), vector.begin(), vector.end())) << "call " << i;
    ASSERT_GE(array.capacity(), array.size());
  }
}

}  // namespace
}  // namespace atl::jobs
