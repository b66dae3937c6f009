// The rows of a block's joints as they act while the joints hold: with an impulse along one comes what the point and the
// locked rows need so as not to move. So a sweep over the joint solves all that it locks at once, as a block (they are
// orthogonal by M^-1: Gram and Schmidt), and a motor moves what it would in the joint's own coordinate. One row after
// another would leave a part of each that hardly shrinks where arms are long for what bodies weigh, as those of universal
// joints a metre off bricks of 10 cm; what sweeps leave, stiff joints ring up from. Included once for each instruction set.

#if defined(ATOLL_SOLVER_JOINT_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATOLL_SOLVER_JOINT_ROWS_INL_H_
#undef ATOLL_SOLVER_JOINT_ROWS_INL_H_
#else
#define ATOLL_SOLVER_JOINT_ROWS_INL_H_
#endif

#include <solver/constraints/joint.h>

#include "sweep/joint_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atl::solver {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace jobs::HWY_NAMESPACE;

// A row, the spins that a unit of impulse along it gives, and its response.
struct RowLanes {
  V3 linear, first, second;
  V3 turned_first, turned_second;
  V response;
  V gap;
};

HWY_INLINE void set_response(const JointLanes& c, V inverse_mass, RowLanes& row) {
  row.turned_first = c.first.inverse_inertia * row.first;
  row.turned_second = c.second.inverse_inertia * row.second;
  row.response = hn::Add(hn::Mul(inverse_mass, dot(row.linear, row.linear)),
                         hn::Add(dot(row.first, row.turned_first), dot(row.second, row.turned_second)));
}

HWY_INLINE void keep(M mask, const RowLanes& with, RowLanes& row) {
  row.linear = select(mask, with.linear, row.linear);
  row.first = select(mask, with.first, row.first);
  row.second = select(mask, with.second, row.second);
  row.turned_first = select(mask, with.turned_first, row.turned_first);
  row.turned_second = select(mask, with.turned_second, row.turned_second);
  row.response = hn::IfThenElse(mask, with.response, row.response);
  row.gap = hn::IfThenElse(mask, with.gap, row.gap);
}

// Whether enough of a row is left that rounding doesn't decide how it acts.
HWY_INLINE M enough(V left, V response) {
  return hn::Gt(left, hn::Mul(splat(static_cast<float>(tuning::least_held)), response));
}

// The mass of the point is that of where it was a substep ago: rows are nearly orthogonal to it then.
HWY_INLINE void hold_point(const JointLanes& c, V inverse_mass, const PointLanes& point, const V3& offset,
                           const SymmetricMatrix& mass, M acts, RowLanes& row) {
  const V3 rate = inverse_mass * row.linear +
                  (cross(row.turned_second, point.arm_second) + cross(row.turned_first, point.arm_first));
  const V3 hold = splat(-1) * (mass * rate);
  RowLanes with;
  with.linear = row.linear + hold;
  with.first = row.first + cross(point.arm_first, hold);
  with.second = row.second + cross(point.arm_second, hold);
  with.gap = hn::Add(row.gap, dot(hold, offset));
  set_response(c, inverse_mass, with);
  keep(hn::And(acts, enough(with.response, row.response)), with, row);
}

HWY_INLINE void hold_locked(V inverse_mass, const RowLanes& by, M acts, RowLanes& row) {
  const V part = hn::Div(hn::Add(hn::Mul(inverse_mass, dot(row.linear, by.linear)),
                                 hn::Add(dot(row.first, by.turned_first), dot(row.second, by.turned_second))),
                         by.response);
  RowLanes with;
  with.linear = row.linear - part * by.linear;
  with.first = row.first - part * by.first;
  with.second = row.second - part * by.second;
  with.turned_first = row.turned_first - part * by.turned_first;
  with.turned_second = row.turned_second - part * by.turned_second;
  with.response = hn::Sub(row.response, hn::Mul(hn::Mul(part, part), by.response));
  with.gap = hn::Sub(row.gap, hn::Mul(part, by.gap));
  keep(hn::And(acts, enough(with.response, row.response)), with, row);
}

// The impulses of all rows together, along the rows as they are.
struct ImpulseLanes {
  V3 linear, first, second;
};
HWY_INLINE ImpulseLanes impulse_of(const JointKernelData& data, const JointBlock& block, std::size_t lane) {
  const V3 none{zero(), zero(), zero()};
  ImpulseLanes sum{none, none, none};
  for (std::size_t r = block.first_row; r < block.first_row + block.rows; ++r) {
    const JointRowBlock& row = data.rows[r];
    const V impulse = load(row.impulse + lane);
    sum.linear = sum.linear + impulse * load3(row.linear, lane);
    sum.first = sum.first + impulse * load3(row.angular_first, lane);
    sum.second = sum.second + impulse * load3(row.angular_second, lane);
  }
  return sum;
}

