#pragma once
/// Visits all arrays that an object holds. Its arrays() tells them, as std::tie of its arrays and of parts that have
/// arrays() themselves.

#include <jobs/compact_array.h>

#include <cstddef>
#include <memory>
#include <tuple>
#include <vector>

namespace atl::jobs {

template <typename T, typename Visit>
requires requires(const T& object) { object.arrays(); }
void for_each_array(const T& object, const Visit& visit);

/// Calls visit(array) for each of the arrays, std::vectors or CompactArrays.
template <typename T, typename Visit>
void for_each_array(const std::vector<T>& array, const Visit& visit) {
  visit(array);
}
template <typename T, typename Visit>
void for_each_array(const CompactArray<T>& array, const Visit& visit) {
  visit(array);
}
template <typename... T, typename Visit>
void for_each_array(const std::tuple<T...>& parts, const Visit& visit) {
  std::apply([&visit](const auto&... part) { (for_each_array(part, visit), ...); }, parts);
}
template <typename T, typename Visit>
requires requires(const T& object) { object.arrays(); }
void for_each_array(const T& object, const Visit& visit) { for_each_array(object.arrays(), visit); }

template <typename... T>
std::size_t bytes_of(const T&... objects);

/// The memory in bytes that an entry of an array owns outside of the array itself.
template <typename T>
std::size_t bytes_beside(const T& entry) {
  if constexpr (requires { for_each_array(entry, [](const auto&) {}); }) return bytes_of(entry);
  return 0;
}
template <typename T>
std::size_t bytes_beside(const std::unique_ptr<T>& entry) {
  return entry == nullptr ? 0 : sizeof(T) + bytes_beside(*entry);
}

/// Memory that arrays of these objects hold, used or not.
template <typename... T>
std::size_t bytes_of(const T&... objects) {
  std::size_t bytes = 0;
  const auto add = [&bytes](const auto& array) {
    bytes += array.capacity() * sizeof(array[0]);
    for (const auto& entry : array) bytes += bytes_beside(entry);
  };
  (for_each_array(objects, add), ...);
  return bytes;
}

}  // namespace atl::jobs
