#include <collision/aabb_tree_builder.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

namespace atl::collision {
namespace {

constexpr int axis_bits = 21;
constexpr int max_height = 40;

// Twice the centre: the sum has no rounding to halve.
float centre(const Aabb& box, std::size_t axis) { return box.lower[axis] + box.upper[axis]; }

// Cubic cells of a grid that most centres are in; what is outside counts to the cells at its faces.
struct Grid {
  std::array<double, 3> origin;
  double cells_per_unit;
};

Grid grid_around(const std::vector<AabbTreeLeaf>& leaves) {
  // A sample tells how far most of the centres spread, whatever a few others do.
  constexpr std::size_t most_samples = 64;
  // Cells are then at most 1/512 of that spread.
  constexpr double most_spreads = 4096;
  const std::size_t stride = (leaves.size() + most_samples - 1) / most_samples;
  double extent = 0;
  double spread = 0;
  std::array<double, 3> lowest{}, middle{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double lower = std::numeric_limits<double>::infinity();
    double upper = -lower;
    std::array<double, most_samples> samples;
    std::size_t count = 0;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
      const double c = static_cast<double>(centre(leaves[i].box, axis));
      if (!(std::abs(c) < std::numeric_limits<float>::infinity())) continue;
      lower = std::min(lower, c);
      upper = std::max(upper, c);
      if (i % stride == 0) samples[count++] = c;
    }
    if (count > 0) {
      std::sort(samples.begin(), samples.begin() + static_cast<std::ptrdiff_t>(count));
      spread = std::max(spread, samples[count - 1 - count / 10] - samples[count / 10]);
      middle[axis] = samples[count / 2];
    }
    if (lower <= upper) {
      lowest[axis] = lower;
      extent = std::max(extent, upper - lower);
    }
  }
  Grid grid{lowest, 0};
  if (spread > 0 && extent > most_spreads * spread) {
    extent = most_spreads * spread;
    for (std::size_t axis = 0; axis < 3; ++axis) grid.origin[axis] = middle[axis] - 0.5 * extent;
  }
  if (extent > 0) grid.cells_per_unit = (1 << axis_bits) / extent;
  return grid;
}

// Spreads 21 bits to every third place.
std::uint64_t spread_bits(std::uint64_t x) {
  x = (x | x << 32) & 0x001f00000000ffffu;
  x = (x | x << 16) & 0x001f0000ff0000ffu;
  x = (x | x << 8) & 0x100f00f00f00f00fu;
  x = (x | x << 4) & 0x10c30c30c30c30c3u;
  return (x | x << 2) & 0x1249249249249249u;
}

std::uint64_t morton_code(const Aabb& box, const Grid& grid) {
  std::uint64_t code = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    constexpr double last = (1 << axis_bits) - 1;
    const double cell = (static_cast<double>(centre(box, axis)) - grid.origin[axis]) * grid.cells_per_unit;
    const double inside = cell >= 0 ? std::min(cell, last) : 0;  // of a NaN: 0
    code |= spread_bits(static_cast<std::uint64_t>(inside)) << axis;
  }
  return code;
}

}  // namespace

// Radix sort from the lowest digit up, which keeps the order of equal codes. Digits that don't vary are left out.
void AabbTreeBuilder::sort_codes() {
  constexpr int digit_bits = 8;
  constexpr std::size_t digits = 8;
  constexpr std::size_t values = 1 << digit_bits;
  static_assert(digits * digit_bits >= 3 * axis_bits);
  std::array<std::array<std::uint32_t, values>, digits> counts{};
  for (const Code& code : codes_) {
    for (std::size_t digit = 0; digit < digits; ++digit) {
      ++counts[digit][code.code >> (digit * digit_bits) & (values - 1)];
    }
  }
  sorted_.resize(codes_.size());
  for (std::size_t digit = 0; digit < digits; ++digit) {
    const std::size_t shift = digit * digit_bits;
    std::array<std::uint32_t, values>& places = counts[digit];
    if (places[codes_[0].code >> shift & (values - 1)] == codes_.size()) continue;
    std::uint32_t place = 0;
    for (std::uint32_t& count : places) place += std::exchange(count, place);
    for (const Code& code : codes_) sorted_[places[code.code >> shift & (values - 1)]++] = code;
    std::swap(codes_, sorted_);
  }
}

void AabbTreeBuilder::build(std::vector<AabbTreeNode>& nodes, std::vector<std::int32_t>& slots) {
  nodes.clear();
  if (leaves.size() == 1) {
    nodes.emplace_back();
    nodes[0].child[0] = static_cast<std::int32_t>(~leaves[0].item);
    nodes[0].set_box(0, leaves[0].box);
    slots[leaves[0].item] = 0;
  }
  if (leaves.size() < 2) return;
  nodes.reserve(leaves.size() - 1);
  nodes_ = &nodes;
  slots_ = &slots;
  const Grid grid = grid_around(leaves);
  codes_.resize(leaves.size());
  for (std::uint32_t i = 0; i < leaves.size(); ++i) codes_[i] = {morton_code(leaves[i].box, grid), i};
  sort_codes();
  build_node(0, leaves.size(), AabbTreeNode::none, max_height);
}

// Of two leaves at least. Returns the node's box.
Aabb AabbTreeBuilder::build_node(std::size_t begin, std::size_t end, std::int32_t parent, int levels_left) {
  const std::size_t number = nodes_->size();
  nodes_->emplace_back().parent = parent;
  const std::size_t middle = split(begin, end, levels_left);
  const auto slot = static_cast<std::int32_t>(2 * number);
  const Aabb first = build_child(begin, middle, slot, levels_left - 1);
  const Aabb second = build_child(middle, end, slot + 1, levels_left - 1);
  AabbTreeNode& node = (*nodes_)[number];
  node.set_box(0, first);
  node.set_box(1, second);
  for (const std::int32_t child : node.child) {
    if (!AabbTreeNode::is_node(child)) continue;
    node.height = std::max(node.height, 1 + (*nodes_)[static_cast<std::size_t>(child)].height);
  }
  return node.joined();
}

Aabb AabbTreeBuilder::build_child(std::size_t begin, std::size_t end, std::int32_t slot, int levels_left) {
  std::int32_t& child = (*nodes_)[static_cast<std::size_t>(slot / 2)].child[slot % 2];
  if (end - begin == 1) {
    const AabbTreeLeaf& leaf = leaves[codes_[begin].leaf];
    child = static_cast<std::int32_t>(~leaf.item);
    (*slots_)[leaf.item] = slot;
    return leaf.box;
  }
  child = static_cast<std::int32_t>(nodes_->size());
  return build_node(begin, end, slot, levels_left);
}

// The first code of the second half.
std::size_t AabbTreeBuilder::split(std::size_t begin, std::size_t end, int levels_left) const {
  const std::uint64_t differing = codes_[begin].code ^ codes_[end - 1].code;
  // Halves of halves need as many levels as the count has bits.
  const bool too_high = levels_left <= static_cast<int>(std::bit_width(end - begin));
  if (differing == 0 || too_high) return begin + (end - begin) / 2;
  const std::uint64_t bit = std::bit_floor(differing);
  std::size_t low = begin;  // without the bit
  std::size_t high = end - 1;
  while (high - low > 1) {
    const std::size_t middle = low + (high - low) / 2;
    ((codes_[middle].code & bit) != 0 ? high : low) = middle;
  }
  return high;
}

}  // namespace atl::collision
