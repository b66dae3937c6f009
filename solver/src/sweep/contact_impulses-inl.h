// Handles accumulated impulses around the sweeps: warm start, bounces, and the way back to the manifolds. Included once
// for each instruction set.

#if defined(ATOLL_SOLVER_CONTACT_IMPULSES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATOLL_SOLVER_CONTACT_IMPULSES_INL_H_
#undef ATOLL_SOLVER_CONTACT_IMPULSES_INL_H_
#else
#define ATOLL_SOLVER_CONTACT_IMPULSES_INL_H_
#endif

#include <features/with_restitution.h>
#include <features/with_surfaces.h>
#include <solver/tuning.h>

#include "sweep/contact_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atl::solver {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace jobs::HWY_NAMESPACE;

template <MovableSides movable>
void warm_start_by(const ContactKernelData& data, std::size_t begin, std::size_t end) {
  for (std::size_t b = begin; b < end; ++b) {
    const ContactBlock& block = data.blocks[b];
    for (std::size_t lane = 0; lane < block_lanes; lane += lanes) {
      ContactLanes<movable> c = load_contacts<movable>(data, block, lane);
      V sum = zero();
      V sum_y = zero();
      V sum_minus_x = zero();
      for (std::size_t i = 0; i < max_points; ++i) {
        const V impulse = load(block.normal_impulse[i] + lane);
        sum = hn::Add(sum, impulse);
        sum_y = hn::Add(sum_y, hn::Mul(impulse, load(block.y[i] + lane)));
        sum_minus_x = hn::Sub(sum_minus_x, hn::Mul(impulse, load(block.x[i] + lane)));
      }
      const V f1 = load(block.friction_impulse[0] + lane);
      const V f2 = load(block.friction_impulse[1] + lane);
      const V twist = load(block.torsional_impulse + lane);
      if (with_surfaces && data.surface_blocks != nullptr) {
        const SurfaceBlock& surface = data.surface_blocks[b];
        sum_y = hn::Add(sum_y, load(surface.rolling_impulse[0] + lane));
        sum_minus_x = hn::Add(sum_minus_x, load(surface.rolling_impulse[1] + lane));
      }
      apply(c, sum * c.normal + (f1 * c.tangent1 + f2 * c.tangent2),
            twist * c.normal + (sum_y * c.tangent1 + sum_minus_x * c.tangent2));
      store_contact_bodies(c, data, block, lane);
    }
  }
}

inline void warm_start(const ContactKernelData& data, std::size_t begin, std::size_t end) {
  if (data.bodies.locks.empty()) return warm_start_by<MovableSides::Both>(data, begin, end);
  warm_start_by<MovableSides::Locked>(data, begin, end);
}

// Impulses of points, by the manifold's numbers.
HWY_INLINE V4 back_to_manifold(const PlanarBlock& block, std::size_t lane, const V4& rows) {
  const M planar = hn::Gt(load(block.planar + lane), zero());
  const V first = load(block.point[0] + lane);
  const V second = load(block.point[1] + lane);
  const auto of_point = [&](float point, V row) {
    const V sum = hn::Add(hn::IfThenElseZero(hn::Eq(first, splat(point)), rows.x),
                          hn::IfThenElseZero(hn::Eq(second, splat(point)), rows.y));
    return hn::IfThenElse(planar, sum, row);
  };
  return {of_point(0, rows.x), of_point(1, rows.y), of_point(2, rows.z), of_point(3, rows.w)};
}

inline void store_impulses(const ContactKernelData& data, std::size_t begin, std::size_t end) {
  const V together = splat(data.constants.refinement);
  for (std::size_t b = begin; b < end; ++b) {
    ContactBlock& block = data.blocks[b];
    for (std::size_t lane = 0; lane < block_lanes; lane += lanes) {
      unsigned used = 0;
      for (std::size_t k = 0; k < lanes; ++k) used |= (block.slot[lane + k] >= 0 ? 1u : 0u) << k;
      const std::int32_t* slot = block.slot + lane;
      collision::ContactManifold* manifolds = data.manifolds;
      V4 normal = {load(block.normal_impulse[0] + lane), load(block.normal_impulse[1] + lane),
                   load(block.normal_impulse[2] + lane), load(block.normal_impulse[3] + lane)};
      if (with_restitution && block.traits.bounces) {
        const auto impulse_of = [&](V impulse, std::size_t i) {
          const V spent = load(data.bounces[b].spent[i] + lane);
          return hn::IfThenElse(hn::Gt(spent, zero()), hn::Neg(hn::Add(impulse, spent)), impulse);
        };
        normal = {impulse_of(normal.x, 0), impulse_of(normal.y, 1), impulse_of(normal.z, 2), impulse_of(normal.w, 3)};
      }
      if (data.planar_blocks != nullptr) normal = back_to_manifold(data.planar_blocks[b], lane, normal);
      store_rows(
          {hn::Mul(together, normal.x), hn::Mul(together, normal.y), hn::Mul(together, normal.z),
           hn::Mul(together, normal.w)},
          [=](std::size_t k) { return manifolds[slot[k]].normal_impulse; }, used);
      const V3 t1 = load3(block.tangent, lane);
      const V3 t2 = cross(load3(block.normal, lane), t1);
      const V3 friction =
          together * (load(block.friction_impulse[0] + lane) * t1 + load(block.friction_impulse[1] + lane) * t2);
      store_rows(
          {friction.x, friction.y, friction.z, hn::Mul(together, load(block.torsional_impulse + lane))},
          [=](std::size_t k) { return manifolds[slot[k]].friction_impulse; }, used);
      if (!with_surfaces || data.surface_blocks == nullptr) continue;
      const SurfaceBlock& surface = data.surface_blocks[b];
      SurfaceContact* contacts = data.surface_contacts;
      const V3 rolling =
          together * (load(surface.rolling_impulse[0] + lane) * t1 + load(surface.rolling_impulse[1] + lane) * t2);
      store_rows(
          {rolling.x, rolling.y, rolling.z, load(surface.torsional_friction[0] + lane)},
          [=](std::size_t k) { return contacts[slot[k]].rolling_impulse; }, used);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace atl::solver
HWY_AFTER_NAMESPACE();

#endif  // ATOLL_SOLVER_CONTACT_IMPULSES_INL_H_
