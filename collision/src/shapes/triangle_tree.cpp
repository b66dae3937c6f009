#include <collision/shapes/triangle_tree.h>
#include <jobs/assert.h>

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>

namespace atl::collision {

// A node of the binary tree that the wide one is made from, in depth-first order: the first child is the next node.
struct TriangleTree::BinaryNode {
  Aabb box;
  std::uint32_t second;  // child; 0 of a leaf
  std::uint32_t item;    // of a leaf
};

namespace {

using BinaryNode = TriangleTree::BinaryNode;

// More bins than this gain little (Wald 2007, section 3).
constexpr int bins = 16;
// Below this depth splits are at the median, so that no geometry makes the recursion deep.
constexpr int deepest_heuristic_split = 48;

struct Builder {
  std::span<const Aabb> boxes;
  std::vector<Vector3> centres;
  std::vector<BinaryNode> nodes;

  void build(std::uint32_t* begin, std::uint32_t* end, int depth);
  std::uint32_t* split(std::uint32_t* begin, std::uint32_t* end, int depth) const;
};

// Computed in double, since areas of large surfaces overflow in float.
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
  double min = 0;
  int best = 0;
  for (std::size_t i = bins - 1; i > 0; --i) {
    joined = joined.joined(box[i]);
    total += count[i];
    const double cost = left[i - 1] + half_area(joined) * static_cast<double>(total);
    if (i < bins - 1 && cost >= min) continue;
    min = cost;
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
  ATL_ASSERT(begin < end, end - begin);
  ATL_ASSERT(depth < static_cast<int>(TriangleTree::max_depth), depth, end - begin);
  const std::size_t node = nodes.size();
  nodes.push_back({boxes[*begin], 0, *begin});
  if (end - begin == 1) return;
  std::uint32_t* middle = split(begin, end, depth);
  ATL_ASSERT(begin < middle && middle < end, middle - begin, end - begin);
  build(begin, middle, depth + 1);
  const auto second = static_cast<std::uint32_t>(nodes.size());
  build(middle, end, depth + 1);
  nodes[node].second = second;
  nodes[node].box = nodes[node + 1].box.joined(nodes[second].box);
}

// Nodes of the binary tree that are to be children of one node, in order.
struct Children {
  std::array<std::uint32_t, TriangleTree::width> node;
  std::size_t count = 0;
};

// The children of a node, of which the largest are opened while there is room.
Children gather(std::span<const BinaryNode> nodes, std::uint32_t root) {
  Children children;
  children.node[children.count++] = root;
  while (children.count < TriangleTree::width) {
    std::size_t largest = children.count;
    double max = -1;
    for (std::size_t i = 0; i < children.count; ++i) {
      const BinaryNode& node = nodes[children.node[i]];
      const double area = node.second == 0 ? -1 : half_area(node.box);
      if (!(area > max)) continue;
      max = area;
      largest = i;
    }
    if (largest == children.count) break;
    for (std::size_t i = children.count++; i > largest + 1; --i) children.node[i] = children.node[i - 1];
    children.node[largest + 1] = nodes[children.node[largest]].second;
    ++children.node[largest];
  }
  return children;
}

}  // namespace

// The origin is finite, and so is the scale, and more than none: the difference to any bound is a number, and times the
// scale, too.
TriangleTree::Node TriangleTree::frame_of(const Aabb& box) {
  constexpr float max = std::numeric_limits<float>::max();
  constexpr float min = std::numeric_limits<float>::min();
  Node node = {};
  node.origin.setZero();
  node.steps.setOnes();
  node.lower.fill(beyond * each);
  node.upper.fill(top_bits);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    node.origin[axis] = std::clamp(box.lower[i], -max, max);
    node.steps[axis] = std::clamp((last_step - 2) / (box.upper[i] - node.origin[axis]), min, max);
  }
  ATL_ASSERT((node.steps > 0).all() && node.steps.isFinite().all(), node.steps[0], node.steps[1], node.steps[2]);
  return node;
}

void TriangleTree::Node::set_bounds(std::size_t child, const Aabb& box) {
  const Eigen::Array4i from = steps_to(box.lower);
  const Eigen::Array4i to = steps_to(box.upper);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    lower[i] &= ~(std::uint64_t{0xff} << 8 * child);
    ATL_ASSERT(from[axis] >= 0 && from[axis] <= to[axis] && to[axis] <= static_cast<int>(last_step), child, axis,
               from[axis], to[axis]);
    lower[i] |= static_cast<std::uint64_t>(from[axis]) << 8 * child;
    upper[i] |= static_cast<std::uint64_t>(to[axis]) << 8 * child;
  }
}

void TriangleTree::build(std::span<const Aabb> item_boxes) {
  nodes.clear();
  node_boxes.clear();
  items.clear();
  boxes.clear();
  if (item_boxes.empty()) return;
  std::vector<std::uint32_t> order(item_boxes.size());
  std::iota(order.begin(), order.end(), 0u);
  Builder builder{item_boxes, {}, {}};
  builder.nodes.reserve(2 * item_boxes.size() - 1);
  builder.centres.reserve(item_boxes.size());
  for (const Aabb& box : item_boxes) {
    const auto centre = [&](std::size_t axis) { return (double{box.lower[axis]} + box.upper[axis]) / 2; };
    builder.centres.emplace_back(centre(0), centre(1), centre(2));
  }
  builder.build(order.data(), order.data() + order.size(), 0);
  take(builder.nodes);
}

// A level after the other, so that the children of a node stand in a row.
void TriangleTree::take(std::span<const BinaryNode> binary) {
  items.reserve(binary.size() / 2 + 1);
  boxes.reserve(binary.size() / 2 + 1);
  std::vector<std::uint32_t> roots = {0};  // of the nodes, in the binary tree
  for (std::size_t n = 0; n < roots.size(); ++n) {
    const Aabb& around = binary[roots[n]].box;
    const Children children = gather(binary, roots[n]);
    ATL_ASSERT(children.count >= 2 || binary.size() == 1, n, children.count);
    Node node = frame_of(around);
    node.first_node = static_cast<std::uint32_t>(roots.size());
    node.first_item = static_cast<std::uint32_t>(items.size());
    node.count = static_cast<std::uint8_t>(children.count);
    for (std::size_t i = 0; i < children.count; ++i) {
      const BinaryNode& child = binary[children.node[i]];
      node.set_bounds(i, child.box);
      if (child.second != 0) {
        node.inner = static_cast<std::uint8_t>(node.inner | 1u << i);
        node.place[i] = static_cast<std::uint8_t>(roots.size() - node.first_node);
        roots.push_back(children.node[i]);
      } else {
        node.place[i] = static_cast<std::uint8_t>(items.size() - node.first_item);
        items.push_back(child.item);
        boxes.push_back(child.box);
      }
    }
    nodes.push_back(node);
    node_boxes.push_back(around);
  }
  ATL_ASSERT(items.size() == binary.size() / 2 + 1, items.size(), binary.size());
  nodes.shrink_to_fit();
  node_boxes.shrink_to_fit();
}

}  // namespace atl::collision
