// Makes contact blocks of manifolds. Included once for each instruction set.

#if defined(ATOLL_SOLVER_CONTACT_PREPARE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATOLL_SOLVER_CONTACT_PREPARE_INL_H_
#undef ATOLL_SOLVER_CONTACT_PREPARE_INL_H_
#else
#define ATOLL_SOLVER_CONTACT_PREPARE_INL_H_
#endif

#include <features/with_restitution.h>
#include <features/with_surfaces.h>
#include <jobs/prefetch.h>

#include "sweep/contact_lanes-inl.h"
#include "sweep/contact_locks-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atl::solver {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace jobs::HWY_NAMESPACE;

HWY_INLINE const collision::ContactManifold& manifold_of(const ContactKernelData& data, const ContactBlock& block,
                                                         std::size_t lane) {
  // The manifold that a lane without a contact reads.
  static constexpr collision::ContactManifold vacant = {
      {0, 0, 1},
      0,
      {0, 0, 0},
      0,
      {0, 0, 0},
      0,
      {0, 0, 0, 0},
      {0, 0, 0, 0},
      {collision::no_point, collision::no_point, collision::no_point, collision::no_point},
      {0, 0, 0, 0},
      {0, 0, 0},
      0};
  const std::int32_t slot = block.slot[lane];
  return slot < 0 ? vacant : data.manifolds[slot];
}

template <typename ManifoldOf>
HWY_INLINE ManifoldLanes load_manifolds(const ManifoldOf& of) {
  return {load_rows([&](std::size_t k) { return of(k).normal; }),
          load_rows([&](std::size_t k) { return of(k).anchor_first; }),
          load_rows([&](std::size_t k) { return of(k).anchor_second; }),
          load_rows([&](std::size_t k) { return of(k).x; }),
          load_rows([&](std::size_t k) { return of(k).y; }),
          load_rows([&](std::size_t k) { return of(k).separation; }),
          load_rows([&](std::size_t k) { return of(k).normal_impulse; }),
          load_rows([&](std::size_t k) { return of(k).friction_impulse; })};
}

HWY_INLINE void store4(const V4& v, float (*rows)[block_lanes], std::size_t lane) {
  store(v.x, rows[0] + lane);
  store(v.y, rows[1] + lane);
  store(v.z, rows[2] + lane);
  store(v.w, rows[3] + lane);
}

// A contact without friction, or without torsional friction, has mass 0 in that row, so that sweeps leave exactly zero.
HWY_INLINE void prepare_masses(ContactBlock& block, std::size_t lane, const ContactLanes<>& c, M rubs, M twists) {
  const V inverse_mass = hn::Add(c.inverse_mass_first, c.inverse_mass_second);
  const M vacant = hn::Eq(inverse_mass, zero());
  const V one_if_vacant = hn::IfThenElse(vacant, splat(1), zero());
  const V3& t1 = c.tangent1;
  const V3& t2 = c.tangent2;

  const V3 n_first = cross(c.anchor_first, c.normal);
  const V3 n_second = cross(c.anchor_second, c.normal);
  const V k[6] = {
      hn::Add(hn::Add(inverse_mass, angular_response(c, n_first, n_second, n_first, n_second)), one_if_vacant),
      angular_response(c, n_first, n_second, t1, t1),
      angular_response(c, n_first, n_second, t2, t2),
      angular_response(c, t1, t1, t1, t1),
      angular_response(c, t1, t1, t2, t2),
      angular_response(c, t2, t2, t2, t2)};
  for (std::size_t i = 0; i < 6; ++i) store(k[i], block.k[i] + lane);

  const Plane mass = tangential_response(c, hn::Add(inverse_mass, one_if_vacant)).inverse();
  Plane{hn::IfThenElseZero(rubs, mass.m11), hn::IfThenElseZero(rubs, mass.m12), hn::IfThenElseZero(rubs, mass.m22)}
      .store_to(block.friction_mass, lane);

  const V twist = angular_response(c, c.normal, c.normal, c.normal, c.normal);
  const M turns = hn::And(twists, hn::Gt(twist, zero()));
  store(hn::IfThenElse(turns, hn::Div(splat(1), hn::IfThenElse(turns, twist, splat(1))), zero()),
        block.twist_mass + lane);
}

