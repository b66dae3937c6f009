#include <collision/broadphase/broadphase.h>
#include <jobs/append.h>

#include <algorithm>

namespace atl::collision {

Broadphase::Proxy& Broadphase::claim(std::uint32_t shape, Kind kind, const Filter& filter) {
  if (shape >= proxies_.size()) {
    jobs::append(proxies_, shape + std::size_t{1});
    jobs::append(flags_, shape + std::size_t{1});
  }
  proxies_[shape].kind = kind;
  link(shape, filter);
  mark_moved(shape);
  return proxies_[shape];
}

Broadphase::Owner& Broadphase::owner(std::uint32_t number) {
  if (number >= owners_.size()) jobs::append(owners_, number + std::size_t{1});
  return owners_[number];
}

// Gives a shape its filter and a place among those of its owner.
void Broadphase::link(std::uint32_t shape, const Filter& filter) {
  Proxy& proxy = proxies_[shape];
  proxy.filter = filter;
  if (filter.owner == Filter::own_shape) proxy.filter.owner = shape;
  std::uint32_t& first = owner(proxy.filter.owner).first_shape;
  proxy.next_of_owner = first;
  proxy.previous_of_owner = no_shape;
  if (first != no_shape) proxies_[first].previous_of_owner = shape;
  first = shape;
  restrict(shape);
}

void Broadphase::unlink(std::uint32_t shape) {
  const Proxy& proxy = proxies_[shape];
  const std::uint32_t next = proxy.next_of_owner;
  const std::uint32_t previous = proxy.previous_of_owner;
  if (next != no_shape) proxies_[next].previous_of_owner = previous;
  (previous != no_shape ? proxies_[previous].next_of_owner : owners_[proxy.filter.owner].first_shape) = next;
}

// Two shapes without restrictions may meet, without a look at their filters: their owners differ.
void Broadphase::restrict(std::uint32_t shape) {
  const Filter& filter = proxies_[shape].filter;
  const bool restricted = filter != Filter{.owner = shape} || owners_[filter.owner].ignored_owners > 0;
  flags_[shape] = static_cast<std::uint8_t>((flags_[shape] & ~restricted_flag) | (restricted ? restricted_flag : 0));
}

void Broadphase::mark_moved(std::uint32_t shape) {
  if (has_moved(shape)) return;
  flags_[shape] |= moved_flag;
  moved_.push_back(shape);
}

// After a change of what the owner ignores.
void Broadphase::mark_shapes_of(std::uint32_t owner) {
  for (std::uint32_t shape = owners_[owner].first_shape; shape != no_shape; shape = proxies_[shape].next_of_owner) {
    restrict(shape);
    mark_moved(shape);
  }
}

void Broadphase::add_box(std::uint32_t shape, const Aabb& fat, bool fixed, const Filter& filter) {
  Proxy& proxy = claim(shape, fixed ? Kind::Fixed : Kind::Moving, filter);
  proxy.fat = fat.known_or_nan();
  fixed ? fixed_.insert_later(shape, proxy.fat) : moving_.insert(shape, proxy.fat);
}

void Broadphase::add_half_space(std::uint32_t shape, const Plane& plane, const Filter& filter) {
  claim(shape, Kind::HalfSpace, filter);
  half_spaces_.insert(half_spaces_.begin() + static_cast<std::ptrdiff_t>(half_space_index(shape)),
                      HalfSpace{shape, plane});
}

void Broadphase::remove(std::uint32_t shape) {
  Proxy& proxy = proxies_[shape];
  if (proxy.kind == Kind::HalfSpace) {
    half_spaces_.erase(half_spaces_.begin() + static_cast<std::ptrdiff_t>(half_space_index(shape)));
  } else {
    tree_of(proxy).remove(shape);
  }
  unlink(shape);
  // Its entry in moved_, if there is one, stays until all are forgotten: to look for it takes too long.
  proxy = Proxy{};
}

void Broadphase::set_filter(std::uint32_t shape, const Filter& filter) {
  unlink(shape);
  link(shape, filter);
  mark_moved(shape);
}

void Broadphase::ignore(std::uint32_t owner_a, std::uint32_t owner_b) {
  const Pair owners = Pair::of(owner_a, owner_b);
  if (owner_a == owner_b || ignored_.contains(owners)) return;
  ignored_.insert(owners);
  for (const std::uint32_t number : {owner_a, owner_b}) {
    ++owner(number).ignored_owners;
    mark_shapes_of(number);
  }
}

void Broadphase::unignore(std::uint32_t owner_a, std::uint32_t owner_b) {
  const Pair owners = Pair::of(owner_a, owner_b);
  if (!ignored_.contains(owners)) return;
  ignored_.erase(owners);
  for (const std::uint32_t number : {owner_a, owner_b}) {
    --owner(number).ignored_owners;
    mark_shapes_of(number);
  }
}

bool Broadphase::allowed(std::uint32_t a, std::uint32_t b) const {
  if (((flags_[a] | flags_[b]) & restricted_flag) == 0) return a != b;
  const Filter& x = proxies_[a].filter;
  const Filter& y = proxies_[b].filter;
  if (!may_meet(x, y)) return false;
  if (owners_[x.owner].ignored_owners == 0 || owners_[y.owner].ignored_owners == 0) return true;
  return !ignored_.contains(Pair::of(x.owner, y.owner));
}

void Broadphase::move_box(std::uint32_t shape, const Aabb& fat) {
  restore_box(shape, fat);
  mark_moved(shape);
}

void Broadphase::move_half_space(std::uint32_t shape, const Plane& plane) {
  restore_half_space(shape, plane);
  mark_moved(shape);
}

void Broadphase::restore_box(std::uint32_t shape, const Aabb& fat) {
  Proxy& proxy = proxies_[shape];
  proxy.fat = fat.known_or_nan();
  tree_of(proxy).move(shape, proxy.fat);
}

void Broadphase::restore_half_space(std::uint32_t shape, const Plane& plane) {
  half_spaces_[half_space_index(shape)].plane = plane;
}

// Of a shape that is none: where it would stand.
std::size_t Broadphase::half_space_index(std::uint32_t shape) const {
  const auto place = std::lower_bound(half_spaces_.begin(), half_spaces_.end(), shape,
                                      [](const HalfSpace& other, std::uint32_t s) { return other.shape < s; });
  return static_cast<std::size_t>(place - half_spaces_.begin());
}

bool Broadphase::overlap(std::uint32_t a, std::uint32_t b) const {
  if (!allowed(a, b)) return false;
  const bool plane_a = is_half_space(a);
  const bool plane_b = is_half_space(b);
  if (!plane_a && !plane_b) return proxies_[a].fat.overlaps(proxies_[b].fat);
  if (plane_a && plane_b) return false;
  const std::uint32_t shape = plane_a ? a : b;
  return touches(half_spaces_[half_space_index(shape)].plane, proxies_[plane_a ? b : a].fat);
}

// The pairs that a shape has to report, known or not.
void Broadphase::find_partners(std::uint32_t shape, std::vector<Pair>& found) const {
  const Proxy& proxy = proxies_[shape];
  const auto report = [&](std::uint32_t other) {
    if (allowed(shape, other)) found.push_back(Pair::of(shape, other));
  };
  const auto consider = [&](std::uint32_t other) {
    // Of two shapes that both moved, the lower one reports the pair. And this one moved.
    if (other > shape || !has_moved(other)) report(other);
  };
  if (proxy.kind == Kind::Free || meets_nothing(proxy.filter)) return;
  if (proxy.kind == Kind::HalfSpace) {
    const Plane& plane = half_spaces_[half_space_index(shape)].plane;
    moving_.query_if([&plane](const Aabb& box) { return touches(plane, box); }, consider);
    return;
  }
  const bool moved = has_moved(shape);
  if (moved) moving_.query(proxy.fat, consider);
  if (proxy.kind == Kind::Fixed) return;
  if (moving_ask_) {
    fixed_.query(proxy.fat, [&](std::uint32_t other) {
      if (moved || has_moved(other)) report(other);
    });
  } else {
    fixed_.query(proxy.fat, consider);
  }
  if (!moved) return;
  for (const HalfSpace& half_space : half_spaces_) {
    if (touches(half_space.plane, proxy.fat)) consider(half_space.shape);
  }
}

// Where more fixed shapes were added or moved than there are moving ones, these ask for them.
std::span<const std::uint32_t> Broadphase::list_askers() {
  moving_ask_ = false;
  if (moved_.size() > moving_.size()) {
    const auto is_fixed = [this](std::uint32_t shape) { return proxies_[shape].kind == Kind::Fixed; };
    const auto fixed = static_cast<std::size_t>(std::count_if(moved_.begin(), moved_.end(), is_fixed));
    moving_ask_ = fixed > moving_.size();
  }
  if (!moving_ask_) return moved_;
  askers_.clear();
  for (const std::uint32_t shape : moved_) {
    if (proxies_[shape].kind == Kind::HalfSpace) askers_.push_back(shape);
  }
  moving_.for_each([this](std::uint32_t shape) { askers_.push_back(shape); });
  return askers_;
}

// Whether one of them may meet fixed ones.
bool Broadphase::ask_fixed(std::span<const std::uint32_t> askers) const {
  return std::any_of(askers.begin(), askers.end(), [this](std::uint32_t shape) {
    return proxies_[shape].kind == Kind::Moving && !meets_nothing(proxies_[shape].filter);
  });
}

std::span<const Pair> Broadphase::find_new_pairs(const PairSet& known, jobs::Arena& arena) {
  new_pairs_.clear();
  // All pairs have a moving shape.
  if (moving_.size() == 0) return new_pairs_;
  moving_.rebuild_if_worn(&arena);
  const std::span<const std::uint32_t> askers = list_askers();
  if (fixed_.is_behind() && ask_fixed(askers)) fixed_.take_in(&arena);
  fixed_.rebuild_if_worn(&arena);

  constexpr std::size_t grain = 64;
  const std::size_t chunks = jobs::Arena::chunk_count(askers.size(), grain);
  if (found_.size() < chunks) found_.resize(chunks);
  arena.parallel_for(askers.size(), grain, [&](std::size_t begin, std::size_t end) {
    std::vector<Pair>& found = found_[begin / grain];
    found.clear();
    for (std::size_t i = begin; i < end; ++i) find_partners(askers[i], found);
    known.drop_contained(found, 0);
  });

  for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
    new_pairs_.insert(new_pairs_.end(), found_[chunk].begin(), found_[chunk].end());
  }
  // No pair is found twice, so sorted they show neither the order of moves nor the trees' shape.
  sort_pairs(new_pairs_, sort_scratch_);
  return new_pairs_;
}

void Broadphase::forget_moves() {
  constexpr auto kept = static_cast<std::uint8_t>(~moved_flag);
  if (moved_.size() < flags_.size() / 16) {
    for (const std::uint32_t shape : moved_) flags_[shape] &= kept;
  } else {
    for (std::uint8_t& flags : flags_) flags &= kept;
  }
  moved_.clear();
}

}  // namespace atl::collision
