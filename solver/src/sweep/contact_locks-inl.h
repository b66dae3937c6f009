// Motion locks in contacts: effective masses, and rows without response. Included once for each instruction set.

#if defined(ATOLL_SOLVER_CONTACT_LOCKS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATOLL_SOLVER_CONTACT_LOCKS_INL_H_
#undef ATOLL_SOLVER_CONTACT_LOCKS_INL_H_
#else
#define ATOLL_SOLVER_CONTACT_LOCKS_INL_H_
#endif

#include "sweep/contact_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atl::solver {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace jobs::HWY_NAMESPACE;

// A row whose response with locks is less than this part of that without gets no impulse. The impulse would have to be
// so large that rounding would throw the bodies about.
constexpr float min_response = 1e-3f;

// The part of both bodies' inverse mass that locks remove along each axis.
HWY_INLINE V3 lost_inverse_mass(const SolverBodies& bodies, const ContactBlock& block, std::size_t lane,
                                const ContactLanes<>& c) {
  const auto lost = [&](const std::int32_t* index, V inverse_mass) {
    const V4 free = load_free_axes(bodies, index + lane);
    return inverse_mass * (V3{splat(1), splat(1), splat(1)} - V3{free.x, free.y, free.z});
  };
  return lost(block.first, c.inverse_mass_first) + lost(block.second, c.inverse_mass_second);
}

// Reduces a manifold to two points at most, for a contact in a plane, where only x counts: the deepest point and the
// one farthest from it, in order of x. Every other point hands its impulse to the nearer of the two, so it doesn't
// matter which of two points that coincide in the plane is kept.
struct PlanarPoints {
  V x[2], separation[2], impulse[2];
  V point[2];  // of the manifold; -1 if there is none

  HWY_INLINE PlanarPoints(const V (&xs)[max_points], const V (&separations)[max_points],
                          const V (&impulses)[max_points]) {
    const V none = splat(collision::no_point);
    const auto is_there = [&](std::size_t i) { return hn::Lt(separations[i], none); };
    V deepest = none, at = zero(), deepest_point = splat(-1);
    for (std::size_t i = 0; i < max_points; ++i) {
      const M deeper = hn::Lt(separations[i], deepest);
      deepest = hn::IfThenElse(deeper, separations[i], deepest);
      at = hn::IfThenElse(deeper, xs[i], at);
      deepest_point = hn::IfThenElse(deeper, splat(static_cast<float>(i)), deepest_point);
    }
    V reach = zero();
    for (std::size_t i = 0; i < max_points; ++i) {
      reach = hn::Max(reach, hn::IfThenElseZero(is_there(i), hn::Abs(hn::Sub(xs[i], at))));
    }
    const V far = hn::Mul(splat(0.999f), reach);
    V other = none, other_at = zero(), other_point = splat(-1);
    for (std::size_t i = 0; i < max_points; ++i) {
      const V distance = hn::Abs(hn::Sub(xs[i], at));
      const M better = hn::And(hn::And(hn::Gt(distance, zero()), hn::Ge(distance, far)), hn::Lt(separations[i], other));
      other = hn::IfThenElse(better, separations[i], other);
      other_at = hn::IfThenElse(better, xs[i], other_at);
      other_point = hn::IfThenElse(better, splat(static_cast<float>(i)), other_point);
    }
    const M two = hn::Ge(other_point, zero());
    const M swapped = hn::And(two, hn::Lt(other_at, at));
    const auto in_order = [&](V(&rows)[2], V a, V b) {
      rows[0] = hn::IfThenElse(swapped, b, a);
      rows[1] = hn::IfThenElse(swapped, a, b);
    };
    in_order(x, at, other_at);
    in_order(separation, deepest, other);
    in_order(point, deepest_point, other_point);
    impulse[0] = impulse[1] = zero();
    for (std::size_t i = 0; i < max_points; ++i) {
      const V pushes = hn::IfThenElseZero(is_there(i), impulses[i]);
      const M to_second = hn::And(two, hn::Lt(hn::Abs(hn::Sub(xs[i], x[1])), hn::Abs(hn::Sub(xs[i], x[0]))));
      impulse[0] = hn::Add(impulse[0], hn::IfThenZeroElse(to_second, pushes));
      impulse[1] = hn::Add(impulse[1], hn::IfThenElseZero(to_second, pushes));
    }
  }
};

