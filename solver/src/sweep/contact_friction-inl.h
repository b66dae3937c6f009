// Friction of a block's contacts: along the tangents, about the normal, and against rolling. Included once for each
// instruction set.

#if defined(ATOLL_SOLVER_CONTACT_FRICTION_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATOLL_SOLVER_CONTACT_FRICTION_INL_H_
#undef ATOLL_SOLVER_CONTACT_FRICTION_INL_H_
#else
#define ATOLL_SOLVER_CONTACT_FRICTION_INL_H_
#endif

#include <solver/constraints/friction_ellipse.h>

#include <array>

#include "sweep/contact_normals-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atl::solver {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace jobs::HWY_NAMESPACE;

// The radius (m) of a contact that turns a spin into a speed: that of the smaller of the two bodies.
template <MovableSides movable>
HWY_INLINE V reach_of(const ContactLanes<movable>& c) {
  return hn::Sqrt(hn::Min(dot(c.anchor_first, c.anchor_first), dot(c.anchor_second, c.anchor_second)));
}

// Holds back rolling: an angular impulse about an axis in the tangent plane, bound as friction is.
template <MovableSides movable>
HWY_INLINE void solve_rolling(const ContactBlock& block, SurfaceBlock& surface, std::size_t lane, V normal_impulse,
                              ContactLanes<movable>& c, Residual& residual) {
  const V3 spin = gained_spin(c);
  const Plane mass = Plane::load_from(surface.rolling_mass, lane);
  const auto turning = [&](V start, std::size_t axis, V gained) {
    return hn::Add(hn::Add(start, gained), load(surface.spin[axis] + lane));
  };
  const V w1 = turning(load(block.start_normal[1] + lane), 0, dot(c.tangent1, spin));
  const V w2 = turning(load(block.start_normal[2] + lane), 1, dot(c.tangent2, spin));
  const V old1 = load(surface.rolling_impulse[0] + lane);
  const V old2 = load(surface.rolling_impulse[1] + lane);
  V new1 = hn::Sub(old1, mass.first(w1, w2));
  V new2 = hn::Sub(old2, mass.second(w1, w2));
  clamp_to_disc(new1, new2, hn::Mul(load(surface.rolling_friction[0] + lane), normal_impulse));
  store(new1, surface.rolling_impulse[0] + lane);
  store(new2, surface.rolling_impulse[1] + lane);
  apply(c, {zero(), zero(), zero()}, hn::Sub(new1, old1) * c.tangent1 + hn::Sub(new2, old2) * c.tangent2);
  const V3 change = gained_spin(c) - spin;
  const V reach = reach_of(c);
  residual.add(hn::Mul(reach, dot(c.tangent1, change)));
  residual.add(hn::Mul(reach, dot(c.tangent2, change)));
}

// Contacts with a body that is locked along some axis.
HWY_INLINE M locked_lanes(const ContactBlock& block, std::size_t lane, const ContactLanes<MovableSides::Locked>& c) {
  const auto differs = [&](const V3& along_axes, const float* inverse_mass) {
    const V of_all = load(inverse_mass + lane);
    return hn::Or(hn::Ne(along_axes.x, of_all), hn::Or(hn::Ne(along_axes.y, of_all), hn::Ne(along_axes.z, of_all)));
  };
  return hn::Or(differs(c.inverse_mass_first, block.inverse_mass[0]),
                differs(c.inverse_mass_second, block.inverse_mass[1]));
}

// The sum over all points of a contact.
template <std::size_t points>
HWY_INLINE V normal_impulse_of(const ContactBlock& block, std::size_t lane) {
  V sum = load(block.normal_impulse[0] + lane);
  for (std::size_t i = 1; i < points; ++i) sum = hn::Add(sum, load(block.normal_impulse[i] + lane));
  return sum;
}

inline FrictionEllipse ellipse_of(const SurfaceBlock& surface, std::size_t lane) {
  return {surface.cosine[0][lane], surface.sine[0][lane], surface.ratio[0][lane]};
}

// Shortens impulses that would stop all slip, in lanes where friction depends on its direction.
HWY_NOINLINE void hold_in_ellipses(const ContactBlock& block, const SurfaceBlock& surface, Friction friction,
                                   std::size_t lane, const V& bounds, const V& wanted1, const V& wanted2, V& p1,
                                   V& p2) {
  HWY_ALIGN float bound[lanes], wanted[2][lanes], held[2][lanes];
  store(bounds, bound);
  store(wanted1, wanted[0]);
  store(wanted2, wanted[1]);
  store(p1, held[0]);
  store(p2, held[1]);
  for (std::size_t k = 0; k < lanes; ++k) {
    const FrictionEllipse ellipse = ellipse_of(surface, lane + k);
    if (ellipse.is_disc()) continue;
    std::array<double, 2> impulse = {wanted[0][k], wanted[1][k]};
    const auto& mass = block.friction_mass;
    if (friction == Friction::Pyramid) {
      ellipse.hold_in_rectangle(bound[k], impulse);
    } else {
      ellipse.hold({mass[0][lane + k], mass[1][lane + k], mass[2][lane + k]}, bound[k], impulse);
    }
    for (std::size_t axis = 0; axis < 2; ++axis) held[axis][k] = static_cast<float>(impulse[axis]);
  }
  p1 = load(held[0]);
  p2 = load(held[1]);
}

