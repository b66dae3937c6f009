#include <collision/broadphase/aabb_tree.h>
#include <jobs/assert.h>
#include <jobs/scratch.h>

#include <utility>

namespace atl::collision {

void AabbTree::insert(std::uint32_t item, const Aabb& box) {
  ++changes_;
  nodes_.insert(item, box);
  if (nodes_.is_too_high()) rebuild({}, nullptr);
}

void AabbTree::insert_later(std::uint32_t item, const Aabb& box) {
  nodes_.set_aside(item, ~static_cast<std::int32_t>(later_.size()));
  later_.push_back({box, item});
}

void AabbTree::take_in(jobs::Arena* arena) {
  // Leaves that are built in the time in which one is inserted. For a thousand to a million unit boxes strewn over a
  // plane that is 1 to 2.3 us against 0.1 to 0.2 us. Fewer new leaves than a tenth of the tree are inserted.
  constexpr std::size_t insertion = 10;
  if (later_.empty()) return;
  const std::size_t all = size();
  if (later_.size() * insertion < all) {
    for (const AabbTreeLeaf& leaf : later_) insert(leaf.item, leaf.box);
    later_.clear();
    return;
  }
  // Gives back the memory for so many items, since batches of this size are rare.
  rebuild(std::exchange(later_, {}), arena);
  builder_.clear();
  builder_.shrink_to_fit();
}

void AabbTree::remove(std::uint32_t item) {
  const std::int32_t slot = nodes_.slot(item);
  if (slot >= 0) {
    ++changes_;
    nodes_.remove(item);
    return;
  }
  ATL_ASSERT(static_cast<std::size_t>(~slot) < later_.size(), item, slot, later_.size());
  ATL_ASSERT(waiting(slot).item == item, item, slot, waiting(slot).item);
  // The last one takes its place.
  nodes_.set_aside(item, AabbTreeNode::none);
  AabbTreeLeaf& leaf = waiting(slot);
  if (later_.back().item != item) {
    leaf = later_.back();
    nodes_.set_aside(leaf.item, slot);
  }
  later_.pop_back();
}

void AabbTree::move(std::uint32_t item, const Aabb& box) {
  const std::int32_t slot = nodes_.slot(item);
  if (slot < 0) {
    ATL_ASSERT(static_cast<std::size_t>(~slot) < later_.size(), item, slot, later_.size());
    waiting(slot).box = box;
    return;
  }
  // Far from its neighbours a leaf would make the boxes around all of them large.
  if (nodes_.size() > 2 && !nodes_.box(item).overlaps(box)) {
    remove(item);
    insert(item, box);
    return;
  }
  ++changes_;
  nodes_.set_box(item, box);
}

void AabbTree::rebuild_if_worn(jobs::Arena* arena) {
  if (changes_ >= nodes_.size() && nodes_.size() > 2) rebuild({}, arena);
}

// Takes these leaves and those of the nodes. Only a large tree has a builder of its own: small ones take that of the
// thread.
void AabbTree::rebuild(std::vector<AabbTreeLeaf> leaves, jobs::Arena* arena) {
  constexpr std::size_t large = 4096;
  changes_ = 0;
  const jobs::Borrowed<AabbTreeBuilder> of_thread;
  const std::size_t size = leaves.size() + nodes_.size();
  if (size >= large && builder_.empty()) builder_.resize(1);
  AabbTreeBuilder& builder = size >= large ? builder_.front() : *of_thread;
  if (leaves.empty()) {
    builder.leaves.clear();
  } else {
    builder.leaves = std::move(leaves);
  }
  builder.leaves.reserve(size);
  nodes_.rebuild(builder, arena);
  ATL_ASSERT(nodes_.size() == size, nodes_.size(), size);
  ATL_ASSERT(!nodes_.is_too_high(), size);
}

}  // namespace atl::collision
