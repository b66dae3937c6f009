// A sweep of sequential impulses over contact blocks. Included once for each instruction set.

#if defined(ATOLL_SOLVER_CONTACT_SWEEP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATOLL_SOLVER_CONTACT_SWEEP_INL_H_
#undef ATOLL_SOLVER_CONTACT_SWEEP_INL_H_
#else
#define ATOLL_SOLVER_CONTACT_SWEEP_INL_H_
#endif

#include <features/with_restitution.h>
#include <features/with_surfaces.h>

#include "sweep/contact_friction-inl.h"
#include "sweep/contact_normals-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atl::solver {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace jobs::HWY_NAMESPACE;

// The change of the normal in a body's own frame. A rolling ball's lowest point does not rise with its surface.
HWY_INLINE V3 normal_change(const ContactKernelData& data, const std::int32_t* index, const V4& moved,
                            const V3& normal) {
  return moved.w * turned_change(conjugate(load_rotation(data.bodies, index)), normal);
}

// The points' separations, for which those of the start of the step change by `at_centre` and, linear in their x and y,
// along the tangents. A gap that a sweep has closed is none: what single precision leaves of it has either sign, which
// is not to tell whether the contact is soft.
template <std::size_t points>
HWY_INLINE void shift_points(ContactBlock& block, std::size_t lane, V at_centre, V along_x, V along_y) {
  for (std::size_t i = 0; i < points; ++i) {
    const V x = load(block.x[i] + lane);
    const V y = load(block.y[i] + lane);
    const V shift = hn::Add(at_centre, hn::Add(hn::Mul(x, along_x), hn::Mul(y, along_y)));
    const V start = load(block.start_separation[i] + lane);
    const V separation = hn::Add(start, shift);
    const M closed = hn::Le(hn::Abs(separation), hn::Mul(splat(1e-6f), start));
    store(hn::IfThenZeroElse(closed, separation), block.separation[i] + lane);
  }
}

HWY_INLINE const TurningBlock* turning_of(const ContactKernelData& data, std::size_t b) {
  return data.turning_blocks != nullptr ? &data.turning_blocks[b] : nullptr;
}

// The change of the normal as a surface of revolution sees it, which takes no part in its spin: by the shortest turn of
// its axis. Zero without an axis.
HWY_INLINE V3 swing_change(const Q& turn, const V3& axis, const V3& normal) {
  const V3 gained = turned_change(turn, axis);
  const V3 k = cross(axis, gained);
  const V one_and_cosine = hn::Add(splat(2), dot(axis, gained));
  const V3 across = cross(k, normal);
  return hn::Div(splat(1), hn::Max(one_and_cosine, splat(1e-6f))) * cross(k, across) - across;
}

// Refreshes the separations of contacts of which some have rims: see ContactArm.
template <std::size_t points, MovableSides movable>
HWY_INLINE void refresh_rolling_separations(const ContactKernelData& data, ContactBlock& block,
                                            const TurningBlock& turning, const RimBlock& rims, std::size_t lane) {
  const V3 normal = load3(block.normal, lane);
  const V3 tangent = load3(block.tangent, lane);
  struct Side {
    V3 moved, by_point;
    V turned;
  };
  const auto side_of = [&](const std::int32_t* index, const float(*pivots)[block_lanes],
                           const float(*rim_rows)[block_lanes], const float(*axes)[block_lanes]) -> Side {
    const V4 moved = load_displacement(data.bodies, index);
    const Q turn = load_rotation(data.bodies, index);
    const V3 axis = load3(axes, lane);
    const V3 change = moved.w * turned_change(conjugate(turn), normal);
    const V3 swung = swing_change(turn, axis, normal);
    return {{moved.x, moved.y, moved.z},
            select(hn::Gt(dot(axis, axis), zero()), swung, change),
            hn::Add(dot(change, load3(pivots, lane)), dot(swung, load3(rim_rows, lane)))};
  };
  const V3 none{zero(), zero(), zero()};
  Side first{none, none, zero()}, second = first;
  if constexpr (first_moves<movable>) {
    first = side_of(block.first + lane, turning.pivot_first, rims.rim_first, rims.axis_first);
  }
  if constexpr (second_moves<movable>) {
    second = side_of(block.second + lane, turning.pivot_second, rims.rim_second, rims.axis_second);
  }
  // The sums of refresh_separations(), to the bit: lanes without rims may share a block with others or not.
  const V at_centre = hn::Add(dot(normal, second.moved - first.moved), hn::Sub(second.turned, first.turned));
  const V3 by_point = second.by_point - first.by_point;
  shift_points<points>(block, lane, at_centre, dot(by_point, tangent), dot(by_point, cross(normal, tangent)));
}