HWY_INLINE bool any(const M& mask) { return !hn::AllFalse(D(), mask); }

// Records the features that the block has, so that kernels leave out the others.
HWY_INLINE void record_traits(ContactTraits& traits, const ManifoldLanes& m) {
  const V separation[max_points] = {m.separation.x, m.separation.y, m.separation.z, m.separation.w};
  for (std::size_t i = traits.points; i < max_points; ++i) {
    if (any(hn::Lt(separation[i], splat(collision::no_point)))) traits.points = static_cast<std::uint8_t>(i + 1);
  }
  traits.friction |= any(hn::Gt(m.normal.w, zero()));
  traits.bounces |= any(hn::Gt(m.anchor_first.w, zero()));
}

HWY_INLINE const SurfaceContact& surface_of(const ContactKernelData& data, const ContactBlock& block,
                                            std::size_t lane) {
  static constexpr SurfaceContact plain = {};
  const std::int32_t slot = block.slot[lane];
  return slot < 0 ? plain : data.surface_contacts[slot];
}

// The rolling impulses, and in w the torsional friction.
HWY_INLINE V4 rolling_lanes(const ContactKernelData& data, const ContactBlock& block, std::size_t lane) {
  return load_rows([&](std::size_t k) { return surface_of(data, block, lane + k).rolling_impulse; });
}

// Friction that depends on its direction.
HWY_INLINE void prepare_grip(const ContactKernelData& data, ContactBlock& block, SurfaceBlock& surface,
                             std::size_t lane, const ContactLanes<>& c, V twist) {
  const V4 grip = load_rows([&](std::size_t k) { return surface_of(data, block, lane + k).grip; });
  const V along1 = dot(c.tangent1, {grip.x, grip.y, grip.z}), along2 = dot(c.tangent2, {grip.x, grip.y, grip.z});
  const V length = hn::Sqrt(hn::Add(hn::Mul(along1, along1), hn::Mul(along2, along2)));
  const M uneven = hn::Gt(length, zero());
  const V part = hn::IfThenElse(uneven, length, splat(1));
  store(hn::IfThenElse(uneven, hn::Div(along1, part), splat(1)), surface.cosine[0] + lane);
  store(hn::IfThenElseZero(uneven, hn::Div(along2, part)), surface.sine[0] + lane);
  store(hn::IfThenElse(uneven, grip.w, splat(1)), surface.ratio[0] + lane);
  store(hn::Mul(load(block.friction + lane), part), block.friction + lane);
  store(hn::Mul(load(block.friction_radius + lane), hn::IfThenElse(uneven, hn::Div(twist, part), splat(1))),
        block.friction_radius + lane);
}