HWY_INLINE void store_row(const SubstepConstants& constants, const RowLanes& row, M acts, M locked, std::size_t lane,
                          JointRowBlock& to) {
  const V3 none{zero(), zero(), zero()};
  const auto kept = [&](V value) { return hn::IfThenElseZero(acts, value); };
  const auto keep_in = [&](float* numbers) { store(kept(load(numbers + lane)), numbers + lane); };
  store3(select(acts, row.linear, none), to.linear, lane);
  store3(select(acts, row.first, none), to.angular_first, lane);
  store3(select(acts, row.second, none), to.angular_second, lane);
  store(kept(hn::Div(splat(1), row.response)), to.mass + lane);
  store(kept(row.response), to.inverse_mass + lane);
  keep_in(to.impulse);
  // What the most of its impulse makes of the rate.
  for (float* change : {to.motor_change, to.soft_motor_change}) {
    store(kept(hn::Min(hn::Mul(load(change + lane), row.response), splat(unlimited_speed))), change + lane);
  }
  const V most = hn::Mul(splat(static_cast<float>(tuning::most_closed)), splat(constants.inverse_h));
  const V closing = clamp_to(hn::Mul(splat(constants.joint.bias_rate), row.gap), most);
  const V shift = hn::Mul(splat(-constants.joint.mass_scale), closing);
  store(hn::IfThenElse(locked, shift, load(to.soft_shift + lane)), to.soft_shift + lane);
}

inline void hold_rows(const JointKernelData& data, FreeRowBlock* of, std::size_t b) {
  JointBlock& block = data.blocks[b];
  for (std::size_t lane = 0; lane < block_lanes; lane += lanes) {
    const JointLanes c = load_joints(data, block, lane);
    const V inverse_mass = hn::Add(c.inverse_mass_first, c.inverse_mass_second);
    const auto is = [lane](const float* flag) { return hn::Gt(load(flag + lane), zero()); };
    // Rows that may bring something along.
    const auto stirs = [&](std::size_t r) { return hn::And(is(of[r].acts), hn::Eq(load(of[r].idle + lane), zero())); };
    RowLanes rows[max_joint_rows];
    for (std::size_t r = 0; r < block.rows; ++r) {
      rows[r].linear = load3(of[r].linear, lane);
      rows[r].first = load3(of[r].angular_first, lane);
      rows[r].second = load3(of[r].angular_second, lane);
      rows[r].gap = load(of[r].gap + lane);
      set_response(c, inverse_mass, rows[r]);
      store(rows[r].response, of[r].response + lane);
    }
    if (block.point != 0) {
      const PointMotion now = point_motion(data, block, lane, c);
      const SymmetricMatrix mass = load_matrix(block.mass, lane);
      for (std::size_t r = 0; r < block.rows; ++r) {
        hold_point(c, inverse_mass, now.point, now.offset, mass, stirs(r), rows[r]);
      }
    }
    for (std::size_t held = 0; held < block.rows; ++held) {
      const M holds = hn::And(hn::And(is(of[held].locked), is(of[held].acts)), hn::Gt(rows[held].response, zero()));
      if (hn::AllFalse(D(), holds)) continue;
      for (std::size_t r = 0; r < block.rows; ++r) {
        if (r == held) continue;
        M acts = hn::And(holds, stirs(r));
        if (r < held) acts = hn::AndNot(is(of[r].locked), acts);
        hold_locked(inverse_mass, rows[held], acts, rows[r]);
      }
    }
    const ImpulseLanes before = impulse_of(data, block, lane);
    for (std::size_t r = 0; r < block.rows; ++r) {
      const V response = rows[r].response;
      const M acts = hn::And(is(of[r].acts), hn::And(hn::Gt(response, zero()), hn::IsFinite(response)));
      store_row(data.constants, rows[r], acts, is(of[r].locked), lane, data.rows[block.first_row + r]);
    }
    const ImpulseLanes now = impulse_of(data, block, lane);
    store3(now.linear - before.linear, block.carried_linear, lane);
    store3(now.first - before.first, block.carried_first, lane);
    store3(now.second - before.second, block.carried_second, lane);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace atl::solver
HWY_AFTER_NAMESPACE();

#endif  // ATOLL_SOLVER_JOINT_ROWS_INL_H_