template <typename how, typename what>
HWY_INLINE void solve_friction(ContactBlock& block, SurfaceBlock* surface, [[maybe_unused]] Friction friction,
                               std::size_t lane, ContactLanes<what::movable>& c, Residual& residual) {
  const V3 velocity = gained_velocity(c);
  V v1 = hn::Add(load(block.start_tangent[0] + lane), dot(c.tangent1, velocity));
  V v2 = hn::Add(load(block.start_tangent[1] + lane), dot(c.tangent2, velocity));
  const V gained_twist = dot(c.normal, gained_spin(c));
  V spin = hn::Add(load(block.start_tangent[2] + lane), gained_twist);
  const V normal_impulse = normal_impulse_of<what::points>(block, lane);
  const V bound = hn::Mul(load(block.friction + lane), normal_impulse);
  V torsional_bound = hn::Mul(bound, load(block.friction_radius + lane));
  if constexpr (how::special) {
    if (surface != nullptr) {
      v1 = hn::Add(v1, load(surface->slip[0] + lane));
      v2 = hn::Add(v2, load(surface->slip[1] + lane));
      spin = hn::Add(spin, load(surface->spin[2] + lane));
      torsional_bound = hn::Add(torsional_bound, hn::Mul(load(surface->torsional_friction[0] + lane), normal_impulse));
    }
  }

  const V old1 = load(block.friction_impulse[0] + lane);
  const V old2 = load(block.friction_impulse[1] + lane);
  const Plane mass = Plane::load_from(block.friction_mass, lane);
  V new1 = hn::Sub(old1, mass.first(v1, v2));
  V new2 = hn::Sub(old2, mass.second(v1, v2));
  [[maybe_unused]] const V wanted1 = new1, wanted2 = new2;
  if (how::special && friction == Friction::Pyramid) {
    new1 = clamp_to(new1, bound);
    new2 = clamp_to(new2, bound);
  } else {
    hold_in_disc(mass, new1, new2, bound);
  }
  if constexpr (how::special) {
    const bool uneven = surface != nullptr && !hn::AllFalse(D(), hn::Lt(load(surface->ratio[0] + lane), splat(1)));
    if (uneven) hold_in_ellipses(block, *surface, friction, lane, bound, wanted1, wanted2, new1, new2);
  }
  const V old_twist = load(block.torsional_impulse + lane);
  const V new_twist = clamp_to(hn::Sub(old_twist, hn::Mul(load(block.twist_mass + lane), spin)), torsional_bound);
  store(new1, block.friction_impulse[0] + lane);
  store(new2, block.friction_impulse[1] + lane);
  store(new_twist, block.torsional_impulse + lane);
  apply(c, hn::Sub(new1, old1) * c.tangent1 + hn::Sub(new2, old2) * c.tangent2,
        hn::Sub(new_twist, old_twist) * c.normal);
  if constexpr (how::special) {
    if (surface != nullptr) solve_rolling(block, *surface, lane, normal_impulse, c, residual);
    const M rubs = hn::Gt(load(block.friction + lane), zero());
    const Plane response = mass.inverse();
    const V change1 = hn::Sub(new1, old1);
    const V change2 = hn::Sub(new2, old2);
    V slowed1 = response.first(change1, change2);
    V slowed2 = response.second(change1, change2);
    if constexpr (what::movable == MovableSides::Locked) {
      // The effective mass says nothing about an axis along which bodies are locked, so the change is measured there.
      const V3 slowed = gained_velocity(c) - velocity;
      const M locked = locked_lanes(block, lane, c);
      slowed1 = hn::IfThenElse(locked, dot(c.tangent1, slowed), slowed1);
      slowed2 = hn::IfThenElse(locked, dot(c.tangent2, slowed), slowed2);
    }
    residual.add(hn::IfThenElseZero(rubs, slowed1));
    residual.add(hn::IfThenElseZero(rubs, slowed2));
    const V twist_change = hn::Sub(dot(c.normal, gained_spin(c)), gained_twist);
    residual.add(hn::Mul(load(block.friction_radius + lane), twist_change));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace atl::solver
HWY_AFTER_NAMESPACE();

#endif  // ATOLL_SOLVER_CONTACT_FRICTION_INL_H_
