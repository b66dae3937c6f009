// Normal impulses of a block's contacts: the kinds of sweeps there are, and what each makes of a contact's points.
// Included once for each instruction set.

#if defined(ATOLL_SOLVER_CONTACT_NORMALS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATOLL_SOLVER_CONTACT_NORMALS_INL_H_
#undef ATOLL_SOLVER_CONTACT_NORMALS_INL_H_
#else
#define ATOLL_SOLVER_CONTACT_NORMALS_INL_H_
#endif

#include <solver/tuning.h>

#include "sweep/contact_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atl::solver {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace jobs::HWY_NAMESPACE;

// The parameters by which a sweep changes normal impulses, and all that its points depend on.
template <Push push_, bool special_>
struct NormalLaw {
  static constexpr Push push = push_;
  static constexpr bool special = special_;
};

// The parameters of an ordinary sweep, fixed at compile time.
template <Push push_, bool refresh_, bool rubs_, int rounds_>
struct Common : NormalLaw<push_, false> {
  using normals = NormalLaw<push_, false>;
  static HWY_INLINE bool refresh(const Sweep&) { return refresh_; }
  static HWY_INLINE bool rubs(const Sweep&) { return rubs_; }
  static HWY_INLINE int rounds(const Sweep&) { return rounds_; }
};

// Whatever a sweep asks for, and what few scenes need and costs something: running surfaces, rolling and torsional
// friction, the pyramid, locks, slop, and a residual.
template <Push push_>
struct Special : NormalLaw<push_, true> {
  using normals = NormalLaw<push_, true>;
  static HWY_INLINE bool refresh(const Sweep& sweep) { return sweep.refresh; }
  static HWY_INLINE bool rubs(const Sweep& sweep) { return sweep.friction != Friction::None; }
  static HWY_INLINE int rounds(const Sweep& sweep) { return sweep.twice ? 2 : 1; }
};

// The work that blocks need, fixed at compile time; the rest is left out.
template <std::size_t points_, MovableSides movable_>
struct What {
  static constexpr std::size_t points = points_;
  static constexpr MovableSides movable = movable_;
};

// The largest change of relative speed so far. Each lane on its own: the most of all is no sum and knows no order.
struct Residual {
  V max;
  HWY_INLINE Residual() : max(zero()) {}
  // NaN counts as nothing: instruction sets differ in which of two numbers is the larger if one is NaN.
  HWY_INLINE void add(V change) { max = hn::IfThenElse(hn::Gt(hn::Abs(change), max), hn::Abs(change), max); }
};

// The update of a point in a sweep: its impulse changes by offset - mass * speed, or to zero.
struct PointTarget {
  V offset, mass;
};

template <typename normals>
struct PointTargets {
  const ContactKernelData& data;
  const ContactBlock& block;
  std::size_t lane;
  V soft_rate, soft_impulse, soft_mass;

  HWY_INLINE PointTargets(const ContactKernelData& of, const ContactBlock& contacts, std::size_t from)
      : data(of),
        block(contacts),
        lane(from),
        soft_rate(load(block.bias_rate + lane)),
        soft_impulse(load(block.impulse_scale + lane)),
        soft_mass(hn::Sub(splat(1), soft_impulse)) {}

  // Apart: may close the gap in this substep, no faster. Overlapping: a push, or nothing but a stop. Corrections
  // leave gaps to the velocities.
  HWY_INLINE PointTarget of(std::size_t i, V rigid_mass, V old_impulse) const {
    const SubstepConstants& constants = data.constants;
    const V separation = load(block.separation[i] + lane);
    V speed_bias = hn::Mul(hn::Max(separation, zero()), splat(constants.inverse_h));
    V mass = rigid_mass;
    V leak = zero();
    if constexpr (normals::push != Push::None) {
      const M apart = hn::Gt(separation, zero());
      V overlap = separation;
      if constexpr (normals::special) overlap = hn::Min(hn::Add(separation, splat(constants.slop)), zero());
      const V push = hn::Max(hn::Mul(soft_rate, overlap), hn::Neg(load(block.push_speed + lane)));
      speed_bias = hn::IfThenElse(apart, normals::push == Push::Split ? zero() : speed_bias, push);
      mass = hn::IfThenElse(apart, mass, hn::Mul(mass, soft_mass));
      leak = hn::IfThenElse(apart, zero(), hn::Mul(soft_impulse, old_impulse));
    }
    return {hn::Neg(hn::Add(hn::Mul(mass, speed_bias), leak)), mass};
  }
};

