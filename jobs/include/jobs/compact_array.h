#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>

namespace atl::jobs {

/// The memory of a CompactArray: size and capacity stand ahead of the entries, so that an object takes 8 bytes.
template <typename T>
class CompactMemory {
 public:
  CompactMemory() = default;
  CompactMemory(CompactMemory&& other) noexcept : entries_(std::exchange(other.entries_, nothing())) {}
  CompactMemory& operator=(CompactMemory&& other) noexcept {
    if (this == &other) return *this;
    give_back();
    entries_ = std::exchange(other.entries_, nothing());
    return *this;
  }
  ~CompactMemory() { give_back(); }

  std::size_t size() const { return head()->size; }
  std::size_t capacity() const { return head()->capacity; }

 protected:
  T* entries() const { return entries_; }
  // The head of what has no memory stays as it is.
  void set_size(std::size_t count) {
    if (capacity() > 0) head()->size = static_cast<std::uint32_t>(count);
  }
  // Other memory for so many entries, and those that there are.
  void move_to(std::size_t room) {
    if (room > ~std::uint32_t{0}) throw std::bad_alloc();
    auto* const memory = static_cast<std::byte*>(take(head_bytes + room * sizeof(T)));
    T* const to = reinterpret_cast<T*>(memory + head_bytes);
    std::construct_at(reinterpret_cast<Head*>(to) - 1,
                      Head{static_cast<std::uint32_t>(size()), static_cast<std::uint32_t>(room)});
    std::uninitialized_move(entries_, entries_ + size(), to);
    give_back();
    entries_ = to;
  }

 private:
  struct Head {
    std::uint32_t size;
    std::uint32_t capacity;
  };
  static constexpr std::size_t alignment = std::max(alignof(T), alignof(Head));
  static constexpr std::size_t head_bytes = std::max(alignof(T), sizeof(Head));  // so that entries are aligned
  static constexpr bool over_aligned = alignment > __STDCPP_DEFAULT_NEW_ALIGNMENT__;

  // The place of the entries of all empty arrays, behind a head that says so and is never written.
  static T* nothing() {
    struct Nothing {
      alignas(alignment) std::byte head[head_bytes] = {};
    };
    static constexpr Nothing empty;
    return reinterpret_cast<T*>(const_cast<std::byte*>(empty.head) + head_bytes);
  }
  Head* head() const { return reinterpret_cast<Head*>(entries_) - 1; }

  static void* take(std::size_t bytes) {
    if constexpr (over_aligned) return ::operator new (bytes, std::align_val_t{alignment});
    return ::operator new(bytes);
  }
  void give_back() {
    if (capacity() == 0) return;
    std::destroy(entries_, entries_ + size());
    auto* const memory = reinterpret_cast<std::byte*>(entries_) - head_bytes;
    if constexpr (over_aligned) {
      ::operator delete (memory, std::align_val_t{alignment});
    } else {
      ::operator delete(memory);
    }
  }

  T* entries_ = nothing();
};

/// The entries of a CompactArray.
template <typename T>
class CompactEntries : public CompactMemory<T> {
 public:
  bool empty() const { return this->size() == 0; }
  T* data() { return this->entries(); }
  const T* data() const { return this->entries(); }
  T* begin() { return data(); }
  const T* begin() const { return data(); }
  T* end() { return data() + this->size(); }
  const T* end() const { return data() + this->size(); }
  T& operator[](std::size_t i) { return data()[i]; }
  const T& operator[](std::size_t i) const { return data()[i]; }
  T& front() { return data()[0]; }
  const T& front() const { return data()[0]; }
  T& back() { return data()[this->size() - 1]; }
  const T& back() const { return data()[this->size() - 1]; }
};

/// A std::vector of which an object takes 8 bytes instead of 24. A world has some two hundred arrays, most of them
/// short or empty, and a program may have thousands of worlds. At most 2^32 - 1 entries.
template <typename T>
class CompactArray : public CompactEntries<T> {
  static_assert(std::is_nothrow_move_constructible_v<T>);