// separation = start + n . (moved centres) + turned anchors.
template <std::size_t points, MovableSides movable>
HWY_INLINE void refresh_separations(const ContactKernelData& data, ContactBlock& block, const TurningBlock* turning,
                                    std::size_t lane, ContactLanes<movable> c) {
  if (turning != nullptr) {
    c.anchor_first = load3(turning->pivot_first, lane);
    c.anchor_second = load3(turning->pivot_second, lane);
  }
  const V3 rest{zero(), zero(), zero()};
  if constexpr (movable == MovableSides::First) {
    const V4 moved = load_displacement(data.bodies, c.first.index);
    const V3 change = normal_change(data, c.first.index, moved, c.normal);
    const V at_centre =
        hn::Add(dot(c.normal, rest - V3{moved.x, moved.y, moved.z}), hn::Sub(zero(), dot(change, c.anchor_first)));
    const V3 turned = rest - change;
    shift_points<points>(block, lane, at_centre, dot(turned, c.tangent1), dot(turned, c.tangent2));
  } else if constexpr (movable == MovableSides::Second) {
    const V4 moved = load_displacement(data.bodies, c.second.index);
    const V3 change = normal_change(data, c.second.index, moved, c.normal);
    const V at_centre = hn::Add(dot(c.normal, V3{moved.x, moved.y, moved.z}), dot(change, c.anchor_second));
    shift_points<points>(block, lane, at_centre, dot(change, c.tangent1), dot(change, c.tangent2));
  } else {
    const V4 first = load_displacement(data.bodies, c.first.index);
    const V4 second = load_displacement(data.bodies, c.second.index);
    const V3 change_first = normal_change(data, c.first.index, first, c.normal);
    const V3 change_second = normal_change(data, c.second.index, second, c.normal);
    const V3 moved = V3{second.x, second.y, second.z} - V3{first.x, first.y, first.z};
    const V turned = hn::Sub(dot(change_second, c.anchor_second), dot(change_first, c.anchor_first));
    const V3 change = change_second - change_first;
    shift_points<points>(block, lane, hn::Add(dot(c.normal, moved), turned), dot(change, c.tangent1),
                         dot(change, c.tangent2));
  }
}

// Refreshes separations of contacts with rims or without.
template <std::size_t points, MovableSides movable>
HWY_INLINE void refresh_any_separations(const ContactKernelData& data, std::size_t b, std::size_t lane,
                                        const ContactLanes<movable>& c) {
  ContactBlock& block = data.blocks[b];
  if (block.traits.rims) {
    refresh_rolling_separations<points, movable>(data, block, data.turning_blocks[b], data.rim_blocks[b], lane);
  } else {
    refresh_separations<points>(data, block, turning_of(data, b), lane, c);
  }
}

// Adds to refreshed separations the motion of surfaces that bend.
template <std::size_t points>
HWY_INLINE void raise_surfaces(const Sweep& sweep, ContactBlock& block, const SurfaceBlock& surface, std::size_t lane) {
  const V risen = hn::Mul(splat(sweep.rise_time), load(surface.rise[0] + lane));
  for (std::size_t i = 0; i < points; ++i) {
    store(hn::Sub(load(block.separation[i] + lane), risen), block.separation[i] + lane);
  }
}

// Hides bouncy points without contact yet from a refreshed sweep, since the substep in which they arrive has to see how
// fast they close. Once bodies have moved, points without impulse are hidden too. A body that an impact has moved since
// the substep began is pushed by its overlap before that.
inline void hide_bounces(const Sweep& sweep, ContactBlock& block, const BounceBlock& bounce, std::size_t lane) {
  const M bouncy = hn::Gt(load(bounce.restitution + lane), zero());
  for (std::size_t i = 0; i < block.traits.points; ++i) {
    V separation = load(block.separation[i] + lane);
    if (!sweep.relaxes) separation = hn::IfThenElse(bouncy, load(bounce.separation[i] + lane), separation);
    const M yet_to_come =
        sweep.relaxes ? hn::Eq(load(block.normal_impulse[i] + lane), zero()) : hn::Gt(separation, zero());
    separation = hn::IfThenElse(hn::And(bouncy, yet_to_come), splat(collision::no_point), separation);
    store(separation, block.separation[i] + lane);
  }
}

