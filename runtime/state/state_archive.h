#pragma once
/// Archives that walk over a world's state: world_state.h describes the state once, and each archive writes, reads or
/// hashes it.

#include <atoll/error.h>
#include <jobs/hash.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace atl {

template <typename T>
concept StateScalar = std::is_arithmetic_v<T> || std::is_enum_v<T>;  // std::byte is one

// Each kind of archive has
//   value(x)           a number, flag or enumerator
//   values(data, n)    numbers in a row; how many is known without asking
//   list(array)        as many as there are
//   bits(array)        flags that are 0 or 1, as many as the array has
//   small(x)           a number that is mostly below 128
//   rows<W>(v, rest)   rows of W numbers each, as many as the array has, most of which may be as `rest`
// and `reads`, whether that changes what is walked over, and `hashes`.

/// Writes into bytes, from their beginning on. They grow where needed and never shrink.
class StateWriter {
 public:
  static constexpr bool reads = false;
  static constexpr bool hashes = false;

  explicit StateWriter(std::vector<std::byte>& bytes) : bytes_(bytes), at_(bytes.data()), end_(at_ + bytes.size()) {}

  std::size_t size() const { return static_cast<std::size_t>(at_ - bytes_.data()); }

  template <StateScalar T>
  void value(const T& value) {
    put(&value, sizeof(T));
  }
  template <StateScalar T>
  void values(const T* data, std::size_t count) {
    put(data, count * sizeof(T));
  }
  void list(const auto& all) {
    value(static_cast<std::uint32_t>(all.size()));
    values(all.data(), all.size());
  }
  // Seven bits a byte, the lowest first; the eighth says that more follow.
  void small(std::uint32_t value) {
    make_room(5);
    for (; value > 0x7f; value >>= 7) *at_++ = static_cast<std::byte>(value | 0x80);
    *at_++ = static_cast<std::byte>(value);
  }
  void bits(std::span<const std::uint8_t> flags) {
    for (std::size_t begin = 0; begin < flags.size(); begin += 64) {
      std::uint64_t word = 0;
      for (std::size_t i = begin; i < std::min(begin + 64, flags.size()); ++i) {
        word |= std::uint64_t{flags[i] != 0} << (i - begin);
      }
      value(word);
    }
  }
  template <std::size_t width, typename Rows>
  void rows(const Rows& all, const std::array<typename Rows::value_type, width>& rest) {
    using T = typename Rows::value_type;
    constexpr std::size_t row = width * sizeof(T);
    const std::size_t count = all.size() / width;
    for (std::size_t begin = 0; begin < count; begin += 64) {
      make_room(sizeof(std::uint64_t) + 64 * row);
      std::byte* const mask_at = at_;
      at_ += sizeof(std::uint64_t);
      std::uint64_t mask = 0;
      for (std::size_t i = begin; i < std::min(begin + 64, count); ++i) {
        const T* from = all.data() + i * width;
        std::memcpy(at_, from, row);
        const bool stands = std::memcmp(from, rest.data(), row) != 0;
        mask |= std::uint64_t{stands} << (i - begin);
        at_ += stands ? row : 0;
      }
      std::memcpy(mask_at, &mask, sizeof mask);
    }
  }
  void check(bool, const char*) {}

 private:
  void make_room(std::size_t count) {
    if (static_cast<std::size_t>(end_ - at_) < count) grow(count);
  }
  void grow(std::size_t count) {
    const std::size_t used = size();
    bytes_.resize(std::max(used + count, 2 * bytes_.size()));
    at_ = bytes_.data() + used;
    end_ = bytes_.data() + bytes_.size();
  }
  void put(const void* data, std::size_t count) {
    make_room(count);
    if (count > 0) std::memcpy(at_, data, count);
    at_ += count;
  }

  std::vector<std::byte>& bytes_;
  std::byte* at_;
  std::byte* end_;
};

/// The source that a StateReader reads, as messages name it.
struct StateSource {
  const char* prefix = "Snapshot: ";
  const char* what = "state";
  const char* writer = "World::save";
  bool from_file = false;  ///< then it may come of a program that writes nonsense, or of somebody who means harm
};

/// Reads what a StateWriter wrote. Throws Error where that can't be what it is given; check() likewise.
class StateReader {
 public:
  static constexpr bool reads = true;
  static constexpr bool hashes = false;

  explicit StateReader(std::span<const std::byte> bytes, const StateSource& source = {})
      : source_(source), begin_(bytes.data()), at_(begin_), end_(begin_ + bytes.size()) {}

  std::size_t left() const { return static_cast<std::size_t>(end_ - at_); }