 public:
  using value_type = T;
  using CompactEntries<T>::begin;
  using CompactEntries<T>::end;
  using CompactEntries<T>::size;
  using CompactEntries<T>::capacity;

  CompactArray() = default;
  explicit CompactArray(std::size_t count, const T& value = T()) { resize(count, value); }
  CompactArray(CompactArray&& other) noexcept = default;
  CompactArray& operator=(CompactArray&& other) noexcept = default;
  CompactArray(const CompactArray& other) : CompactEntries<T>() { assign(other.begin(), other.end()); }
  CompactArray& operator=(const CompactArray& other) {
    if (this != &other) assign(other.begin(), other.end());
    return *this;
  }

  /// Makes room for exactly so many; all else that makes it longer makes it so by half at least.
  void reserve(std::size_t count) {
    if (count > capacity()) this->move_to(count);
  }
  void clear() { shrink(0); }
  void push_back(T value) { emplace_back(std::move(value)); }
  /// The arguments must not be parts of its own entries.
  template <typename... Arguments>
  T& emplace_back(Arguments&&... arguments) {
    constexpr std::size_t first = std::max<std::size_t>(1, 32 / sizeof(T));
    if (size() == capacity()) this->move_to(std::max(first, size() + (size() + 1) / 2));
    T* const place = std::construct_at(end(), std::forward<Arguments>(arguments)...);
    this->set_size(size() + 1);
    return *place;
  }
  void pop_back() { shrink(size() - 1); }
  void resize(std::size_t count) {
    grow_with(count, [](T* from, T* to) { std::uninitialized_value_construct(from, to); });
  }
  void resize(std::size_t count, const T& value) {
    grow_with(count, [copy = T(value)](T* from, T* to) { std::uninitialized_fill(from, to, copy); });
  }
  void assign(std::size_t count, const T& value) {
    const T copy(value);
    clear();
    resize(count, copy);
  }
  template <std::forward_iterator Iterator>
  void assign(Iterator first, Iterator last) {
    clear();
    insert(end(), first, last);
  }
  /// Moves what follows a place, and puts a value there.
  void insert(const T* place, const T& value) {
    const std::ptrdiff_t at = place - begin();
    push_back(value);
    std::rotate(begin() + at, end() - 1, end());
  }
  template <std::forward_iterator Iterator>
  void insert(const T* place, Iterator first, Iterator last) {
    const std::ptrdiff_t at = place - begin();
    const std::size_t before = size();
    const std::size_t after = before + static_cast<std::size_t>(std::distance(first, last));
    if (after > capacity()) this->move_to(std::max(after, before + before / 2));
    std::uninitialized_copy(first, last, end());
    this->set_size(after);
    std::rotate(begin() + at, begin() + before, end());
  }
  T* erase(const T* first, const T* last) {
    T* const to = begin() + (first - begin());
    if (first == last) return to;  // nothing is to be moved onto itself
    shrink(static_cast<std::size_t>(std::move(begin() + (last - begin()), end(), to) - begin()));
    return to;
  }
  T* erase(const T* place) { return erase(place, place + 1); }

 private:
  void shrink(std::size_t count) {
    std::destroy(begin() + count, end());
    this->set_size(count);
  }
  template <typename Construct>
  void grow_with(std::size_t count, const Construct& construct) {
    if (count <= size()) return shrink(count);
    if (count > capacity()) this->move_to(std::max(count, size() + size() / 2));
    construct(end(), begin() + count);
    this->set_size(count);
  }
};

template <typename T>
bool operator==(const CompactArray<T>& a, const CompactArray<T>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

/// Like std::erase_if() and std::erase() of a vector.
template <typename T, typename Predicate>
std::size_t erase_if(CompactArray<T>& array, const Predicate& predicate) {
  const std::size_t before = array.size();
  array.erase(std::remove_if(array.begin(), array.end(), predicate), array.end());
  return before - array.size();
}
template <typename T>
std::size_t erase(CompactArray<T>& array, const T& value) {
  return erase_if(array, [&value](const T& entry) { return entry == value; });
}

}  // namespace atl::jobs