// Sweeps over blocks of one kind.
template <typename how, typename what>
HWY_NOINLINE void sweep_alike(const ContactKernelData& data, const Sweep& sweep, std::size_t begin, std::size_t end,
                              Residual& of_all) {
  Residual residual;
  for (std::size_t b = begin; b < end; ++b) {
    ContactBlock& block = data.blocks[b];
    SurfaceBlock* surface =
        with_surfaces && how::special && data.surface_blocks != nullptr ? &data.surface_blocks[b] : nullptr;
    const bool rises = how::special && surface != nullptr && data.rises != nullptr;
    auto* impulses = how::push == Push::Split ? data.split_blocks[b].impulse : block.normal_impulse;
    for (std::size_t lane = 0; lane < block_lanes; lane += lanes) {
      ContactLanes<what::movable> c = load_contacts<what::movable>(data, block, lane);
      if (how::refresh(sweep)) {
        if constexpr (how::special) {
          refresh_any_separations<what::points>(data, b, lane, c);
        } else {
          refresh_separations<what::points>(data, block, turning_of(data, b), lane, c);
        }
        if (rises) raise_surfaces<what::points>(sweep, block, *surface, lane);
        if (with_restitution && block.traits.bounces) hide_bounces(sweep, block, data.bounces[b], lane);
      }
      const V rise = rises ? hn::Mul(splat(sweep.rise_part), load(surface->rise[0] + lane)) : zero();
      // One round over the points leaves a body that lands flat tilted, and friction with too low a bound.
      for (int round = 0; round < how::rounds(sweep); ++round) {
        solve_normals<how, what>(data, block, impulses, lane, c, residual, sweep.backwards, rise);
      }
      // Last, so that its bound is the normal impulse that it goes with.
      if (how::push != Push::Split && how::rubs(sweep) && block.traits.friction) {
        solve_friction<how, what>(block, surface, sweep.friction, lane, c, residual);
      }
      store_contact_bodies(c, data, block, lane);
    }
  }
  of_all.add(residual.max);
}

template <typename how, std::size_t points>
HWY_INLINE void sweep_points(const ContactKernelData& data, const Sweep& sweep, MovableSides movable, std::size_t begin,
                             std::size_t end, Residual& residual) {
  if (movable == MovableSides::First) {
    sweep_alike<how, What<points, MovableSides::First>>(data, sweep, begin, end, residual);
  } else if (movable == MovableSides::Second) {
    sweep_alike<how, What<points, MovableSides::Second>>(data, sweep, begin, end, residual);
  } else {
    sweep_alike<how, What<points, MovableSides::Both>>(data, sweep, begin, end, residual);
  }
}

// Sweeps with a kernel for each kind of block.
template <typename how>
void sweep_by_kind(const ContactKernelData& data, const Sweep& sweep, std::size_t begin, std::size_t end) {
  const auto movable_of = [&](std::size_t b) { return data.leaves_out ? data.blocks[b].movable : MovableSides::Both; };
  const auto points_of = [&](std::size_t b) {
    const std::uint8_t points = data.blocks[b].traits.points;
    return points == 3 ? std::uint8_t{4} : points;
  };
  Residual residual;
  for (std::size_t next; begin < end; begin = next) {
    const MovableSides movable = movable_of(begin);
    const std::uint8_t points = points_of(begin);
    const auto is_alike = [&](std::size_t b) { return movable_of(b) == movable && points_of(b) == points; };
    for (next = begin + 1; next < end && is_alike(next);) ++next;
    if (points == 1) {
      sweep_points<how, 1>(data, sweep, movable, begin, next, residual);
    } else if (points == 2) {
      sweep_points<how, 2>(data, sweep, movable, begin, next, residual);
    } else {
      sweep_points<how, max_points>(data, sweep, movable, begin, next, residual);
    }
  }
}

