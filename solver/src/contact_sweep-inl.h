// A sweep of sequential impulses over contact blocks. Included once for each instruction set.

#if defined(ATOLL_SOLVER_CONTACT_SWEEP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATOLL_SOLVER_CONTACT_SWEEP_INL_H_
#undef ATOLL_SOLVER_CONTACT_SWEEP_INL_H_
#else
#define ATOLL_SOLVER_CONTACT_SWEEP_INL_H_
#endif

#include "contact_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atl::solver {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace jobs::HWY_NAMESPACE;

// R(q)^T n - n without cancellation, for the rotation that a body has made since the start of the step.
HWY_INLINE V3 turned_normal_change(const V4& q, const V3& n) {
  const V3 v{q.x, q.y, q.z};
  const V3 t = cross(v, n);
  const V3 change = cross(v, t) - q.w * t;
  return change + change;
}

// separation = start + n . (moved centres) + turned anchors; linear in a point's x and y.
HWY_INLINE void refresh_separations(const ContactKernelData& data, ContactBlock& block, std::size_t lane,
                                    const ContactLanes& c) {
  const V4 first = load_displacement(data.bodies, c.first.index);
  const V4 second = load_displacement(data.bodies, c.second.index);
  // A rolling ball's lowest point does not rise with its surface.
  const V3 change_first = first.w * turned_normal_change(load_rotation(data.bodies, c.first.index), c.normal);
  const V3 change_second = second.w * turned_normal_change(load_rotation(data.bodies, c.second.index), c.normal);
  const V3 moved = V3{second.x, second.y, second.z} - V3{first.x, first.y, first.z};
  const V turned = hn::Sub(dot(change_second, c.anchor_second), dot(change_first, c.anchor_first));
  const V at_centre = hn::Add(dot(c.normal, moved), turned);
  const V3 change = change_second - change_first;
  const V along_x = dot(change, c.tangent1);
  const V along_y = dot(change, c.tangent2);
  for (std::size_t i = 0; i < max_points; ++i) {
    const V x = load(block.x[i] + lane);
    const V y = load(block.y[i] + lane);
    const V shift = hn::Add(at_centre, hn::Add(hn::Mul(x, along_x), hn::Mul(y, along_y)));
    store(hn::Add(load(block.start_separation[i] + lane), shift), block.separation[i] + lane);
  }
}

// What is known of a sweep when it is compiled. `special` is what few scenes need and may cost something: running
// surfaces, rolling and torsional friction, slop, and a residual; whether those refresh they ask as they run.
enum class Refresh { No, Yes, Asks };

template <Push push_, Refresh refresh_, Friction friction_>
struct How {
  static constexpr Push push = push_;
  static constexpr Refresh refresh = refresh_;
  static constexpr Friction friction = friction_;
  static constexpr bool special = refresh_ == Refresh::Asks;
};

// The largest change of relative speed so far. Each lane on its own: the most of all is no sum and knows no order.
struct Residual {
  V most;
  HWY_INLINE Residual() : most(zero()) {}
  HWY_INLINE void add(V change) { most = hn::Max(most, hn::Abs(change)); }
};

// m, of a contact: what turns a spin into a speed. Of the bodies the smaller one's.
HWY_INLINE V reach_of(const ContactLanes& c) {
  return hn::Sqrt(hn::Min(dot(c.anchor_first, c.anchor_first), dot(c.anchor_second, c.anchor_second)));
}

// Holds back rolling: an angular impulse about an axis in the tangent plane, bound as friction is.
HWY_INLINE void solve_rolling(SurfaceBlock& surface, std::size_t lane, V normal_impulse, ContactLanes& c,
                              Residual& residual) {
  const V3 spin = relative_spin(c);
  const Plane mass = Plane::load_from(surface.rolling_mass, lane);
  const V w1 = dot(c.tangent1, spin);
  const V w2 = dot(c.tangent2, spin);
  const V old1 = load(surface.rolling_impulse[0] + lane);
  const V old2 = load(surface.rolling_impulse[1] + lane);
  V new1 = hn::Sub(old1, mass.first(w1, w2));
  V new2 = hn::Sub(old2, mass.second(w1, w2));
  clamp_to_disc(new1, new2, hn::Mul(load(surface.rolling_friction[0] + lane), normal_impulse));
  store(new1, surface.rolling_impulse[0] + lane);
  store(new2, surface.rolling_impulse[1] + lane);
  apply(c, {zero(), zero(), zero()}, hn::Sub(new1, old1) * c.tangent1 + hn::Sub(new2, old2) * c.tangent2);
  const V3 change = relative_spin(c) - spin;
  const V reach = reach_of(c);
  residual.add(hn::Mul(reach, dot(c.tangent1, change)));
  residual.add(hn::Mul(reach, dot(c.tangent2, change)));
}

