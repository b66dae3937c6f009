// Impacts that bounce: how fast points close as a substep begins, and what is given back as it ends. Included once for
// each instruction set.
//
// Bounces go from body to body one substep after the other: a bouncy point that would meet nothing in this one, if it
// were not for other impacts, waits for the next. Solved at once, as one impact, they would end as one that shares its
// motion.

#if defined(ATOLL_SOLVER_CONTACT_BOUNCES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATOLL_SOLVER_CONTACT_BOUNCES_INL_H_
#undef ATOLL_SOLVER_CONTACT_BOUNCES_INL_H_
#else
#define ATOLL_SOLVER_CONTACT_BOUNCES_INL_H_
#endif

#include <features/with_surfaces.h>
#include <solver/tuning.h>

#include "sweep/contact_sweep-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atl::solver {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace jobs::HWY_NAMESPACE;

// m/s^2, of the forces on the bodies along the normal.
struct Pull {
  V relative;  // negative where it brings them together
  V most;      // either could be held up by something else: as if both came
};
HWY_INLINE Pull pull_together(const SolverBodies& bodies, const ContactBlock& block, std::size_t lane,
                              const V3& normal) {
  const auto along_normal = [&](const std::int32_t* index) {
    const V4 a = load_rows([&](std::size_t k) { return bodies.acceleration[index[k]].linear; });
    return dot({a.x, a.y, a.z}, normal);
  };
  const V first = along_normal(block.first + lane);
  const V second = along_normal(block.second + lane);
  return {hn::Sub(second, first), hn::Neg(hn::Add(hn::Abs(first), hn::Abs(second)))};
}

// Whether a point that closes at `speed` under `acceleration` gets through its separation within `step` seconds.
HWY_INLINE M meets(V speed, V separation, V acceleration, float step) {
  const V shift = hn::Mul(splat(step), hn::Add(speed, hn::Mul(splat(0.5f * step), acceleration)));
  return hn::Or(hn::Le(separation, zero()), hn::Lt(hn::Add(separation, shift), zero()));
}

// The speed (negative) with which such a point arrives: as if the impact were found to the instant, so that bodies
// bounce off with the energy that they came with. Semi-implicit Euler loses (a h)^2 / 2 of it in each free substep:
// that of the `before` that have been is put back.
HWY_INLINE V impact_speed(V speed, V separation, V acceleration, V lost, float before) {
  const V gained = hn::Mul(hn::Mul(splat(2), acceleration), separation);
  const V put_back = hn::Sub(hn::Mul(splat(before), lost), gained);
  const V square = hn::Max(hn::Add(hn::Mul(speed, speed), put_back), zero());
  return hn::IfThenElse(hn::And(hn::Lt(speed, zero()), hn::Gt(separation, zero())), hn::Neg(hn::Sqrt(square)), speed);
}

template <MovableSides movable>
HWY_INLINE void note_approach(const ContactKernelData& data, int number, ContactBlock& block, BounceBlock& bounce,
                              std::size_t lane) {
  const auto before = static_cast<float>(number);
  const auto after = static_cast<float>(data.constants.substeps - 1 - number);
  const ContactLanes<movable> c = load_contacts<movable>(data, block, lane);
  const NormalSolve solve(c);
  const Pull pull = pull_together(data.bodies, block, lane, c.normal);
  const V fallen = hn::Mul(pull.relative, splat(data.constants.h));
  const V lost = hn::Mul(fallen, fallen);
  const V restitution = load(bounce.restitution + lane);
  const M bouncy = hn::Gt(restitution, zero());
  for (std::size_t i = 0; i < max_points; ++i) {
    const V speed = solve.speed(load(block.x[i] + lane), load(block.y[i] + lane));
    const V separation = load(block.separation[i] + lane);
    const M comes = meets(speed, separation, pull.most, data.constants.h);
    const M waits = hn::AndNot(comes, bouncy);
    store(hn::IfThenElse(waits, splat(collision::no_point), separation), block.separation[i] + lane);
    store(hn::IfThenElseZero(waits, splat(1)), bounce.waits[i] + lane);
    const V arrives = impact_speed(speed, separation, pull.relative, lost, before);
    const V departs = hn::Mul(restitution, arrives);
    // With what the substeps after it will lose.
    const V square = hn::Add(hn::Mul(departs, departs), hn::Mul(splat(after), lost));
    store(hn::IfThenElse(comes, arrives, zero()), bounce.approach[i] + lane);
    store(hn::Sqrt(square), bounce.departure[i] + lane);
    store(zero(), bounce.max_impulse[i] + lane);
  }
}

