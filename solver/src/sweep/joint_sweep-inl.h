// A sweep of sequential impulses over blocks of joints, and what comes before the first. Included once for each
// instruction set.
//
// Impulses are carried from substep to substep as what they made of velocities, by rows as these were. Bodies turn in
// between, and the impulse at a point that has turned with its body has another torque. A sweep that carries adds the
// difference, so that what is applied is at all times the accumulated impulse along the rows as they are: without it a
// pair of joined bodies that spins would gain or lose angular momentum in every substep.

#if defined(ATOLL_SOLVER_JOINT_SWEEP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATOLL_SOLVER_JOINT_SWEEP_INL_H_
#undef ATOLL_SOLVER_JOINT_SWEEP_INL_H_
#else
#define ATOLL_SOLVER_JOINT_SWEEP_INL_H_
#endif

#include "sweep/contact_sweep-inl.h"
#include "sweep/joint_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atl::solver {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace jobs::HWY_NAMESPACE;

inline void prepare_joints(const JointKernelData& data, std::size_t begin, std::size_t end) {
  const FreeVelocityRows* free_velocity = data.bodies.free_velocity.data();
  for (std::size_t b = begin; b < end; ++b) {
    JointBlock& block = data.blocks[b];
    for (std::size_t lane = 0; lane < block_lanes; lane += lanes) {
      const auto store_inverse_mass = [&](const std::int32_t* index, float(&to)[3][block_lanes]) {
        const V mass = load_rows([=](std::size_t k) { return free_velocity[index[k]].linear; }).w;
        if (data.bodies.locks.empty()) return store3({mass, mass, mass}, to, lane);
        const V4 free = load_free_axes(data.bodies, index);
        store3(mass * V3{free.x, free.y, free.z}, to, lane);
      };
      store_inverse_mass(block.first + lane, block.inverse_mass_first);
      store_inverse_mass(block.second + lane, block.inverse_mass_second);
      if (block.point == 0) continue;
      const PointLanes point{load3(block.start_arm_first, lane), load3(block.start_arm_second, lane)};
      store3(point.arm_first, block.arm_first, lane);
      store3(point.arm_second, block.arm_second, lane);
      store3(load3(block.start_offset, lane), block.offset, lane);
      store_matrix(point_mass(data.bodies, load_joints(data, block, lane), point), block.mass, lane);
    }
  }
}

inline void warm_start_joints(const JointKernelData& data, float applied, float kept, std::size_t begin,
                              std::size_t end) {
  for (std::size_t b = begin; b < end; ++b) {
    JointBlock& block = data.blocks[b];
    for (std::size_t lane = 0; lane < block_lanes; lane += lanes) {
      JointLanes c = load_joints(data, block, lane);
      V3 linear{zero(), zero(), zero()};
      V3 first = linear;
      V3 second = linear;
      // Sums that begin with zero never are -0, so idle rows change no bit.
      for (std::size_t r = 0; r < block.rows; ++r) {
        JointRowBlock& row = data.rows[block.first_row + r];
        const V carried = load(row.impulse + lane);
        const V impulse = hn::Mul(splat(applied), carried);
        store(hn::Mul(splat(kept), carried), row.impulse + lane);
        linear = linear + impulse * load3(row.linear, lane);
        first = first + impulse * load3(row.angular_first, lane);
        second = second + impulse * load3(row.angular_second, lane);
      }
      if (block.point != 0) {
        const PointLanes point = PointLanes::load_from(block, lane);
        const V3 carried = load3(block.impulse, lane);
        const V3 impulse = splat(applied) * carried;
        store3(splat(kept) * carried, block.impulse, lane);
        linear = linear + impulse;
        first = first + cross(point.arm_first, impulse);
        second = second + cross(point.arm_second, impulse);
      }
      apply(c, linear, first, second);
      store_joint_bodies(c, data, block, lane);
    }
  }
}

