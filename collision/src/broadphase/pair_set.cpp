#include <collision/broadphase/pair_set.h>
#include <jobs/assert.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <utility>

namespace atl::collision {

// Radix sort over the bytes of the key that differ at all; a few thousand shapes have four of them.
void sort_pairs(std::vector<Pair>& pairs, std::vector<Pair>& scratch) {
  // Below, clearing the counters costs more than sorting does.
  constexpr std::size_t min = 300;
  if (pairs.size() < min) {
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

// Fibonacci hashing (Knuth, TAOCP 3, section 6.4): the high bits of a product by 2^64 over the golden ratio.
std::size_t PairSet::home(std::uint64_t key) const {
  ATL_ASSERT(std::has_single_bit(keys_.size()), keys_.size());
  key ^= key >> 29;
  return static_cast<std::size_t>((key * 0x9e3779b97f4a7c15u) >> 20) & (keys_.size() - 1);
}

bool PairSet::contains(Pair pair) const {
  if (keys_.empty()) return false;
  for (std::size_t slot = home(pair.key()); keys_[slot] != vacant; slot = next(slot)) {
    if (keys_[slot] == pair.key()) return true;
  }
  return false;
}

void PairSet::drop_contained(std::vector<Pair>& pairs, std::size_t begin) const {
  if (keys_.empty()) return;
  constexpr std::size_t ahead = 16;
  ATL_ASSERT(begin <= pairs.size(), begin, pairs.size());
  std::size_t kept = begin;
  for (std::size_t i = begin; i < pairs.size(); ++i) {
    if (i + ahead < pairs.size()) __builtin_prefetch(&keys_[home(pairs[i + ahead].key())]);
    const Pair pair = pairs[i];
    pairs[kept] = pair;
    kept += contains(pair) ? 0 : 1;
  }
  pairs.resize(kept);
}

void PairSet::insert(Pair pair) {
  ATL_ASSERT(pair.first < pair.second, pair.first, pair.second);
  ATL_ASSERT(!contains(pair), pair.first, pair.second);
  if (2 * (size_ + 1) > keys_.size()) grow();
  std::size_t slot = home(pair.key());
  while (keys_[slot] != vacant) slot = next(slot);
  keys_[slot] = pair.key();
  ++size_;
}

// Backward-shift deletion: later keys of the run move up, so no tombstones are left.
void PairSet::erase(Pair pair) {
  ATL_ASSERT(contains(pair), pair.first, pair.second, size_);
  std::size_t hole = home(pair.key());
  while (keys_[hole] != pair.key()) hole = next(hole);
  for (std::size_t slot = next(hole); keys_[slot] != vacant; slot = next(slot)) {
    const std::size_t from_home = (slot - home(keys_[slot])) & (keys_.size() - 1);
    const std::size_t from_hole = (slot - hole) & (keys_.size() - 1);
    if (from_home < from_hole) continue;
    keys_[hole] = keys_[slot];
    hole = slot;
  }
  keys_[hole] = vacant;
  --size_;
}

void PairSet::grow() {
  jobs::CompactArray<std::uint64_t> old(keys_.empty() ? 64 : 2 * keys_.size(), vacant);
  std::swap(old, keys_);
  ATL_ASSERT(size_ <= keys_.size() / 2, size_, keys_.size());
  for (const std::uint64_t key : old) {
    if (key == vacant) continue;
    std::size_t slot = home(key);
    while (keys_[slot] != vacant) slot = next(slot);
    keys_[slot] = key;
  }
}

}  // namespace atl::collision