template <typename how>
HWY_INLINE void solve_friction(ContactBlock& block, SurfaceBlock* surface, std::size_t lane, ContactLanes& c,
                               Residual& residual) {
  const V3 velocity = relative_velocity(c);
  V v1 = dot(c.tangent1, velocity);
  V v2 = dot(c.tangent2, velocity);
  const V spin = dot(c.normal, relative_spin(c));
  V normal_impulse = load(block.normal_impulse[0] + lane);
  for (std::size_t i = 1; i < max_points; ++i) {
    normal_impulse = hn::Add(normal_impulse, load(block.normal_impulse[i] + lane));
  }
  const V bound = hn::Mul(load(block.friction + lane), normal_impulse);
  V twist_bound = hn::Mul(bound, load(block.lever + lane));
  if constexpr (how::special) {
    if (surface != nullptr) {
      v1 = hn::Add(v1, load(surface->slip[0] + lane));
      v2 = hn::Add(v2, load(surface->slip[1] + lane));
      twist_bound = hn::Add(twist_bound, hn::Mul(load(surface->torsional_friction[0] + lane), normal_impulse));
    }
  }

  const V old1 = load(block.friction_impulse[0] + lane);
  const V old2 = load(block.friction_impulse[1] + lane);
  const Plane mass = Plane::load_from(block.friction_mass, lane);
  V new1 = hn::Sub(old1, mass.first(v1, v2));
  V new2 = hn::Sub(old2, mass.second(v1, v2));
  if constexpr (how::friction == Friction::Cone) {
    clamp_to_disc(new1, new2, bound);
  } else {
    new1 = clamp_to(new1, bound);
    new2 = clamp_to(new2, bound);
  }
  const V old_twist = load(block.twist_impulse + lane);
  const V new_twist = clamp_to(hn::Sub(old_twist, hn::Mul(load(block.twist_mass + lane), spin)), twist_bound);
  store(new1, block.friction_impulse[0] + lane);
  store(new2, block.friction_impulse[1] + lane);
  store(new_twist, block.twist_impulse + lane);
  apply(c, hn::Sub(new1, old1) * c.tangent1 + hn::Sub(new2, old2) * c.tangent2,
        hn::Sub(new_twist, old_twist) * c.normal);
  if constexpr (how::special) {
    if (surface != nullptr) solve_rolling(*surface, lane, normal_impulse, c, residual);
    const Plane response = mass.inverse();
    const V change1 = hn::Sub(new1, old1);
    const V change2 = hn::Sub(new2, old2);
    residual.add(response.first(change1, change2));
    residual.add(response.second(change1, change2));
    const V twist_change = hn::Sub(dot(c.normal, relative_spin(c)), spin);
    residual.add(hn::Mul(load(block.lever + lane), twist_change));
  }
}

