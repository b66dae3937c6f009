// The axes that part two boxes best, for a lane of pairs. Included once for each instruction set.

#if defined(ATOLL_COLLISION_BOX_AXES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATOLL_COLLISION_BOX_AXES_INL_H_
#undef ATOLL_COLLISION_BOX_AXES_INL_H_
#else
#define ATOLL_COLLISION_BOX_AXES_INL_H_
#endif

#include <collision/narrowphase/box_axes.h>

#include <limits>

#include "narrowphase/wide-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atl::collision {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

HWY_INLINE WideV wide(double value) { return hn::Set(Wide(), value); }

// The axis of the greatest separation of those offered; of equals, the first.
struct BestAxis {
  WideV separation, code;

  HWY_INLINE void offer(WideV fresh, double of) {
    const auto better = hn::Gt(fresh, separation);
    separation = hn::IfThenElse(better, fresh, separation);
    code = hn::IfThenElse(better, wide(of), code);
  }
};

HWY_INLINE WideV nowhere() { return wide(-std::numeric_limits<double>::infinity()); }
HWY_INLINE BestAxis no_axis() { return {nowhere(), wide(0)}; }

HWY_INLINE void find_box_axes(const BoxBlock& block, std::size_t lane, BoxAxes& axes) {
  const auto of = [lane](const auto& pointers) {
    return [&pointers, lane](std::size_t k) { return pointers[lane + k]; };
  };
  const auto put = [lane](BoxAxes::Row& row, WideV value) { hn::Store(value, Wide(), row.data() + lane); };

  // The second box in the frame of the first.
  const WideQ first = load_wide4(of(block.orientation_first));
  const WideQ q = conjugate_times(first, load_wide4(of(block.orientation_second)));
  const WideV3 between = load_wide3(of(block.position_second)) - load_wide3(of(block.position_first));
  const WideQ inverse = {{hn::Neg(first.v.x), hn::Neg(first.v.y), hn::Neg(first.v.z)}, first.w};
  const WideV3 seen = rotate(inverse, between);
  const WideV t[3] = {seen.x, seen.y, seen.z};
  const WideV one = wide(1);
  const WideV3 twice = q.v + q.v;
  const WideV xx = hn::Mul(twice.x, q.v.x), xy = hn::Mul(twice.x, q.v.y), xz = hn::Mul(twice.x, q.v.z);
  const WideV yy = hn::Mul(twice.y, q.v.y), yz = hn::Mul(twice.y, q.v.z), zz = hn::Mul(twice.z, q.v.z);
  const WideV wx = hn::Mul(twice.x, q.w), wy = hn::Mul(twice.y, q.w), wz = hn::Mul(twice.z, q.w);
  const WideV r[3][3] = {{hn::Sub(one, hn::Add(yy, zz)), hn::Sub(xy, wz), hn::Add(xz, wy)},
                         {hn::Add(xy, wz), hn::Sub(one, hn::Add(xx, zz)), hn::Sub(yz, wx)},
                         {hn::Sub(xz, wy), hn::Add(yz, wx), hn::Sub(one, hn::Add(xx, yy))}};
  for (std::size_t i = 0; i < 3; ++i) {
    put(axes.position[i], t[i]);
    for (std::size_t j = 0; j < 3; ++j) put(axes.rotation[3 * j + i], r[i][j]);
  }
  put(axes.orientation[0], q.v.x);
  put(axes.orientation[1], q.v.y);
  put(axes.orientation[2], q.v.z);
  put(axes.orientation[3], q.w);

  const WideV3 half_first = load_wide3(of(block.half_first));
  const WideV3 half_second = load_wide3(of(block.half_second));
  const WideV a[3] = {half_first.x, half_first.y, half_first.z};
  const WideV b[3] = {half_second.x, half_second.y, half_second.z};
  WideV along[3][3];
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) along[i][j] = hn::Abs(r[i][j]);
  }

  BestAxis face = no_axis();
  for (std::size_t i = 0; i < 3; ++i) {
    const WideV reach =
        hn::Add(hn::Add(hn::Mul(along[i][0], b[0]), hn::Mul(along[i][1], b[1])), hn::Mul(along[i][2], b[2]));
    face.offer(hn::Sub(hn::Sub(hn::Abs(t[i]), a[i]), reach), static_cast<double>(1 + i));
  }
  for (std::size_t j = 0; j < 3; ++j) {
    const WideV reach =
        hn::Add(hn::Add(hn::Mul(along[0][j], a[0]), hn::Mul(along[1][j], a[1])), hn::Mul(along[2][j], a[2]));
    const WideV offset = hn::Add(hn::Add(hn::Mul(r[0][j], t[0]), hn::Mul(r[1][j], t[1])), hn::Mul(r[2][j], t[2]));
    face.offer(hn::Sub(hn::Sub(hn::Abs(offset), b[j]), reach), static_cast<double>(4 + j));
  }
  put(axes.face, face.separation);
  put(axes.face_code, face.code);

  // Gottschalk et al., "OBBTree", SIGGRAPH 1996, section 5. Separations are compared by their squares with their
  // sign, so that one root is taken for all nine.
  BestAxis edge = no_axis();
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t i1 = (i + 1) % 3;
    const std::size_t i2 = (i + 2) % 3;
    for (std::size_t j = 0; j < 3; ++j) {
      const std::size_t j1 = (j + 1) % 3;
      const std::size_t j2 = (j + 2) % 3;
      const WideV sine_squared = hn::Add(hn::Mul(r[i1][j], r[i1][j]), hn::Mul(r[i2][j], r[i2][j]));
      const WideV offset = hn::Abs(hn::Sub(hn::Mul(t[i2], r[i1][j]), hn::Mul(t[i1], r[i2][j])));
      const WideV reach = hn::Add(hn::Add(hn::Mul(a[i1], along[i2][j]), hn::Mul(a[i2], along[i1][j])),
                                  hn::Add(hn::Mul(b[j1], along[i][j2]), hn::Mul(b[j2], along[i][j1])));
      const WideV apart = hn::Sub(offset, reach);
      const WideV square = hn::Div(hn::Mul(apart, hn::Abs(apart)), sine_squared);
      // Parallel edges have a face axis.
      const auto counts = hn::Ge(sine_squared, wide(1e-12));
      edge.offer(hn::IfThenElse(counts, square, nowhere()), static_cast<double>(7 + 3 * i + j));
    }
  }
  put(axes.edge, hn::CopySign(hn::Sqrt(hn::Abs(edge.separation)), edge.separation));
  put(axes.edge_code, edge.code);

  const WideV distance = hn::Sqrt(dot(seen, seen));
  const WideV from_second[3] = {
      hn::Add(hn::Add(hn::Mul(r[0][0], t[0]), hn::Mul(r[1][0], t[1])), hn::Mul(r[2][0], t[2])),
      hn::Add(hn::Add(hn::Mul(r[0][1], t[0]), hn::Mul(r[1][1], t[1])), hn::Mul(r[2][1], t[2])),
      hn::Add(hn::Add(hn::Mul(r[0][2], t[0]), hn::Mul(r[1][2], t[1])), hn::Mul(r[2][2], t[2]))};
  WideV reach = wide(0);
  for (std::size_t i = 0; i < 3; ++i) {
    reach = hn::Add(reach, hn::Add(hn::Mul(a[i], hn::Abs(t[i])), hn::Mul(b[i], hn::Abs(from_second[i]))));
  }
  const WideV apart = hn::Sub(distance, hn::Div(reach, distance));
  put(axes.centres, hn::IfThenElse(hn::Gt(distance, wide(0)), apart, nowhere()));
}

void find_box_axes(const BoxBlock& block, BoxAxes& axes) {
  for (std::size_t lane = 0; lane < block_lanes; lane += wide_lanes) find_box_axes(block, lane, axes);
}

}  // namespace HWY_NAMESPACE
}  // namespace atl::collision
HWY_AFTER_NAMESPACE();

#endif  // ATOLL_COLLISION_BOX_AXES_INL_H_
