// The rows of a block's joints as they act while the joints hold: with an impulse along one comes what the point and
// the locked rows need so as not to move. So a sweep over the joint solves all that it locks at once, as a block (they
// are orthogonal by M^-1: Gram and Schmidt), and a motor moves what it would in the joint's own coordinate. One row
// after another would leave a part of each that hardly shrinks where arms are long for what bodies weigh, as those of
// universal joints a metre off bricks of 10 cm; what sweeps leave, stiff joints ring up from. Included once for each
// instruction set.

#if defined(ATOLL_SOLVER_JOINT_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATOLL_SOLVER_JOINT_ROWS_INL_H_
#undef ATOLL_SOLVER_JOINT_ROWS_INL_H_
#else
#define ATOLL_SOLVER_JOINT_ROWS_INL_H_
#endif

#include <bit>

#include "sweep/joint_coordinates-inl.h"

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
  V floor;  // a response up to which is rounding, of bodies with motion locks; else 0
  V gap;
};

HWY_INLINE void set_response(const JointLanes& c, const V3& inverse_mass, RowLanes& row) {
  row.turned_first = c.first.inverse_inertia * row.first;
  row.turned_second = c.second.inverse_inertia * row.second;
  row.response = hn::Add(dot(change_by(inverse_mass, row.linear), row.linear),
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

// True if enough of a row's response is left for it to exceed rounding. Motion locks may leave nothing of it, and the
// row is left out then.
HWY_INLINE M enough(const RowLanes& left, const RowLanes& row) {
  return hn::Or(hn::Gt(left.response, min_response_of(row.response)), hn::Gt(row.floor, zero()));
}

// The response that a row would have if its bodies could turn about all axes as about that which is easiest, and move
// likewise.
HWY_INLINE V response_without_locks(const JointLanes& c, const V3& inverse_mass, const RowLanes& row) {
  const auto trace = [](const SymmetricMatrix& m) { return hn::Add(hn::Add(m.xx, m.yy), m.zz); };
  const V moves = hn::Add(hn::Add(inverse_mass.x, inverse_mass.y), inverse_mass.z);
  return hn::Add(hn::Mul(moves, dot(row.linear, row.linear)),
                 hn::Add(hn::Mul(trace(c.first.inverse_inertia), dot(row.first, row.first)),
                         hn::Mul(trace(c.second.inverse_inertia), dot(row.second, row.second))));
}

HWY_INLINE void hold_point(const JointLanes& c, const V3& inverse_mass, const FrameLanes& frames,
                           const SymmetricMatrix& mass, M acts, RowLanes& row) {
  const PointLanes& point = frames.point;
  const V3 rate = change_by(inverse_mass, row.linear) +
                  (cross(row.turned_second, point.arm_second) + cross(row.turned_first, point.arm_first));
  const V3 hold = splat(-1) * (mass * rate);
  RowLanes with;
  with.linear = row.linear + hold;
  with.first = row.first + cross(point.arm_first, hold);
  with.second = row.second + cross(point.arm_second, hold);
  with.gap = hn::Add(row.gap, dot(hold, frames.offset));
  set_response(c, inverse_mass, with);
  keep(hn::And(acts, enough(with, row)), with, row);
}

HWY_INLINE void hold_locked(const V3& inverse_mass, const RowLanes& by, M acts, RowLanes& row) {
  const V part = hn::Div(hn::Add(dot(change_by(inverse_mass, row.linear), by.linear),
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
  keep(hn::And(acts, enough(with, row)), with, row);
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

HWY_INLINE void turn_to_world(Coordinate coordinate, const FrameLanes& frames, CoordinateLanes& row) {
  if (coordinate <= Coordinate::Distance) return;
  const auto in_world = [&frames](const V3& v) {
    return v.x * frames.axes[0] + (v.y * frames.axes[1] + v.z * frames.axes[2]);
  };
  const bool alike = !is_geared(coordinate);
  row.first = in_world(row.first);
  row.second = alike ? row.first : in_world(row.second);
  if (!alike) row.linear = in_world(row.linear);
}

// A turn's position over full turns, that next to the one before; a rate's, which its travel adds to.
HWY_INLINE V continued(Coordinate coordinate, V value, V before, V travel) {
  constexpr float turn = 6.2831853f;
  if (is_geared(coordinate)) return hn::Add(before, travel);
  if (is_rate(coordinate)) return before;
  if (!counts_turns(coordinate)) return value;
  return hn::Add(value, hn::Mul(splat(turn), hn::Round(hn::Mul(hn::Sub(before, value), splat(1 / turn)))));
}

// The motion of a row by the velocities at which bodies have moved.
HWY_INLINE V travel_of(const JointKernelData& data, const JointRowBlock& row, std::size_t lane, JointLanes moved) {
  if (!data.bodies.correction.empty()) {
    const VelocityRows* correction = data.bodies.correction.data();
    for (BodyLanes* body : {&moved.first, &moved.second}) {
      const std::int32_t* index = body->index;
      const V4 linear = load_rows([=](std::size_t k) { return correction[index[k]].linear; });
      const V4 angular = load_rows([=](std::size_t k) { return correction[index[k]].angular; });
      body->v = body->v + V3{linear.x, linear.y, linear.z};
      body->w = body->w + V3{angular.x, angular.y, angular.z};
    }
  }
  const V rate =
      row_rate(load3(row.linear, lane), load3(row.angular_first, lane), load3(row.angular_second, lane), moved);
  return hn::Mul(splat(data.constants.h), rate);
}

// Finds what a coordinate is now, with the value that the law sees.
HWY_INLINE CoordinateLanes find_coordinate(const FrameLanes& frames, V ratio, V travel, std::size_t lane,
                                           JointCoordinateBlock& of) {
  const V coordinates = load(of.coordinate + lane), before = load(of.position + lane), base = load(of.base + lane);
  const V3 none{zero(), zero(), zero()};
  CoordinateLanes found = {none, none, none, zero(), splat(1)};
  V position = before;
  for (std::uint32_t rest = of.kinds; rest != 0; rest &= rest - 1) {
    const int number = std::countr_zero(rest);
    const auto coordinate = static_cast<Coordinate>(number);
    const M is = hn::Eq(coordinates, splat(static_cast<float>(number)));
    CoordinateLanes one = coordinate_in_lanes(coordinate, frames, ratio);
    const V one_position = continued(coordinate, one.value, before, travel);
    one.value = one_position;
    if (is_hinged(coordinate)) fade_angle(frames, hinges_of(coordinate), base, one);
    if (coordinate == Coordinate::Twist) {
      one.value = hn::Add(one_position, base);
      fade_twist(frames, one);
      one.value = hn::Sub(one.value, base);
    }
    if (is_turn(coordinate)) {
      fade_turn(frames, axis_of(coordinate, Coordinate::TurnX), hn::Gt(load(of.fades + lane), zero()), one);
    }
    turn_to_world(coordinate, frames, one);
    position = hn::IfThenElse(is, one_position, position);
    found.linear = select(is, one.linear, found.linear);
    found.first = select(is, one.first, found.first);
    found.second = select(is, one.second, found.second);
    found.value = hn::IfThenElse(is, one.value, found.value);
    found.share = hn::IfThenElse(is, one.share, found.share);
  }
  store(hn::IfThenElse(hn::IsFinite(position), position, before), of.position + lane);
  store(found.value, of.value + lane);
  store(found.share, of.share + lane);
  return found;
}

HWY_INLINE V as_speed(V value) { return clamp_to(value, splat(unlimited_speed)); }
HWY_INLINE V one_where(M mask) { return hn::IfThenElseZero(mask, splat(1)); }

// The numbers of JointRowBlock for laws without springs. Softness is an implicit spring: 1 / (1 + stiffness) of the
// impulse leaks.
HWY_INLINE void set_law(const SubstepConstants& constants, const JointBlock& block, const JointCoordinateBlock& of,
                        const RowLanes& row, std::size_t lane, JointRowBlock& to) {
  const V leak = load(block.impulse_scale + lane), held = load(block.mass_scale + lane);
  const V bias_rate = load(block.bias_rate + lane), inverse_h = splat(constants.inverse_h);
  const M locked = hn::Gt(load(of.locked + lane), zero());
  const V value = load(of.value + lane);
  const V room_below = hn::Sub(value, load(of.lower + lane));
  const V room_above = hn::Sub(load(of.upper + lane), value);
  const auto set = [lane](V number, float* numbers) { store(number, numbers + lane); };

  // A motor without a bound would overpower the end of a range, so its speed is limited to stop there by itself.
  const V max = load(of.motor_impulse + lane);
  const V speed = hn::Mul(load(of.share + lane), load(of.motor_speed + lane));
  const V within = hn::Min(hn::Max(speed, hn::Neg(hn::Mul(room_below, inverse_h))), hn::Mul(room_above, inverse_h));
  const M unbounded = hn::Ge(max, splat(unlimited_speed));
  set(splat(1), to.spring_scale);
  set(splat(1), to.motor_part);
  set(load(to.next_motor_speed + lane), to.motor_speed);
  set(as_speed(hn::IfThenElse(unbounded, within, speed)), to.next_motor_speed);
  const V change = hn::Mul(max, row.response);
  set(as_speed(change), to.motor_change);
  const V rubs = hn::Mul(load(of.friction_impulse + lane), row.response);
  set(as_speed(rubs), to.friction_change);

  const M below = hn::Lt(room_below, zero());
  const auto free_speed = [&](V room) {
    return hn::IfThenZeroElse(locked, as_speed(hn::Mul(hn::Max(room, zero()), inverse_h)));
  };
  set(hn::Neg(free_speed(room_below)), to.lower_speed);
  set(free_speed(room_above), to.upper_speed);
  set(one_where(hn::Or(locked, below)), to.soft_lower);
  set(one_where(hn::Or(locked, hn::Lt(room_above, zero()))), to.soft_upper);
  const V out = hn::Min(hn::Mul(bias_rate, hn::Neg(hn::Min(room_below, room_above))), splat(constants.push_speed));
  const V closed = hn::Mul(splat(static_cast<float>(tuning::max_closing)), inverse_h);
  const V closing = clamp_to(hn::Mul(bias_rate, row.gap), closed);
  const V target = hn::IfThenElse(locked, hn::Neg(closing), hn::IfThenElse(below, out, hn::Neg(out)));
  set(leak, to.soft_scale);
  set(hn::Mul(held, target), to.soft_shift);
  set(splat(1), to.soft_motor_part);
  set(as_speed(hn::Mul(leak, change)), to.soft_motor_change);
  set(as_speed(hn::Mul(leak, rubs)), to.soft_friction_change);
}

HWY_INLINE void store_row(const RowLanes& row, M acts, std::size_t lane, JointRowBlock& to) {
  const V3 none{zero(), zero(), zero()};
  store3(select(acts, row.linear, none), to.linear, lane);
  store3(select(acts, row.first, none), to.angular_first, lane);
  store3(select(acts, row.second, none), to.angular_second, lane);
  store(hn::IfThenElseZero(acts, hn::Div(splat(1), row.response)), to.mass + lane);
  store(hn::IfThenElseZero(acts, row.response), to.inverse_mass + lane);
  store(hn::IfThenElseZero(acts, load(to.impulse + lane)), to.impulse + lane);
}

HWY_INLINE void hold_rows(const JointBlock& block, const JointLanes& c, const FrameLanes& frames, std::size_t lane,
                          const JointCoordinateBlock* of, const M (&acts)[max_joint_rows],
                          RowLanes (&rows)[max_joint_rows]) {
  const V3 inverse_mass = c.inverse_mass_first + c.inverse_mass_second;
  const auto locked = [=](std::size_t r) { return hn::Gt(load(of[r].locked + lane), zero()); };
  // A free coordinate well within its range has no impulse in this substep, or a little of it.
  const V idle = splat(static_cast<float>(tuning::max_closing));
  M stirs[max_joint_rows];
  for (std::size_t r = 0; r < block.rows; ++r) {
    const V value = load(of[r].value + lane);
    const V room = hn::Min(hn::Sub(value, load(of[r].lower + lane)), hn::Sub(load(of[r].upper + lane), value));
    stirs[r] = hn::And(acts[r], hn::Or(hn::Eq(load(of[r].idles + lane), zero()), hn::Le(room, idle)));
  }
  if (block.point != 0) {
    const SymmetricMatrix mass = load_matrix(block.mass, lane);
    for (std::size_t r = 0; r < block.rows; ++r) hold_point(c, inverse_mass, frames, mass, stirs[r], rows[r]);
  }
  for (std::size_t held = 0; held < block.rows; ++held) {
    const M holds = hn::And(hn::And(locked(held), acts[held]), hn::Gt(rows[held].response, rows[held].floor));
    if (hn::AllFalse(D(), holds)) continue;
    for (std::size_t r = 0; r < block.rows; ++r) {
      if (r == held) continue;
      M brings = hn::And(holds, stirs[r]);
      if (r < held) brings = hn::AndNot(locked(r), brings);
      hold_locked(inverse_mass, rows[held], brings, rows[r]);
    }
  }
}

inline void refresh_rows(const JointKernelData& data, bool moved, std::size_t begin, std::size_t end) {
  constexpr std::uint32_t geared =
      1u << static_cast<unsigned>(Coordinate::Gear) | 1u << static_cast<unsigned>(Coordinate::Rack);
  const V3 none{zero(), zero(), zero()};
  for (std::size_t b = begin; b < end; ++b) {
    JointBlock& block = data.blocks[b];
    if (block.rows == 0) continue;
    JointRowBlock* to = data.rows + block.first_row;
    JointCoordinateBlock* of = data.coordinates + block.first_row;
    for (std::size_t lane = 0; lane < block_lanes; lane += lanes) {
      const JointLanes c = load_joints(data, block, lane);
      const FrameLanes frames = frames_now(data, block, data.frames[b], lane, c);
      if (moved && block.point != 0) store_matrix(point_mass(data.bodies, c, frames.point), block.mass, lane);
      const V3 inverse_mass = c.inverse_mass_first + c.inverse_mass_second;
      const M with = with_locks(data.bodies, c);
      const V ratio = load(data.frames[b].ratio + lane);
      RowLanes rows[max_joint_rows];
      M acts[max_joint_rows];
      for (std::size_t r = 0; r < block.rows; ++r) {
        const V travel = moved && (of[r].kinds & geared) != 0 ? travel_of(data, to[r], lane, c) : zero();
        const CoordinateLanes found = find_coordinate(frames, ratio, travel, lane, of[r]);
        rows[r].linear = found.linear;
        rows[r].first = found.first;
        rows[r].second = found.second;
        set_response(c, inverse_mass, rows[r]);
        store(rows[r].response, of[r].response + lane);
        const M locked = hn::Gt(load(of[r].locked + lane), zero());
        rows[r].gap = hn::IfThenElseZero(locked, hn::Sub(found.value, load(of[r].lower + lane)));
        acts[r] = hn::And(hn::Ge(load(of[r].coordinate + lane), zero()), hn::IsFinite(found.value));
        rows[r].floor = zero();
        if (!hn::AllFalse(D(), with)) {
          constexpr auto least = static_cast<float>(tuning::min_swept_response_share);
          const V without = response_without_locks(c, inverse_mass, rows[r]);
          rows[r].floor = hn::IfThenElseZero(with, hn::Mul(splat(least), without));
        }
      }
      hold_rows(block, c, frames, lane, of, acts, rows);
      const ImpulseLanes before = impulse_of(data, block, lane);
      for (std::size_t r = 0; r < block.rows; ++r) {
        const V response = rows[r].response;
        set_law(data.constants, block, of[r], rows[r], lane, to[r]);
        store_row(rows[r], hn::And(acts[r], hn::And(hn::Gt(response, rows[r].floor), hn::IsFinite(response))), lane,
                  to[r]);
      }
      const ImpulseLanes now = impulse_of(data, block, lane);
      store3(moved ? now.linear - before.linear : none, block.carried_linear, lane);
      store3(moved ? now.first - before.first : none, block.carried_first, lane);
      store3(moved ? now.second - before.second : none, block.carried_second, lane);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace atl::solver
HWY_AFTER_NAMESPACE();

#endif  // ATOLL_SOLVER_JOINT_ROWS_INL_H_
