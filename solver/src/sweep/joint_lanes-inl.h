// A block's joints in lanes: their bodies, the point that they share and how it moves. Included once for each
// instruction set.

#if defined(ATOLL_SOLVER_JOINT_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATOLL_SOLVER_JOINT_LANES_INL_H_
#undef ATOLL_SOLVER_JOINT_LANES_INL_H_
#else
#define ATOLL_SOLVER_JOINT_LANES_INL_H_
#endif

#include "sweep/contact_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atl::solver {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace jobs::HWY_NAMESPACE;

// A block's joints from `lane` on, with their bodies.
struct JointLanes {
  BodyLanes first, second;
  V3 inverse_mass_first, inverse_mass_second;    // along the world's axes, of which some may be locked
  V3 start_velocity, start_first, start_second;  // of the second body against the first, and spins, as the step begins
};

HWY_INLINE JointLanes load_joints(const JointKernelData& data, const JointBlock& block, std::size_t lane) {
  const std::int32_t* first = block.first + lane;
  const std::int32_t* second = block.second + lane;
  const VelocityRows* start = data.bodies.start_velocity.data();
  const auto start_row = [=](const std::int32_t* index, const float(VelocityRows::*row)[3]) {
    const V4 rows = load_rows([=](std::size_t k) { return start[index[k]].*row; });
    return V3{rows.x, rows.y, rows.z};
  };
  return {load_bodies(data.bodies, first),
          load_bodies(data.bodies, second),
          load3(block.inverse_mass_first, lane),
          load3(block.inverse_mass_second, lane),
          start_row(second, &VelocityRows::linear) - start_row(first, &VelocityRows::linear),
          start_row(first, &VelocityRows::angular),
          start_row(second, &VelocityRows::angular)};
}

HWY_INLINE void store_joint_bodies(const JointLanes& c, const JointKernelData& data, const JointBlock& block,
                                   std::size_t lane) {
  store_bodies(c.first, data.bodies, static_cast<unsigned>(block.write_first) >> lane);
  store_bodies(c.second, data.bodies, static_cast<unsigned>(block.write_second) >> lane);
}

// An impulse and angular impulses about the centres of mass, on the second body; the opposite on the first.
HWY_INLINE void apply(JointLanes& c, const V3& linear, const V3& angular_first, const V3& angular_second) {
  c.first.v = c.first.v - change_by(c.inverse_mass_first, linear);
  c.first.w = c.first.w - c.first.inverse_inertia * angular_first;
  c.second.v = c.second.v + change_by(c.inverse_mass_second, linear);
  c.second.w = c.second.w + c.second.inverse_inertia * angular_second;
}

// The rate along a row.
HWY_INLINE V row_rate(const V3& linear, const V3& angular_first, const V3& angular_second, const JointLanes& c) {
  return hn::Add(
      dot(linear, c.start_velocity + (c.second.v - c.first.v)),
      hn::Sub(dot(angular_second, c.start_second + c.second.w), dot(angular_first, c.start_first + c.first.w)));
}

// The origins of the two frames.
struct PointLanes {
  V3 arm_first, arm_second;

  HWY_INLINE static PointLanes load_from(const JointBlock& block, std::size_t lane) {
    return {load3(block.arm_first, lane), load3(block.arm_second, lane)};
  }
  // Velocity of the second against the first.
  HWY_INLINE V3 rate(const JointLanes& c) const {
    return (c.start_velocity + (c.second.v - c.first.v)) +
           (cross(c.start_second + c.second.w, arm_second) - cross(c.start_first + c.first.w, arm_first));
  }
  HWY_INLINE void apply_to(JointLanes& c, const V3& impulse) const {
    apply(c, impulse, cross(arm_first, impulse), cross(arm_second, impulse));
  }
};

// -[r]x I^-1 [r]x: what an impulse at r makes of the velocity there by turning the body.
HWY_INLINE SymmetricMatrix turning_response(const SymmetricMatrix& inverse_inertia, const V3& r) {
  // Columns of I^-1 [r]x; those of [r]x are (0, z, -y), (-z, 0, x), (y, -x, 0).
  const V3 a = inverse_inertia * V3{zero(), r.z, hn::Neg(r.y)};
  const V3 b = inverse_inertia * V3{hn::Neg(r.z), zero(), r.x};
  const V3 c = inverse_inertia * V3{r.y, hn::Neg(r.x), zero()};
  const V3 ra = cross(r, a);
  const V3 rb = cross(r, b);
  const V3 rc = cross(r, c);
  return {hn::Neg(ra.x), hn::Neg(rb.y), hn::Neg(rc.z), hn::Neg(rb.x), hn::Neg(rc.x), hn::Neg(rc.y)};
}

