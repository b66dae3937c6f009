// Vector algebra over lanes of doubles. Included once for each instruction set.

#if defined(ATOLL_COLLISION_WIDE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATOLL_COLLISION_WIDE_INL_H_
#undef ATOLL_COLLISION_WIDE_INL_H_
#else
#define ATOLL_COLLISION_WIDE_INL_H_
#endif

#include <jobs/lanes-inl.h>

HWY_BEFORE_NAMESPACE();
namespace atl::collision {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace jobs::HWY_NAMESPACE;
using jobs::block_lanes;

// Double lanes: poses may be far from the origin, and their differences are small.
using Wide = hn::CappedTag<double, block_lanes>;
using WideV = hn::Vec<Wide>;
constexpr std::size_t wide_lanes = hn::MaxLanes(Wide());

using WideV3 = Vector3Lanes<WideV>;
struct WideQ {
  WideV3 v;
  WideV w;
};

// The two doubles at from(lane) of every lane, as columns.
struct WidePair {
  WideV first, second;
};

#if HWY_TARGET == HWY_SCALAR

template <typename From>
HWY_INLINE WidePair load_pairs(const From& from) {
  const double* pair = from(std::size_t{0});
  return {hn::Set(Wide(), pair[0]), hn::Set(Wide(), pair[1])};
}

#else

// Blocks of two: those of every second lane from `k` on.
template <typename From, std::size_t n = wide_lanes>
HWY_INLINE WideV load_alternate_pairs(const From& from, std::size_t k) {
  const hn::FixedTag<double, 2> d2;
  if constexpr (n == 2) {
    return hn::LoadU(d2, from(k));
  } else {
    const hn::FixedTag<double, (n < 4 ? n : 4)> d4;
    const auto lower = hn::Combine(d4, hn::LoadU(d2, from(k + 2)), hn::LoadU(d2, from(k)));
    if constexpr (n == 4) {
      return lower;
    } else {
      const auto upper = hn::Combine(d4, hn::LoadU(d2, from(k + 6)), hn::LoadU(d2, from(k + 4)));
      return hn::Combine(hn::FixedTag<double, n>(), upper, lower);
    }
  }
}

template <typename From>
HWY_INLINE WidePair load_pairs(const From& from) {
  const WideV even = load_alternate_pairs(from, 0);
  const WideV odd = load_alternate_pairs(from, 1);
  return {hn::InterleaveLower(Wide(), even, odd), hn::InterleaveUpper(Wide(), even, odd)};
}

#endif  // HWY_TARGET == HWY_SCALAR

template <typename From>
HWY_INLINE WideV3 load_wide3(const From& from) {
  const WidePair xy = load_pairs(from);
  const WidePair yz = load_pairs([&](std::size_t k) { return from(k) + 1; });
  return {xy.first, xy.second, yz.second};
}
template <typename From>
HWY_INLINE WideQ load_wide4(const From& from) {
  const WidePair xy = load_pairs(from);
  const WidePair zw = load_pairs([&](std::size_t k) { return from(k) + 2; });
  return {{xy.first, xy.second, zw.first}, zw.second};
}
// v + 2 w (u x v) + 2 u x (u x v), u the vector part.
HWY_INLINE WideV3 rotate(const WideQ& q, const WideV3& v) {
  const WideV3 t = cross(q.v, v);
  const WideV3 twice = t + t;
  return (v + q.w * twice) + cross(q.v, twice);
}
HWY_INLINE WideQ conjugate_times(const WideQ& a, const WideQ& b) {
  return {(a.w * b.v - b.w * a.v) + cross(b.v, a.v), hn::Add(hn::Mul(a.w, b.w), dot(a.v, b.v))};
}
HWY_INLINE WideQ times_conjugate(const WideQ& a, const WideQ& b) {
  return {(b.w * a.v - a.w * b.v) + cross(b.v, a.v), hn::Add(hn::Mul(a.w, b.w), dot(a.v, b.v))};
}

}  // namespace HWY_NAMESPACE
}  // namespace atl::collision
HWY_AFTER_NAMESPACE();

#endif  // ATOLL_COLLISION_WIDE_INL_H_
