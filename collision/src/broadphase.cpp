#include <collision/broadphase.h>

#include <algorithm>
#include <cmath>

namespace atl::collision {

Broadphase::Proxy& Broadphase::claim(std::uint32_t shape, Kind kind) {
  if (shape >= proxies_.size()) proxies_.resize(shape + std::size_t{1});
  proxies_[shape].kind = kind;
  mark_moved(shape);
  return proxies_[shape];
}

void Broadphase::mark_moved(std::uint32_t shape) {
  if (proxies_[shape].moved) return;
  proxies_[shape].moved = true;
  moved_.push_back(shape);
}

void Broadphase::add_box(std::uint32_t shape, const Aabb& fat, bool fixed) {
  Proxy& proxy = claim(shape, fixed ? Kind::Fixed : Kind::Moving);
  proxy.fat = fat;
  proxy.leaf = (fixed ? fixed_ : moving_).insert(shape, fat);
}

void Broadphase::add_half_space(std::uint32_t shape, const Plane& plane) {
  claim(shape, Kind::HalfSpace);
  half_spaces_.insert(half_spaces_.begin() + static_cast<std::ptrdiff_t>(half_space_index(shape)),
                      HalfSpace{shape, plane});
}

void Broadphase::remove(std::uint32_t shape) {
  Proxy& proxy = proxies_[shape];
  if (proxy.kind == Kind::HalfSpace) {
    std::erase_if(half_spaces_, [shape](const HalfSpace& other) { return other.shape == shape; });
  } else {
    (proxy.kind == Kind::Fixed ? fixed_ : moving_).remove(proxy.leaf);
  }
  if (proxy.moved) std::erase(moved_, shape);
  proxy = Proxy{};
}

void Broadphase::move_box(std::uint32_t shape, const Aabb& fat) {
  Proxy& proxy = proxies_[shape];
  proxy.fat = fat;
  (proxy.kind == Kind::Fixed ? fixed_ : moving_).move(proxy.leaf, fat);
  mark_moved(shape);
}

void Broadphase::move_half_space(std::uint32_t shape, const Plane& plane) {
  half_spaces_[half_space_index(shape)].plane = plane;
  mark_moved(shape);
}

// Of a shape that is none: where it would stand.
std::size_t Broadphase::half_space_index(std::uint32_t shape) const {
  const auto place = std::lower_bound(half_spaces_.begin(), half_spaces_.end(), shape,
                                      [](const HalfSpace& other, std::uint32_t s) { return other.shape < s; });
  return static_cast<std::size_t>(place - half_spaces_.begin());
}

// In double: the plane may be far from the world's origin.
bool Broadphase::touches(const Plane& plane, const Aabb& box) {
  double lowest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double n = plane.normal[static_cast<Eigen::Index>(i)];
    lowest += n * static_cast<double>(n > 0 ? box.lower[i] : box.upper[i]);
  }
  return lowest <= plane.offset;
}

bool Broadphase::overlap(std::uint32_t a, std::uint32_t b) const {
  const bool plane_a = is_half_space(a);
  const bool plane_b = is_half_space(b);
  if (!plane_a && !plane_b) return proxies_[a].fat.overlaps(proxies_[b].fat);
  if (plane_a && plane_b) return false;
  const std::uint32_t shape = plane_a ? a : b;
  return touches(half_spaces_[half_space_index(shape)].plane, proxies_[plane_a ? b : a].fat);
}

void Broadphase::query(std::uint32_t shape, const PairSet& known, std::vector<Pair>& found) const {
  const Proxy& proxy = proxies_[shape];
  const auto consider = [&](std::uint32_t other) {
    // Of two shapes that both moved, the lower one reports the pair.
    if (other == shape || (proxies_[other].moved && other < shape)) return;
    const Pair pair = Pair::of(shape, other);
    if (!known.contains(pair)) found.push_back(pair);
  };
  if (proxy.kind == Kind::HalfSpace) {
    const Plane& plane = half_spaces_[half_space_index(shape)].plane;
    for (std::uint32_t other = 0; other < proxies_.size(); ++other) {
      if (proxies_[other].kind == Kind::Moving && touches(plane, proxies_[other].fat)) consider(other);
    }
    return;
  }
  moving_.query(proxy.fat, consider);
  if (proxy.kind == Kind::Fixed) return;
  fixed_.query(proxy.fat, consider);
  for (const HalfSpace& half_space : half_spaces_) {
    if (touches(half_space.plane, proxy.fat)) consider(half_space.shape);
  }
}

std::span<const Pair> Broadphase::find_new_pairs(const PairSet& known, jobs::Arena& arena) {
  moving_.rebuild_if_worn();
  fixed_.rebuild_if_worn();
  std::sort(moved_.begin(), moved_.end());

  constexpr std::size_t grain = 64;
  const std::size_t chunks = jobs::Arena::chunk_count(moved_.size(), grain);
  if (found_.size() < chunks) found_.resize(chunks);
  arena.parallel_for(moved_.size(), grain, [&](std::size_t begin, std::size_t end) {
    std::vector<Pair>& found = found_[begin / grain];
    found.clear();
    for (std::size_t i = begin; i < end; ++i) query(moved_[i], known, found);
  });

  new_pairs_.clear();
  for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
    new_pairs_.insert(new_pairs_.end(), found_[chunk].begin(), found_[chunk].end());
  }
  std::sort(new_pairs_.begin(), new_pairs_.end());
  return new_pairs_;
}

void Broadphase::forget_moves() {
  for (const std::uint32_t shape : moved_) proxies_[shape].moved = false;
  moved_.clear();
}

}  // namespace atl::collision
