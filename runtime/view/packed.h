#pragma once

#include <cstddef>
#include <cstdint>
#include <future>
#include <string>
#include <type_traits>
#include <vector>

namespace atl::view {

/// RFC 4648, section 4.
std::string base64(const std::vector<std::uint8_t>& bytes);

/// Numbers as text that a page can take apart: little-endian bytes, deflated (zlib, RFC 1950), in base64.
class Packer {
 public:
  template <typename Number>
  void add(Number value) {
    static_assert(std::is_arithmetic_v<Number>);
    add(&value, sizeof value);
  }
  /// Adds numbers as they are in memory.
  void add(const void* data, std::size_t size) {
    const auto* bytes = static_cast<const std::uint8_t*>(data);
    bytes_.insert(bytes_.end(), bytes, bytes + size);
  }
  enum class Likes { Repeats, Runs };  ///< what is sought in the bytes: any that come again, or runs of one
  std::string text(Likes likes = Likes::Repeats) const;

 private:
  std::vector<std::uint8_t> bytes_;
};

/// Texts that threads of their own make while the caller goes on, in the order in which they were added.
class PackedTexts {
 public:
  void add(Packer packer, Packer::Likes likes);
  /// All since the last call. Throws Error where one could not be made.
  std::vector<std::string> take();

 private:
  std::vector<std::future<std::string>> texts_;
};

}  // namespace atl::view
