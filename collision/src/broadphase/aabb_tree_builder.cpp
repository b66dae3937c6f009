#include <collision/broadphase/aabb_tree_builder.h>
#include <jobs/assert.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <utility>

namespace atl::collision {
namespace {

constexpr int axis_bits = 21;
constexpr int max_height = 40;

constexpr std::size_t leaf_grain = 8192;
// Number of leaves from which on a tree is built in parallel. Below it the build takes about a millisecond at most.
constexpr std::size_t many_leaves = 16384;
// Largest part of a parallel build: its codes and boxes stay in a core's second-level cache.
constexpr std::size_t part_leaves = 8192;

// Twice the centre: the sum has no rounding to halve.
double centre(const Aabb& box, std::size_t axis) { return static_cast<double>(box.lower[axis] + box.upper[axis]); }

// Spreads 21 bits to every third place.
std::uint64_t spread_bits(std::uint64_t x) {
  x = (x | x << 32) & 0x001f00000000ffffu;
  x = (x | x << 16) & 0x001f0000ff0000ffu;
  x = (x | x << 8) & 0x100f00f00f00f00fu;
  x = (x | x << 4) & 0x10c30c30c30c30c3u;
  return (x | x << 2) & 0x1249249249249249u;
}

bool is_finite(double centre) { return std::abs(centre) < std::numeric_limits<float>::infinity(); }

}  // namespace

// Calls body(begin, end) for chunks of the leaves.
template <typename Body>
void AabbTreeBuilder::for_leaves(const Body& body) const {
  if (arena_) return arena_->parallel_for(leaves.size(), leaf_grain, body);
  for (std::size_t begin = 0; begin < leaves.size(); begin += leaf_grain) {
    body(begin, std::min(leaves.size(), begin + leaf_grain));
  }
}

AabbTreeBuilder::Grid AabbTreeBuilder::grid_around_leaves() {
  // A sample tells how far most of the centres spread, whatever a few others do.
  constexpr std::size_t max_samples = 64;
  // Cells are then at most 1/512 of that spread.
  constexpr double max_spreads = 4096;
  for_leaves([this](std::size_t begin, std::size_t end) {
    std::array<Range, 3> ranges;
    for (std::size_t i = begin; i < end; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double c = centre(leaves[i].box, axis);
        if (is_finite(c)) ranges[axis] = {std::min(ranges[axis].lower, c), std::max(ranges[axis].upper, c)};
      }
    }
    chunks_[begin / leaf_grain].ranges = ranges;
  });
  const std::size_t stride = (leaves.size() + max_samples - 1) / max_samples;
  double extent = 0;
  double spread = 0;
  std::array<double, 3> lowest{}, middle{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::array<double, max_samples> samples;
    std::size_t count = 0;
    for (std::size_t i = 0; i < leaves.size(); i += stride) {
      const double c = centre(leaves[i].box, axis);
      if (is_finite(c)) samples[count++] = c;
    }
    if (count > 0) {
      std::sort(samples.begin(), samples.begin() + static_cast<std::ptrdiff_t>(count));
      spread = std::max(spread, samples[count - 1 - count / 10] - samples[count / 10]);
      middle[axis] = samples[count / 2];
    }
    Range range;
    for (const Chunk& chunk : chunks_) {
      range = {std::min(range.lower, chunk.ranges[axis].lower), std::max(range.upper, chunk.ranges[axis].upper)};
    }
    if (range.lower <= range.upper) {
      lowest[axis] = range.lower;
      extent = std::max(extent, range.upper - range.lower);
    }
  }
  Grid grid{lowest, 0};
  if (spread > 0 && extent > max_spreads * spread) {
    extent = max_spreads * spread;
    for (std::size_t axis = 0; axis < 3; ++axis) grid.origin[axis] = middle[axis] - 0.5 * extent;
  }
  if (extent > 0) grid.cells_per_unit = (1 << axis_bits) / extent;
  ATL_ASSERT(grid.cells_per_unit >= 0 && std::isfinite(grid.cells_per_unit), extent, spread);
  return grid;
}

void AabbTreeBuilder::find_codes() {
  const Grid grid = grid_around_leaves();
  codes_.resize(leaves.size());
  for_leaves([&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      std::uint64_t code = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        constexpr double last = (1 << axis_bits) - 1;
        const double cell = (centre(leaves[i].box, axis) - grid.origin[axis]) * grid.cells_per_unit;
        const double inside = cell >= 0 ? std::min(cell, last) : 0;  // of a NaN: 0
        code |= spread_bits(static_cast<std::uint64_t>(inside)) << axis;
      }
      codes_[i] = {code, static_cast<std::uint32_t>(i)};
    }
  });
}