// The rate that a row's law makes of the rate without its impulse: see JointRowBlock. Monotone in it, so a motor never
// drives beyond its speed, and a limit only stops what would pass it. A split sweep sees what is locked, and limits.
template <Push push>
HWY_INLINE V lawful_rate(const JointRowBlock& row, std::size_t lane, bool moved, V free) {
  V lower = load(row.lower_speed + lane);
  V upper = load(row.upper_speed + lane);
  const M soft_lower = hn::Gt(load(row.soft_lower + lane), zero());
  const M soft_upper = hn::Gt(load(row.soft_upper + lane), zero());
  if constexpr (push == Push::Split) {
    const V shift = load(row.soft_shift + lane);
    lower = hn::IfThenElse(soft_lower, shift, lower);
    upper = hn::IfThenElse(soft_upper, shift, upper);
    return hn::Min(hn::Max(free, lower), upper);
  }
  const V motor_speed = load((moved ? row.motor_speed : row.next_motor_speed) + lane);
  const auto driven = [&](V rate, const float* part, const float* change) {
    return hn::Add(rate, clamp_to(hn::Mul(load(part + lane), hn::Sub(motor_speed, rate)), load(change + lane)));
  };
  // Friction holds the rate at zero, or takes off all it has of what the motor, if it is, makes of the rest.
  const auto rubbed = [&](V rate, const float* part, const float* change, const float* friction) {
    const V max = load(friction + lane);
    const M rubs = hn::Gt(max, zero());
    const V free_of_it = driven(rate, part, change);
    if (hn::AllFalse(D(), rubs)) return free_of_it;
    const V forwards = driven(hn::Sub(rate, max), part, change), backwards = driven(hn::Add(rate, max), part, change);
    return hn::IfThenElse(rubs, hn::Min(hn::Max(forwards, zero()), backwards), free_of_it);
  };
  const V sprung = hn::Add(hn::Mul(load(row.spring_scale + lane), free), load(row.spring_shift + lane));
  const V rate = rubbed(sprung, row.motor_part, row.motor_change, row.friction_change);
  if constexpr (push == Push::Bias) {
    const V soft = rubbed(hn::Add(hn::Mul(load(row.soft_scale + lane), free), load(row.soft_shift + lane)),
                          row.soft_motor_part, row.soft_motor_change, row.soft_friction_change);
    lower = hn::IfThenElse(soft_lower, soft, lower);
    upper = hn::IfThenElse(soft_upper, soft, upper);
  } else if (moved) {
    const M open = hn::Gt(load(row.open_ends + lane), zero());
    lower = hn::IfThenElse(open, rate, lower);
    upper = hn::IfThenElse(open, rate, upper);
  }
  return hn::Min(hn::Max(rate, lower), upper);
}

template <Push push>
HWY_INLINE void solve_row(JointRowBlock& row, float* accumulated, std::size_t lane, const JointSweep& sweep,
                          bool looks_back, JointLanes& c, Residual& residual) {
  const V3 linear = load3(row.linear, lane);
  const V3 angular_first = load3(row.angular_first, lane);
  const V3 angular_second = load3(row.angular_second, lane);
  const V mass = load(row.mass + lane);
  const V old_impulse = load(accumulated + lane);
  const V rate = row_rate(linear, angular_first, angular_second, c);
  const V free = hn::Sub(rate, hn::Mul(load(row.inverse_mass + lane), old_impulse));
  const V lawful = lawful_rate<push>(row, lane, sweep.moved, free);
  const V change = hn::Sub(lawful, rate);
  const V impulse = hn::Mul(mass, change);
  JointLanes solved = c;
  apply(solved, impulse * linear, impulse * angular_first, impulse * angular_second);
  // Lanes without this row keep every bit, even the sign of a zero, so that results don't depend on the other lanes.
  const M active = hn::Gt(mass, zero());
  c.first.v = select(active, solved.first.v, c.first.v);
  c.first.w = select(active, solved.first.w, c.first.w);
  c.second.v = select(active, solved.second.v, c.second.v);
  c.second.w = select(active, solved.second.w, c.second.w);
  store(hn::IfThenElse(active, hn::Add(old_impulse, impulse), old_impulse), accumulated + lane);
  if (push != Push::Split && looks_back) store(lawful, row.rate + lane);
  if (sweep.measures) residual.add(hn::IfThenElse(active, change, zero()));
}

// The speed that closes an offset, but no more than tuning::max_closing in a substep.
HWY_INLINE V3 closing_speed(V bias_rate, const V3& offset, float inverse_h) {
  const V3 closing = bias_rate * offset;
  const V max = splat(static_cast<float>(tuning::max_closing) * inverse_h);
  const V square = dot(closing, closing);
  const M fast = hn::Gt(square, hn::Mul(max, max));
  if (hn::AllFalse(D(), fast)) return closing;
  return select(fast, hn::Div(max, hn::Sqrt(square)) * closing, closing);
}

