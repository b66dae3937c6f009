#pragma once

#include <jobs/append.h>
#include <jobs/arrays.h>
#include <jobs/compact_array.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace atl::jobs {

/// The bits of a value, by which SharedValues tells it from others. A type with padding has an overload of its own, in
/// its namespace.
template <typename T>
std::array<std::uint64_t, sizeof(T) / sizeof(std::uint64_t)> words_of(const T& value) {
  static_assert(sizeof(T) % sizeof(std::uint64_t) == 0);
  std::array<std::uint64_t, sizeof(T) / sizeof(std::uint64_t)> words;
  std::memcpy(words.data(), static_cast<const void*>(&value), sizeof(T));
  return words;
}

/// Compares words without branches: compilers make it a few vector instructions, where a comparison of arrays is a
/// call.
template <typename T>
bool same_bits(const T& a, const T& b) {
  const auto x = words_of(a), y = words_of(b);
  std::uint64_t differing = 0;
  for (std::size_t i = 0; i < x.size(); ++i) differing |= x[i] ^ y[i];
  return differing == 0;
}

/// An array of values of which most are like others, bit for bit: each is kept once, and an entry takes four bytes. To
/// read one is as fast as from a plain array, or faster where few values are in use. A value that no entry has any more
/// makes room for another.
template <typename T>
class SharedValues {
 public:
  SharedValues() : SharedValues(T()) {}
  /// `rest` is what entries are until they are set.
  explicit SharedValues(const T& rest) : values_(1, rest), uses_(1, 1) {}

  std::size_t size() const { return numbers_.size(); }
  const T& operator[](std::size_t entry) const { return values_[numbers_[entry]]; }

  /// Makes it longer.
  void resize(std::size_t count) { append(numbers_, count, std::uint32_t{0}); }

  void set(std::size_t entry, const T& value) {
    const std::uint32_t before = numbers_[entry];
    if (same_bits(values_[before], value)) return;
    const std::uint32_t number = find_or_add(value);
    if (number != 0) ++uses_[number];
    numbers_[entry] = number;
    if (before != 0 && --uses_[before] == 0) drop(before);
  }

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(numbers_, values_, uses_, free_, table_); }

 private:
  static constexpr std::uint32_t vacant = ~std::uint32_t{0};

  // Multiplied and folded, as in jobs/hash.h, but each word by itself, so that none waits for another.
  std::size_t home(const T& value) const {
    std::uint64_t hash = 0;
    std::uint64_t salt = 0x9e3779b97f4a7c15u;
    for (const std::uint64_t word : words_of(value)) {
      const __uint128_t product = static_cast<__uint128_t>(word ^ salt) * 0xa0761d6478bd642fu;
      hash += static_cast<std::uint64_t>(product) ^ static_cast<std::uint64_t>(product >> 64);
      salt += 0xe7037ed1a0b428dbu;
    }
    return static_cast<std::size_t>((hash * 0x9e3779b97f4a7c15u) >> 20) & (table_.size() - 1);
  }
  std::size_t next(std::size_t place) const { return (place + 1) & (table_.size() - 1); }

  std::uint32_t find_or_add(const T& value) {
    // Entries that come one after the other are often alike.
    if (same_bits(values_[last_], value)) return last_;
    if (same_bits(values_[0], value)) return 0;
    if (is_hashed() && 2 * (values_.size() - free_.size() + 1) > table_.size()) grow();
    std::size_t place = 0;
    if (is_hashed()) {
      for (place = home(value); table_[place] != vacant; place = next(place)) {
        if (same_bits(values_[table_[place]], value)) return last_ = table_[place];
      }
    } else {
      for (std::uint32_t number = 1; number < values_.size(); ++number) {
        if (uses_[number] > 0 && same_bits(values_[number], value)) return last_ = number;
      }
    }
    std::uint32_t number = static_cast<std::uint32_t>(values_.size());
    if (free_.empty()) {
      values_.push_back(value);
      uses_.push_back(0);
    } else {
      number = free_.back();
      free_.pop_back();
      values_[number] = value;
    }
    if (is_hashed()) table_[place] = number;
    if (!is_hashed() && values_.size() > few) grow();
    return last_ = number;
  }

  // Backward-shift deletion, as in PairSet.
  void drop(std::uint32_t number) {
    if (last_ == number) last_ = 0;
    free_.push_back(number);
    if (!is_hashed()) return;
    std::size_t hole = home(values_[number]);
    while (table_[hole] != number) hole = next(hole);
    for (std::size_t place = next(hole); table_[place] != vacant; place = next(place)) {
      const std::size_t wanted = home(values_[table_[place]]);
      if (((place - wanted) & (table_.size() - 1)) < ((place - hole) & (table_.size() - 1))) continue;
      table_[hole] = table_[place];
      hole = place;
    }
    table_[hole] = vacant;
  }

  // So many values are compared one by one, without a table.
  static constexpr std::size_t few = 8;
  bool is_hashed() const { return !table_.empty(); }

  void grow() {
    CompactArray<std::uint32_t> all;
    if (is_hashed()) {
      std::copy_if(table_.begin(), table_.end(), std::back_inserter(all), [](std::uint32_t n) { return n != vacant; });
    } else {
      for (std::uint32_t number = 1; number < values_.size(); ++number) all.push_back(number);
    }
    table_.assign(is_hashed() ? 2 * table_.size() : 4 * few, vacant);
    for (const std::uint32_t number : all) {
      std::size_t place = home(values_[number]);
      while (table_[place] != vacant) place = next(place);
      table_[place] = number;
    }
  }

  CompactArray<std::uint32_t> numbers_;  // by entry: of its value
  CompactArray<T> values_;               // the first is that of entries which were never set
  CompactArray<std::uint32_t> uses_;     // by value: entries that have it
  CompactArray<std::uint32_t> free_;     // numbers of values that none has
  CompactArray<std::uint32_t> table_;    // numbers of the others but the first; open addressing, at most half full
  std::uint32_t last_ = 0;               // the last value that was set
};

}  // namespace atl::jobs
