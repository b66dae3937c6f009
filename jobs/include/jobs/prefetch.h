#pragma once

#include <cstddef>

namespace atl::jobs {

inline constexpr std::size_t cache_line = 64;  ///< bytes

/// Asks memory for an object that will be needed soon, from a byte of it on. Where it isn't inlined, GCC takes it for a
/// function without effect and drops the call.
template <typename T>
[[gnu::always_inline]] inline void prefetch(const T& object, std::size_t from = 0) {
  const auto* bytes = reinterpret_cast<const char*>(&object);
  for (std::size_t at = from; at < sizeof(T); at += cache_line) __builtin_prefetch(bytes + at);
}

}  // namespace atl::jobs