// A contact that has just begun has no normal impulse, and so nothing that an earlier one in its slot left behind.
HWY_INLINE void prepare_surfaces(const ContactKernelData& data, ContactBlock& block, SurfaceBlock& surface,
                                 std::size_t lane, const ContactLanes<>& c, const V4& rolling) {
  const V4 slip = load_rows([&](std::size_t k) { return surface_of(data, block, lane + k).slip; });
  const V normal_impulse = load_of(block, lane);
  store(dot(c.tangent1, {slip.x, slip.y, slip.z}), surface.slip[0] + lane);
  store(dot(c.tangent2, {slip.x, slip.y, slip.z}), surface.slip[1] + lane);
  const V4 spin = load_rows([&](std::size_t k) { return surface_of(data, block, lane + k).spin; });
  const V3* axes[3] = {&c.tangent1, &c.tangent2, &c.normal};
  for (std::size_t i = 0; i < 3; ++i) store(dot(*axes[i], {spin.x, spin.y, spin.z}), surface.spin[i] + lane);
  store(slip.w, surface.rolling_friction[0] + lane);
  store(rolling.w, surface.torsional_friction[0] + lane);
  for (std::size_t k = lane; k < lane + lanes; ++k) {
    const bool rises = data.rises != nullptr && block.slot[k] >= 0;
    surface.rise[0][k] = rises ? data.rises[block.slot[k]] / data.constants.step : 0;
  }

  prepare_grip(data, block, surface, lane, c, spin.w);

  const V3 kept = splat(1 / data.constants.refinement) * V3{rolling.x, rolling.y, rolling.z};
  V r1 = dot(c.tangent1, kept);
  V r2 = dot(c.tangent2, kept);
  clamp_to_disc(r1, r2, hn::Mul(slip.w, normal_impulse));
  // A disc of radius zero lets pass what is so small that its square is zero.
  const M rolls_hard = hn::Gt(slip.w, zero());
  store(hn::IfThenElse(rolls_hard, r1, zero()), surface.rolling_impulse[0] + lane);
  store(hn::IfThenElse(rolls_hard, r2, zero()), surface.rolling_impulse[1] + lane);

  // Bodies that can't turn are not to be held from rolling.
  Plane spins{load(block.k[3] + lane), load(block.k[4] + lane), load(block.k[5] + lane)};
  const M turn = hn::And(rolls_hard, hn::Gt(spins.determinant(), zero()));
  spins = {hn::IfThenElse(turn, spins.m11, splat(1)), hn::IfThenElse(turn, spins.m12, zero()),
           hn::IfThenElse(turn, spins.m22, splat(1))};
  const Plane mass = spins.inverse();
  Plane{hn::IfThenElse(turn, mass.m11, zero()), hn::IfThenElse(turn, mass.m12, zero()),
        hn::IfThenElse(turn, mass.m22, zero())}
      .store_to(surface.rolling_mass, lane);
  if (!data.bodies.locks.empty()) lock_rolling(data.bodies, block, lane, rolls_hard, surface);
}

// A ball is touched where the normal through its centre leaves it. Its contact may be some way from there: as the step
// starts, it may yet have to travel to where it will be hit.
HWY_INLINE void put_on_line_of_centres(const SolverBodies& bodies, const ContactBlock& block, std::size_t lane,
                                       ContactLanes<>& c) {
  const auto on_line = [&](const std::int32_t* index, const V3& anchor) {
    const V carries = load_displacement(bodies, index).w;
    return select(hn::Gt(carries, zero()), anchor, dot(anchor, c.normal) * c.normal);
  };
  c.anchor_first = on_line(block.first + lane, c.anchor_first);
  c.anchor_second = on_line(block.second + lane, c.anchor_second);
}

// Bodies that are apart will have closed by the time they push: each is touched at its own surface, not half way.
HWY_INLINE void put_on_surfaces(const ManifoldLanes& m, ContactLanes<>& c) {
  const V min = hn::Min(hn::Min(m.separation.x, m.separation.y), hn::Min(m.separation.z, m.separation.w));
  const M apart = hn::And(hn::Gt(min, zero()), hn::Lt(min, splat(collision::no_point)));
  const V3 half_gap = hn::IfThenElseZero(apart, hn::Mul(splat(0.5f), min)) * c.normal;
  c.anchor_first = c.anchor_first - half_gap;
  c.anchor_second = c.anchor_second + half_gap;
}

// An arm turned by the vector `turn`.
HWY_INLINE V3 turned_arm(const V3& turn, const V3& arm) {
  const V3 u = splat(0.5f) * turn;
  const V norm = hn::Add(splat(1), dot(u, u));
  const V3 t = cross(u, arm);
  return arm + hn::Div(splat(2), norm) * (t + cross(u, t));
}

// An arm that a body has taken along for half of the step, from its pivot and its rim. The lowest point of a round body
// is not moved by its spin, but the turn of its axis moves it along the rim.
HWY_INLINE V3 arm_half_way(const V3& half, const V3& pivot, const V3& rim, const V3& axis, const V3& normal) {
  constexpr auto min_lean = static_cast<float>(tuning::min_lean);
  const V along = dot(axis, normal);
  const V lean = hn::Max(hn::Sub(splat(1), hn::Mul(along, along)), splat(min_lean));
  const V3 without_spin = half - dot(half, axis) * axis;
  const V3 tilt = without_spin + hn::Div(hn::Mul(dot(without_spin, normal), along), lean) * axis;
  const M revolved = hn::Gt(dot(axis, axis), zero());
  // A spin goes with its axis, which it doesn't turn.
  const V3 on_axis = dot(pivot, axis) * axis;
  return turned_arm(half, pivot - on_axis) + select(revolved, turned_arm(tilt, on_axis + rim), rim);
}