// For the first substep, with what the last step left: a point that is apart has bounced off, or has yet to arrive.
HWY_INLINE void prepare_bounces(const ContactKernelData& data, ContactBlock& block, BounceBlock& bounce,
                                std::size_t lane, V restitution) {
  store(restitution, bounce.restitution + lane);
  const M bouncy = hn::Gt(restitution, zero());
  M apart = bouncy;
  for (std::size_t i = 0; i < max_points; ++i) {
    const M gone = hn::And(bouncy, hn::Gt(load(block.separation[i] + lane), zero()));
    apart = hn::And(apart, gone);
    const V impulse = load(block.normal_impulse[i] + lane);
    store(hn::IfThenElse(gone, zero(), impulse), block.normal_impulse[i] + lane);
    store(zero(), bounce.spent[i] + lane);
  }
  for (float* rubs : {block.friction_impulse[0], block.friction_impulse[1], block.torsional_impulse}) {
    store(hn::IfThenElse(apart, zero(), load(rubs + lane)), rubs + lane);
  }
  if (data.bodies.locks.empty()) {
    note_approach<MovableSides::Both>(data, 0, block, bounce, lane);
  } else {
    note_approach<MovableSides::Locked>(data, 0, block, bounce, lane);
  }
}

template <MovableSides movable>
void note_approaches_by(const ContactKernelData& data, int number, std::size_t begin, std::size_t end) {
  for (std::size_t b = begin; b < end; ++b) {
    ContactBlock& block = data.blocks[b];
    if (!block.traits.bounces) continue;
    for (std::size_t lane = 0; lane < block_lanes; lane += lanes) {
      // Others keep what their last sweep saw.
      V seen[max_points];
      for (std::size_t i = 0; i < max_points; ++i) seen[i] = load(block.separation[i] + lane);
      const ContactLanes<movable> c = load_contacts<movable>(data, block, lane);
      refresh_separations<max_points>(data, block, turning_of(data, b), lane, c);
      const M bouncy = hn::Gt(load(data.bounces[b].restitution + lane), zero());
      for (std::size_t i = 0; i < max_points; ++i) {
        const V separation = load(block.separation[i] + lane);
        store(hn::IfThenElse(bouncy, separation, seen[i]), block.separation[i] + lane);
      }
      note_approach<movable>(data, number, block, data.bounces[b], lane);
    }
  }
}

inline void note_approaches(const ContactKernelData& data, int number, std::size_t begin, std::size_t end) {
  if (data.bodies.locks.empty()) return note_approaches_by<MovableSides::Both>(data, number, begin, end);
  note_approaches_by<MovableSides::Locked>(data, number, begin, end);
}

// Speeds back to the points that hit, and how they did.
template <MovableSides movable>
HWY_INLINE void give_back(const ContactBlock& block, const BounceBlock& bounce, std::size_t lane, const M (&hits)[4],
                          V (&impulses)[4], ContactLanes<movable>& c) {
  const std::size_t points = block.traits.points;
  NormalSolve solve(c);
  for (std::size_t n = 0; n < std::size_t{tuning::landing_rounds} * points; ++n) {
    const std::size_t i = n % points;
    const V x = load(block.x[i] + lane);
    const V y = load(block.y[i] + lane);
    const PointResponse response(block, lane, x, y);
    const V target = hn::Sub(solve.speed(x, y), load(bounce.departure[i] + lane));
    const V wanted = hn::Max(hn::Neg(hn::Mul(response.mass, target)), hn::Neg(impulses[i]));
    const V impulse = hn::IfThenElse(hits[i], wanted, zero());
    impulses[i] = hn::Add(impulses[i], impulse);
    response.apply(impulse, x, y, solve);
  }
  solve.finish(c);
}

