#include <collision/aabb_tree.h>

#include <algorithm>

namespace atl::collision {

std::int32_t AabbTree::allocate() {
  if (free_ == none) {
    nodes_.emplace_back();
    return static_cast<std::int32_t>(nodes_.size()) - 1;
  }
  const std::int32_t node = free_;
  free_ = at(node).parent;
  at(node) = Node{};
  return node;
}

void AabbTree::release(std::int32_t node) {
  at(node) = Node{};
  at(node).parent = free_;
  free_ = node;
}

// Walks down to the node that grows least, in area, by getting the new leaf as its sibling.
std::int32_t AabbTree::best_sibling(const Aabb& box) const {
  std::int32_t node = root_;
  while (!at(node).is_leaf()) {
    const Node& here = at(node);
    const float joined = here.box.joined(box).half_area();
    const float cost_here = 2 * joined;                           // a new parent of this node and the leaf
    const float inherited = 2 * (joined - here.box.half_area());  // this node's growth, if it goes deeper
    float cost[2];
    for (int side = 0; side < 2; ++side) {
      const Node& child = at(here.child[side]);
      const float grown = child.box.joined(box).half_area();
      cost[side] = inherited + (child.is_leaf() ? grown : grown - child.box.half_area());
    }
    if (cost_here < cost[0] && cost_here < cost[1]) break;
    node = here.child[cost[1] < cost[0] ? 1 : 0];
  }
  return node;
}

std::int32_t AabbTree::insert(std::uint32_t item, const Aabb& box) {
  const std::int32_t leaf = allocate();
  at(leaf).box = box;
  at(leaf).item = item;
  ++leaf_count_;
  ++changes_;
  if (root_ == none) {
    root_ = leaf;
    return leaf;
  }
  const std::int32_t sibling = best_sibling(box);
  const std::int32_t parent = allocate();
  const std::int32_t grandparent = at(sibling).parent;
  at(parent).parent = grandparent;
  at(parent).child[0] = sibling;
  at(parent).child[1] = leaf;
  at(sibling).parent = parent;
  at(leaf).parent = parent;
  if (grandparent == none) {
    root_ = parent;
  } else {
    Node& above = at(grandparent);
    above.child[above.child[1] == sibling ? 1 : 0] = parent;
  }
  refit(parent);
  if (at(root_).height > max_depth / 2) rebuild();
  return leaf;
}

void AabbTree::remove(std::int32_t leaf) {
  --leaf_count_;
  ++changes_;
  const std::int32_t parent = at(leaf).parent;
  release(leaf);
  if (parent == none) {
    root_ = none;
    return;
  }
  const std::int32_t sibling = at(parent).child[at(parent).child[0] == leaf ? 1 : 0];
  const std::int32_t grandparent = at(parent).parent;
  at(sibling).parent = grandparent;
  release(parent);
  if (grandparent == none) {
    root_ = sibling;
  } else {
    Node& above = at(grandparent);
    above.child[above.child[1] == parent ? 1 : 0] = sibling;
    refit(grandparent);
  }
}

void AabbTree::move(std::int32_t leaf, const Aabb& box) {
  at(leaf).box = box;
  ++changes_;
  refit(at(leaf).parent);
}

// Recomputes boxes and heights from a node upwards, as far as they change.
void AabbTree::refit(std::int32_t node) {
  while (node != none) {
    Node& here = at(node);
    const Node& left = at(here.child[0]);
    const Node& right = at(here.child[1]);
    const Aabb box = left.box.joined(right.box);
    const std::int32_t height = 1 + std::max(left.height, right.height);
    if (box == here.box && height == here.height) return;
    here.box = box;
    here.height = height;
    node = here.parent;
  }
}

void AabbTree::rebuild_if_worn() {
  if (changes_ > leaf_count_ && leaf_count_ > 2) rebuild();
}

void AabbTree::rebuild() {
  changes_ = 0;
  leaves_.clear();
  // Every node that is not a leaf goes; leaves keep their numbers, which are handles.
  std::int32_t stack[max_depth];
  int top = 0;
  stack[top++] = root_;
  while (top > 0) {
    const std::int32_t node = stack[--top];
    if (at(node).is_leaf()) {
      leaves_.push_back(node);
    } else {
      stack[top++] = at(node).child[1];
      stack[top++] = at(node).child[0];
      release(node);
    }
  }
  root_ = build(leaves_.data(), leaves_.data() + leaves_.size(), none);
}

std::int32_t AabbTree::build(std::int32_t* begin, std::int32_t* end, std::int32_t parent) {
  if (end - begin == 1) {
    at(*begin).parent = parent;
    return *begin;
  }
  // Twice the centres: their sum has no rounding to halve.
  const auto centre = [this](std::int32_t leaf, std::size_t axis) {
    return at(leaf).box.lower[axis] + at(leaf).box.upper[axis];
  };
  Aabb box = Aabb::empty();
  Aabb centres = Aabb::empty();
  for (const std::int32_t* leaf = begin; leaf != end; ++leaf) {
    box = box.joined(at(*leaf).box);
    const std::array<float, 3> c = {centre(*leaf, 0), centre(*leaf, 1), centre(*leaf, 2)};
    centres = centres.joined({c, c});
  }
  std::size_t axis = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    if (centres.upper[i] - centres.lower[i] > centres.upper[axis] - centres.lower[axis]) axis = i;
  }
  std::int32_t* middle = begin + (end - begin) / 2;
  std::nth_element(begin, middle, end, [&](std::int32_t a, std::int32_t b) {
    const float ca = centre(a, axis);
    const float cb = centre(b, axis);
    return ca != cb ? ca < cb : at(a).item < at(b).item;
  });
  const std::int32_t node = allocate();
  at(node).box = box;
  at(node).parent = parent;
  const std::int32_t left = build(begin, middle, node);
  const std::int32_t right = build(middle, end, node);
  at(node).child[0] = left;
  at(node).child[1] = right;
  at(node).height = 1 + std::max(at(left).height, at(right).height);
  return node;
}

}  // namespace atl::collision
