#pragma once
/// Expects an Error whose message holds certain words.

#include <atoll/error.h>
#include <gtest/gtest.h>

#include <functional>
#include <initializer_list>
#include <string>
#include <string_view>

namespace atl::test {

inline void expect_error(const std::function<void()>& call, std::initializer_list<std::string_view> words) {
  try {
    call();
    ADD_FAILURE() << "expected an Error that names " << *words.begin();
  } catch (const Error& error) {
    const std::string message = error.what();
    for (std::string_view word : words) {
      EXPECT_NE(message.find(word), std::string::npos) << "'" << message << "' does not hold '" << word << "'";
    }
  }
}

}  // namespace atl::test
