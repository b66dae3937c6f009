// Small vector algebra and row transposes over lanes, for the kernels of the layers above. Included once for each
// instruction set, by a file that Highway compiles for each.

#if defined(ATOLL_JOBS_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATOLL_JOBS_LANES_INL_H_
#undef ATOLL_JOBS_LANES_INL_H_
#else
#define ATOLL_JOBS_LANES_INL_H_
#endif

#include <hwy/highway.h>
#include <jobs/block_lanes.h>

HWY_BEFORE_NAMESPACE();
namespace atl::jobs {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// The name by which users choose the instruction set.
HWY_INLINE const char* set_name() {
  switch (HWY_TARGET) {
    case HWY_AVX3:
      return "avx512";
    case HWY_AVX2:
      return "avx2";
    case HWY_SSE4:
      return "sse4";
    case HWY_NEON:
      return "neon";
    default:
      return "portable";
  }
}

// A whole block where the set is wide enough, else a part of it.
using D = hn::CappedTag<float, block_lanes>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;
constexpr std::size_t lanes = hn::MaxLanes(D());

HWY_INLINE V splat(float value) { return hn::Set(D(), value); }
HWY_INLINE V zero() { return hn::Zero(D()); }
HWY_INLINE V load(const float* from) { return hn::Load(D(), from); }
HWY_INLINE void store(V value, float* to) { hn::Store(value, D(), to); }

// Vectors in lanes, of floats or doubles.
template <typename Lane>
struct Vector3Lanes {
  Lane x, y, z;
};
using V3 = Vector3Lanes<V>;

HWY_INLINE V3 load3(const float (*rows)[block_lanes], std::size_t lane) {
  return {load(rows[0] + lane), load(rows[1] + lane), load(rows[2] + lane)};
}
HWY_INLINE void store3(const V3& v, float (*rows)[block_lanes], std::size_t lane) {
  store(v.x, rows[0] + lane);
  store(v.y, rows[1] + lane);
  store(v.z, rows[2] + lane);
}

template <typename Lane>
HWY_INLINE Vector3Lanes<Lane> operator+(const Vector3Lanes<Lane>& a, const Vector3Lanes<Lane>& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
template <typename Lane>
HWY_INLINE Vector3Lanes<Lane> operator-(const Vector3Lanes<Lane>& a, const Vector3Lanes<Lane>& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
template <typename Lane>
HWY_INLINE Vector3Lanes<Lane> operator*(Lane s, const Vector3Lanes<Lane>& a) {
  return {hn::Mul(s, a.x), hn::Mul(s, a.y), hn::Mul(s, a.z)};
}

template <typename Lane>
HWY_INLINE Lane dot(const Vector3Lanes<Lane>& a, const Vector3Lanes<Lane>& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
template <typename Lane>
HWY_INLINE Vector3Lanes<Lane> cross(const Vector3Lanes<Lane>& a, const Vector3Lanes<Lane>& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}

HWY_INLINE V3 select(M mask, const V3& yes, const V3& no) {
  return {hn::IfThenElse(mask, yes.x, no.x), hn::IfThenElse(mask, yes.y, no.y), hn::IfThenElse(mask, yes.z, no.z)};
}

// Quaternions.
struct Q {
  V3 vector;
  V scalar;
};

HWY_INLINE Q operator*(const Q& a, const Q& b) {
  return {(a.scalar * b.vector + b.scalar * a.vector) + cross(a.vector, b.vector),
          hn::Sub(hn::Mul(a.scalar, b.scalar), dot(a.vector, b.vector))};
}
HWY_INLINE Q conjugate(const Q& q) {
  return {{hn::Neg(q.vector.x), hn::Neg(q.vector.y), hn::Neg(q.vector.z)}, q.scalar};
}
HWY_INLINE Q normalized(const Q& q) {
  const V norm = hn::Sqrt(hn::Add(dot(q.vector, q.vector), hn::Mul(q.scalar, q.scalar)));
  const V scale = hn::Div(splat(1), norm);
  return {scale * q.vector, hn::Mul(scale, q.scalar)};
}
// R(q) v - v, of a small rotation without cancellation.
HWY_INLINE V3 turned_change(const Q& q, const V3& v) {
  const V3 t = cross(q.vector, v);
  const V3 twice = t + t;
  return q.scalar * twice + cross(q.vector, twice);
}
// R(q) v.
HWY_INLINE V3 turned(const Q& q, const V3& v) { return v + turned_change(q, v); }

// Two unit vectors that make a right-handed frame with a unit vector. The same operations in the same order as in
// collision::tangents(), which names the source.
struct TangentLanes {
  V3 first, second;
};
HWY_INLINE TangentLanes tangent_lanes(const V3& n) {
  const V sign = hn::CopySign(splat(1), n.z);
  const V a = hn::Div(splat(-1), hn::Add(sign, n.z));
  const V b = hn::Mul(hn::Mul(n.x, n.y), a);
  return {
      {hn::Add(splat(1), hn::Mul(sign, hn::Mul(hn::Mul(n.x, n.x), a))), hn::Mul(sign, b), hn::Neg(hn::Mul(sign, n.x))},
      {b, hn::Add(sign, hn::Mul(hn::Mul(n.y, n.y), a)), hn::Neg(n.y)}};
}

HWY_INLINE V clamp_to(V value, V bound) { return hn::Max(hn::Neg(bound), hn::Min(value, bound)); }

struct SymmetricMatrix {
  V xx, yy, zz, xy, xz, yz;
};
HWY_INLINE V3 operator*(const SymmetricMatrix& m, const V3& v) {
  return {hn::Add(hn::Add(hn::Mul(m.xx, v.x), hn::Mul(m.xy, v.y)), hn::Mul(m.xz, v.z)),
          hn::Add(hn::Add(hn::Mul(m.xy, v.x), hn::Mul(m.yy, v.y)), hn::Mul(m.yz, v.z)),
          hn::Add(hn::Add(hn::Mul(m.xz, v.x), hn::Mul(m.yz, v.y)), hn::Mul(m.zz, v.z))};
}

// Four vectors: component i of the row of every lane.
struct V4 {
  V x, y, z, w;
};

#if HWY_TARGET == HWY_SCALAR

// Loads one row of four floats a lane, from row_of(lane), 16-byte aligned.
template <typename RowOf>
HWY_INLINE V4 load_rows(const RowOf& row_of) {
  const float* row = row_of(std::size_t{0});
  return {splat(row[0]), splat(row[1]), splat(row[2]), splat(row[3])};
}

// Stores one row a lane, to row_of(lane), for the lanes in `mask` (bit k: lane k).
template <typename RowOf>
HWY_INLINE void store_rows(const V4& columns, const RowOf& row_of, unsigned mask) {
  if ((mask & 1) == 0) return;
  float* row = row_of(std::size_t{0});
  row[0] = hn::GetLane(columns.x);
  row[1] = hn::GetLane(columns.y);
  row[2] = hn::GetLane(columns.z);
  row[3] = hn::GetLane(columns.w);
}

#else

// Transposes, within each 128-bit block, four rows of four. Its own inverse.
HWY_INLINE V4 transpose(V a, V b, V c, V e) {
  const D d;
  const hn::RepartitionToWide<D> wide;
  const auto ab_lower = hn::BitCast(wide, hn::InterleaveLower(d, a, b));
  const auto ab_upper = hn::BitCast(wide, hn::InterleaveUpper(d, a, b));
  const auto ce_lower = hn::BitCast(wide, hn::InterleaveLower(d, c, e));
  const auto ce_upper = hn::BitCast(wide, hn::InterleaveUpper(d, c, e));
  return {hn::BitCast(d, hn::InterleaveLower(wide, ab_lower, ce_lower)),
          hn::BitCast(d, hn::InterleaveUpper(wide, ab_lower, ce_lower)),
          hn::BitCast(d, hn::InterleaveLower(wide, ab_upper, ce_upper)),
          hn::BitCast(d, hn::InterleaveUpper(wide, ab_upper, ce_upper))};
}

// Row k of the lower and, where there are eight lanes, row k + 4 of the upper half.
template <typename RowOf, std::size_t n = lanes>
HWY_INLINE V load_row_pair(const RowOf& row_of, std::size_t k) {
  const hn::FixedTag<float, 4> d4;
  if constexpr (n == 4) {
    return hn::Load(d4, row_of(k));
  } else {
    return hn::Combine(hn::FixedTag<float, n>(), hn::Load(d4, row_of(k + 4)), hn::Load(d4, row_of(k)));
  }
}

template <typename Rows, typename RowOf>
HWY_INLINE void store_row_pair(Rows rows, const RowOf& row_of, std::size_t k, bool lower, bool upper) {
  const hn::FixedTag<float, 4> d4;
  if constexpr (lanes == 4) {
    if (lower) hn::Store(rows, d4, row_of(k));
  } else {
    if (lower) hn::Store(hn::LowerHalf(d4, rows), d4, row_of(k));
    if (upper) hn::Store(hn::UpperHalf(d4, rows), d4, row_of(k + 4));
  }
}

// Loads one row of four floats a lane, from row_of(lane), 16-byte aligned.
template <typename RowOf>
HWY_INLINE V4 load_rows(const RowOf& row_of) {
  return transpose(load_row_pair(row_of, 0), load_row_pair(row_of, 1), load_row_pair(row_of, 2),
                   load_row_pair(row_of, 3));
}

// Stores one row a lane, to row_of(lane), for the lanes in `mask` (bit k: lane k).
template <typename RowOf>
HWY_INLINE void store_rows(const V4& columns, const RowOf& row_of, unsigned mask) {
  const V4 rows = transpose(columns.x, columns.y, columns.z, columns.w);
  constexpr unsigned all = (1u << lanes) - 1;
  const V row[4] = {rows.x, rows.y, rows.z, rows.w};
  if ((mask & all) == all) {
    for (std::size_t k = 0; k < 4; ++k) store_row_pair(row[k], row_of, k, true, true);
  } else {
    for (std::size_t k = 0; k < 4; ++k) {
      store_row_pair(row[k], row_of, k, (mask >> k & 1) != 0, (mask >> (k + 4) & 1) != 0);
    }
  }
}

#endif  // HWY_TARGET == HWY_SCALAR

}  // namespace HWY_NAMESPACE
}  // namespace atl::jobs
HWY_AFTER_NAMESPACE();

#endif  // ATOLL_JOBS_LANES_INL_H_
