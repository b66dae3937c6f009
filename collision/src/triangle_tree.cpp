#include <collision/triangle_tree.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace atl::collision {
namespace {

// More bins than this gain little (Wald 2007, section 3).
constexpr int bins = 16;
// Below this depth splits are at the median, so that no geometry makes the recursion deep.
constexpr int deepest_heuristic_split = 48;

struct Builder {
  std::span<const Aabb> boxes;
  std::vector<Vector3> centres;
  std::vector<TriangleTree::Node>& nodes;

  void build(std::uint32_t* begin, std::uint32_t* end, int depth);
  std::uint32_t* split(std::uint32_t* begin, std::uint32_t* end, int depth) const;
};

// In double: in float the areas of large surfaces overflow.
double half_area(const Aabb& box) {
  const double x = double{box.upper[0]} - box.lower[0];
  const double y = double{box.upper[1]} - box.lower[1];
  const double z = double{box.upper[2]} - box.lower[2];
  return x < 0 ? 0 : x * y + y * z + z * x;
}

// The bin after which the boxes' areas, times how many they are, sum up to least.
int best_split(const std::array<Aabb, bins>& box, const std::array<std::size_t, bins>& count) {
  std::array<double, bins> left = {};
  Aabb joined = Aabb::empty();
  std::size_t total = 0;
  for (std::size_t i = 0; i < bins; ++i) {
    joined = joined.joined(box[i]);
    total += count[i];
    left[i] = half_area(joined) * static_cast<double>(total);
  }
  joined = Aabb::empty();
  total = 0;
  double least = 0;
  int best = 0;
  for (std::size_t i = bins - 1; i > 0; --i) {
    joined = joined.joined(box[i]);
    total += count[i];
    const double cost = left[i - 1] + half_area(joined) * static_cast<double>(total);
    if (i < bins - 1 && cost >= least) continue;
    least = cost;
    best = static_cast<int>(i) - 1;
  }
  return best;
}

std::uint32_t* Builder::split(std::uint32_t* begin, std::uint32_t* end, int depth) const {
  Vector3 lower = centres[*begin];
  Vector3 upper = lower;
  for (const std::uint32_t* i = begin; i < end; ++i) {
    lower = lower.cwiseMin(centres[*i]);
    upper = upper.cwiseMax(centres[*i]);
  }
  int axis = 0;
  const double extent = (upper - lower).maxCoeff(&axis);
  if (extent > 0 && depth < deepest_heuristic_split) {
    const auto bin = [&](std::uint32_t item) {
      return std::min(bins - 1, static_cast<int>((centres[item][axis] - lower[axis]) / extent * bins));
    };
    std::array<Aabb, bins> box;
    box.fill(Aabb::empty());
    std::array<std::size_t, bins> count = {};
    for (const std::uint32_t* i = begin; i < end; ++i) {
      const auto b = static_cast<std::size_t>(bin(*i));
      box[b] = box[b].joined(boxes[*i]);
      ++count[b];
    }
    const int last = best_split(box, count);
    std::uint32_t* middle = std::stable_partition(begin, end, [&](std::uint32_t item) { return bin(item) <= last; });
    if (middle != begin && middle != end) return middle;
  }
  std::uint32_t* middle = begin + (end - begin) / 2;
  std::nth_element(begin, middle, end, [&](std::uint32_t a, std::uint32_t b) {
    return centres[a][axis] != centres[b][axis] ? centres[a][axis] < centres[b][axis] : a < b;
  });
  return middle;
}

void Builder::build(std::uint32_t* begin, std::uint32_t* end, int depth) {
  const std::size_t node = nodes.size();
  nodes.push_back({boxes[*begin], 0, *begin});
  if (end - begin > 1) {
    nodes[node].item = TriangleTree::no_item;
    std::uint32_t* middle = split(begin, end, depth);
    const std::size_t left = nodes.size();
    build(begin, middle, depth + 1);
    const std::size_t right = nodes.size();
    build(middle, end, depth + 1);
    nodes[node].box = nodes[left].box.joined(nodes[right].box);
  }
  nodes[node].skip = static_cast<std::uint32_t>(nodes.size());
}

}  // namespace

void TriangleTree::build(std::span<const Aabb> boxes) {
  nodes.clear();
  if (boxes.empty()) return;
  nodes.reserve(2 * boxes.size() - 1);
  std::vector<std::uint32_t> items(boxes.size());
  std::iota(items.begin(), items.end(), 0u);
  Builder builder{boxes, {}, nodes};
  builder.centres.reserve(boxes.size());
  for (const Aabb& box : boxes) {
    const auto centre = [&](std::size_t axis) { return (double{box.lower[axis]} + box.upper[axis]) / 2; };
    builder.centres.emplace_back(centre(0), centre(1), centre(2));
  }
  builder.build(items.data(), items.data() + items.size(), 0);
}

}  // namespace atl::collision