// A normal that leans farther out of the plane pushes nothing within it.
constexpr float min_in_plane = 0.1f;

// Contacts all of whose bodies that may move stay in one plane, and those of them that push across it.
struct PlanarLanes {
  M planar, across;
};

// Turns such contacts into their plane: normal and first tangent lie in it, and the second across it. Others stay as
// they are.
HWY_INLINE PlanarLanes turn_into_plane(const SolverBodies& bodies, const ContactBlock& block, std::size_t lane,
                                       PlanarBlock& planar_block, ContactLanes<>& c, ManifoldLanes& m) {
  const V kind_first = load_free_axes(bodies, block.first + lane).w;
  const V kind_second = load_free_axes(bodies, block.second + lane).w;
  const V plane = hn::Max(kind_first, kind_second);
  const V other = hn::Min(kind_first, kind_second);
  const M planar = hn::And(hn::Gt(plane, zero()), hn::Or(hn::Eq(other, zero()), hn::Eq(other, plane)));
  store(hn::IfThenElseZero(planar, splat(1)), planar_block.planar + lane);
  if (hn::AllFalse(D(), planar)) return {planar, planar};

  const auto is_across = [&](float axis) { return hn::IfThenElseZero(hn::Eq(plane, splat(axis)), splat(1)); };
  const V3 axis{is_across(1), is_across(2), is_across(3)};
  const V3 within{hn::IfThenZeroElse(hn::Gt(axis.x, zero()), c.normal.x),
                  hn::IfThenZeroElse(hn::Gt(axis.y, zero()), c.normal.y),
                  hn::IfThenZeroElse(hn::Gt(axis.z, zero()), c.normal.z)};
  const V length = hn::Sqrt(dot(within, within));
  const M across = hn::And(planar, hn::Not(hn::Gt(length, splat(min_in_plane))));
  const V scale = hn::Div(splat(1), hn::IfThenElse(hn::Gt(length, splat(min_in_plane)), length, splat(1)));
  const V3 normal = select(across, {axis.z, axis.x, axis.y}, scale * within);
  const V3 tangent = cross(axis, normal);

  const V none = splat(collision::no_point);
  const V along_first = dot(c.tangent1, tangent);
  const V along_second = dot(c.tangent2, tangent);
  const V old_x[max_points] = {m.x.x, m.x.y, m.x.z, m.x.w};
  const V old_y[max_points] = {m.y.x, m.y.y, m.y.z, m.y.w};
  const V old_separation[max_points] = {m.separation.x, m.separation.y, m.separation.z, m.separation.w};
  const V impulse[max_points] = {m.impulse.x, m.impulse.y, m.impulse.z, m.impulse.w};
  V x[max_points], separation[max_points];
  for (std::size_t i = 0; i < max_points; ++i) {
    x[i] = hn::Add(hn::Mul(old_x[i], along_first), hn::Mul(old_y[i], along_second));
    const M there = hn::AndNot(across, hn::Lt(old_separation[i], none));
    separation[i] = hn::IfThenElse(there, hn::Mul(old_separation[i], scale), none);
  }
  const PlanarPoints points(x, separation, impulse);
  for (std::size_t i = 0; i < 2; ++i) store(points.point[i], planar_block.point[i] + lane);
  const auto put = [&](V4& rows, V first, V second, V rest) {
    rows = {hn::IfThenElse(planar, first, rows.x), hn::IfThenElse(planar, second, rows.y),
            hn::IfThenElse(planar, rest, rows.z), hn::IfThenElse(planar, rest, rows.w)};
  };
  put(m.x, points.x[0], points.x[1], zero());
  put(m.y, zero(), zero(), zero());
  put(m.separation, points.separation[0], points.separation[1], none);
  put(m.impulse, points.impulse[0], points.impulse[1], zero());
  c.normal = select(planar, normal, c.normal);
  c.tangent1 = select(planar, tangent, c.tangent1);
  c.tangent2 = cross(c.normal, c.tangent1);
  return {planar, across};
}

