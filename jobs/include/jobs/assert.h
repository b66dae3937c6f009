#pragma once

#include <initializer_list>

/// Stops the program where an invariant doesn't hold, and prints the condition and the values that are named after it:
///
///   ATL_ASSERT(slot < count, slot, count);
///   solver/src/x.cpp:12: atoll asserts slot < count; [slot, count] = [12, 8]
///
/// The values are numbers. Builds with ATOLL_ASSERTS check this: those of the presets debug, asan, tsan and fuzz, and
/// those of continuous integration. Elsewhere neither the condition nor the values are evaluated.
#if ATOLL_ASSERTS
#define ATL_ASSERT(condition, ...) \
  ((condition) ? void() : ::atl::jobs::assertion_failed(__FILE__, __LINE__, #condition, #__VA_ARGS__, {__VA_ARGS__}))
#else
#define ATL_ASSERT(condition, ...) ((void)sizeof(::atl::jobs::unevaluated(condition __VA_OPT__(, ) __VA_ARGS__)))
#endif

namespace atl::jobs {

/// For checks that take more than a condition: loops over what a phase has made.
#if ATOLL_ASSERTS
inline constexpr bool with_asserts = true;
#else
inline constexpr bool with_asserts = false;
#endif

/// A number as the message of a failed assertion shows it.
struct AssertedValue {
  // Implicit, so that numbers of several types stand in one list.
  template <class Number>
  AssertedValue(Number number) : value(static_cast<double>(number)) {}  // NOLINT(google-explicit-constructor)
  double value;
};

/// Prints the message to stderr and aborts. `names` are the values' expressions, separated by commas.
[[noreturn]] void assertion_failed(const char* file, int line, const char* condition, const char* names,
                                   std::initializer_list<AssertedValue> values);

// Declared so that what only assertions use counts as used in builds that leave them out.
template <class... Values>
char unevaluated(const Values&... values);

}  // namespace atl::jobs