// Radix sort from the lowest digit up, which keeps the order of equal codes. Digits that don't vary are left out.
void AabbTreeBuilder::sort_bucket(std::size_t begin, std::size_t end) {
  constexpr std::size_t digits = 8;
  static_assert(digits * digit_bits >= 3 * axis_bits);
  constexpr std::size_t few = 128;  // for which it takes longer to count digits
  ATL_ASSERT(begin <= end && end <= codes_.size(), begin, end, codes_.size());
  const std::span<Code> bucket = std::span(codes_).subspan(begin, end - begin);
  const auto precedes = [](const Code& a, const Code& b) {
    return a.code != b.code ? a.code < b.code : a.leaf < b.leaf;
  };
  if (bucket.size() < few) return std::sort(bucket.begin(), bucket.end(), precedes);
  std::array<std::array<std::uint32_t, digit_values>, digits> counts{};
  for (const Code& code : bucket) {
    for (std::size_t digit = 0; digit < digits; ++digit) {
      ++counts[digit][code.code >> (digit * digit_bits) & (digit_values - 1)];
    }
  }
  std::span<Code> from = bucket;
  std::span<Code> to = std::span(sorted_).subspan(begin, end - begin);
  for (std::size_t digit = 0; digit < digits; ++digit) {
    const std::size_t shift = digit * digit_bits;
    std::array<std::uint32_t, digit_values>& places = counts[digit];
    if (places[from[0].code >> shift & (digit_values - 1)] == from.size()) continue;
    std::uint32_t place = 0;
    for (std::uint32_t& count : places) place += std::exchange(count, place);
    for (const Code& code : from) to[places[code.code >> shift & (digit_values - 1)]++] = code;
    std::swap(from, to);
  }
  if (from.data() != bucket.data()) std::copy(from.begin(), from.end(), bucket.begin());
}

// Many codes are put into buckets by the highest digit that varies, which are then sorted on their own.
void AabbTreeBuilder::sort_codes() {
  sorted_.resize(codes_.size());
  if (codes_.size() < many_leaves) return sort_bucket(0, codes_.size());
  for_leaves([this](std::size_t begin, std::size_t end) {
    std::uint64_t bits = 0;
    for (std::size_t i = begin; i < end; ++i) bits |= codes_[i].code ^ codes_[0].code;
    chunks_[begin / leaf_grain].differing = bits;
  });
  std::uint64_t differing = 0;
  for (const Chunk& chunk : chunks_) differing |= chunk.differing;
  const int shift = std::max(0, static_cast<int>(std::bit_width(differing)) - digit_bits);
  const auto digit_of = [shift](const Code& code) { return code.code >> shift & (digit_values - 1); };

  for_leaves([&](std::size_t begin, std::size_t end) {
    std::array<std::uint32_t, digit_values>& counts = chunks_[begin / leaf_grain].places;
    counts.fill(0);
    for (std::size_t i = begin; i < end; ++i) ++counts[digit_of(codes_[i])];
  });
  // Turns counts into places: by digit first, then by chunk, so that the sort is stable for any number of chunks.
  std::array<std::size_t, digit_values + 1> bucket_begin;
  std::uint32_t place = 0;
  for (std::size_t digit = 0; digit < digit_values; ++digit) {
    bucket_begin[digit] = place;
    for (Chunk& chunk : chunks_) place += std::exchange(chunk.places[digit], place);
  }
  bucket_begin[digit_values] = place;
  ATL_ASSERT(place == codes_.size(), place, codes_.size());
  for_leaves([&](std::size_t begin, std::size_t end) {
    std::array<std::uint32_t, digit_values>& places = chunks_[begin / leaf_grain].places;
    for (std::size_t i = begin; i < end; ++i) sorted_[places[digit_of(codes_[i])]++] = codes_[i];
  });
  std::swap(codes_, sorted_);
  const auto sort_buckets = [&](std::size_t begin, std::size_t end) {
    for (std::size_t digit = begin; digit < end; ++digit) sort_bucket(bucket_begin[digit], bucket_begin[digit + 1]);
  };
  arena_ ? arena_->parallel_for(digit_values, 1, sort_buckets) : sort_buckets(0, digit_values);
}

void AabbTreeBuilder::build(jobs::CompactArray<AabbTreeNode>& nodes, jobs::CompactArray<std::int32_t>& slots,
                            jobs::Arena* arena) {
  nodes.clear();
  if (leaves.size() == 1) {
    nodes.emplace_back();
    nodes[0].child[0] = static_cast<std::int32_t>(~leaves[0].item);
    nodes[0].set_box(0, leaves[0].box);
    slots[leaves[0].item] = 0;
  }
  if (leaves.size() < 2) return;
  arena_ = arena;
  chunks_.resize(jobs::Arena::chunk_count(leaves.size(), leaf_grain));
  find_codes();
  sort_codes();
  if constexpr (jobs::with_asserts) {
    // Strictly in order, so that each leaf is there once.
    for (std::size_t i = 1; i < codes_.size(); ++i) {
      const Code &before = codes_[i - 1], &code = codes_[i];
      ATL_ASSERT(before.code < code.code || (before.code == code.code && before.leaf < code.leaf), i, before.leaf,
                 code.leaf);
    }
  }
  nodes.resize(leaves.size() - 1);
  nodes_ = &nodes;
  slots_ = &slots;
  divide();
  const auto build_parts = [this](std::size_t begin, std::size_t end) {
    for (std::size_t part = begin; part < end; ++part) build_node(parts_[part]);
  };
  arena_ ? arena_->parallel_for(parts_.size(), 1, build_parts) : build_parts(0, parts_.size());
  // Boxes and heights are passed up from the parts to the root.
  for (std::size_t i = above_.size(); i-- > 0;) join(above_[i]);
}