// rad, of the bodies' half turns, and in w the kind of ShapeRows.
HWY_INLINE V4 load_half_turn(const SolverBodies& bodies, const std::int32_t* index) {
  const ShapeRows* shape = bodies.shape.data();
  return load_rows([=](std::size_t k) { return shape[index[k]].half_turn; });
}

// rad, about the normal: how far a turn takes the line along which a surface of revolution touches.
HWY_INLINE V line_turn(const V4& turn, const V3& axis, const V3& normal) {
  const V3 flat = axis - dot(axis, normal) * normal;
  const V square = hn::Max(dot(flat, flat), splat(static_cast<float>(tuning::min_lean)));
  const V3 moved = cross({turn.x, turn.y, turn.z}, axis);
  return hn::IfThenElseZero(hn::Gt(turn.w, zero()), hn::Div(dot(normal, cross(flat, moved)), square));
}

// Turns the lines in which such surfaces touch, by two points, as far as their axes turn in half of the step. A load
// on one end of a line that lags would drive the rolling.
HWY_INLINE void turn_lines(const SolverBodies& bodies, const RimBlock& rims, std::size_t lane, const ContactLanes<>& c,
                           ManifoldLanes& m) {
  const V3 axis_first = load3(rims.axis_first, lane), axis_second = load3(rims.axis_second, lane);
  const V of_first = line_turn(load_half_turn(bodies, c.first.index), axis_first, c.normal);
  const V of_second = line_turn(load_half_turn(bodies, c.second.index), axis_second, c.normal);
  const V turn = hn::IfThenElse(hn::Gt(dot(axis_first, axis_first), zero()), of_first, of_second);
  const M lines =
      hn::And(hn::Lt(m.separation.y, splat(collision::no_point)), hn::Ge(m.separation.z, splat(collision::no_point)));
  const V tangent = hn::IfThenElseZero(lines, turn);
  const V cosine = hn::Div(splat(1), hn::Sqrt(hn::Add(splat(1), hn::Mul(tangent, tangent))));
  const auto turned = [&](V& x, V& y) {
    const V old = x;
    x = hn::Mul(cosine, hn::Sub(x, hn::Mul(tangent, y)));
    y = hn::Mul(cosine, hn::Add(y, hn::Mul(tangent, old)));
  };
  turned(m.x.x, m.y.x);
  turned(m.x.y, m.y.y);
}

// Takes contacts that have rims along with each of their bodies for half of the step.
HWY_NOINLINE void roll_half_way(const SolverBodies& bodies, TurningBlock& turning, const RimBlock& rims,
                                std::size_t lane, ContactLanes<>& c, ManifoldLanes& m) {
  turn_lines(bodies, rims, lane, c, m);
  const auto take = [&](const BodyLanes& body, const float(*rim_rows)[block_lanes], const float(*axes)[block_lanes],
                        float(*pivots)[block_lanes], V3& arm) {
    const V4 turn = load_half_turn(bodies, body.index);
    const V3 rim = load3(rim_rows, lane);
    const V3 pivot = arm - rim;
    store3(pivot, pivots, lane);
    const V3 taken = arm_half_way({turn.x, turn.y, turn.z}, pivot, rim, load3(axes, lane), c.normal);
    arm = select(hn::Gt(turn.w, zero()), taken, arm);
  };
  take(c.first, rims.rim_first, rims.axis_first, turning.pivot_first, c.anchor_first);
  take(c.second, rims.rim_second, rims.axis_second, turning.pivot_second, c.anchor_second);
}

// Turns the planes of faces as far as these turn in half of the step: what slides along one that lagged would get into
// it, by half of the way that it slides times the turn. What stays in a plane of its bodies has its normal in that.
HWY_INLINE void turn_planes(const TurningBlock& turning, std::size_t lane, M in_plane, ContactLanes<>& c) {
  const V3 turn = load3(turning.plane_turn, lane);
  const M turns = hn::AndNot(in_plane, hn::Gt(dot(turn, turn), zero()));
  if (hn::AllFalse(D(), turns)) return;
  c.normal = select(turns, turned_arm(turn, c.normal), c.normal);
  c.tangent1 = select(turns, turned_arm(turn, c.tangent1), c.tangent1);
  c.tangent2 = select(turns, cross(c.normal, c.tangent1), c.tangent2);
}