// One round over the points of each contact.
template <typename how>
HWY_INLINE void solve_points(const ContactKernelData& data, ContactBlock& block, float (*impulses)[block_lanes],
                             std::size_t lane, const ContactLanes& c, NormalSolve& solve, Residual& residual) {
  const SubstepConstants& constants = data.constants;
  const V inverse_h = splat(constants.inverse_h);
  const M fixed = hn::Or(hn::Eq(c.inverse_mass_first, zero()), hn::Eq(c.inverse_mass_second, zero()));
  const auto soft = [&](float of_fixed, float of_dynamic) {
    return hn::IfThenElse(fixed, splat(of_fixed), splat(of_dynamic));
  };
  const Softness& with_fixed = constants.fixed_contact;
  const Softness& with_dynamic = constants.dynamic_contact;
  const V soft_rate = soft(with_fixed.bias_rate, with_dynamic.bias_rate);
  const V soft_mass = soft(with_fixed.mass_scale, with_dynamic.mass_scale);
  const V soft_impulse = soft(with_fixed.impulse_scale, with_dynamic.impulse_scale);

  for (std::size_t i = 0; i < max_points; ++i) {
    const V x = load(block.x[i] + lane);
    const V y = load(block.y[i] + lane);
    const V old_impulse = load(impulses[i] + lane);
    const V separation = load(block.separation[i] + lane);
    const PointResponse response(block, lane, x, y);
    // Apart: may close the gap in this substep, no faster. Overlapping: a push, or nothing but a stop. Corrections
    // leave gaps to the velocities.
    const M apart = hn::Gt(separation, zero());
    V speed_bias = hn::Mul(separation, inverse_h);
    V mass = response.mass;
    V leak = zero();
    if constexpr (how::push == Push::None) {
      speed_bias = hn::IfThenElse(apart, speed_bias, zero());
    } else {
      V overlap = separation;
      if constexpr (how::special) overlap = hn::Min(hn::Add(separation, splat(constants.slop)), zero());
      const V push = hn::Max(hn::Mul(soft_rate, overlap), splat(-constants.push_speed));
      speed_bias = hn::IfThenElse(apart, how::push == Push::Split ? zero() : speed_bias, push);
      mass = hn::IfThenElse(apart, mass, hn::Mul(mass, soft_mass));
      leak = hn::IfThenElse(apart, zero(), hn::Mul(soft_impulse, old_impulse));
    }
    // All but the product with the speed is off the chain from point to point.
    const V offset = hn::Neg(hn::Add(hn::Mul(mass, speed_bias), leak));
    const V wanted = hn::Sub(offset, hn::Mul(mass, solve.speed(x, y)));
    const V impulse = hn::Max(wanted, hn::Neg(old_impulse));
    store(hn::Add(old_impulse, impulse), impulses[i] + lane);
    response.apply(impulse, x, y, solve);
    if constexpr (how::special) residual.add(hn::Mul(impulse, response.own));
  }
}

// One round leaves a body that lands flat turning, and it jumps sideways. A contact that closes faster than this at its
// centre gets this many more: a box of 1 m dropped flat from 3 m then slides by 0.05 mm instead of 15, from 10 m by 4
// mm instead of 150.
constexpr float landing_speed = 0.5f;  // m/s
constexpr int landing_rounds = 7;

// For the lanes that land, and for them alone: whether others of their block do must not show.
template <typename how>
HWY_NOINLINE void share_impact(const ContactKernelData& data, ContactBlock& block, float (*impulses)[block_lanes],
                               std::size_t lane, const M& lands, ContactLanes& c, Residual& residual) {
  V before[max_points];
  for (std::size_t i = 0; i < max_points; ++i) before[i] = load(impulses[i] + lane);
  ContactLanes landed = c;
  Residual of_landed = residual;
  NormalSolve solve(landed);
  for (int round = 0; round < landing_rounds; ++round) {
    solve_points<how>(data, block, impulses, lane, landed, solve, of_landed);
  }
  solve.finish(landed);
  for (std::size_t i = 0; i < max_points; ++i) {
    store(hn::IfThenElse(lands, load(impulses[i] + lane), before[i]), impulses[i] + lane);
  }
  c.first.v = select(lands, landed.first.v, c.first.v);
  c.first.w = select(lands, landed.first.w, c.first.w);
  c.second.v = select(lands, landed.second.v, c.second.v);
  c.second.w = select(lands, landed.second.w, c.second.w);
  residual.most = hn::IfThenElse(lands, of_landed.most, residual.most);
}

template <typename how>
HWY_INLINE void solve_normals(const ContactKernelData& data, ContactBlock& block, float (*impulses)[block_lanes],
                              std::size_t lane, ContactLanes& c, Residual& residual) {
  NormalSolve solve(c);
  const M lands = hn::Lt(solve.u, splat(-landing_speed));
  solve_points<how>(data, block, impulses, lane, c, solve, residual);
  solve.finish(c);
  if (HWY_LIKELY(hn::AllFalse(D(), lands))) return;
  // Of copies, so that nothing else has to be in memory.
  ContactLanes landing = c;
  Residual landing_residual = residual;
  share_impact<how>(data, block, impulses, lane, lands, landing, landing_residual);
  c = landing;
  residual = landing_residual;
}