// The inverse of a positive definite matrix, by its factors L D L^T: sums of squares on the diagonal, and nothing that
// leaves single precision's range for bodies of any mass.
HWY_INLINE SymmetricMatrix inverse_of(const SymmetricMatrix& k) {
  const auto inverse = [](V pivot) { return hn::Div(splat(1), pivot); };
  const V e0 = inverse(k.xx);
  const V l10 = hn::Mul(k.xy, e0);
  const V l20 = hn::Mul(k.xz, e0);
  const V e1 = inverse(hn::Sub(k.yy, hn::Mul(l10, k.xy)));
  const V rest = hn::Sub(k.yz, hn::Mul(l10, k.xz));
  const V l21 = hn::Mul(rest, e1);
  const V e2 = inverse(hn::Sub(hn::Sub(k.zz, hn::Mul(l20, k.xz)), hn::Mul(l21, rest)));
  // The entries of L^-1 below the diagonal.
  const V m10 = hn::Neg(l10);
  const V m21 = hn::Neg(l21);
  const V m20 = hn::Sub(hn::Mul(l10, l21), l20);
  const V yz = hn::Mul(m21, e2);
  const V xz = hn::Mul(m20, e2);
  const V xy = hn::Mul(m10, e1);
  return {hn::Add(hn::Add(e0, hn::Mul(m10, xy)), hn::Mul(m20, xz)),
          hn::Add(e1, hn::Mul(m21, yz)),
          e2,
          hn::Add(xy, hn::Mul(m20, yz)),
          xz,
          yz};
}

// Joints with a body that is locked along or about an axis.
HWY_INLINE M with_locks(const SolverBodies& bodies, const JointLanes& c) {
  if (bodies.locks.empty()) return hn::Lt(zero(), zero());
  const auto has_locks = [&](const std::int32_t* index) {
    const V4 free = load_free_axes(bodies, index);
    const M moves = hn::Gt(hn::Mul(hn::Mul(free.x, free.y), free.z), zero());
    return hn::Or(hn::Not(moves), hn::Lt(free.w, splat(-1)));
  };
  return hn::Or(has_locks(c.first.index), has_locks(c.second.index));
}

// The smallest response that isn't rounding beside one of such a size.
HWY_INLINE V min_response_of(V size) { return hn::Mul(splat(static_cast<float>(tuning::min_response_share)), size); }

HWY_INLINE SymmetricMatrix select(M mask, const SymmetricMatrix& yes, const SymmetricMatrix& no) {
  const auto pick = [=](V a, V b) { return hn::IfThenElse(mask, a, b); };
  return {pick(yes.xx, no.xx), pick(yes.yy, no.yy), pick(yes.zz, no.zz),
          pick(yes.xy, no.xy), pick(yes.xz, no.xz), pick(yes.yz, no.yz)};
}

HWY_INLINE SymmetricMatrix scaled(V by, const SymmetricMatrix& m) {
  return {hn::Mul(by, m.xx), hn::Mul(by, m.yy), hn::Mul(by, m.zz),
          hn::Mul(by, m.xy), hn::Mul(by, m.xz), hn::Mul(by, m.yz)};
}

HWY_INLINE SymmetricMatrix sum(const SymmetricMatrix& a, const SymmetricMatrix& b) {
  return {hn::Add(a.xx, b.xx), hn::Add(a.yy, b.yy), hn::Add(a.zz, b.zz),
          hn::Add(a.xy, b.xy), hn::Add(a.xz, b.xz), hn::Add(a.yz, b.yz)};
}

HWY_INLINE SymmetricMatrix adjugate(const SymmetricMatrix& m) {
  const auto minor = [](V a, V b, V c, V d) { return hn::Sub(hn::Mul(a, b), hn::Mul(c, d)); };
  return {minor(m.yy, m.zz, m.yz, m.yz), minor(m.xx, m.zz, m.xz, m.xz), minor(m.xx, m.yy, m.xy, m.xy),
          minor(m.xz, m.yz, m.xy, m.zz), minor(m.xy, m.yz, m.xz, m.yy), minor(m.xy, m.xz, m.yz, m.xx)};
}

// The pseudoinverse of a positive semidefinite matrix (Penrose, 1955): what isn't rounding of it is inverted, and what
// asks for anything else is given nothing. An inverse that left a row out would answer a gap along which nothing moves
// by a motion across.
HWY_INLINE SymmetricMatrix inverse_of_what_acts(const SymmetricMatrix& k) {
  const V trace = hn::Add(hn::Add(k.xx, k.yy), k.zz);
  const M any = hn::Gt(trace, zero());
  const V over = hn::IfThenElseZero(any, hn::Div(splat(1), hn::IfThenElse(any, trace, splat(1))));
  const SymmetricMatrix one = scaled(over, k);  // of trace 1
  const SymmetricMatrix adjoint = adjugate(one);
  const V pairs = hn::Add(hn::Add(adjoint.xx, adjoint.yy), adjoint.zz);  // the sum of products of two eigenvalues
  const V all = hn::Add(hn::Add(hn::Mul(one.xx, adjoint.xx), hn::Mul(one.xy, adjoint.xy)), hn::Mul(one.xz, adjoint.xz));
  const M lines = hn::Le(pairs, min_response_of(splat(1)));  // moves along a line, in which one is the projection on it
  const M planes = hn::AndNot(lines, hn::Le(all, min_response_of(pairs)));
  // The adjugate of what moves in a plane is the projection on its normal, times the product of two eigenvalues.
  const V normal = hn::IfThenElseZero(planes, hn::Div(splat(1), hn::IfThenElse(lines, splat(1), pairs)));
  const SymmetricMatrix still = scaled(normal, adjoint);
  const SymmetricMatrix unit{splat(1), splat(1), splat(1), zero(), zero(), zero()};
  const SymmetricMatrix inverse = inverse_of(select(lines, unit, sum(one, still)));
  return scaled(over, select(lines, one, sum(inverse, scaled(splat(-1), still))));
}