// Removes the locked part from the masses of a block; points without response get none. Returns true if some lane has a
// body locked along an axis, other than in a plane. Other lanes stay as they are, bit for bit.
HWY_INLINE bool lock_contacts(const SolverBodies& bodies, ContactBlock& block, std::size_t lane,
                              const ContactLanes<>& c, M rubs, M planar, V4& separation) {
  const V3 lost = lost_inverse_mass(bodies, block, lane, c);
  const M locked = hn::AndNot(planar, hn::Gt(hn::Add(lost.x, hn::Add(lost.y, lost.z)), zero()));
  if (hn::AllFalse(D(), locked)) return false;

  const auto lost_along = [&](const V3& a, const V3& b) {
    return dot(lost, {hn::Mul(a.x, b.x), hn::Mul(a.y, b.y), hn::Mul(a.z, b.z)});
  };
  const V inverse_mass = hn::Add(c.inverse_mass_first, c.inverse_mass_second);
  const V min = hn::Mul(splat(min_response), inverse_mass);
  const V k00 = load(block.k[0] + lane);
  // A response that rounding left below zero would turn the gap of a point that isn't there into a push without bound.
  const V left = hn::Max(hn::Sub(k00, lost_along(c.normal, c.normal)), hn::Mul(splat(0.5f), min));
  store(hn::IfThenElse(locked, left, k00), block.k[0] + lane);

  V* const separations[max_points] = {&separation.x, &separation.y, &separation.z, &separation.w};
  for (std::size_t i = 0; i < max_points; ++i) {
    const PointResponse response(block, lane, load(block.x[i] + lane), load(block.y[i] + lane));
    const M held = hn::And(locked, hn::Not(hn::Gt(response.own, min)));
    *separations[i] = hn::IfThenElse(held, splat(collision::no_point), *separations[i]);
    store(*separations[i], block.start_separation[i] + lane);
    store(*separations[i], block.separation[i] + lane);
    store(hn::IfThenZeroElse(held, load(block.normal_impulse[i] + lane)), block.normal_impulse[i] + lane);
  }

  Plane tangential = tangential_response(c, inverse_mass);
  tangential.m11 = hn::Sub(tangential.m11, lost_along(c.tangent1, c.tangent1));
  tangential.m12 = hn::Sub(tangential.m12, lost_along(c.tangent1, c.tangent2));
  tangential.m22 = hn::Sub(tangential.m22, lost_along(c.tangent2, c.tangent2));
  const Plane mass = tangential.inverse_above(min);
  const Plane old = Plane::load_from(block.friction_mass, lane);
  const auto pick = [&](V in_locked, V in_others) {
    return hn::IfThenElse(locked, hn::IfThenElseZero(rubs, in_locked), in_others);
  };
  Plane{pick(mass.m11, old.m11), pick(mass.m12, old.m12), pick(mass.m22, old.m22)}.store_to(block.friction_mass, lane);
  return true;
}

// Friction of contacts in a plane is along the first tangent.
HWY_INLINE void keep_in_plane(ContactBlock& block, std::size_t lane, const ContactLanes<>& c, M rubs, M planar) {
  const V inverse_mass = hn::Add(c.inverse_mass_first, c.inverse_mass_second);
  const V response = tangential_response(c, hn::IfThenElse(planar, inverse_mass, splat(1))).m11;
  const Plane old = Plane::load_from(block.friction_mass, lane);
  Plane{hn::IfThenElse(planar, hn::IfThenElseZero(rubs, hn::Div(splat(1), response)), old.m11),
        hn::IfThenZeroElse(planar, old.m12), hn::IfThenZeroElse(planar, old.m22)}
      .store_to(block.friction_mass, lane);
  store(hn::IfThenZeroElse(planar, load(block.friction_impulse[1] + lane)), block.friction_impulse[1] + lane);
}

// Rolling of bodies that may not turn about every axis.
HWY_INLINE void lock_rolling(const SolverBodies& bodies, const ContactBlock& block, std::size_t lane, M rolls_hard,
                             SurfaceBlock& surface) {
  const auto may_not_turn = [&](const std::int32_t* index) {
    const V kind = load_free_axes(bodies, index + lane).w;
    return hn::Or(hn::Gt(kind, zero()), hn::Lt(kind, splat(-1)));
  };
  const M locked = hn::Or(may_not_turn(block.first), may_not_turn(block.second));
  const Plane spins{load(block.k[3] + lane), load(block.k[4] + lane), load(block.k[5] + lane)};
  const Plane mass = spins.inverse_above(hn::Mul(splat(min_response), hn::Add(spins.m11, spins.m22)));
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
