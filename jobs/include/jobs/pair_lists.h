#pragma once

#include <jobs/arrays.h>
#include <jobs/compact_array.h>
#include <jobs/prefetch.h>

#include <cstddef>
#include <cstdint>

namespace atl::jobs {

/// Lists, by body, of what connects two bodies, such as contacts or joints. Each is in the lists of both its bodies, by
/// its ends: 2 * number for the first body, + 1 for the second. It comes and goes in constant time.
class PairLists {
 public:
  /// Makes room for the links of `count` pairs of bodies; `count` must not be less than their number.
  void resize(std::size_t count) { links_.resize(2 * count); }
  void reserve(std::size_t count) { links_.reserve(2 * count); }

  void add(std::uint32_t number, std::uint32_t first, std::uint32_t second) {
    link(2 * number, first);
    link(2 * number + 1, second);
  }
  /// `first` and `second` are those that it was added with.
  void remove(std::uint32_t number, std::uint32_t first, std::uint32_t second) {
    unlink(2 * number, first);
    unlink(2 * number + 1, second);
  }
  /// Empties the lists.
  void clear() { first_end_.assign(first_end_.size(), none); }

  /// Calls visit(number) for what connects a body, in no order to rely on.
  template <typename Visit>
  void for_each_of(std::uint32_t body, const Visit& visit) const {
    if (body >= first_end_.size()) return;
    for (std::uint32_t end = first_end_[body]; end != none; end = links_[end].next) visit(end / 2);
  }

  void prefetch(std::uint32_t number) const { jobs::prefetch(links_[2 * std::size_t{number}]); }
  auto arrays() const { return std::tie(links_, first_end_); }

 private:
  static constexpr std::uint32_t none = ~std::uint32_t{0};

  struct Link {
    std::uint32_t next = none;
    std::uint32_t previous = none;
  };

  void link(std::uint32_t end, std::uint32_t body) {
    if (body >= first_end_.size()) first_end_.resize(body + std::size_t{1}, none);
    const std::uint32_t next = first_end_[body];
    links_[end] = {next, none};
    if (next != none) links_[next].previous = end;
    first_end_[body] = end;
  }
  void unlink(std::uint32_t end, std::uint32_t body) {
    const Link link = links_[end];
    if (link.next != none) links_[link.next].previous = link.previous;
    (link.previous != none ? links_[link.previous].next : first_end_[body]) = link.next;
  }

  CompactArray<Link> links_;               // by end
  CompactArray<std::uint32_t> first_end_;  // by body, up to the last that was ever connected
};

}  // namespace atl::jobs