// Friction bound by all that the contact pushed with, its bounce included (Walton, "Numerical simulation of inclined
// chute flows of monodisperse, inelastic, frictional spheres", Mech. Mater. 1993).
template <MovableSides movable>
HWY_INLINE void rub_in_bounce(const ContactBlock& block, const SurfaceBlock* surface, Friction friction,
                              std::size_t lane, V pushed, V (&rubs)[3], ContactLanes<movable>& c) {
  const V3 velocity = relative_velocity(c);
  V v1 = dot(c.tangent1, velocity);
  V v2 = dot(c.tangent2, velocity);
  const V spin = dot(c.normal, relative_spin(c));
  const V bound = hn::Mul(load(block.friction + lane), pushed);
  V torsional_bound = hn::Mul(bound, load(block.friction_radius + lane));
  if (surface != nullptr) {
    v1 = hn::Add(v1, load(surface->slip[0] + lane));
    v2 = hn::Add(v2, load(surface->slip[1] + lane));
    torsional_bound = hn::Add(torsional_bound, hn::Mul(load(surface->torsional_friction[0] + lane), pushed));
  }
  const Plane mass = Plane::load_from(block.friction_mass, lane);
  V new1 = hn::Sub(rubs[0], mass.first(v1, v2));
  V new2 = hn::Sub(rubs[1], mass.second(v1, v2));
  if (friction == Friction::Pyramid) {
    new1 = clamp_to(new1, bound);
    new2 = clamp_to(new2, bound);
  } else {
    hold_in_disc(mass, new1, new2, bound);
  }
  const V new_twist = clamp_to(hn::Sub(rubs[2], hn::Mul(load(block.twist_mass + lane), spin)), torsional_bound);
  apply(c, hn::Sub(new1, rubs[0]) * c.tangent1 + hn::Sub(new2, rubs[1]) * c.tangent2,
        hn::Sub(new_twist, rubs[2]) * c.normal);
  rubs[0] = new1;
  rubs[1] = new2;
  rubs[2] = new_twist;
}

// Takes what impulses made of velocities out of what is carried over to the next substep.
template <MovableSides movable>
HWY_INLINE void keep_from_carrying(const ContactKernelData& data, const ContactBlock& block, std::size_t lane,
                                   const M& bounces, const V (&impulses)[4], const V (&rubs)[3],
                                   ContactLanes<movable> c) {
  const V3 rest{zero(), zero(), zero()};
  c.first.v = c.first.w = c.second.v = c.second.w = rest;
  V sum = zero(), sum_y = zero(), sum_minus_x = zero();
  for (std::size_t i = 0; i < max_points; ++i) {
    sum = hn::Add(sum, impulses[i]);
    sum_y = hn::Add(sum_y, hn::Mul(impulses[i], load(block.y[i] + lane)));
    sum_minus_x = hn::Sub(sum_minus_x, hn::Mul(impulses[i], load(block.x[i] + lane)));
  }
  apply(c, sum * c.normal + (rubs[0] * c.tangent1 + rubs[1] * c.tangent2),
        rubs[2] * c.normal + (sum_y * c.tangent1 + sum_minus_x * c.tangent2));
  FreeVelocityRows* free_velocity = data.bodies.free_velocity.data();
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(D(), bounces, bits);
  const auto add = [&](const BodyLanes& body, unsigned mask) {
    const std::int32_t* index = body.index;
    const auto linear_row = [=](std::size_t k) { return free_velocity[index[k]].linear; };
    const auto angular_row = [=](std::size_t k) { return free_velocity[index[k]].angular; };
    const V4 v = load_rows(linear_row);
    const V4 w = load_rows(angular_row);
    store_rows({hn::Add(v.x, body.v.x), hn::Add(v.y, body.v.y), hn::Add(v.z, body.v.z), v.w}, linear_row, mask);
    store_rows({hn::Add(w.x, body.w.x), hn::Add(w.y, body.w.y), hn::Add(w.z, body.w.z), w.w}, angular_row, mask);
  };
  add(c.first, bits[0] & (static_cast<unsigned>(block.write_first) >> lane));
  add(c.second, bits[0] & (static_cast<unsigned>(block.write_second) >> lane));
}

// The velocities of `from` where the mask is.
template <MovableSides movable>
HWY_INLINE void take(const M& mask, const ContactLanes<movable>& from, ContactLanes<movable>& to) {
  to.first.v = select(mask, from.first.v, to.first.v);
  to.first.w = select(mask, from.first.w, to.first.w);
  to.second.v = select(mask, from.second.v, to.second.v);
  to.second.w = select(mask, from.second.w, to.second.w);
}

