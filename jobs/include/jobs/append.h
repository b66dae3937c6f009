#pragma once

#include <cstddef>
#include <vector>

namespace atl::jobs {

/// Resizes an array that mostly grows by one: then it is that much faster than std::vector::resize, which is a call,
/// that a world of many arrays fills twice as fast.
template <typename T>
void append(std::vector<T>& array, std::size_t count, const T& value = T()) {
  if (count == array.size() + 1) {
    array.push_back(value);
  } else {
    array.resize(count, value);
  }
}

}  // namespace atl::jobs