// One round over the points of each contact.
template <typename normals, std::size_t points>
HWY_INLINE void solve_points(const ContactKernelData& data, ContactBlock& block, float (*impulses)[block_lanes],
                             std::size_t lane, NormalSolve& solve, Residual& residual, bool backwards) {
  const PointTargets<normals> targets(data, block, lane);
  for (std::size_t n = 0; n < points; ++n) {
    const std::size_t i = backwards ? points - 1 - n : n;
    const V x = load(block.x[i] + lane);
    const V y = load(block.y[i] + lane);
    const V old_impulse = load(impulses[i] + lane);
    const PointResponse response(block, lane, x, y);
    // Only the product with the speed depends on the point before.
    const PointTarget target = targets.of(i, response.mass, old_impulse);
    const V wanted = hn::Sub(target.offset, hn::Mul(target.mass, solve.speed(x, y)));
    const V impulse = hn::Max(wanted, hn::Neg(old_impulse));
    store(hn::Add(old_impulse, impulse), impulses[i] + lane);
    response.apply(impulse, x, y, solve);
    if constexpr (normals::special) residual.add(hn::Mul(impulse, response.own));
  }
}

// The first answer to an impact, in lanes that land: one step down the gradient of all points together, of the best
// length. It is symmetric in the points, so a body that lands flat stays flat whatever order of the points follows.
template <typename normals, std::size_t points>
HWY_NOINLINE void spread_impact(const ContactKernelData& data, const ContactBlock& block,
                                float (*impulses)[block_lanes], std::size_t lane, const M& lands, NormalSolve& solve) {
  const PointTargets<normals> targets(data, block, lane);
  V change[points];
  NormalSolve along = solve;
  along.u = along.w1 = along.w2 = zero();
  V gained = zero();
  for (std::size_t i = 0; i < points; ++i) {
    const V x = load(block.x[i] + lane);
    const V y = load(block.y[i] + lane);
    const V old_impulse = load(impulses[i] + lane);
    const PointResponse response(block, lane, x, y);
    const PointTarget target = targets.of(i, response.mass, old_impulse);
    const V wanted = hn::Sub(target.offset, hn::Mul(target.mass, solve.speed(x, y)));
    change[i] = hn::Max(wanted, hn::Neg(old_impulse));
    gained = hn::Add(gained, hn::Mul(change[i], hn::Mul(wanted, response.own)));
    response.apply(change[i], x, y, along);
  }
  V curvature = zero();
  for (std::size_t i = 0; i < points; ++i) {
    const V speed = along.speed(load(block.x[i] + lane), load(block.y[i] + lane));
    curvature = hn::Add(curvature, hn::Mul(change[i], speed));
  }
  const M steps = hn::And(lands, hn::And(hn::Gt(curvature, zero()), hn::Gt(gained, zero())));
  const V part = hn::Min(hn::Div(gained, hn::IfThenElse(steps, curvature, splat(1))), splat(1));
  const V taken = hn::IfThenElseZero(steps, part);
  NormalSolve after = solve;
  for (std::size_t i = 0; i < points; ++i) {
    const V x = load(block.x[i] + lane);
    const V y = load(block.y[i] + lane);
    const V old_impulse = load(impulses[i] + lane);
    const V impulse = hn::Mul(taken, change[i]);
    store(hn::IfThenElse(steps, hn::Add(old_impulse, impulse), old_impulse), impulses[i] + lane);
    PointResponse(block, lane, x, y).apply(impulse, x, y, after);
  }
  for (V NormalSolve::*number : {&NormalSolve::u, &NormalSolve::w1, &NormalSolve::w2, &NormalSolve::sum,
                                 &NormalSolve::sum_y, &NormalSolve::sum_minus_x}) {
    solve.*number = hn::IfThenElse(steps, after.*number, solve.*number);
  }
}

