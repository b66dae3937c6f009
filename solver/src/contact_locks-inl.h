// What motion locks change about contacts: effective masses, and rows that nothing answers. Included once for each
// instruction set.

#if defined(ATOLL_SOLVER_CONTACT_LOCKS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATOLL_SOLVER_CONTACT_LOCKS_INL_H_
#undef ATOLL_SOLVER_CONTACT_LOCKS_INL_H_
#else
#define ATOLL_SOLVER_CONTACT_LOCKS_INL_H_
#endif

#include "contact_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atl::solver {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace jobs::HWY_NAMESPACE;

// What answers an impulse by less than this part of what it would without locks isn't pushed: it would have to be by
// so much that rounding throws it about.
constexpr float least_answer = 1e-3f;

// Of the inverse mass of both bodies, what locks take along each axis.
HWY_INLINE V3 lost_inverse_mass(const SolverBodies& bodies, const ContactBlock& block, std::size_t lane,
                                const ContactLanes<>& c) {
  const auto lost = [&](const std::int32_t* index, V inverse_mass) {
    const V4 free = load_free_axes(bodies, index + lane);
    return inverse_mass * (V3{splat(1), splat(1), splat(1)} - V3{free.x, free.y, free.z});
  };
  return lost(block.first, c.inverse_mass_first) + lost(block.second, c.inverse_mass_second);
}

// Takes from the masses of a block what its bodies' locks do; points that nothing answers are none. Whether any lane
// has a body that is locked along an axis. Others stay as they are, bit for bit.
HWY_INLINE bool lock_contacts(const SolverBodies& bodies, ContactBlock& block, std::size_t lane,
                              const ContactLanes<>& c, M rubs, V4& separation) {
  const V3 lost = lost_inverse_mass(bodies, block, lane, c);
  const M locked = hn::Gt(hn::Add(lost.x, hn::Add(lost.y, lost.z)), zero());
  if (hn::AllFalse(D(), locked)) return false;

  const auto lost_along = [&](const V3& a, const V3& b) {
    return dot(lost, {hn::Mul(a.x, b.x), hn::Mul(a.y, b.y), hn::Mul(a.z, b.z)});
  };
  const V inverse_mass = hn::Add(c.inverse_mass_first, c.inverse_mass_second);
  const V least = hn::Mul(splat(least_answer), inverse_mass);
  const V k00 = load(block.k[0] + lane);
  store(hn::IfThenElse(locked, hn::Sub(k00, lost_along(c.normal, c.normal)), k00), block.k[0] + lane);

  V* const separations[max_points] = {&separation.x, &separation.y, &separation.z, &separation.w};
  for (std::size_t i = 0; i < max_points; ++i) {
    const PointResponse response(block, lane, load(block.x[i] + lane), load(block.y[i] + lane));
    const M held = hn::And(locked, hn::Not(hn::Gt(response.own, least)));
    *separations[i] = hn::IfThenElse(held, splat(collision::no_point), *separations[i]);
    store(*separations[i], block.start_separation[i] + lane);
    store(*separations[i], block.separation[i] + lane);
    store(hn::IfThenZeroElse(held, load(block.normal_impulse[i] + lane)), block.normal_impulse[i] + lane);
  }

  Plane tangential = tangential_response(c, inverse_mass);
  tangential.m11 = hn::Sub(tangential.m11, lost_along(c.tangent1, c.tangent1));
  tangential.m12 = hn::Sub(tangential.m12, lost_along(c.tangent1, c.tangent2));
  tangential.m22 = hn::Sub(tangential.m22, lost_along(c.tangent2, c.tangent2));
  const Plane mass = tangential.inverse_above(least);
  const Plane old = Plane::load_from(block.friction_mass, lane);
  const auto pick = [&](V in_locked, V in_others) {
    return hn::IfThenElse(locked, hn::IfThenElseZero(rubs, in_locked), in_others);
  };
  Plane{pick(mass.m11, old.m11), pick(mass.m12, old.m12), pick(mass.m22, old.m22)}.store_to(block.friction_mass, lane);
  return true;
}

// Rolling of bodies that may not turn about every axis.
HWY_INLINE void lock_rolling(const SolverBodies& bodies, const ContactBlock& block, std::size_t lane, M rolls_hard,
                             SurfaceBlock& surface) {
  const M locked = hn::Eq(
      hn::Min(load_free_axes(bodies, block.first + lane).w, load_free_axes(bodies, block.second + lane).w), zero());
  const Plane spins{load(block.k[3] + lane), load(block.k[4] + lane), load(block.k[5] + lane)};
  const Plane mass = spins.inverse_above(hn::Mul(splat(least_answer), hn::Add(spins.m11, spins.m22)));
  const Plane old = Plane::load_from(surface.rolling_mass, lane);
  const auto pick = [&](V in_locked, V in_others) {
    return hn::IfThenElse(locked, hn::IfThenElseZero(rolls_hard, in_locked), in_others);
  };
  Plane{pick(mass.m11, old.m11), pick(mass.m12, old.m12), pick(mass.m22, old.m22)}.store_to(surface.rolling_mass, lane);
}

}  // namespace HWY_NAMESPACE
}  // namespace atl::solver
HWY_AFTER_NAMESPACE();

#endif  // ATOLL_SOLVER_CONTACT_LOCKS_INL_H_
