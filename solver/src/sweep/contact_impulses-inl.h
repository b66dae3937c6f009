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

// All that contacts push with: along and about the normal and the tangents.
struct CarriedImpulse {
  V push = zero();
  V f1, f2;  // friction
  V twist;
  V about1 = zero(), about2 = zero();

  HWY_INLINE CarriedImpulse(const ContactBlock& block, const SurfaceBlock* surface, std::size_t lane) {
    for (std::size_t i = 0; i < max_points; ++i) {
      const V impulse = load(block.normal_impulse[i] + lane);
      push = hn::Add(push, impulse);
      about1 = hn::Add(about1, hn::Mul(impulse, load(block.y[i] + lane)));
      about2 = hn::Sub(about2, hn::Mul(impulse, load(block.x[i] + lane)));
    }
    f1 = load(block.friction_impulse[0] + lane);
    f2 = load(block.friction_impulse[1] + lane);
    twist = load(block.torsional_impulse + lane);
    if (surface == nullptr) return;
    about1 = hn::Add(about1, load(surface->rolling_impulse[0] + lane));
    about2 = hn::Add(about2, load(surface->rolling_impulse[1] + lane));
  }

  template <MovableSides movable>
  HWY_INLINE V3 linear(const ContactLanes<movable>& c) const {
    return push * c.normal + (f1 * c.tangent1 + f2 * c.tangent2);
  }
  template <MovableSides movable>
  HWY_INLINE V3 angular(const ContactLanes<movable>& c) const {
    return twist * c.normal + (about1 * c.tangent1 + about2 * c.tangent2);
  }

  // The work against the motion that there is as the step begins, and that of surfaces.
  HWY_INLINE V work_at_start(const ContactBlock& block, const SurfaceBlock* surface, std::size_t lane) const {
    V slip1 = load(block.start_tangent[0] + lane), slip2 = load(block.start_tangent[1] + lane);
    V spin = load(block.start_tangent[2] + lane);
    V spin1 = load(block.start_normal[1] + lane), spin2 = load(block.start_normal[2] + lane);
    if (surface != nullptr) {
      slip1 = hn::Add(slip1, load(surface->slip[0] + lane));
      slip2 = hn::Add(slip2, load(surface->slip[1] + lane));
      spin = hn::Add(spin, load(surface->spin[2] + lane));
      spin1 = hn::Add(spin1, load(surface->spin[0] + lane));
      spin2 = hn::Add(spin2, load(surface->spin[1] + lane));
    }
    const V turning = hn::Add(hn::Mul(twist, spin), hn::Add(hn::Mul(about1, spin1), hn::Mul(about2, spin2)));
    const V rubbing = hn::Add(hn::Mul(f1, slip1), hn::Mul(f2, slip2));
    return hn::Add(hn::Add(hn::Mul(push, load(block.start_normal[0] + lane)), rubbing), turning);
  }
};

HWY_INLINE const SurfaceBlock* surface_of(const ContactKernelData& data, std::size_t block) {
  return with_surfaces && data.surface_blocks != nullptr ? &data.surface_blocks[block] : nullptr;
}

template <MovableSides movable>
void warm_start_by(const ContactKernelData& data, std::size_t begin, std::size_t end) {
  for (std::size_t b = begin; b < end; ++b) {
    const ContactBlock& block = data.blocks[b];
    for (std::size_t lane = 0; lane < block_lanes; lane += lanes) {
      ContactLanes<movable> c = load_contacts<movable>(data, block, lane);
      const CarriedImpulse carried(block, surface_of(data, b), lane);
      apply(c, carried.linear(c), carried.angular(c));
      store_contact_bodies(c, data, block, lane);
    }
  }
}

inline void warm_start(const ContactKernelData& data, std::size_t begin, std::size_t end) {
  if (data.bodies.locks.empty()) return warm_start_by<MovableSides::Both>(data, begin, end);
  warm_start_by<MovableSides::Locked>(data, begin, end);
}