template <Push push>
HWY_INLINE void solve_point(const SubstepConstants& constants, JointBlock& block, std::size_t lane,
                            const JointSweep& sweep, JointLanes& c, Residual& residual) {
  const PointLanes point = PointLanes::load_from(block, lane);
  const SymmetricMatrix mass = load_matrix(block.mass, lane);
  const V3 rate = point.rate(c);
  V3 impulse;
  if constexpr (push == Push::None) {
    impulse = splat(-1) * (mass * rate);
  } else {
    const V3 closing = closing_speed(load(block.bias_rate + lane), load3(block.offset, lane), constants.inverse_h);
    impulse = hn::Neg(load(block.mass_scale + lane)) * (mass * (rate + closing));
  }
  impulse = splat(sweep.relaxation) * impulse;
  // A split sweep holds the point without an accumulated impulse; only softness and warm start need one.
  if constexpr (push != Push::Split) {
    const V3 old_impulse = load3(block.impulse, lane);
    if constexpr (push == Push::Bias)
      impulse = impulse - hn::Mul(splat(sweep.relaxation), load(block.impulse_scale + lane)) * old_impulse;
    store3(old_impulse + impulse, block.impulse, lane);
  }
  point.apply_to(c, impulse);
  if (!sweep.measures) return;
  const V3 change = point.rate(c) - rate;
  residual.add(hn::Sqrt(dot(change, change)));
}

template <Push push, bool refresh, bool carries>
float sweep_joint_blocks(const JointKernelData& data, const JointSweep& sweep, std::size_t begin, std::size_t end) {
  Residual residual;
  for (std::size_t b = begin; b < end; ++b) {
    JointBlock& block = data.blocks[b];
    for (std::size_t lane = 0; lane < block_lanes; lane += lanes) {
      JointLanes c = load_joints(data, block, lane);
      if constexpr (push == Push::Split) c.start_velocity = c.start_first = c.start_second = {zero(), zero(), zero()};
      if (refresh && block.point != 0) refresh_point(data, block, lane, c);
      if (carries) {
        const V3 first = load3(block.carried_first, lane);
        const V3 second = load3(block.carried_second, lane);
        if (block.rows > 0) {
          apply(c, load3(block.carried_linear, lane), first, second);
        } else {
          c.first.w = c.first.w - c.first.inverse_inertia * first;
          c.second.w = c.second.w + c.second.inverse_inertia * second;
        }
      }
      // The point last: of what is left over it shows most.
      for (std::size_t r = block.first_row; r < block.first_row + block.rows; ++r) {
        float* impulse = push == Push::Split ? data.split_rows[r].impulse : data.rows[r].impulse;
        solve_row<push>(data.rows[r], impulse, lane, sweep, block.looks_back != 0, c, residual);
      }
      if (block.point != 0) solve_point<push>(data.constants, block, lane, sweep, c, residual);
      store_joint_bodies(c, data, block, lane);
    }
  }
  return sweep.measures ? hn::GetLane(hn::MaxOfLanes(D(), residual.max)) : 0;
}

template <Push push>
float sweep_joints_with_push(const JointKernelData& data, const JointSweep& sweep, std::size_t begin, std::size_t end) {
  if (sweep.refresh) {
    return sweep.carries ? sweep_joint_blocks<push, true, true>(data, sweep, begin, end)
                         : sweep_joint_blocks<push, true, false>(data, sweep, begin, end);
  }
  return sweep.carries ? sweep_joint_blocks<push, false, true>(data, sweep, begin, end)
                       : sweep_joint_blocks<push, false, false>(data, sweep, begin, end);
}

inline float sweep_joints(const JointKernelData& data, const JointSweep& sweep, std::size_t begin, std::size_t end) {
  switch (sweep.push) {
    case Push::None:
      return sweep_joints_with_push<Push::None>(data, sweep, begin, end);
    case Push::Bias:
      return sweep_joints_with_push<Push::Bias>(data, sweep, begin, end);
    case Push::Split:
      return sweep_joint_blocks<Push::Split, false, false>(data, sweep, begin, end);
  }
  return 0;
}

}  // namespace HWY_NAMESPACE
}  // namespace atl::solver
HWY_AFTER_NAMESPACE();

#endif  // ATOLL_SOLVER_JOINT_SWEEP_INL_H_
