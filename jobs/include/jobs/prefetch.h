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

inline std::size_t lines_of(std::size_t bytes) { return (bytes + cache_line - 1) / cache_line; }

/// Asks for so many lines from a place on, to be there later rather than at once.
[[gnu::always_inline]] inline void prefetch_lines(const void* from, std::size_t lines) {
  constexpr int read = 0, second_level = 2;
  const auto* bytes = static_cast<const char*>(from);
  for (std::size_t i = 0; i < lines; ++i) __builtin_prefetch(bytes + i * cache_line, read, second_level);
}

}  // namespace atl::jobs
