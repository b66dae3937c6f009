#include <collision/broadphase/pair.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

namespace atl::collision {

// Radix sort over the bytes of the key that differ at all; a few thousand shapes have four of them.
void sort_pairs(std::vector<Pair>& pairs, std::vector<Pair>& scratch) {
  // Below, clearing the counters costs more than sorting does.
  constexpr std::size_t least = 300;
  if (pairs.size() < least) {
    std::sort(pairs.begin(), pairs.end());
    return;
  }
  std::uint64_t differing = 0;
  for (const Pair pair : pairs) differing |= pair.key() ^ pairs[0].key();
  scratch.resize(pairs.size());
  for (int shift = 0; shift < 64; shift += 8) {
    if ((differing >> shift & 0xff) == 0) continue;
    std::array<std::size_t, 256> places{};
    for (const Pair pair : pairs) ++places[pair.key() >> shift & 0xff];
    std::size_t place = 0;
    for (std::size_t& count : places) place += std::exchange(count, place);
    for (const Pair pair : pairs) scratch[places[pair.key() >> shift & 0xff]++] = pair;
    std::swap(pairs, scratch);
  }
}

}  // namespace atl::collision