// The same of all contacts.
HWY_INLINE void take_half_way(const SolverBodies& bodies, TurningBlock& turning, const RimBlock* rims, std::size_t lane,
                              ContactLanes<>& c, ManifoldLanes& m) {
  if (HWY_UNLIKELY(rims != nullptr)) return roll_half_way(bodies, turning, *rims, lane, c, m);
  store3(c.anchor_first, turning.pivot_first, lane);
  store3(c.anchor_second, turning.pivot_second, lane);
  const auto moved = [&](const BodyLanes& body, const V3& arm) {
    const V4 turn = load_half_turn(bodies, body.index);
    return select(hn::Gt(turn.w, zero()), turned_arm({turn.x, turn.y, turn.z}, arm), arm);
  };
  c.anchor_first = moved(c.first, c.anchor_first);
  c.anchor_second = moved(c.second, c.anchor_second);
}

// Loads the lanes with the velocities that the step begins with.
HWY_INLINE ContactLanes<> lanes_of(const SolverBodies& bodies, const ContactBlock& block, std::size_t lane,
                                   const ManifoldLanes& m) {
  ContactLanes<> c;
  c.normal = {m.normal.x, m.normal.y, m.normal.z};
  c.tangent1 = tangent_lanes(c.normal).first;
  c.tangent2 = cross(c.normal, c.tangent1);
  c.anchor_first = {m.anchor_first.x, m.anchor_first.y, m.anchor_first.z};
  c.anchor_second = {m.anchor_second.x, m.anchor_second.y, m.anchor_second.z};
  load_bodies(bodies, bodies.start_velocity.data(), block.first + lane, c.first);
  load_bodies(bodies, bodies.start_velocity.data(), block.second + lane, c.second);
  const FreeVelocityRows* free_velocity = bodies.free_velocity.data();
  const auto inverse_mass_of = [&](const std::int32_t* index) {
    return load_rows([=](std::size_t k) { return free_velocity[index[k]].linear; }).w;
  };
  c.inverse_mass_first = inverse_mass_of(block.first + lane);
  c.inverse_mass_second = inverse_mass_of(block.second + lane);
  return c;
}

HWY_INLINE void store_geometry(ContactBlock& block, std::size_t lane, const ContactLanes<>& c, const ManifoldLanes& m) {
  store3(c.normal, block.normal, lane);
  store3(c.tangent1, block.tangent, lane);
  store3(c.anchor_first, block.anchor_first, lane);
  store3(c.anchor_second, block.anchor_second, lane);
  store(m.normal.w, block.friction + lane);
  store(m.anchor_second.w, block.friction_radius + lane);
  store4(m.x, block.x, lane);
  store4(m.y, block.y, lane);
  store4(m.separation, block.start_separation, lane);
  store4(m.separation, block.separation, lane);
  store(c.inverse_mass_first, block.inverse_mass[0] + lane);
  store(c.inverse_mass_second, block.inverse_mass[1] + lane);
}

HWY_INLINE void store_start(ContactBlock& block, std::size_t lane, const ContactLanes<>& c) {
  const NormalSolve normal(c);
  const V3 velocity = gained_velocity(c);
  store3({normal.u, normal.w1, normal.w2}, block.start_normal, lane);
  store3({dot(c.tangent1, velocity), dot(c.tangent2, velocity), dot(c.normal, gained_spin(c))}, block.start_tangent,
         lane);
}

