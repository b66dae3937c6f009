// The change of bodies' kinetic energy by impulses. Included once for each instruction set.

#if defined(ATOLL_SOLVER_JOINT_ENERGY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATOLL_SOLVER_JOINT_ENERGY_INL_H_
#undef ATOLL_SOLVER_JOINT_ENERGY_INL_H_
#else
#define ATOLL_SOLVER_JOINT_ENERGY_INL_H_
#endif

#include "sweep/joint_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atl::solver {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace jobs::HWY_NAMESPACE;

inline void find_work(const SolverBodies& bodies, const VelocityRows* forced, WorkRow* work, std::size_t begin,
                      std::size_t end) {
  for (std::size_t i = begin; i < end; i += lanes) {
    const V4 v = load_rows([&](std::size_t k) { return bodies.velocity[i + k].linear; });
    const V4 w = load_rows([&](std::size_t k) { return bodies.velocity[i + k].angular; });
    const V4 rest = load_rows([&](std::size_t k) { return &bodies.inertia[i + k].zz; });
    const V4 free_v = load_rows([&](std::size_t k) { return bodies.free_velocity[i + k].linear; });
    const V4 free_w = load_rows([&](std::size_t k) { return bodies.free_velocity[i + k].angular; });
    const V4 start = load_rows([&](std::size_t k) { return bodies.start_velocity[i + k].linear; });
    const V4 start_spin = load_rows([&](std::size_t k) { return bodies.start_velocity[i + k].angular; });
    V3 before{free_v.x, free_v.y, free_v.z}, before_spin{free_w.x, free_w.y, free_w.z};
    if (forced != nullptr) {
      const V4 add = load_rows([&](std::size_t k) { return forced[i + k].linear; });
      const V4 add_spin = load_rows([&](std::size_t k) { return forced[i + k].angular; });
      before = before + V3{add.x, add.y, add.z};
      before_spin = before_spin + V3{add_spin.x, add_spin.y, add_spin.z};
    }
    const V mass = hn::Div(splat(1), free_v.w);
    const SymmetricMatrix inverse_inertia{v.w, w.w, rest.x, rest.y, rest.z, rest.w};
    SymmetricMatrix inertia = inverse_of(inverse_inertia);
    if (!bodies.locks.empty()) {
      const M turns = hn::Eq(load_rows([&](std::size_t k) { return bodies.locks[i + k].free; }).w, splat(-1));
      inertia = select(turns, inertia, inverse_of_what_acts(inverse_inertia));
    }
    const V3 gained = V3{v.x, v.y, v.z} - before, gained_spin = V3{w.x, w.y, w.z} - before_spin;
    before = V3{start.x, start.y, start.z} + before;
    before_spin = V3{start_spin.x, start_spin.y, start_spin.z} + before_spin;
    const V3 momentum = mass * gained, angular_momentum = inertia * gained_spin;
    const V half = splat(0.5f);
    const V energy =
        hn::Mul(half, hn::Add(hn::Mul(mass, dot(before, before)), dot(before_spin, inertia * before_spin)));
    const V linear = hn::Add(dot(before, momentum), dot(before_spin, angular_momentum));
    const V square = hn::Mul(half, hn::Add(dot(gained, momentum), dot(gained_spin, angular_momentum)));
    store_rows(
        {energy, linear, square, hn::Mul(half, mass)}, [&](std::size_t k) { return &work[i + k].before; }, ~0u);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace atl::solver
HWY_AFTER_NAMESPACE();

#endif  // ATOLL_SOLVER_JOINT_ENERGY_INL_H_