// Changes only the lanes that land, so that no lane's result depends on others of its block.
template <typename normals, std::size_t points>
HWY_NOINLINE void solve_impact(const ContactKernelData& data, ContactBlock& block, float (*impulses)[block_lanes],
                               std::size_t lane, const M& lands, NormalSolve& solve, Residual& residual,
                               bool backwards) {
  V before[points];
  for (std::size_t i = 0; i < points; ++i) before[i] = load(impulses[i] + lane);
  for (int round = 0; round < tuning::landing_rounds; ++round) {
    solve_points<normals, points>(data, block, impulses, lane, solve, residual, backwards);
  }
  for (std::size_t i = 0; i < points; ++i) {
    store(hn::IfThenElse(lands, load(impulses[i] + lane), before[i]), impulses[i] + lane);
  }
}

// Velocities that are split off have no start.
template <Push push, MovableSides movable>
HWY_INLINE NormalSolve start_of(const ContactLanes<movable>& c, const ContactBlock& block, std::size_t lane) {
  if constexpr (push == Push::Split) return NormalSolve(c);
  return NormalSolve(c, block, lane);
}

template <typename how, typename what>
HWY_INLINE void solve_normals(const ContactKernelData& data, ContactBlock& block, float (*impulses)[block_lanes],
                              std::size_t lane, ContactLanes<what::movable>& c, Residual& residual, bool backwards,
                              [[maybe_unused]] const V& rise) {
  NormalSolve solve = start_of<how::push>(c, block, lane);
  if constexpr (how::special) solve.u = hn::Sub(solve.u, rise);
  const M lands = hn::Lt(solve.u, splat(-tuning::landing_speed));
  const bool any_lands = HWY_UNLIKELY(!hn::AllFalse(D(), lands));
  // The rare branches below work on copies, so that the compiler can keep the originals in registers.
  if constexpr (what::points > 1) {
    // A contact also counts if it parts as fast, pushed by an impulse that was carried over.
    M hits = hn::Gt(hn::Abs(solve.u), splat(tuning::spread_speed));
    if (HWY_UNLIKELY(!hn::AllFalse(D(), hits))) {
      V pushed = load(impulses[0] + lane);
      for (std::size_t i = 1; i < what::points; ++i) pushed = hn::Add(pushed, load(impulses[i] + lane));
      hits = hn::And(hits, hn::Or(hn::Lt(solve.u, zero()), hn::Gt(pushed, zero())));
      NormalSolve spread = solve;
      // Both separations are tested, since that of a missing point may get smaller if bodies turn about a far point.
      const V none = splat(collision::no_point);
      const M several =
          hn::And(hn::Lt(load(block.start_separation[1] + lane), none), hn::Lt(load(block.separation[1] + lane), none));
      spread_impact<typename how::normals, what::points>(data, block, impulses, lane, hn::And(hits, several), spread);
      solve = spread;
    }
  }
  solve_points<typename how::normals, what::points>(data, block, impulses, lane, solve, residual, backwards);
  solve.finish(c);
  if (!any_lands) return;
  ContactLanes<what::movable> landed = c;
  Residual of_landed = residual;
  NormalSolve impact = start_of<how::push>(landed, block, lane);
  if constexpr (how::special) impact.u = hn::Sub(impact.u, rise);
  solve_impact<typename how::normals, what::points>(data, block, impulses, lane, lands, impact, of_landed, backwards);
  impact.finish(landed);
  if constexpr (first_moves<what::movable>) {
    c.first.v = select(lands, landed.first.v, c.first.v);
    c.first.w = select(lands, landed.first.w, c.first.w);
  }
  if constexpr (second_moves<what::movable>) {
    c.second.v = select(lands, landed.second.v, c.second.v);
    c.second.w = select(lands, landed.second.w, c.second.w);
  }
  residual.max = hn::IfThenElse(lands, of_landed.max, residual.max);
}

}  // namespace HWY_NAMESPACE
}  // namespace atl::solver
HWY_AFTER_NAMESPACE();

#endif  // ATOLL_SOLVER_CONTACT_NORMALS_INL_H_