// Scaled by s, a contact's impulses do work linear s against the free motion, and half of `gained` s^2 against what all
// impulses change it by. Contacts of bodies that were not struck keep theirs, whatever shares the block.
inline float find_fitting(const ContactKernelData& data, const std::uint8_t* struck, FittingBlock* fitting,
                          std::size_t begin, std::size_t end) {
  V least = splat(1);
  for (std::size_t b = begin; b < end; ++b) {
    const ContactBlock& block = data.blocks[b];
    alignas(64) float of_struck[block_lanes];
    fitting[b].any = false;
    for (std::size_t lane = 0; lane < block_lanes; ++lane) {
      const bool any = (struck[block.first[lane]] | struck[block.second[lane]]) == 1;
      of_struck[lane] = any ? 1.0f : 0.0f;
      fitting[b].any |= any;
    }
    if (!fitting[b].any) continue;
    for (std::size_t lane = 0; lane < block_lanes; lane += lanes) {
      const ContactLanes<> c = load_contacts<>(data, block, lane);
      ContactLanes<> free = c;
      const FreeVelocityRows* rows = data.bodies.free_velocity.data();
      const auto load_free = [&](const std::int32_t* index, BodyLanes& body) {
        const V4 v = load_rows([=](std::size_t k) { return rows[index[k]].linear; });
        const V4 w = load_rows([=](std::size_t k) { return rows[index[k]].angular; });
        body.v = {v.x, v.y, v.z};
        body.w = {w.x, w.y, w.z};
      };
      load_free(block.first + lane, free.first);
      load_free(block.second + lane, free.second);
      const SurfaceBlock* const surface = surface_of(data, b);
      const CarriedImpulse carried(block, surface, lane);
      const V3 push = carried.linear(c), twist = carried.angular(c);
      const V3 velocity = gained_velocity(free), spin = gained_spin(free);
      const V linear =
          hn::Add(carried.work_at_start(block, surface, lane), hn::Add(dot(push, velocity), dot(twist, spin)));
      const V gained = hn::Add(dot(push, gained_velocity(c) - velocity), dot(twist, gained_spin(c) - spin));
      const M positive = hn::And(hn::Gt(gained, zero()), hn::Gt(load(of_struck + lane), zero()));
      const M costs = hn::And(positive, hn::Gt(hn::Add(linear, hn::Mul(splat(0.5f), gained)), zero()));
      const V best = hn::Div(hn::Neg(linear), hn::IfThenElse(costs, gained, splat(1)));
      const V scale = hn::IfThenElse(costs, hn::Max(hn::Min(best, splat(1)), zero()), splat(1));
      store(scale, fitting[b].scale + lane);
      least = hn::Min(least, scale);
    }
  }
  return hn::GetLane(hn::MinOfLanes(D(), least));
}

template <MovableSides movable>
void fit_impulses_by(const ContactKernelData& data, const FittingBlock* fitting, std::size_t begin, std::size_t end) {
  for (std::size_t b = begin; b < end; ++b) {
    if (!fitting[b].any) continue;
    ContactBlock& block = data.blocks[b];
    for (std::size_t lane = 0; lane < block_lanes; lane += lanes) {
      const V scale = load(fitting[b].scale + lane);
      const M scaled = hn::Lt(scale, splat(1));
      if (hn::AllFalse(D(), scaled)) continue;
      ContactLanes<movable> c = load_contacts<movable>(data, block, lane);
      const CarriedImpulse carried(block, surface_of(data, b), lane);
      const V back = hn::IfThenElseZero(scaled, hn::Sub(scale, splat(1)));
      apply(c, back * carried.linear(c), back * carried.angular(c));
      // Other lanes stay as they are, to the sign of a zero.
      unsigned lanes_scaled = 0;
      for (std::size_t k = 0; k < lanes; ++k) lanes_scaled |= (fitting[b].scale[lane + k] < 1 ? 1u : 0u) << k;
      if constexpr (first_moves<movable>)
        store_bodies(c.first, data.bodies, static_cast<unsigned>(block.write_first) >> lane & lanes_scaled);
      if constexpr (second_moves<movable>)
        store_bodies(c.second, data.bodies, static_cast<unsigned>(block.write_second) >> lane & lanes_scaled);
      const auto fit = [&](float* impulses) { store(hn::Mul(scale, load(impulses + lane)), impulses + lane); };
      for (auto& of_point : block.normal_impulse) fit(of_point);
      for (auto& of_axis : block.friction_impulse) fit(of_axis);
      fit(block.torsional_impulse);
      if (!with_surfaces || data.surface_blocks == nullptr) continue;
      for (auto& of_axis : data.surface_blocks[b].rolling_impulse) fit(of_axis);
    }
  }
}

inline void fit_impulses(const ContactKernelData& data, const FittingBlock* fitting, std::size_t begin,
                         std::size_t end) {
  if (data.bodies.locks.empty()) return fit_impulses_by<MovableSides::Both>(data, fitting, begin, end);
  fit_impulses_by<MovableSides::Locked>(data, fitting, begin, end);
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
      // Bodies that a sweep throws at each other fast enough get to where points that there are not count as lying.
      const auto there = [&](std::size_t i) {
        const M is = hn::Lt(load(block.start_separation[i] + lane), splat(collision::no_point));
        return hn::IfThenElseZero(is, load(block.normal_impulse[i] + lane));
      };
      V4 normal = {there(0), there(1), there(2), there(3)};
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
