// Finds the points that may bounce in a substep. Their impulses are found in double (impacts.h). Included once for each
// instruction set.

#if defined(ATOLL_SOLVER_CONTACT_BOUNCES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATOLL_SOLVER_CONTACT_BOUNCES_INL_H_
#undef ATOLL_SOLVER_CONTACT_BOUNCES_INL_H_
#else
#define ATOLL_SOLVER_CONTACT_BOUNCES_INL_H_
#endif

#include <solver/tuning.h>

#include "sweep/contact_prepare-inl.h"
#include "sweep/contact_sweep-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atl::solver {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace jobs::HWY_NAMESPACE;

// m/s^2, with which forces may bring the bodies together along the normal: either could be held up by something else.
HWY_INLINE V max_pull(const SolverBodies& bodies, const ContactBlock& block, std::size_t lane, const V3& normal) {
  const auto along_normal = [&](const std::int32_t* index) {
    const V4 a = load_rows([&](std::size_t k) { return bodies.acceleration[index[k]].linear; });
    return hn::Abs(dot({a.x, a.y, a.z}, normal));
  };
  return hn::Add(along_normal(block.first + lane), along_normal(block.second + lane));
}

// m, by which bodies are too far apart along the normal: half a substep times what forces and contacts have changed
// their velocities by. Steps take that back as they end (group_results.h).
HWY_INLINE V parted_by(const SolverBodies& bodies, const ContactBlock& block, std::size_t lane, const V3& normal, V h) {
  const auto gained = [&](const std::int32_t* index) {
    const V4 v = load_rows([&](std::size_t k) { return bodies.velocity[index[k]].linear; });
    const V4 blow = load_rows([&](std::size_t k) { return bodies.blow[index[k]].linear; });
    return dot(V3{v.x, v.y, v.z} - V3{blow.x, blow.y, blow.z}, normal);
  };
  const V apart = hn::Sub(gained(block.second + lane), gained(block.first + lane));
  return hn::Mul(hn::Mul(splat(0.5f), h), apart);
}

template <MovableSides movable>
void find_approaches_by(const ContactKernelData& data, std::size_t begin, std::size_t end) {
  const V h = splat(data.constants.h);
  const V slowest = splat(-data.constants.restitution_threshold);
  for (std::size_t b = begin; b < end; ++b) {
    ContactBlock& block = data.blocks[b];
    if (!block.traits.bounces) continue;
    BounceBlock& bounce = data.bounces[b];
    unsigned closes = 0;
    for (std::size_t lane = 0; lane < block_lanes; lane += lanes) {
      // Others keep what their last sweep saw. Points that are yet to arrive, and don't bounce, are left to the substep
      // in which they touch.
      V seen[max_points];
      for (std::size_t i = 0; i < max_points; ++i) seen[i] = load(block.separation[i] + lane);
      const ContactLanes<movable> c = load_contacts<movable>(data, block, lane);
      refresh_any_separations<max_points>(data, b, lane, c);
      const NormalSolve solve(c, block, lane);
      const V fall = hn::Mul(h, max_pull(data.bodies, block, lane, c.normal));
      V ahead = parted_by(data.bodies, block, lane, c.normal, h);
      if (data.joined != nullptr) ahead = hn::IfThenElseZero(are_free(data.joined, block, lane), ahead);
      const M bouncy = hn::Gt(load(bounce.restitution + lane), zero());
      M any = hn::Lt(zero(), zero());
      for (std::size_t i = 0; i < max_points; ++i) {
        const V speed = solve.speed(load(block.x[i] + lane), load(block.y[i] + lane));
        const V separation = hn::Sub(load(block.separation[i] + lane), ahead);
        const V fastest = hn::Sub(speed, fall);
        const V then = hn::Add(separation, hn::Mul(h, fastest));
        any = hn::Or(any, hn::And(hn::Lt(fastest, slowest), hn::Lt(then, zero())));
        store(separation, bounce.separation[i] + lane);
        const V hidden = hn::IfThenElse(hn::Gt(separation, zero()), splat(collision::no_point), separation);
        store(hn::IfThenElse(bouncy, hidden, seen[i]), block.separation[i] + lane);
      }
      any = hn::And(any, bouncy);
      std::uint8_t bits[8] = {};
      hn::StoreMaskBits(D(), any, bits);
      closes |= static_cast<unsigned>(bits[0]) << lane;
    }
    bounce.closes = static_cast<std::uint8_t>(closes);
  }
}

inline void find_approaches(const ContactKernelData& data, std::size_t begin, std::size_t end) {
  if (data.bodies.locks.empty()) return find_approaches_by<MovableSides::Both>(data, begin, end);
  find_approaches_by<MovableSides::Locked>(data, begin, end);
}

}  // namespace HWY_NAMESPACE
}  // namespace atl::solver
HWY_AFTER_NAMESPACE();

#endif  // ATOLL_SOLVER_CONTACT_BOUNCES_INL_H_