// The sweep with every feature, which few scenes need.
template <Push push>
float special_sweep(const ContactKernelData& data, const Sweep& sweep, std::size_t begin, std::size_t end) {
  using how = Special<push>;
  Residual residual;
  if (data.bodies.locks.empty()) {
    sweep_alike<how, What<max_points, MovableSides::Both>>(data, sweep, begin, end, residual);
  } else {
    sweep_alike<how, What<max_points, MovableSides::Locked>>(data, sweep, begin, end, residual);
  }
  return hn::GetLane(hn::MaxOfLanes(D(), residual.max));
}

// A step of soft contacts with relaxation is made of these.
inline bool is_common(const Sweep& sweep) {
  if (sweep.friction == Friction::Pyramid) return false;
  if (sweep.push == Push::None) return sweep.refresh && !sweep.twice;
  return sweep.push == Push::Bias && !sweep.refresh && (sweep.twice || sweep.friction == Friction::None);
}

// Refreshes blocks that have rims, ahead of a sweep that leaves it out: to choose within a sweep costs those without.
HWY_NOINLINE void refresh_rims(const ContactKernelData& data, const Sweep& sweep, std::size_t begin, std::size_t end) {
  for (std::size_t b = begin; b < end; ++b) {
    ContactBlock& block = data.blocks[b];
    for (std::size_t lane = 0; lane < block_lanes; lane += lanes) {
      refresh_rolling_separations<max_points, MovableSides::Both>(data, block, data.turning_blocks[b],
                                                                  data.rim_blocks[b], lane);
      if (with_restitution && block.traits.bounces) hide_bounces(sweep, block, data.bounces[b], lane);
    }
  }
}

inline void common_relaxation(const ContactKernelData& data, const Sweep& sweep, std::size_t begin, std::size_t end) {
  if (data.rim_blocks == nullptr) return sweep_by_kind<Common<Push::None, true, true, 1>>(data, sweep, begin, end);
  const auto has_rims = [&](std::size_t b) { return data.blocks[b].traits.rims; };
  for (std::size_t next; begin < end; begin = next) {
    const bool rims = has_rims(begin);
    for (next = begin + 1; next < end && has_rims(next) == rims;) ++next;
    if (rims) {
      refresh_rims(data, sweep, begin, next);
      sweep_by_kind<Common<Push::None, false, true, 1>>(data, sweep, begin, next);
    } else {
      sweep_by_kind<Common<Push::None, true, true, 1>>(data, sweep, begin, next);
    }
  }
}

// Blocks without friction tell so themselves.
inline void common_sweep(const ContactKernelData& data, const Sweep& sweep, std::size_t begin, std::size_t end) {
  if (sweep.push == Push::None) {
    common_relaxation(data, sweep, begin, end);
  } else if (sweep.twice) {
    sweep_by_kind<Common<Push::Bias, false, true, 2>>(data, sweep, begin, end);
  } else {
    sweep_by_kind<Common<Push::Bias, false, false, 1>>(data, sweep, begin, end);
  }
}

template <Push push>
float sweep_with_push(const ContactKernelData& data, const Sweep& sweep, std::size_t begin, std::size_t end) {
  const bool special = sweep.measures || !is_common(sweep) || data.surface_blocks != nullptr ||
                       data.split_blocks != nullptr || data.constants.slop > 0;
  if (special) return special_sweep<push>(data, sweep, begin, end);
  if (data.bodies.locks.empty()) {
    common_sweep(data, sweep, begin, end);
    return 0;
  }
  const auto is_locked = [&](std::size_t b) { return data.blocks[b].traits.locked; };
  for (std::size_t next; begin < end; begin = next) {
    const bool locked = is_locked(begin);
    for (next = begin + 1; next < end && is_locked(next) == locked;) ++next;
    if (locked) {
      special_sweep<push>(data, sweep, begin, next);
    } else {
      common_sweep(data, sweep, begin, next);
    }
  }
  return 0;
}

inline float sweep(const ContactKernelData& data, const Sweep& sweep, std::size_t begin, std::size_t end) {
  switch (sweep.push) {
    case Push::None:
      return sweep_with_push<Push::None>(data, sweep, begin, end);
    case Push::Bias:
      return sweep_with_push<Push::Bias>(data, sweep, begin, end);
    case Push::Split:
      return special_sweep<Push::Split>(data, sweep, begin, end);
  }
  return 0;
}

}  // namespace HWY_NAMESPACE
}  // namespace atl::solver
HWY_AFTER_NAMESPACE();

#endif  // ATOLL_SOLVER_CONTACT_SWEEP_INL_H_
