#pragma once

#include <cstddef>

namespace atl::jobs {

/// Resizes an array that mostly grows by one, which is then a store and no call, as std::vector::resize is: a body that
/// is added appends to some forty arrays.
template <typename Array>
[[gnu::always_inline]] inline void append(Array& array, std::size_t count,
                                          const typename Array::value_type& value = typename Array::value_type()) {
  if (count == array.size() + 1) {
    array.push_back(value);
  } else {
    array.resize(count, value);
  }
}

}  // namespace atl::jobs
