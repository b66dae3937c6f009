#include "view/packed.h"

#include <atoll/error.h>
#include <zlib.h>

#include <bit>
#include <string_view>

namespace atl::view {
namespace {

static_assert(std::endian::native == std::endian::little);

// Fast, and within a tenth of what level 9 comes to.
constexpr int level = 4;

std::vector<std::uint8_t> deflated(const std::vector<std::uint8_t>& bytes) {
  uLongf size = compressBound(bytes.size());
  std::vector<std::uint8_t> result(size);
  if (compress2(result.data(), &size, bytes.data(), bytes.size(), level) != Z_OK) {
    throw Error("the film could not be compressed: out of memory");
  }
  result.resize(size);
  return result;
}

std::string base64(const std::vector<std::uint8_t>& bytes) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (k < count ? bytes[i + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? digits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

}  // namespace

std::string Packer::text() const { return base64(deflated(bytes_)); }

}  // namespace atl::view
