#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

namespace atl::view {

/// Numbers as text that a page can take apart: little-endian bytes, deflated (zlib, RFC 1950), in base64.
class Packer {
 public:
  template <typename Number>
  void add(Number value) {
    static_assert(std::is_arithmetic_v<Number>);
    add(&value, sizeof value);
  }
  /// Of numbers as they are in memory.
  void add(const void* data, std::size_t size) {
    const auto* bytes = static_cast<const std::uint8_t*>(data);
    bytes_.insert(bytes_.end(), bytes, bytes + size);
  }
  enum class Likes { Repeats, Runs };  ///< what is sought in the bytes: any that come again, or runs of one
  std::string text(Likes likes = Likes::Repeats) const;

 private:
  std::vector<std::uint8_t> bytes_;
};

}  // namespace atl::view