// Makes the nodes above the parts, and hangs the parts on them.
void AabbTreeBuilder::divide() {
  parts_.clear();
  above_.clear();
  const std::size_t max = arena_ == nullptr || leaves.size() < many_leaves ? leaves.size() : part_leaves;
  divided_.assign(1, {0, leaves.size(), 0, AabbTreeNode::none, max_height});
  while (!divided_.empty()) {
    const Part part = divided_.back();
    divided_.pop_back();
    if (part.end - part.begin <= max) {
      parts_.push_back(part);
      continue;
    }
    above_.push_back(part.number);
    AabbTreeNode& node = (*nodes_)[part.number];
    node.parent = part.parent;
    const std::size_t middle = split(part);
    for (const int side : {0, 1}) {
      const Part child = child_of(part, side, middle);
      if (child.end - child.begin == 1) {
        node.set_box(side, build_child(part, side, middle));
        continue;
      }
      node.child[side] = static_cast<std::int32_t>(child.number);
      divided_.push_back(child);
    }
  }
}

// Sets what a node made above the parts stores of its children (boxes and heights), once these are complete.
void AabbTreeBuilder::join(std::size_t number) {
  AabbTreeNode& node = (*nodes_)[number];
  for (const int side : {0, 1}) {
    if (!AabbTreeNode::is_node(node.child[side])) continue;
    const AabbTreeNode& child = (*nodes_)[static_cast<std::size_t>(node.child[side])];
    node.set_box(side, child.joined());
    node.height = std::max(node.height, 1 + child.height);
  }
}

AabbTreeBuilder::Part AabbTreeBuilder::child_of(const Part& part, int side, std::size_t middle) const {
  const auto slot = static_cast<std::int32_t>(2 * part.number) + side;
  if (side == 0) return {part.begin, middle, part.number + 1, slot, part.levels_left - 1};
  return {middle, part.end, part.number + (middle - part.begin), slot, part.levels_left - 1};
}

// Builds the subtree of a part, which has at least two leaves. Returns its box.
Aabb AabbTreeBuilder::build_node(const Part& part) {
  ATL_ASSERT(part.end - part.begin >= 2, part.number, part.begin, part.end);
  ATL_ASSERT(part.number + (part.end - part.begin) <= nodes_->size() + 1, part.number, part.begin, part.end);
  ATL_ASSERT(part.levels_left > 0, part.number, part.end - part.begin);
  AabbTreeNode& node = (*nodes_)[part.number];
  node.parent = part.parent;
  const std::size_t middle = split(part);
  node.set_box(0, build_child(part, 0, middle));
  node.set_box(1, build_child(part, 1, middle));
  for (const std::int32_t child : node.child) {
    if (!AabbTreeNode::is_node(child)) continue;
    node.height = std::max(node.height, 1 + (*nodes_)[static_cast<std::size_t>(child)].height);
  }
  return node.joined();
}

Aabb AabbTreeBuilder::build_child(const Part& part, int side, std::size_t middle) {
  const Part child = child_of(part, side, middle);
  std::int32_t& place = (*nodes_)[part.number].child[side];
  if (child.end - child.begin > 1) {
    place = static_cast<std::int32_t>(child.number);
    return build_node(child);
  }
  const AabbTreeLeaf& leaf = leaves[codes_[child.begin].leaf];
  ATL_ASSERT(leaf.item < slots_->size(), leaf.item, slots_->size());
  place = static_cast<std::int32_t>(~leaf.item);
  (*slots_)[leaf.item] = child.parent;
  return leaf.box;
}

// The first code of the second half.
std::size_t AabbTreeBuilder::split(const Part& part) const {
  const auto [begin, end] = std::pair(part.begin, part.end);
  const std::uint64_t differing = codes_[begin].code ^ codes_[end - 1].code;
  // Halves of halves need as many levels as the count has bits.
  const bool too_high = part.levels_left <= static_cast<int>(std::bit_width(end - begin));
  if (differing == 0 || too_high) return begin + (end - begin) / 2;
  const std::uint64_t bit = std::bit_floor(differing);
  std::size_t low = begin;  // without the bit
  std::size_t high = end - 1;
  while (high - low > 1) {
    const std::size_t middle = low + (high - low) / 2;
    ((codes_[middle].code & bit) != 0 ? high : low) = middle;
  }
  ATL_ASSERT((codes_[low].code & bit) == 0 && (codes_[high].code & bit) != 0, begin, low, high, end);
  return high;
}

}  // namespace atl::collision
