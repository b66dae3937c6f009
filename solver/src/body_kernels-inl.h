// Integration of an island group's bodies. Included once for each instruction set.

#if defined(ATOLL_SOLVER_BODY_KERNELS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATOLL_SOLVER_BODY_KERNELS_INL_H_
#undef ATOLL_SOLVER_BODY_KERNELS_INL_H_
#else
#define ATOLL_SOLVER_BODY_KERNELS_INL_H_
#endif

#include <jobs/lanes-inl.h>
#include <solver/solver_bodies.h>
#include <solver/solver_settings.h>

HWY_BEFORE_NAMESPACE();
namespace atl::solver {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace jobs::HWY_NAMESPACE;

// One Newton step on I (w' - w) + h w' x I w' = 0 from w' = w: implicit, so no spin of any speed gains energy
// (Catto, "Numerical Methods", GDC 2015).
HWY_INLINE V3 add_gyroscopic_torque(const SymmetricMatrix& inertia, const V3& w, V h) {
  const V3 momentum = inertia * w;
  const V3 residual = h * cross(w, momentum);
  // Jacobian I + h ([w]x I - [I w]x), by columns.
  const V3 ix{inertia.xx, inertia.xy, inertia.xz};
  const V3 iy{inertia.xy, inertia.yy, inertia.yz};
  const V3 iz{inertia.xz, inertia.yz, inertia.zz};
  const V3 mx{zero(), momentum.z, hn::Neg(momentum.y)};
  const V3 my{hn::Neg(momentum.z), zero(), momentum.x};
  const V3 mz{momentum.y, hn::Neg(momentum.x), zero()};
  const V3 a = ix + h * (cross(w, ix) - mx);
  const V3 b = iy + h * (cross(w, iy) - my);
  const V3 c = iz + h * (cross(w, iz) - mz);
  // Cramer's rule.
  const V3 bc = cross(b, c);
  const V determinant = dot(a, bc);
  const V3 solution{dot(residual, bc), dot(a, cross(residual, c)), dot(a, cross(b, residual))};
  return w - V3{hn::Div(solution.x, determinant), hn::Div(solution.y, determinant), hn::Div(solution.z, determinant)};
}

inline void integrate_velocities(SolverBodies& bodies, const SubstepConstants& constants, bool carry_over,
                                 std::size_t begin, std::size_t end) {
  const V h = splat(constants.h);
  const bool gyroscopic = !bodies.gyroscopic.empty();
  for (std::size_t i = begin; i < end; i += lanes) {
    const auto linear_row = [&](std::size_t k) { return bodies.velocity[i + k].linear; };
    const auto angular_row = [&](std::size_t k) { return bodies.velocity[i + k].angular; };
    const auto free_linear_row = [&](std::size_t k) { return bodies.free_velocity[i + k].linear; };
    const auto free_angular_row = [&](std::size_t k) { return bodies.free_velocity[i + k].angular; };
    const V4 v4 = load_rows(linear_row);
    const V4 w4 = load_rows(angular_row);
    const V4 a4 = load_rows([&](std::size_t k) { return bodies.acceleration[i + k].linear; });
    const V4 b4 = load_rows([&](std::size_t k) { return bodies.acceleration[i + k].angular; });
    const V4 old_free_v4 = load_rows(free_linear_row);
    const V4 old_free_w4 = load_rows(free_angular_row);

    const V3 v{v4.x, v4.y, v4.z};
    V3 w{w4.x, w4.y, w4.z};
    const V3 constraint_v = v - V3{old_free_v4.x, old_free_v4.y, old_free_v4.z};
    const V3 constraint_w = w - V3{old_free_w4.x, old_free_w4.y, old_free_w4.z};
    if (gyroscopic) {
      const V4 diagonal = load_rows([&](std::size_t k) { return &bodies.gyroscopic[i + k].xx; });
      const V4 rest = load_rows([&](std::size_t k) { return &bodies.gyroscopic[i + k].xy; });
      const SymmetricMatrix inertia{diagonal.x, diagonal.y, diagonal.z, rest.x, rest.y, rest.z};
      const M active = hn::Gt(rest.w, zero());
      const V3 turned = add_gyroscopic_torque(inertia, w, h);
      w = {hn::IfThenElse(active, turned.x, w.x), hn::IfThenElse(active, turned.y, w.y),
           hn::IfThenElse(active, turned.z, w.z)};
    }
    const V3 free_v = a4.w * (v + h * V3{a4.x, a4.y, a4.z});
    const V3 free_w = b4.w * (w + h * V3{b4.x, b4.y, b4.z});
    const V3 new_v = carry_over ? free_v + constraint_v : free_v;
    const V3 new_w = carry_over ? free_w + constraint_w : free_w;
    store_rows({free_v.x, free_v.y, free_v.z, old_free_v4.w}, free_linear_row, ~0u);
    store_rows({free_w.x, free_w.y, free_w.z, old_free_w4.w}, free_angular_row, ~0u);
    store_rows({new_v.x, new_v.y, new_v.z, v4.w}, linear_row, ~0u);
    store_rows({new_w.x, new_w.y, new_w.z, w4.w}, angular_row, ~0u);
  }
}

inline void integrate_positions(SolverBodies& bodies, const SubstepConstants& constants, std::size_t begin,
                                std::size_t end) {
  const V h = splat(constants.h);
  const V half_h = splat(0.5f * constants.h);
  for (std::size_t i = begin; i < end; i += lanes) {
    const auto linear_row = [&](std::size_t k) { return bodies.displacement[i + k].linear; };
    const auto rotation_row = [&](std::size_t k) { return bodies.displacement[i + k].rotation; };
    const V4 v = load_rows([&](std::size_t k) { return bodies.velocity[i + k].linear; });
    const V4 w4 = load_rows([&](std::size_t k) { return bodies.velocity[i + k].angular; });
    const V4 p = load_rows(linear_row);
    const V4 q = load_rows(rotation_row);

    const V3 moved = V3{p.x, p.y, p.z} + h * V3{v.x, v.y, v.z};
    // q' = q + h/2 (w, 0) q, normalised.
    const V3 w = half_h * V3{w4.x, w4.y, w4.z};
    const V3 u{q.x, q.y, q.z};
    const V3 vector = u + (q.w * w + cross(w, u));
    const V scalar = hn::Sub(q.w, dot(w, u));
    const V norm = hn::Sqrt(hn::Add(dot(vector, vector), hn::Mul(scalar, scalar)));
    const V scale = hn::Div(splat(1), norm);
    const V3 unit = scale * vector;
    store_rows({moved.x, moved.y, moved.z, p.w}, linear_row, ~0u);
    store_rows({unit.x, unit.y, unit.z, hn::Mul(scale, scalar)}, rotation_row, ~0u);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace atl::solver
HWY_AFTER_NAMESPACE();

#endif  // ATOLL_SOLVER_BODY_KERNELS_INL_H_