// The inverse of K = J M^-1 J^T of the point. Where motion locks leave nothing that moves, it has no part.
HWY_INLINE SymmetricMatrix point_mass(const SolverBodies& bodies, const JointLanes& c, const PointLanes& point) {
  const V3 inverse_mass = c.inverse_mass_first + c.inverse_mass_second;
  const SymmetricMatrix a = turning_response(c.first.inverse_inertia, point.arm_first);
  const SymmetricMatrix b = turning_response(c.second.inverse_inertia, point.arm_second);
  const auto matrix = [&](const V3& diagonal) {
    return SymmetricMatrix{hn::Add(diagonal.x, hn::Add(a.xx, b.xx)),
                           hn::Add(diagonal.y, hn::Add(a.yy, b.yy)),
                           hn::Add(diagonal.z, hn::Add(a.zz, b.zz)),
                           hn::Add(a.xy, b.xy),
                           hn::Add(a.xz, b.xz),
                           hn::Add(a.yz, b.yz)};
  };
  const M none = hn::Eq(hn::Add(hn::Add(inverse_mass.x, inverse_mass.y), inverse_mass.z), zero());
  const M locked = with_locks(bodies, c);
  const SymmetricMatrix mass = inverse_of(matrix(select(none, {splat(1), splat(1), splat(1)}, inverse_mass)));
  if (hn::AllFalse(D(), locked)) return mass;
  return select(locked, inverse_of_what_acts(matrix(inverse_mass)), mass);
}

HWY_INLINE void store_matrix(const SymmetricMatrix& m, float (*rows)[block_lanes], std::size_t lane) {
  const V values[6] = {m.xx, m.yy, m.zz, m.xy, m.xz, m.yz};
  for (std::size_t i = 0; i < 6; ++i) store(values[i], rows[i] + lane);
}
HWY_INLINE SymmetricMatrix load_matrix(const float (*rows)[block_lanes], std::size_t lane) {
  return {load(rows[0] + lane), load(rows[1] + lane), load(rows[2] + lane),
          load(rows[3] + lane), load(rows[4] + lane), load(rows[5] + lane)};
}

// The point of a joint, moved by the bodies' displacements.
struct PointMotion {
  PointLanes point;
  V3 offset;
};
HWY_INLINE PointMotion point_motion(const JointKernelData& data, const JointBlock& block, std::size_t lane,
                                    const JointLanes& c) {
  const V3 start_first = load3(block.start_arm_first, lane);
  const V3 start_second = load3(block.start_arm_second, lane);
  const V3 change_first = turned_change(load_rotation(data.bodies, c.first.index), start_first);
  const V3 change_second = turned_change(load_rotation(data.bodies, c.second.index), start_second);
  const V4 first = load_displacement(data.bodies, c.first.index);
  const V4 second = load_displacement(data.bodies, c.second.index);
  const V3 moved = V3{second.x, second.y, second.z} - V3{first.x, first.y, first.z};
  return {{start_first + change_first, start_second + change_second},
          load3(block.start_offset, lane) + (moved + (change_second - change_first))};
}

// The same for the sweeps, with what K is there.
HWY_INLINE void refresh_point(const JointKernelData& data, JointBlock& block, std::size_t lane, const JointLanes& c) {
  const auto [now, offset] = point_motion(data, block, lane, c);
  store3(offset, block.offset, lane);
  const PointLanes before = PointLanes::load_from(block, lane);
  const V3 impulse = load3(block.impulse, lane);
  V3 carried_first = cross(now.arm_first - before.arm_first, impulse);
  V3 carried_second = cross(now.arm_second - before.arm_second, impulse);
  if (block.rows > 0) {
    carried_first = load3(block.carried_first, lane) + carried_first;
    carried_second = load3(block.carried_second, lane) + carried_second;
  }
  store3(carried_first, block.carried_first, lane);
  store3(carried_second, block.carried_second, lane);
  store3(now.arm_first, block.arm_first, lane);
  store3(now.arm_second, block.arm_second, lane);
  // Blocks with rows have found it already, as these hold the point.
  if (block.rows == 0) store_matrix(point_mass(data.bodies, c, now), block.mass, lane);
}

}  // namespace HWY_NAMESPACE
}  // namespace atl::solver
HWY_AFTER_NAMESPACE();

#endif  // ATOLL_SOLVER_JOINT_LANES_INL_H_
