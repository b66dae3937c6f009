// What happens to accumulated impulses around the sweeps: warm start, bounces, and back to the manifolds. Included once
// for each instruction set.

#if defined(ATOLL_SOLVER_CONTACT_IMPULSES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATOLL_SOLVER_CONTACT_IMPULSES_INL_H_
#undef ATOLL_SOLVER_CONTACT_IMPULSES_INL_H_
#else
#define ATOLL_SOLVER_CONTACT_IMPULSES_INL_H_
#endif

#include "contact_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atl::solver {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace jobs::HWY_NAMESPACE;

inline void warm_start(const ContactKernelData& data, std::size_t begin, std::size_t end) {
  for (std::size_t b = begin; b < end; ++b) {
    const ContactBlock& block = data.blocks[b];
    for (std::size_t lane = 0; lane < block_lanes; lane += lanes) {
      ContactLanes c = load_contacts(data, block, lane);
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
      const V twist = load(block.twist_impulse + lane);
      if (data.surface_blocks != nullptr) {
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

// Over the points of each contact: with one, a face that hits flat would leave spinning.
constexpr std::size_t restitution_sweeps = 16;

inline void restitute(const ContactKernelData& data, std::size_t begin, std::size_t end) {
  const V threshold = splat(-data.constants.restitution_threshold);
  for (std::size_t b = begin; b < end; ++b) {
    ContactBlock& block = data.blocks[b];
    const BounceBlock& bounce = data.bounces[b];
    for (std::size_t lane = 0; lane < block_lanes; lane += lanes) {
      ContactLanes c = load_contacts(data, block, lane);
      const V restitution = load(bounce.restitution + lane);
      NormalSolve solve(c);
      for (std::size_t n = 0; n < restitution_sweeps * max_points; ++n) {
        const std::size_t i = n % max_points;
        const V x = load(block.x[i] + lane);
        const V y = load(block.y[i] + lane);
        const V old_impulse = load(block.normal_impulse[i] + lane);
        const V approach = load(bounce.approach[i] + lane);
        const PointResponse response(block, lane, x, y);
        const M bounces = hn::And(hn::And(hn::Lt(approach, threshold), hn::Gt(restitution, zero())),
                                  hn::Gt(load(bounce.max_impulse[i] + lane), zero()));
        const V target = hn::Add(solve.speed(x, y), hn::Mul(restitution, approach));
        const V wanted = hn::Max(hn::Neg(hn::Mul(response.mass, target)), hn::Neg(old_impulse));
        const V impulse = hn::IfThenElse(bounces, wanted, zero());
        store(hn::Add(old_impulse, impulse), block.normal_impulse[i] + lane);
        response.apply(impulse, x, y, solve);
      }
      solve.finish(c);
      store_contact_bodies(c, data, block, lane);
    }
  }
}

// Lanes where soft contacts would give way farther than they should under what they carry now, and many times as far.
struct Overload {
  unsigned overloaded, crushed;
};
HWY_INLINE Overload overloaded_lanes(const ContactKernelData& data, const ContactBlock& block, std::size_t lane,
                                     V normal_impulse) {
  const V first = load(block.inverse_mass[0] + lane);
  const V second = load(block.inverse_mass[1] + lane);
  const M first_fixed = hn::Eq(first, zero());
  const M second_fixed = hn::Eq(second, zero());
  const V scale = hn::IfThenElse(hn::Or(first_fixed, second_fixed), splat(data.constants.overload_fixed),
                                 splat(data.constants.overload));
  const V give = hn::Mul(hn::Mul(normal_impulse, hn::Add(first, second)), scale);
  const V3 a = load3(block.anchor_first, lane);
  const V3 b = load3(block.anchor_second, lane);
  const V far = splat(collision::no_point);
  const V square = hn::Min(hn::IfThenElse(first_fixed, far, dot(a, a)), hn::IfThenElse(second_fixed, far, dot(b, b)));
  const V give_square = hn::Mul(give, give);
  const auto bits = [](const M& mask) {
    std::uint8_t to[8] = {};
    hn::StoreMaskBits(D(), mask, to);
    return unsigned{to[0]};
  };
  const M over = hn::Gt(give_square, square);
  if (HWY_LIKELY(hn::AllFalse(D(), over))) return {0, 0};
  constexpr auto most = static_cast<float>(crushing * crushing);
  return {bits(over), bits(hn::Gt(give_square, hn::Mul(splat(most), square)))};
}

inline void store_impulses(const ContactKernelData& data, std::size_t begin, std::size_t end) {
  const V together = splat(data.constants.finer);
  for (std::size_t b = begin; b < end; ++b) {
    ContactBlock& block = data.blocks[b];
    Overload all = {0, 0};
    for (std::size_t lane = 0; lane < block_lanes; lane += lanes) {
      unsigned used = 0;
      for (std::size_t k = 0; k < lanes; ++k) used |= (block.slot[lane + k] >= 0 ? 1u : 0u) << k;
      const std::int32_t* slot = block.slot + lane;
      collision::ContactManifold* manifolds = data.manifolds;
      const V4 normal = {load(block.normal_impulse[0] + lane), load(block.normal_impulse[1] + lane),
                         load(block.normal_impulse[2] + lane), load(block.normal_impulse[3] + lane)};
      const V load_of_all = hn::Add(hn::Add(normal.x, normal.y), hn::Add(normal.z, normal.w));
      const Overload here = overloaded_lanes(data, block, lane, load_of_all);
      all.overloaded |= (here.overloaded & used) << lane;
      all.crushed |= (here.crushed & used) << lane;
      store_rows(
          {hn::Mul(together, normal.x), hn::Mul(together, normal.y), hn::Mul(together, normal.z),
           hn::Mul(together, normal.w)},
          [=](std::size_t k) { return manifolds[slot[k]].normal_impulse; }, used);
      const V3 t1 = load3(block.tangent, lane);
      const V3 t2 = cross(load3(block.normal, lane), t1);
      const V3 friction =
          together * (load(block.friction_impulse[0] + lane) * t1 + load(block.friction_impulse[1] + lane) * t2);
      store_rows(
          {friction.x, friction.y, friction.z, hn::Mul(together, load(block.twist_impulse + lane))},
          [=](std::size_t k) { return manifolds[slot[k]].friction_impulse; }, used);
      if (data.surface_blocks == nullptr) continue;
      const SurfaceBlock& surface = data.surface_blocks[b];
      SurfaceContact* contacts = data.surface_contacts;
      const V3 rolling =
          together * (load(surface.rolling_impulse[0] + lane) * t1 + load(surface.rolling_impulse[1] + lane) * t2);
      store_rows(
          {rolling.x, rolling.y, rolling.z, load(surface.torsional_friction[0] + lane)},
          [=](std::size_t k) { return contacts[slot[k]].rolling_impulse; }, used);
    }
    block.overloaded = static_cast<std::uint8_t>(all.overloaded);
    block.crushed = static_cast<std::uint8_t>(all.crushed);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace atl::solver
HWY_AFTER_NAMESPACE();

#endif  // ATOLL_SOLVER_CONTACT_IMPULSES_INL_H_
