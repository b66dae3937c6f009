#pragma once

#include <cstddef>
#include <vector>

namespace atl::jobs {

/// Memory that arrays hold, used or not.
template <typename... T>
std::size_t bytes_of(const std::vector<T>&... arrays) {
  return (std::size_t{0} + ... + (arrays.capacity() * sizeof(T)));
}

}  // namespace atl::jobs