// Starts each substep with its share of the last step's impulses, and with none for friction that isn't there.
HWY_INLINE void store_impulses(ContactBlock& block, std::size_t lane, const ContactLanes<>& c, const ManifoldLanes& m,
                               V share, M rubs, M twists) {
  const auto kept = [&](V impulse) { return hn::Mul(share, hn::Max(impulse, zero())); };
  store4({kept(m.impulse.x), kept(m.impulse.y), kept(m.impulse.z), kept(m.impulse.w)}, block.normal_impulse, lane);
  const V3 friction = share * V3{m.friction.x, m.friction.y, m.friction.z};
  store(hn::IfThenElseZero(rubs, dot(c.tangent1, friction)), block.friction_impulse[0] + lane);
  store(hn::IfThenElseZero(rubs, dot(c.tangent2, friction)), block.friction_impulse[1] + lane);
  store(hn::IfThenElseZero(twists, hn::Mul(share, m.friction.w)), block.torsional_impulse + lane);
}

// The smaller of the bodies that move says how large a contact is. A body sinks in by as much of its size in a step,
// and falls as fast, by the root of gravity times size: of what is larger than usual, the push follows that.
HWY_INLINE void prepare_push(const ContactKernelData& data, ContactBlock& block, std::size_t lane,
                             const ContactLanes<>& c) {
  constexpr auto max = static_cast<float>(1 / tuning::reference_gravity);
  const auto square_of = [](const V3& arm, V inverse_mass) {
    return hn::IfThenElse(hn::Gt(inverse_mass, zero()), dot(arm, arm), splat(collision::no_point));
  };
  const V square =
      hn::Min(square_of(c.anchor_first, c.inverse_mass_first), square_of(c.anchor_second, c.inverse_mass_second));
  const V push = splat(data.constants.push_speed);
  const float largest = 1 / (max * data.constants.gravity);
  const M known = hn::Lt(square, splat(collision::no_point));
  if (hn::AllFalse(D(), hn::And(known, hn::Gt(square, splat(largest * largest))))) {
    store(push, block.push_speed + lane);
    return;
  }
  const V size = hn::IfThenElseZero(known, hn::Sqrt(square));
  const V growth = hn::Max(hn::Mul(splat(max * data.constants.gravity), size), splat(1));
  store(hn::Mul(push, hn::Sqrt(growth)), block.push_speed + lane);
}

// Lanes between bodies without joints.
HWY_INLINE M are_free(const std::uint8_t* joined, const ContactBlock& block, std::size_t lane) {
  float free[lanes];
  for (std::size_t k = 0; k < lanes; ++k) {
    free[k] = joined[block.first[lane + k]] || joined[block.second[lane + k]] ? 0.0f : 1.0f;
  }
  return hn::Gt(hn::LoadU(D(), free), zero());
}

// Sets the softness of each contact by its load in the last step: see Stiffening.
HWY_INLINE void prepare_softness(const ContactKernelData& data, ContactBlock& block, std::size_t lane,
                                 const ContactLanes<>& c) {
  const M first_fixed = hn::Eq(c.inverse_mass_first, zero());
  const M second_fixed = hn::Eq(c.inverse_mass_second, zero());
  const M fixed = hn::Or(first_fixed, second_fixed);
  const Softness& with_fixed = data.constants.fixed_contact;
  const Softness& with_dynamic = data.constants.dynamic_contact;
  const auto soft = [&](float Softness::*number) {
    return hn::IfThenElse(fixed, splat(with_fixed.*number), splat(with_dynamic.*number));
  };
  store(soft(&Softness::bias_rate), block.bias_rate + lane);
  store(soft(&Softness::impulse_scale), block.impulse_scale + lane);

  const Stiffening& stiffening = data.constants.stiffening;
  if (!(stiffening.max > 1)) return;
  const V inverse_mass = hn::Add(c.inverse_mass_first, c.inverse_mass_second);
  const V estimate = hn::Mul(hn::Mul(load_of(block, lane), inverse_mass), splat(stiffening.penetration_by_load));
  constexpr auto part = static_cast<float>(tuning::stiffening_penetration * tuning::stiffening_penetration);
  const V max_square = hn::Mul(
      splat(part), square_of_half_thickness(c.normal, c.anchor_first, first_fixed, c.anchor_second, second_fixed));
  M over = hn::AndNot(fixed, hn::Gt(hn::Mul(estimate, estimate), max_square));
  if (HWY_LIKELY(!any(over))) return;
  if (data.joined != nullptr) over = hn::And(over, are_free(data.joined, block, lane));
  const V times = hn::Div(estimate, hn::Sqrt(hn::IfThenElse(over, max_square, splat(1))));
  const V response = hn::Mul(splat(stiffening.response), hn::Min(times, splat(stiffening.max)));
  const V leak = hn::Div(splat(1), hn::Add(splat(1), response));
  store(hn::IfThenElse(over, leak, load(block.impulse_scale + lane)), block.impulse_scale + lane);
}

