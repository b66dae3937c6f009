#pragma once
/// Choices made from bytes: the same bytes, the same choices.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>

namespace atl::fuzz {

class Bytes {
 public:
  explicit Bytes(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  bool empty() const { return bytes_.empty(); }

  /// 0 once there are no more.
  std::uint8_t byte() {
    if (bytes_.empty()) return 0;
    const std::uint8_t first = bytes_.front();
    bytes_ = bytes_.subspan(1);
    return first;
  }
  template <typename Number>
  Number bits() {
    std::array<std::uint8_t, sizeof(Number)> raw = {};
    for (std::uint8_t& each : raw) each = byte();
    Number number;
    std::memcpy(&number, raw.data(), sizeof number);
    return number;
  }
  /// In [0, count), count <= 256.
  std::uint32_t below(std::size_t count) { return byte() % static_cast<std::uint32_t>(count); }
  bool flag() { return (byte() & 1) != 0; }
  /// In about one of so many cases.
  bool one_in(std::uint32_t count) { return below(count) == count - 1; }

  /// In [lower, upper].
  double within(double lower, double upper) { return lower + (upper - lower) * (bits<std::uint16_t>() / 65535.0); }

  /// Any double at all, those most of all at which code goes wrong.
  double any() {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    constexpr std::array<double, 40> special = {0.0,
                                                -0.0,
                                                1,
                                                -1,
                                                0.5,
                                                1e-3,
                                                1e-6,
                                                1e-9,
                                                1e-12,
                                                1e-15,
                                                9.9e-16,
                                                1e-30,
                                                1e-45,
                                                1e-100,
                                                1e-155,
                                                5e-324,
                                                2.2250738585072014e-308,
                                                1e3,
                                                1e5,
                                                1e6,
                                                -1e6,
                                                1.1e6,
                                                1e9,
                                                1e12,
                                                -1e12,
                                                1.1e12,
                                                1e15,
                                                -1e15,
                                                1.1e15,
                                                1e19,
                                                1e30,
                                                3.4e38,
                                                3.5e38,
                                                1e154,
                                                1.4e154,
                                                1.7976931348623157e308,
                                                -1.7976931348623157e308,
                                                infinity,
                                                -infinity,
                                                std::numeric_limits<double>::quiet_NaN()};
    const std::uint8_t choice = byte();
    return choice < 200 ? special[choice % special.size()] : bits<double>();
  }

 private:
  std::span<const std::uint8_t> bytes_;
};

}  // namespace atl::fuzz
