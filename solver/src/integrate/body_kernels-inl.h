// Integration of an island group's bodies. Included once for each instruction set.

#if defined(ATOLL_SOLVER_BODY_KERNELS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATOLL_SOLVER_BODY_KERNELS_INL_H_
#undef ATOLL_SOLVER_BODY_KERNELS_INL_H_
#else
#define ATOLL_SOLVER_BODY_KERNELS_INL_H_
#endif

#include <jobs/lanes-inl.h>
#include <solver/integrate/solver_bodies.h>
#include <solver/solver_settings.h>
#include <solver/tuning.h>

HWY_BEFORE_NAMESPACE();
namespace atl::solver {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace jobs::HWY_NAMESPACE;

inline void integrate_velocities(SolverBodies& bodies, const SubstepConstants& constants, bool carry_over,
                                 std::size_t begin, std::size_t end) {
  const V h = splat(constants.h);
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
    const V3 w{w4.x, w4.y, w4.z};
    const V3 constraint_v = v - V3{old_free_v4.x, old_free_v4.y, old_free_v4.z};
    const V3 constraint_w = w - V3{old_free_w4.x, old_free_w4.y, old_free_w4.z};
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

inline void clear_corrections(SolverBodies& bodies, std::size_t begin, std::size_t end) {
  // The fourth number of each row is inertia, which has to stay.
  for (std::size_t i = begin; i < end; ++i) {
    bodies.correction[i] = {{0, 0, 0}, bodies.velocity[i].inertia_xx, {0, 0, 0}, bodies.velocity[i].inertia_yy};
  }
}

// The rotation by w h from q on, but for its length. Sine and cosine of half the angle by their series, which leave
// 6e-4 of the angle where it comes to half a turn, and 1e-7 up to a radian; what turns by more is followed for that.
HWY_INLINE Q advanced(const Q& q, const V3& w, V half_h) {
  constexpr float quarter_turn = 2.4674011f;  // its square, of the half angle
  const V3 u = half_h * w;
  const V x = hn::Min(dot(u, u), splat(quarter_turn));
  const auto series = [&](float a, float b, float c) {
    const V rest = hn::Add(splat(b), hn::Mul(x, splat(c)));
    return hn::Add(splat(1), hn::Mul(x, hn::Add(splat(a), hn::Mul(x, rest))));
  };
  const V3 sine = series(-1.0f / 6, 1.0f / 120, -1.0f / 5040) * u;
  const V cosine = series(-1.0f / 2, 1.0f / 24, -1.0f / 720);
  return {cosine * q.vector + (q.scalar * sine + cross(sine, q.vector)),
          hn::Sub(hn::Mul(cosine, q.scalar), dot(sine, q.vector))};
}

// Torque-free motion of bodies with unequal moments of inertia over a substep: Euler's equations, about the principal
// axes, together with the orientation of these, by the classical Runge-Kutta method (Hairer, Norsett and Wanner,
// "Solving Ordinary Differential Equations I", II.1); then scaled to the kinetic energy that it started with, so that
// no spin of any speed gains any. What turns by more than a radian a substep is followed for a radian. All that it
// tells are changes, which lose nothing that adds up over many small steps.
struct Tumbling {
  Q orientation;  // of the principal axes, world frame
  V3 spin;        // about these

  struct Change {
    Q turn;      // world frame
    V3 of_spin;  // about the principal axes where these have come
  };

  HWY_INLINE Change advance(const V3& ratio, const V3& moment, V h) const {
    const V speed = hn::Sqrt(dot(spin, spin));
    const V step = hn::IfThenElse(hn::Gt(hn::Mul(speed, h), splat(1)), hn::Div(splat(1), hn::Max(speed, splat(1))), h);
    const V half = hn::Mul(splat(0.5f), step);
    const auto rate = [&](const V3& w) {
      return V3{hn::Mul(ratio.x, hn::Mul(w.y, w.z)), hn::Mul(ratio.y, hn::Mul(w.z, w.x)),
                hn::Mul(ratio.z, hn::Mul(w.x, w.y))};
    };
    const V3 k1 = rate(spin);
    const V3 w2 = spin + half * k1;
    const V3 k2 = rate(w2);
    const V3 w3 = spin + half * k2;
    const V3 k3 = rate(w3);
    const V3 w4 = spin + step * k3;
    const V3 k4 = rate(w4);

    const Q& q1 = orientation;
    const auto turning = [](const Q& q, const V3& w) { return q * Q{w, zero()}; };
    const auto after = [&](V by, const Q& turn) {
      return Q{q1.vector + by * turn.vector, hn::Add(q1.scalar, hn::Mul(by, turn.scalar))};
    };
    const V quarter = hn::Mul(splat(0.25f), step);
    const Q t1 = turning(q1, spin);
    const Q t2 = turning(after(quarter, t1), w2);
    const Q t3 = turning(after(quarter, t2), w3);
    const Q t4 = turning(after(half, t3), w4);

    const V sixth = hn::Mul(splat(1.0f / 6), step);
    const V twelfth = hn::Mul(splat(1.0f / 12), step);
    const V3 change = (k1 + k4) + splat(2) * (k2 + k3);
    const V3 vector = (t1.vector + t4.vector) + splat(2) * (t2.vector + t3.vector);
    const V scalar = hn::Add(hn::Add(t1.scalar, t4.scalar), hn::Mul(splat(2), hn::Add(t2.scalar, t3.scalar)));
    const Q turn = Q{twelfth * vector, hn::Mul(twelfth, scalar)} * conjugate(q1);
    // The gain of spin, then 1 less the factor that keeps the energy.
    const V3 gained = sixth * change;
    const V3 now = spin + gained;
    const auto energy = [&](const V3& a, const V3& b) {
      return dot(moment, {hn::Mul(a.x, b.x), hn::Mul(a.y, b.y), hn::Mul(a.z, b.z)});
    };
    const V energy_now = energy(now, now);
    const M moves = hn::Gt(energy_now, zero());
    const V excess = hn::Div(energy(spin + now, gained), hn::IfThenElse(moves, energy_now, splat(1)));
    const V root = hn::Sqrt(hn::Max(hn::Sub(splat(1), excess), zero()));
    const V less = hn::IfThenElseZero(moves, hn::Div(excess, hn::Add(splat(1), root)));
    return {normalized({turn.vector, hn::Add(splat(1), turn.scalar)}), gained - less * now};
  }
};

// Turns bodies with unequal moments of inertia, among those of one vector from `i` on. Returns the rotation since the
// start of the step: of these, and of the others as it is given.
HWY_INLINE Q tumble(SolverBodies& bodies, std::size_t i, const Q& before, const Q& plain, V h) {
  const auto angular_row = [&](std::size_t k) { return bodies.velocity[i + k].angular; };
  const V4 w4 = load_rows(angular_row);
  const V4 start4 = load_rows([&](std::size_t k) { return bodies.start_velocity[i + k].angular; });
  const V4 ratio4 = load_rows([&](std::size_t k) { return bodies.gyroscopic[i + k].ratio; });
  const V3 w = V3{start4.x, start4.y, start4.z} + V3{w4.x, w4.y, w4.z};
  constexpr auto min_square = static_cast<float>(tuning::min_spin * tuning::min_spin);
  const M turns = hn::Gt(dot(w, w), splat(min_square));
  const M active = hn::And(turns, hn::Gt(ratio4.w, zero()));
  if (hn::AllFalse(D(), active)) return plain;

  const V4 principal4 = load_rows([&](std::size_t k) { return bodies.gyroscopic[i + k].principal; });
  const V4 moment4 = load_rows([&](std::size_t k) { return bodies.gyroscopic[i + k].moment; });
  const auto free_angular_row = [&](std::size_t k) { return bodies.free_velocity[i + k].angular; };
  const V4 free4 = load_rows(free_angular_row);

  const Q principal{{principal4.x, principal4.y, principal4.z}, principal4.w};
  const Q start = before * principal;
  const Tumbling body{start, turned(conjugate(start), w)};
  const auto [turn, of_spin] = body.advance({ratio4.x, ratio4.y, ratio4.z}, {moment4.x, moment4.y, moment4.z}, h);

  const V3 in_world = turned(turn * start, of_spin) + turned_change(turn, w);
  const V3 gained = select(active, in_world, {zero(), zero(), zero()});
  const V3 new_w = V3{w4.x, w4.y, w4.z} + gained;
  store_rows({new_w.x, new_w.y, new_w.z, w4.w}, angular_row, ~0u);
  // This turn came from no constraint, so it must not be carried over.
  store_rows({hn::Add(free4.x, gained.x), hn::Add(free4.y, gained.y), hn::Add(free4.z, gained.z), free4.w},
             free_angular_row, ~0u);
  const Q turned_by = normalized(turn * before);
  return {select(active, turned_by.vector, plain.vector), hn::IfThenElse(active, turned_by.scalar, plain.scalar)};
}

inline void integrate_positions(SolverBodies& bodies, const SubstepConstants& constants, std::size_t begin,
                                std::size_t end) {
  const V h = splat(constants.h);
  const V half_h = splat(0.5f * constants.h);
  const bool gyroscopic = !bodies.gyroscopic.empty();
  const bool corrects = !bodies.correction.empty();
  for (std::size_t i = begin; i < end; i += lanes) {
    const auto linear_row = [&](std::size_t k) { return bodies.displacement[i + k].linear; };
    const auto rotation_row = [&](std::size_t k) { return bodies.displacement[i + k].rotation; };
    const V4 start_v = load_rows([&](std::size_t k) { return bodies.start_velocity[i + k].linear; });
    const V4 start_w = load_rows([&](std::size_t k) { return bodies.start_velocity[i + k].angular; });
    const V4 gained_v = load_rows([&](std::size_t k) { return bodies.velocity[i + k].linear; });
    const V4 gained_w = load_rows([&](std::size_t k) { return bodies.velocity[i + k].angular; });
    const V3 v = V3{start_v.x, start_v.y, start_v.z} + V3{gained_v.x, gained_v.y, gained_v.z};
    const V3 w = V3{start_w.x, start_w.y, start_w.z} + V3{gained_w.x, gained_w.y, gained_w.z};
    const V4 p = load_rows(linear_row);
    const V4 q4 = load_rows(rotation_row);

    V3 moved = V3{p.x, p.y, p.z} + h * v;
    Q q{{q4.x, q4.y, q4.z}, q4.w};
    if (corrects) {
      const V4 cv = load_rows([&](std::size_t k) { return bodies.correction[i + k].linear; });
      const V4 cw = load_rows([&](std::size_t k) { return bodies.correction[i + k].angular; });
      moved = moved + h * V3{cv.x, cv.y, cv.z};
      q = normalized(advanced(q, {cw.x, cw.y, cw.z}, half_h));
    }
    Q turn = normalized(advanced(q, w, half_h));
    if (gyroscopic) turn = tumble(bodies, i, q, turn, h);
    store_rows({moved.x, moved.y, moved.z, p.w}, linear_row, ~0u);
    store_rows({turn.vector.x, turn.vector.y, turn.vector.z, turn.scalar}, rotation_row, ~0u);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace atl::solver
HWY_AFTER_NAMESPACE();

#endif  // ATOLL_SOLVER_BODY_KERNELS_INL_H_
