#include <collision/broadphase/aabb_tree_nodes.h>
#include <jobs/append.h>
#include <jobs/assert.h>

#include <algorithm>

namespace atl::collision {

std::int32_t AabbTreeNodes::allocate() {
  if (free_ == Node::none) {
    nodes_.emplace_back();
    return static_cast<std::int32_t>(nodes_.size()) - 1;
  }
  const std::int32_t node = free_;
  ATL_ASSERT(node >= 0 && static_cast<std::size_t>(node) < nodes_.size(), node, nodes_.size());
  free_ = at(node).parent;
  at(node) = Node();
  return node;
}

void AabbTreeNodes::release(std::int32_t node) {
  ATL_ASSERT(node >= 0 && static_cast<std::size_t>(node) < nodes_.size(), node, nodes_.size());
  ATL_ASSERT(node != free_, node);
  at(node) = Node();
  at(node).parent = free_;
  free_ = node;
}

// Puts a child into a slot; none is the place of the root.
void AabbTreeNodes::put(std::int32_t slot, std::int32_t child, const Aabb& box) {
  ATL_ASSERT(child != Node::none, slot);
  ATL_ASSERT(slot == Node::none || static_cast<std::size_t>(slot / 2) < nodes_.size(), slot, nodes_.size());
  if (slot == Node::none) {
    root_ = child;
  } else {
    at(slot / 2).child[slot % 2] = child;
    at(slot / 2).set_box(slot % 2, box);
  }
  if (Node::is_node(child)) {
    at(child).parent = slot;
  } else {
    slots_[item_of(child)] = slot;
  }
}

// Walks down to the slot whose content grows least, in area, by getting the new leaf as its sibling.
std::int32_t AabbTreeNodes::best_slot(const Aabb& box) const {
  ATL_ASSERT(root_ != Node::none, root_);
  std::int32_t slot = Node::none;
  std::int32_t content = root_;
  Aabb around = at(root_).joined();
  while (Node::is_node(content)) {
    const Node& node = at(content);
    const float joined = around.joined(box).half_area();
    const float cost_here = 2 * joined;                         // a new parent of this node and the leaf
    const float inherited = 2 * (joined - around.half_area());  // this node's growth, if it goes deeper
    float cost[2];
    for (int side = 0; side < 2; ++side) {
      const Aabb child = node.box(side);
      const float grown = child.joined(box).half_area();
      cost[side] = inherited + (Node::is_leaf(node.child[side]) ? grown : grown - child.half_area());
    }
    if (cost_here < cost[0] && cost_here < cost[1]) break;
    const int side = cost[1] < cost[0] ? 1 : 0;
    slot = 2 * content + side;
    around = node.box(side);
    content = node.child[side];
  }
  return slot;
}

void AabbTreeNodes::insert(std::uint32_t item, const Aabb& box) {
  if (item >= slots_.size()) jobs::append(slots_, item + std::size_t{1}, Node::none);
  ++size_;
  if (size_ <= 2) {
    // The root alone may have fewer than two children.
    if (size_ == 1) root_ = allocate();
    put(2 * root_ + (at(root_).child[0] == Node::none ? 0 : 1), leaf_of(item), box);
    return;
  }
  const std::int32_t slot = best_slot(box);
  const std::int32_t sibling = slot == Node::none ? root_ : at(slot / 2).child[slot % 2];
  const Aabb sibling_box = slot == Node::none ? at(root_).joined() : at(slot / 2).box(slot % 2);
  const std::int32_t parent = allocate();
  put(2 * parent, sibling, sibling_box);
  put(2 * parent + 1, leaf_of(item), box);
  update_height(parent);
  put(slot, parent, at(parent).joined());
  if (slot != Node::none) refit(slot / 2);
}

void AabbTreeNodes::remove(std::uint32_t item) {
  ATL_ASSERT(size_ > 0, item, size_);
  ATL_ASSERT(item < slots_.size(), item, slots_.size());
  const std::int32_t slot = slots_[item];
  slots_[item] = Node::none;
  --size_;
  const std::int32_t node = slot / 2;
  ATL_ASSERT(at(node).child[slot % 2] == leaf_of(item), item, slot, at(node).child[slot % 2]);
  at(node).clear(slot % 2);
  if (size_ == 0) {
    root_ = Node::none;
    release(node);
  } else if (const std::int32_t other = at(node).child[1 - slot % 2]; node != root_ || Node::is_node(other)) {
    // The node's other child takes its place, since a node has two children (the root may have one leaf alone).
    const Aabb box = at(node).box(1 - slot % 2);
    const std::int32_t above = at(node).parent;
    release(node);
    put(above, other, box);
    if (above != Node::none) refit(above / 2);
  }
}

void AabbTreeNodes::set_box(std::uint32_t item, const Aabb& box) {
  const std::int32_t own = slots_[item];
  ATL_ASSERT(at(own / 2).child[own % 2] == leaf_of(item), item, own, at(own / 2).child[own % 2]);
  at(own / 2).set_box(own % 2, box);
  // The boxes above follow, as far as they change.
  std::int32_t node = own / 2;
  for (std::int32_t slot = at(node).parent; slot != Node::none; slot = at(slot / 2).parent) {
    const Aabb joined = at(node).joined();
    node = slot / 2;
    if (joined == at(node).box(slot % 2)) return;
    at(node).set_box(slot % 2, joined);
  }
}

void AabbTreeNodes::set_aside(std::uint32_t item, std::int32_t number) {
  if (item >= slots_.size()) jobs::append(slots_, item + std::size_t{1}, Node::none);
  slots_[item] = number;
}

std::int32_t AabbTreeNodes::height_of(std::int32_t child) const { return Node::is_node(child) ? at(child).height : 0; }

void AabbTreeNodes::update_height(std::int32_t node) {
  at(node).height = 1 + std::max(height_of(at(node).child[0]), height_of(at(node).child[1]));
}

// Limits the height: if one child is much higher than the other, swaps the other for the higher one's higher child.
// This is an AVL tree's rotation, but used rarely, since it disregards the boxes. Without it, insertion along a line
// makes a list.
void AabbTreeNodes::balance(std::int32_t node) {
  // Low enough to bound the height by about twice the ideal, high enough to leave a rebuilt tree alone.
  constexpr std::int32_t max_difference = 4;
  const std::int32_t difference = height_of(at(node).child[0]) - height_of(at(node).child[1]);
  if (difference >= -max_difference && difference <= max_difference) return;
  const int high = difference > 0 ? 0 : 1;
  const std::int32_t tall = at(node).child[high];
  ATL_ASSERT(Node::is_node(tall), node, tall);
  const std::int32_t low = at(node).child[1 - high];
  const Aabb low_box = at(node).box(1 - high);
  const int higher = height_of(at(tall).child[0]) >= height_of(at(tall).child[1]) ? 0 : 1;
  const std::int32_t risen = at(tall).child[higher];
  const Aabb risen_box = at(tall).box(higher);
  put(2 * tall + higher, low, low_box);
  put(2 * node + (1 - high), risen, risen_box);
  put(2 * node + high, tall, at(tall).joined());
  update_height(tall);
}

// Recomputes boxes and heights from a node upwards, as far as they change.
void AabbTreeNodes::refit(std::int32_t node) {
  while (true) {
    const std::int32_t old_height = at(node).height;
    balance(node);
    update_height(node);
    const std::int32_t slot = at(node).parent;
    if (slot == Node::none) return;
    const Aabb box = at(node).joined();
    const bool same_height = at(node).height == old_height;
    node = slot / 2;
    if (same_height && box == at(node).box(slot % 2)) return;
    at(node).set_box(slot % 2, box);
  }
}

void AabbTreeNodes::rebuild(AabbTreeBuilder& builder, jobs::Arena* arena) {
  for (const Node& node : nodes_) {
    for (const int side : {0, 1}) {
      if (Node::is_leaf(node.child[side])) builder.leaves.push_back({node.box(side), item_of(node.child[side])});
    }
  }
  size_ = builder.leaves.size();
  builder.build(nodes_, slots_, arena);
  root_ = nodes_.empty() ? Node::none : 0;
  ATL_ASSERT(nodes_.empty() == (size_ == 0), nodes_.size(), size_);
  free_ = Node::none;
}

}  // namespace atl::collision
