#include <collision/broadphase/proxies.h>
#include <jobs/append.h>
#include <jobs/assert.h>

#include <algorithm>

namespace atl::collision {

Proxies::Proxy& Proxies::claim(std::uint32_t shape, Kind kind) {
  if (shape >= proxies_.size()) jobs::append(proxies_, shape + std::size_t{1});
  ATL_ASSERT(proxies_[shape].kind == Kind::Free, shape, static_cast<int>(proxies_[shape].kind));
  ATL_ASSERT(kind != Kind::Free, shape);
  proxies_[shape].kind = kind;
  return proxies_[shape];
}

void Proxies::add_box(std::uint32_t shape, const Aabb& fat, bool fixed) {
  Proxy& proxy = claim(shape, fixed ? Kind::Fixed : Kind::Moving);
  proxy.fat = fat.known_or_nan();
  (fixed ? fixed_ : moving_).insert_later(shape, proxy.fat);
}

void Proxies::add_half_space(std::uint32_t shape, const Plane& plane) {
  claim(shape, Kind::HalfSpace);
  half_spaces_.insert(half_spaces_.begin() + static_cast<std::ptrdiff_t>(half_space_index(shape)),
                      HalfSpace{shape, plane});
}

void Proxies::remove(std::uint32_t shape) {
  ATL_ASSERT(contains(shape), shape, proxies_.size());
  Proxy& proxy = proxies_[shape];
  if (proxy.kind == Kind::HalfSpace) {
    half_spaces_.erase(half_spaces_.begin() + static_cast<std::ptrdiff_t>(half_space_index(shape)));
  } else {
    tree_of(proxy).remove(shape);
  }
  proxy = Proxy{};
}

void Proxies::set_box(std::uint32_t shape, const Aabb& fat) {
  ATL_ASSERT(contains(shape) && !is_half_space(shape), shape, proxies_.size());
  Proxy& proxy = proxies_[shape];
  proxy.fat = fat.known_or_nan();
  tree_of(proxy).move(shape, proxy.fat);
}

void Proxies::set_plane(std::uint32_t shape, const Plane& plane) {
  ATL_ASSERT(contains(shape) && is_half_space(shape), shape, proxies_.size());
  half_spaces_[half_space_index(shape)].plane = plane;
}

// The index of a half-space in the list; for any other shape, the index at which it would be inserted.
std::size_t Proxies::half_space_index(std::uint32_t shape) const {
  const auto place = std::lower_bound(half_spaces_.begin(), half_spaces_.end(), shape,
                                      [](const HalfSpace& other, std::uint32_t s) { return other.shape < s; });
  return static_cast<std::size_t>(place - half_spaces_.begin());
}

bool Proxies::overlap(std::uint32_t a, std::uint32_t b) const {
  ATL_ASSERT(contains(a) && contains(b), a, b, proxies_.size());
  const bool plane_a = is_half_space(a);
  const bool plane_b = is_half_space(b);
  if (!plane_a && !plane_b) return proxies_[a].fat.overlaps(proxies_[b].fat);
  if (plane_a && plane_b) return false;
  return touches(plane(plane_a ? a : b), proxies_[plane_a ? b : a].fat);
}

}  // namespace atl::collision
