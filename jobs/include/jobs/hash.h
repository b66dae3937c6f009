#pragma once

#include <bit>
#include <cstdint>

namespace atl::jobs {

/// 64-bit hash over words: multiply and fold, as in wyhash (Wang Yi, public domain), whose mixing step this is.
class Hash {
 public:
  void add(std::uint64_t word) {
    const __uint128_t product = static_cast<__uint128_t>(state_ ^ word) * 0xa0761d6478bd642fu;
    state_ = (static_cast<std::uint64_t>(product) ^ static_cast<std::uint64_t>(product >> 64)) + 0xe7037ed1a0b428dbu;
  }
  void add(double value) { add(std::bit_cast<std::uint64_t>(value)); }

  template <typename Numbers>
  void add_all(const Numbers& numbers) {
    for (const auto& number : numbers) add(number);
  }

  std::uint64_t value() const { return state_; }

 private:
  std::uint64_t state_ = 0x9e3779b97f4a7c15u;
};

}  // namespace atl::jobs