template <MovableSides movable>
void restitute_lanes(const ContactKernelData& data, Friction friction, bool last, std::size_t b, std::size_t lane) {
  ContactBlock& block = data.blocks[b];
  BounceBlock& bounce = data.bounces[b];
  const V threshold = splat(-data.constants.restitution_threshold);
  const M bouncy = hn::Gt(load(bounce.restitution + lane), zero());
  M hits[max_points];
  M bounces = hn::Lt(zero(), zero());
  V impulses[max_points];
  for (std::size_t i = 0; i < max_points; ++i) {
    hits[i] = hn::And(hn::And(hn::Lt(load(bounce.approach[i] + lane), threshold), bouncy),
                      hn::Gt(load(bounce.max_impulse[i] + lane), zero()));
    bounces = hn::Or(bounces, hits[i]);
    impulses[i] = load(block.normal_impulse[i] + lane);
  }
  if (hn::AllFalse(D(), bounces)) return;

  ContactLanes<movable> c = load_contacts<movable>(data, block, lane);
  ContactLanes<movable> away = c;
  V rubs[3] = {load(block.friction_impulse[0] + lane), load(block.friction_impulse[1] + lane),
               load(block.torsional_impulse + lane)};
  give_back(block, bounce, lane, hits, impulses, away);
  if (friction != Friction::None && block.traits.friction) {
    const SurfaceBlock* surface = with_surfaces && data.surface_blocks != nullptr ? &data.surface_blocks[b] : nullptr;
    ContactLanes<movable> rubbed = away;
    V rubbed_impulses[max_points] = {impulses[0], impulses[1], impulses[2], impulses[3]};
    const V pushed =
        hn::Add(hn::Add(rubbed_impulses[0], rubbed_impulses[1]), hn::Add(rubbed_impulses[2], rubbed_impulses[3]));
    rub_in_bounce(block, surface, friction, lane, pushed, rubs, rubbed);
    give_back(block, bounce, lane, hits, rubbed_impulses, rubbed);
    const M rub = hn::Gt(load(block.friction + lane), zero());
    take(rub, rubbed, away);
    for (std::size_t i = 0; i < max_points; ++i) impulses[i] = hn::IfThenElse(rub, rubbed_impulses[i], impulses[i]);
  }
  // Whether others of their block bounce must not show.
  take(bounces, away, c);
  store_contact_bodies(c, data, block, lane);
  if (!last) keep_from_carrying(data, block, lane, bounces, impulses, rubs, c);
  const auto put = [&](V impulse, float* to, float* spent) {
    const V kept = last ? impulse : zero();
    store(hn::IfThenElse(bounces, kept, load(to + lane)), to + lane);
    if (spent == nullptr || last) return;
    store(hn::Add(load(spent + lane), hn::IfThenElseZero(bounces, impulse)), spent + lane);
  };
  for (std::size_t i = 0; i < max_points; ++i) put(impulses[i], block.normal_impulse[i], bounce.spent[i]);
  put(rubs[0], block.friction_impulse[0], nullptr);
  put(rubs[1], block.friction_impulse[1], nullptr);
  put(rubs[2], block.torsional_impulse, nullptr);
}

template <MovableSides movable>
void restitute_by(const ContactKernelData& data, Friction friction, bool last, std::size_t begin, std::size_t end) {
  for (std::size_t b = begin; b < end; ++b) {
    if (!data.blocks[b].traits.bounces) continue;
    for (std::size_t lane = 0; lane < block_lanes; lane += lanes) {
      restitute_lanes<movable>(data, friction, last, b, lane);
    }
  }
}

inline void restitute(const ContactKernelData& data, Friction friction, bool last, std::size_t begin, std::size_t end) {
  if (data.bodies.locks.empty()) return restitute_by<MovableSides::Both>(data, friction, last, begin, end);
  restitute_by<MovableSides::Locked>(data, friction, last, begin, end);
}

}  // namespace HWY_NAMESPACE
}  // namespace atl::solver
HWY_AFTER_NAMESPACE();

#endif  // ATOLL_SOLVER_CONTACT_BOUNCES_INL_H_