HWY_INLINE void prepare_lanes(const ContactKernelData& data, std::size_t b, std::size_t lane, ContactTraits& traits) {
  ContactBlock& block = data.blocks[b];
  ManifoldLanes m = load_manifolds(
      [&](std::size_t k) -> const collision::ContactManifold& { return manifold_of(data, block, lane + k); });
  ContactLanes<> c = lanes_of(data.bodies, block, lane, m);
  const bool locks = data.planar_blocks != nullptr;
  const bool surfaces = with_surfaces && data.surface_blocks != nullptr;
  PlanarLanes in_plane{hn::Lt(zero(), zero()), hn::Lt(zero(), zero())};
  if (locks) in_plane = turn_into_plane(data.bodies, block, lane, data.planar_blocks[b], c, m);
  if (data.bodies.balls) put_on_line_of_centres(data.bodies, block, lane, c);
  put_on_surfaces(m, c);
  if (data.turning_blocks != nullptr) {
    take_half_way(data.bodies, data.turning_blocks[b], block.traits.rims ? &data.rim_blocks[b] : nullptr, lane, c, m);
    turn_planes(data.turning_blocks[b], lane, in_plane.planar, c);
  }
  store_geometry(block, lane, c, m);
  store_start(block, lane, c);
  prepare_push(data, block, lane, c);

  M rubs = hn::Gt(m.normal.w, zero());
  if (locks) rubs = hn::AndNot(in_plane.across, rubs);
  M twists = rubs;
  V4 rolling;
  if (surfaces) {
    rolling = rolling_lanes(data, block, lane);
    twists = hn::Or(twists, hn::Gt(rolling.w, zero()));
  }
  if (locks) twists = hn::AndNot(in_plane.planar, twists);
  store_impulses(block, lane, c, m, splat(1 / data.constants.refinement), rubs, twists);
  prepare_softness(data, block, lane, c);
  prepare_masses(block, lane, c, rubs, twists);
  if (locks) {
    traits.locked |= lock_contacts(data.bodies, block, lane, c, rubs, in_plane.planar, m.separation);
    keep_in_plane(block, lane, c, rubs, in_plane.planar);
  }
  if (surfaces) prepare_surfaces(data, block, data.surface_blocks[b], lane, c, rolling);
  record_traits(traits, m);
}

inline void prepare(const ContactKernelData& data, std::size_t begin, std::size_t end) {
  constexpr std::size_t ahead = 2;
  for (std::size_t b = begin; b < end; ++b) {
    ContactBlock& block = data.blocks[b];
    if (b + ahead < end) {
      for (const std::int32_t slot : data.blocks[b + ahead].slot) jobs::prefetch(data.manifolds[slot < 0 ? 0 : slot]);
    }
    ContactTraits traits = {.points = 1, .friction = data.surface_blocks != nullptr, .bounces = false, .locked = false};
    for (std::size_t lane = 0; lane < block_lanes; lane += lanes) prepare_lanes(data, b, lane, traits);
    if (!data.leaves_out) traits = {};
    traits.rims = block.traits.rims;
    block.traits = traits;
    block.traits.bounces &= data.bounces != nullptr;
    if (!with_restitution || !block.traits.bounces) continue;
    for (std::size_t lane = 0; lane < block_lanes; lane += lanes) {
      const V4 rows = load_rows([&](std::size_t k) { return manifold_of(data, block, lane + k).anchor_first; });
      store(rows.w, data.bounces[b].restitution + lane);
      for (auto& spent : data.bounces[b].spent) store(zero(), spent + lane);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace atl::solver
HWY_AFTER_NAMESPACE();

#endif  // ATOLL_SOLVER_CONTACT_PREPARE_INL_H_