  template <StateScalar T>
  void value(T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      std::uint8_t byte = 0;
      take(&byte, 1);
      check(byte <= 1, "a flag that is neither 0 nor 1");
      value = byte != 0;
    } else {
      take(&value, sizeof(T));
    }
  }
  template <StateScalar T>
  void values(T* data, std::size_t count) {
    check(count <= left() / sizeof(T), "the end of the data");
    take(data, count * sizeof(T));
  }
  void list(auto& all) {
    all.resize(count_of(sizeof(all[0])));
    values(all.data(), all.size());
  }
  void small(std::uint32_t& value) {
    value = 0;
    for (unsigned shift = 0; shift < 32; shift += 7) {
      check(at_ != end_, "the end of the data");
      const auto byte = static_cast<std::uint32_t>(*at_++);
      value |= (byte & 0x7f) << shift;
      if (byte < 0x80) return;
    }
    fail("a number that is too long");
  }
  void bits(std::span<std::uint8_t> flags) {
    for (std::size_t begin = 0; begin < flags.size(); begin += 64) {
      std::uint64_t word = 0;
      value(word);
      for (std::size_t i = begin; i < std::min(begin + 64, flags.size()); ++i) flags[i] = word >> (i - begin) & 1;
    }
  }
  template <std::size_t width, typename Rows>
  void rows(Rows& all, const std::array<typename Rows::value_type, width>& rest) {
    using T = typename Rows::value_type;
    constexpr std::size_t row = width * sizeof(T);
    const std::size_t count = all.size() / width;
    for (std::size_t begin = 0; begin < count; begin += 64) {
      std::uint64_t mask = 0;
      value(mask);
      check(static_cast<std::size_t>(std::popcount(mask)) * row <= left(), "the end of the data");
      for (std::size_t i = begin; i < std::min(begin + 64, count); ++i) {
        const bool stands = (mask >> (i - begin) & 1) != 0;
        std::memcpy(all.data() + i * width, stands ? static_cast<const void*>(at_) : rest.data(), row);
        at_ += stands ? row : 0;
      }
    }
  }

  /// A number of things that take so many bytes each, at least.
  std::uint32_t count_of(std::size_t bytes_each) {
    std::uint32_t count = 0;
    value(count);
    check(count <= left() / bytes_each, "a number of things that can't all be there");
    return count;
  }
  /// Passes by the bytes given if they are what comes next.
  bool skip_if_same(std::span<const std::byte> bytes) {
    if (bytes.size() > left() || std::memcmp(at_, bytes.data(), bytes.size()) != 0) return false;
    at_ += bytes.size();
    return true;
  }
  void check(bool holds, const char* found) const {
    if (!holds) fail(found);
  }
  /// Refuses numbers that no world has. Only files are checked: a world of this process may have written any number.
  void check_number(bool holds, const char* found) const { check(holds || !source_.from_file, found); }

 private:
  [[noreturn]] void fail(const char* found) const {
    throw Error(std::string(source_.prefix) + "found " + found + " at byte " + std::to_string(at_ - begin_) +
                " of the " + source_.what + "; expected what " + source_.writer + " wrote");
  }
  void take(void* data, std::size_t count) {
    check(count <= left(), "the end of the data");
    if (count > 0) std::memcpy(data, at_, count);
    at_ += count;
  }

  StateSource source_;
  const std::byte* begin_;
  const std::byte* at_;
  const std::byte* end_;
};

/// Hashes numbers by their values.
class StateHash {
 public:
  static constexpr bool reads = false;
  static constexpr bool hashes = true;

  std::uint64_t result() const { return hash_.value(); }

  template <StateScalar T>
  void value(const T& value) {
    if constexpr (std::is_same_v<T, double>) {
      hash_.add(value);
    } else if constexpr (std::is_same_v<T, float>) {
      hash_.add(std::uint64_t{std::bit_cast<std::uint32_t>(value)});
    } else {
      hash_.add(static_cast<std::uint64_t>(value));
    }
  }
  template <StateScalar T>
  void values(const T* data, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) value(data[i]);
  }
  void list(const auto& all) {
    hash_.add(std::uint64_t{all.size()});
    values(all.data(), all.size());
  }
  void bits(std::span<const std::uint8_t> flags) { list(flags); }
  template <std::size_t width, typename Rows>
  void rows(const Rows& all, const std::array<typename Rows::value_type, width>&) {
    list(all);
  }
  void check(bool, const char*) {}

 private:
  jobs::Hash hash_;
};

template <typename Archive, typename Optional, typename Visit>
void visit_optional(Archive& archive, Optional& optional, const Visit& visit) {
  bool is_there = optional.has_value();
  archive.value(is_there);
  if constexpr (Archive::reads) {
    optional.reset();
    if (is_there) optional.emplace();
  }
  if (is_there) visit(*optional);
}

/// Visits a number, an id, a vector, quaternion, matrix, array or pose, or what may be one of these.
template <typename Archive, typename Value>
void visit_value(Archive& archive, Value& value) {
  using T = std::remove_const_t<Value>;
  if constexpr (StateScalar<T>) {
    archive.value(value);
  } else if constexpr (requires { value.has_value(); }) {
    visit_optional(archive, value, [&archive](auto& there) { visit_value(archive, there); });
  } else if constexpr (requires { value.generation; }) {
    archive.value(value.index);
    archive.value(value.generation);
  } else if constexpr (requires { value.orientation; }) {
    visit_value(archive, value.position);
    visit_value(archive, value.orientation);
  } else if constexpr (requires { value.coeffs(); }) {
    archive.values(value.coeffs().data(), 4);
  } else {
    static_assert(std::is_trivially_destructible_v<T>);  // of a size that is known
    archive.values(value.data(), static_cast<std::size_t>(value.size()));
  }
}

template <typename Archive, typename... Values>
void visit_all(Archive& archive, Values&... values) {
  (visit_value(archive, values), ...);
}

}  // namespace atl
