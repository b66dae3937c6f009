#pragma once

#include <atoll/world.h>

#include <string>
#include <type_traits>

#include "checks/soak/soak.h"

namespace atl::soak {

/// Two worlds that get the same calls, of which nothing may come out different: other threads, and another instruction
/// set where the machine has one.
class Twin {
 public:
  Twin(int threads, int other_threads, Simd other_simd)
      : first_({.threads = threads, .settings = with_events(Simd::Auto)}),
        second_({.threads = other_threads, .settings = with_events(other_simd)}) {}

  const World& world() const { return first_; }
  World& first() { return first_; }
  World& second() { return second_; }
  const World& second() const { return second_; }

  /// Makes a call in both, and returns what both came to. Throws CheckFailed if that isn't the same.
  template <typename Call>
  auto each(const Call& call) {
    if constexpr (std::is_void_v<decltype(call(first_))>) {
      call(first_);
      call(second_);
    } else {
      const auto result = call(first_);
      if (!(call(second_) == result)) throw CheckFailed("a call came to something else in the second world");
      return result;
    }
  }

  /// Throws CheckFailed, naming the first body that differs, unless the two states have the same hash.
  void compare() const;

 private:
  static Settings with_events(Simd simd) { return {.sleeping = true, .contact_events = true, .simd = simd}; }

  World first_;
  World second_;
};

}  // namespace atl::soak