template <typename how>
float sweep_blocks(const ContactKernelData& data, [[maybe_unused]] const Sweep& sweep, std::size_t begin,
                   std::size_t end) {
  Residual residual;
  for (std::size_t b = begin; b < end; ++b) {
    ContactBlock& block = data.blocks[b];
    SurfaceBlock* surface = how::special && data.surface_blocks != nullptr ? &data.surface_blocks[b] : nullptr;
    auto* impulses = how::push == Push::Split ? data.split_blocks[b].impulse : block.normal_impulse;
    for (std::size_t lane = 0; lane < block_lanes; lane += lanes) {
      ContactLanes c = load_contacts(data, block, lane);
      if (how::refresh == Refresh::Yes || (how::special && sweep.refresh)) refresh_separations(data, block, lane, c);
      // Friction last, so that its bound is the normal impulse that it goes with.
      solve_normals<how>(data, block, impulses, lane, c, residual);
      // Rigid contacts have no softness to forgive what a round over the points leaves.
      if (how::push == Push::Split) solve_normals<how>(data, block, impulses, lane, c, residual);
      if constexpr (how::friction != Friction::None) {
        // With a bias it is the first substep, and contacts may be new: one round over the points leaves a body that
        // lands flat tilted, and friction with too low a bound.
        if (how::push == Push::Bias || (how::special && data.split_blocks != nullptr)) {
          solve_normals<how>(data, block, impulses, lane, c, residual);
        }
        solve_friction<how>(block, surface, lane, c, residual);
      }
      store_contact_bodies(c, data, block, lane);
    }
    if (data.bounces != nullptr && how::push != Push::Split) {
      BounceBlock& bounce = data.bounces[b];
      for (std::size_t i = 0; i < max_points; ++i) {
        for (std::size_t lane = 0; lane < block_lanes; lane += lanes) {
          const V impulse = load(block.normal_impulse[i] + lane);
          store(hn::Max(impulse, load(bounce.max_impulse[i] + lane)), bounce.max_impulse[i] + lane);
        }
      }
    }
  }
  return how::special ? hn::GetLane(hn::MaxOfLanes(D(), residual.most)) : 0;
}

template <Push push, Refresh refresh>
float sweep_with_friction(const ContactKernelData& data, const Sweep& sweep, std::size_t begin, std::size_t end) {
  switch (sweep.friction) {
    case Friction::None:
      return sweep_blocks<How<push, refresh, Friction::None>>(data, sweep, begin, end);
    case Friction::Cone:
      return sweep_blocks<How<push, refresh, Friction::Cone>>(data, sweep, begin, end);
    case Friction::Pyramid:
      return sweep_blocks<How<push, refresh, Friction::Pyramid>>(data, sweep, begin, end);
  }
  return 0;
}

template <Push push>
float sweep_with_push(const ContactKernelData& data, const Sweep& sweep, std::size_t begin, std::size_t end) {
  if (sweep.measures || data.surface_blocks != nullptr || data.constants.slop > 0) {
    return sweep_with_friction<push, Refresh::Asks>(data, sweep, begin, end);
  }
  if (sweep.refresh) return sweep_with_friction<push, Refresh::Yes>(data, sweep, begin, end);
  return sweep_with_friction<push, Refresh::No>(data, sweep, begin, end);
}

inline float sweep(const ContactKernelData& data, const Sweep& sweep, std::size_t begin, std::size_t end) {
  switch (sweep.push) {
    case Push::None:
      return sweep_with_push<Push::None>(data, sweep, begin, end);
    case Push::Bias:
      return sweep_with_push<Push::Bias>(data, sweep, begin, end);
    case Push::Split:
      return sweep_blocks<How<Push::Split, Refresh::Asks, Friction::None>>(data, sweep, begin, end);
  }
  return 0;
}

}  // namespace HWY_NAMESPACE
}  // namespace atl::solver
HWY_AFTER_NAMESPACE();

#endif  // ATOLL_SOLVER_CONTACT_SWEEP_INL_H_
