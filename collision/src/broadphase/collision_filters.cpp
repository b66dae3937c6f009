#include <collision/broadphase/collision_filters.h>
#include <jobs/append.h>
#include <jobs/assert.h>

namespace atl::collision {

void CollisionFilters::add(std::uint32_t shape, const Filter& filter) {
  if (shape >= entries_.size()) {
    jobs::append(entries_, shape + std::size_t{1});
    jobs::append(restricted_, shape + std::size_t{1});
  }
  ATL_ASSERT(entries_[shape].filter.owner == Filter::own_shape, shape, entries_[shape].filter.owner);
  link(shape, filter);
}

void CollisionFilters::remove(std::uint32_t shape) {
  unlink(shape);
  entries_[shape] = Entry{};
}

void CollisionFilters::set(std::uint32_t shape, const Filter& filter) {
  unlink(shape);
  link(shape, filter);
}

CollisionFilters::Owner& CollisionFilters::owner(std::uint32_t number) {
  if (number >= owners_.size()) jobs::append(owners_, number + std::size_t{1});
  return owners_[number];
}

// Gives a shape its filter and a place among those of its owner.
void CollisionFilters::link(std::uint32_t shape, const Filter& filter) {
  Entry& entry = entries_[shape];
  entry.filter = filter;
  if (filter.owner == Filter::own_shape) entry.filter.owner = shape;
  std::uint32_t& first = owner(entry.filter.owner).first_shape;
  entry.next_of_owner = first;
  entry.previous_of_owner = no_shape;
  if (first != no_shape) entries_[first].previous_of_owner = shape;
  first = shape;
  update_restricted(shape);
}

void CollisionFilters::unlink(std::uint32_t shape) {
  const Entry& entry = entries_[shape];
  ATL_ASSERT(entry.filter.owner < owners_.size(), shape, entry.filter.owner, owners_.size());
  const std::uint32_t next = entry.next_of_owner;
  const std::uint32_t previous = entry.previous_of_owner;
  ATL_ASSERT(next == no_shape || entries_[next].previous_of_owner == shape, shape, next);
  ATL_ASSERT(previous != no_shape ? entries_[previous].next_of_owner == shape
                                  : owners_[entry.filter.owner].first_shape == shape,
             shape, previous, entry.filter.owner);
  if (next != no_shape) entries_[next].previous_of_owner = previous;
  (previous != no_shape ? entries_[previous].next_of_owner : owners_[entry.filter.owner].first_shape) = next;
}

// Two shapes without restrictions may meet, without a look at their filters: their owners differ.
void CollisionFilters::update_restricted(std::uint32_t shape) {
  const Filter& filter = entries_[shape].filter;
  restricted_[shape] = filter != Filter{.owner = shape} || owners_[filter.owner].disabled_pairs > 0 ? 1 : 0;
}

void CollisionFilters::count_disabled(std::uint32_t number, std::int32_t change) {
  ATL_ASSERT(change > 0 || owner(number).disabled_pairs > 0, number, change);
  owner(number).disabled_pairs += static_cast<std::uint32_t>(change);
  for_each_shape_of(number, [this](std::uint32_t shape) { update_restricted(shape); });
}

bool CollisionFilters::disable_pair(std::uint32_t owner_a, std::uint32_t owner_b) {
  const Pair owners = Pair::of(owner_a, owner_b);
  if (owner_a == owner_b || disabled_.contains(owners)) return false;
  disabled_.insert(owners);
  count_disabled(owner_a, 1);
  count_disabled(owner_b, 1);
  return true;
}

bool CollisionFilters::enable_pair(std::uint32_t owner_a, std::uint32_t owner_b) {
  const Pair owners = Pair::of(owner_a, owner_b);
  if (!disabled_.contains(owners)) return false;
  disabled_.erase(owners);
  count_disabled(owner_a, -1);
  count_disabled(owner_b, -1);
  return true;
}

bool CollisionFilters::filters_allow(std::uint32_t a, std::uint32_t b) const {
  const Filter& x = entries_[a].filter;
  const Filter& y = entries_[b].filter;
  if (!may_meet(x, y)) return false;
  ATL_ASSERT(x.owner < owners_.size() && y.owner < owners_.size(), a, x.owner, b, y.owner, owners_.size());
  if (owners_[x.owner].disabled_pairs == 0 || owners_[y.owner].disabled_pairs == 0) return true;
  return !disabled_.contains(Pair::of(x.owner, y.owner));
}

}  // namespace atl::collision
