// A block's contacts in lanes: their bodies, and the relative speeds that impulses change. Included once for each
// instruction set. Symbols are those of ContactBlock: u, w1, w2 the relative speeds of a manifold, K how impulses
// change them.

#if defined(ATOLL_SOLVER_CONTACT_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATOLL_SOLVER_CONTACT_LANES_INL_H_
#undef ATOLL_SOLVER_CONTACT_LANES_INL_H_
#else
#define ATOLL_SOLVER_CONTACT_LANES_INL_H_
#endif

#include <jobs/lanes-inl.h>
#include <solver/sweep/kernels.h>
#include <solver/tuning.h>

#include <type_traits>

HWY_BEFORE_NAMESPACE();
namespace atl::solver {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace jobs::HWY_NAMESPACE;

// The bodies of one side of a block's contacts.
struct BodyLanes {
  const std::int32_t* index;
  V3 v, w;
  SymmetricMatrix inverse_inertia;
};

// Piece by piece: GCC would copy them as a whole, in other pieces than they were stored in, and wait for that.
HWY_INLINE void load_bodies(const SolverBodies& bodies, const VelocityRows* velocity, const std::int32_t* index,
                            BodyLanes& body) {
  const InertiaRow* inertia = bodies.inertia.data();
  const V4 v = load_rows([=](std::size_t k) { return velocity[index[k]].linear; });
  const V4 w = load_rows([=](std::size_t k) { return velocity[index[k]].angular; });
  const V4 i = load_rows([=](std::size_t k) { return &inertia[index[k]].zz; });
  body.index = index;
  body.v.x = v.x;
  body.v.y = v.y;
  body.v.z = v.z;
  body.w.x = w.x;
  body.w.y = w.y;
  body.w.z = w.z;
  body.inverse_inertia.xx = v.w;
  body.inverse_inertia.yy = w.w;
  body.inverse_inertia.zz = i.x;
  body.inverse_inertia.xy = i.y;
  body.inverse_inertia.xz = i.z;
  body.inverse_inertia.yz = i.w;
}
HWY_INLINE BodyLanes load_bodies(const SolverBodies& bodies, const std::int32_t* index) {
  BodyLanes body;
  load_bodies(bodies, bodies.velocity.data(), index, body);
  return body;
}

// The displacements of bodies since the start of the step, and in w the share by which contact points turn with them.
HWY_INLINE V4 load_displacement(const SolverBodies& bodies, const std::int32_t* index) {
  const DisplacementRows* displacement = bodies.displacement.data();
  return load_rows([=](std::size_t k) { return displacement[index[k]].linear; });
}

// The turns of bodies since the start of the step.
HWY_INLINE Q load_rotation(const SolverBodies& bodies, const std::int32_t* index) {
  const DisplacementRows* displacement = bodies.displacement.data();
  const V4 q = load_rows([=](std::size_t k) { return displacement[index[k]].rotation; });
  return {{q.x, q.y, q.z}, q.w};
}

HWY_INLINE void store_bodies(const BodyLanes& body, SolverBodies& bodies, unsigned mask) {
  VelocityRows* velocity = bodies.velocity.data();
  const std::int32_t* index = body.index;
  store_rows(
      {body.v.x, body.v.y, body.v.z, body.inverse_inertia.xx}, [=](std::size_t k) { return velocity[index[k]].linear; },
      mask);
  store_rows(
      {body.w.x, body.w.y, body.w.z, body.inverse_inertia.yy},
      [=](std::size_t k) { return velocity[index[k]].angular; }, mask);
}

// The rows of ContactManifold, transposed; see there.
struct ManifoldLanes {
  V4 normal, anchor_first, anchor_second, x, y, separation, impulse, friction;
};

template <MovableSides movable>
constexpr bool both_move = movable == MovableSides::Both || movable == MovableSides::Locked;
template <MovableSides movable>
constexpr bool first_moves = movable != MovableSides::Second;
template <MovableSides movable>
constexpr bool second_moves = movable != MovableSides::First;

// A block's contacts from `lane` on, with their bodies. Fixed bodies are not loaded.
template <MovableSides movable = MovableSides::Both>
struct ContactLanes {
  BodyLanes first, second;
  V3 normal, tangent1, tangent2;
  V3 anchor_first, anchor_second;
  // One number, or one for each axis of the world if locks make them differ.
  std::conditional_t<movable == MovableSides::Locked, V3, V> inverse_mass_first, inverse_mass_second;
};

// 1 along axes that bodies may move along, and 0 along those that they are locked along; in w the kind of LockRow.
HWY_INLINE V4 load_free_axes(const SolverBodies& bodies, const std::int32_t* index) {
  const LockRow* locks = bodies.locks.data();
  return load_rows([=](std::size_t k) { return locks[index[k]].free; });
}

template <MovableSides movable = MovableSides::Both>
HWY_INLINE ContactLanes<movable> load_contacts(const ContactKernelData& data, const ContactBlock& block,
                                               std::size_t lane) {
  const auto inverse_mass = [&](std::size_t side, [[maybe_unused]] const std::int32_t* index) {
    const V of_all = load(block.inverse_mass[side] + lane);
    if constexpr (movable == MovableSides::Locked) {
      const V4 free = load_free_axes(data.bodies, index + lane);
      return of_all * V3{free.x, free.y, free.z};
    } else {
      return of_all;
    }
  };
  ContactLanes<movable> c;
  if constexpr (first_moves<movable>)
    load_bodies(data.bodies, data.bodies.velocity.data(), block.first + lane, c.first);
  if constexpr (second_moves<movable>)
    load_bodies(data.bodies, data.bodies.velocity.data(), block.second + lane, c.second);
  c.normal = load3(block.normal, lane);
  c.tangent1 = load3(block.tangent, lane);
  c.tangent2 = cross(c.normal, c.tangent1);
  if constexpr (first_moves<movable>) {
    c.anchor_first = load3(block.anchor_first, lane);
    c.inverse_mass_first = inverse_mass(0, block.first);
  }
  if constexpr (second_moves<movable>) {
    c.anchor_second = load3(block.anchor_second, lane);
    c.inverse_mass_second = inverse_mass(1, block.second);
  }
  return c;
}

template <MovableSides movable>
HWY_INLINE void store_contact_bodies(const ContactLanes<movable>& c, const ContactKernelData& data,
                                     const ContactBlock& block, std::size_t lane) {
  if constexpr (first_moves<movable>)
    store_bodies(c.first, data.bodies, static_cast<unsigned>(block.write_first) >> lane);
  if constexpr (second_moves<movable>)
    store_bodies(c.second, data.bodies, static_cast<unsigned>(block.write_second) >> lane);
}

// Velocity of the second body against the first at the centre, and relative spin, since the step began. Fixed bodies
// are at rest; zero minus something is not the same as its negative, where that is zero.
template <MovableSides movable>
HWY_INLINE V3 gained_velocity(const ContactLanes<movable>& c) {
  const V3 rest{zero(), zero(), zero()};
  if constexpr (movable == MovableSides::First) return rest - (c.first.v + cross(c.first.w, c.anchor_first));
  if constexpr (movable == MovableSides::Second) return c.second.v + cross(c.second.w, c.anchor_second);
  return (c.second.v + cross(c.second.w, c.anchor_second)) - (c.first.v + cross(c.first.w, c.anchor_first));
}
template <MovableSides movable>
HWY_INLINE V3 gained_spin(const ContactLanes<movable>& c) {
  const V3 rest{zero(), zero(), zero()};
  if constexpr (movable == MovableSides::First) return rest - c.first.w;
  if constexpr (movable == MovableSides::Second) return c.second.w;
  return c.second.w - c.first.w;
}

// The change of velocity by an impulse.
HWY_INLINE V3 change_by(V inverse_mass, const V3& impulse) { return inverse_mass * impulse; }
HWY_INLINE V3 change_by(const V3& inverse_mass, const V3& impulse) {
  return {hn::Mul(inverse_mass.x, impulse.x), hn::Mul(inverse_mass.y, impulse.y), hn::Mul(inverse_mass.z, impulse.z)};
}

// An impulse at the centre and an angular impulse, on the second body; the opposite on the first.
template <MovableSides movable>
HWY_INLINE void apply(ContactLanes<movable>& c, const V3& impulse, const V3& angular) {
  if constexpr (first_moves<movable>) {
    c.first.v = c.first.v - change_by(c.inverse_mass_first, impulse);
    c.first.w = c.first.w - c.first.inverse_inertia * (cross(c.anchor_first, impulse) + angular);
  }
  if constexpr (second_moves<movable>) {
    c.second.v = c.second.v + change_by(c.inverse_mass_second, impulse);
    c.second.w = c.second.w + c.second.inverse_inertia * (cross(c.anchor_second, impulse) + angular);
  }
}

// A symmetric 2 x 2 matrix, as blocks hold them.
struct Plane {
  V m11, m12, m22;

  template <std::size_t n>
  HWY_INLINE static Plane load_from(const float (&rows)[n][block_lanes], std::size_t lane) {
    static_assert(n == 3);
    return {load(rows[0] + lane), load(rows[1] + lane), load(rows[2] + lane)};
  }
  HWY_INLINE void store_to(float (*rows)[block_lanes], std::size_t lane) const {
    store(m11, rows[0] + lane);
    store(m12, rows[1] + lane);
    store(m22, rows[2] + lane);
  }
  HWY_INLINE V first(V a, V b) const { return hn::Add(hn::Mul(m11, a), hn::Mul(m12, b)); }
  HWY_INLINE V second(V a, V b) const { return hn::Add(hn::Mul(m12, a), hn::Mul(m22, b)); }
  HWY_INLINE V determinant() const { return hn::Sub(hn::Mul(m11, m22), hn::Mul(m12, m12)); }
  HWY_INLINE Plane inverse() const {
    const V over = hn::Div(splat(1), determinant());
    return {hn::Mul(m22, over), hn::Neg(hn::Mul(m12, over)), hn::Mul(m11, over)};
  }
  // The inverse in the directions in which it is more than `min`, and zero in the others.
  HWY_INLINE Plane inverse_above(V min) const {
    const V half = splat(0.5f);
    const V mean = hn::Mul(half, hn::Add(m11, m22));
    const V apart = hn::Mul(half, hn::Sub(m11, m22));
    const V spread = hn::Sqrt(hn::Add(hn::Mul(apart, apart), hn::Mul(m12, m12)));
    const V high = hn::Add(mean, spread);
    const V low = hn::Sub(mean, spread);
    const M both = hn::Gt(low, min);
    const M one = hn::AndNot(both, hn::Gt(high, min));
    const V one_v = splat(1);
    const V over_determinant = hn::Div(one_v, hn::IfThenElse(both, determinant(), one_v));
    const V of_one = hn::Mul(hn::Add(spread, spread), high);  // high > low here
    const V over_one = hn::Div(one_v, hn::IfThenElse(one, of_one, one_v));
    const auto pick = [&](V in_both, V in_one) {
      return hn::IfThenElse(both, hn::Mul(in_both, over_determinant),
                            hn::IfThenElseZero(one, hn::Mul(in_one, over_one)));
    };
    return {pick(m22, hn::Sub(m11, low)), pick(hn::Neg(m12), m12), pick(m11, hn::Sub(m22, low))};
  }
};

// Two impulses, scaled down to the disc of a radius where they leave it. A disc of no radius lets nothing through, not
// even what is no number.
HWY_INLINE void clamp_to_disc(V& a, V& b, V radius) {
  const M presses = hn::Gt(radius, zero());
  const V length = hn::Sqrt(hn::Add(hn::Mul(a, a), hn::Mul(b, b)));
  const M outside = hn::Gt(length, radius);
  const V scale = hn::IfThenElse(outside, hn::Div(radius, hn::IfThenElse(outside, length, splat(1))), splat(1));
  a = hn::IfThenElseZero(presses, hn::Mul(scale, a));
  b = hn::IfThenElseZero(presses, hn::Mul(scale, b));
}

// hold_in_disc() in lanes that slip, with the s that it would have if m were its mean in all directions.
HWY_NOINLINE void act_against_slip(const Plane& m, const M& slips, V radius, V& p1, V& p2) {
  const auto length_of = [](V a, V b) { return hn::Sqrt(hn::Add(hn::Mul(a, a), hn::Mul(b, b))); };
  const V one = splat(1);
  const V disc = hn::IfThenElse(slips, radius, one);
  const V trace = hn::Add(m.m11, m.m22);
  const V excess_of_all = hn::Div(hn::Sub(length_of(p1, p2), disc), hn::Mul(disc, trace));
  const V s = hn::IfThenElseZero(hn::And(slips, hn::Gt(trace, zero())), hn::Add(excess_of_all, excess_of_all));
  const V d11 = hn::Add(one, hn::Mul(s, m.m11));
  const V d22 = hn::Add(one, hn::Mul(s, m.m22));
  const V d12 = hn::Mul(s, m.m12);
  const V over = hn::Div(one, hn::Sub(hn::Mul(d11, d22), hn::Mul(d12, d12)));
  const V f1 = hn::Mul(over, hn::Sub(hn::Mul(d22, p1), hn::Mul(d12, p2)));
  const V f2 = hn::Mul(over, hn::Sub(hn::Mul(d11, p2), hn::Mul(d12, p1)));
  const V found = length_of(f1, f2);
  const V scale = hn::Div(radius, hn::IfThenElse(hn::Gt(found, zero()), found, one));
  p1 = hn::IfThenElse(slips, hn::Mul(scale, f1), p1);
  p2 = hn::IfThenElse(slips, hn::Mul(scale, f2), p2);
}

// Shortens impulses p, which would stop all slip with the effective mass m, to friction's disc. The result f acts
// against the slip that is left, v = -s f, so that p = (1 + s m) f with s >= 0 and |f| = radius. Its size is exact, its
// direction nearly so.
HWY_INLINE void hold_in_disc(const Plane& m, V& p1, V& p2, V radius) {
  const V square = hn::Add(hn::Mul(p1, p1), hn::Mul(p2, p2));
  const M presses = hn::Gt(radius, zero());
  const M slips = hn::And(presses, hn::Gt(square, hn::Mul(radius, radius)));
  p1 = hn::IfThenElseZero(presses, p1);
  p2 = hn::IfThenElseZero(presses, p2);
  if (HWY_LIKELY(hn::AllFalse(D(), slips))) return;
  // The function gets copies, so that the compiler can keep the originals in registers.
  const Plane mass = m;
  V f1 = p1, f2 = p2;
  act_against_slip(mass, slips, radius, f1, f2);
  p1 = f1;
  p2 = f2;
}

// J M^-1 J^T for two rows with angular parts j (on both bodies, towards the second) and linear parts alike.
HWY_INLINE V angular_response(const ContactLanes<>& c, const V3& j_first, const V3& j_second, const V3& i_first,
                              const V3& i_second) {
  return hn::Add(dot(j_first, c.first.inverse_inertia * i_first), dot(j_second, c.second.inverse_inertia * i_second));
}

// The response of the tangential speeds at the centre to friction there. `linear` is the response without turning.
HWY_INLINE Plane tangential_response(const ContactLanes<>& c, V linear) {
  const V3& t1 = c.tangent1;
  const V3& t2 = c.tangent2;
  const V3 t1_first = cross(c.anchor_first, t1);
  const V3 t1_second = cross(c.anchor_second, t1);
  const V3 t2_first = cross(c.anchor_first, t2);
  const V3 t2_second = cross(c.anchor_second, t2);
  return {hn::Add(linear, angular_response(c, t1_first, t1_second, t1_first, t1_second)),
          angular_response(c, t1_first, t1_second, t2_first, t2_second),
          hn::Add(linear, angular_response(c, t2_first, t2_second, t2_first, t2_second))};
}

// N s: the normal impulses of all points of a contact.
HWY_INLINE V load_of(const ContactBlock& block, std::size_t lane) {
  const float(*impulses)[block_lanes] = block.normal_impulse;
  return hn::Add(hn::Add(load(impulses[0] + lane), load(impulses[1] + lane)),
                 hn::Add(load(impulses[2] + lane), load(impulses[3] + lane)));
}

// m^2: of the thinner of the two bodies that move, along the normal from its centre of mass to the contact.
HWY_INLINE V square_of_half_thickness(const V3& normal, const V3& arm_first, const M& first_fixed, const V3& arm_second,
                                      const M& second_fixed) {
  constexpr auto min_square = static_cast<float>(tuning::min_thickness * tuning::min_thickness);
  const auto of = [&](const V3& arm, const M& fixed) {
    const V along = dot(normal, arm);
    const V square = hn::Max(hn::Mul(along, along), hn::Mul(splat(min_square), dot(arm, arm)));
    return hn::IfThenElse(fixed, splat(collision::no_point), square);
  };
  return hn::Min(of(arm_first, first_fixed), of(arm_second, second_fixed));
}

// The normal impulses of a manifold's points and the speeds that they change.
struct NormalSolve {
  V u, w1, w2;
  V sum = zero(), sum_y = zero(), sum_minus_x = zero();  // of the impulses applied

  template <MovableSides movable>
  HWY_INLINE explicit NormalSolve(const ContactLanes<movable>& c) {
    u = dot(c.normal, gained_velocity(c));
    const V3 spin = gained_spin(c);
    w1 = dot(c.tangent1, spin);
    w2 = dot(c.tangent2, spin);
  }
  // Adds the speeds that the block stored as the step began.
  template <MovableSides movable>
  HWY_INLINE NormalSolve(const ContactLanes<movable>& c, const ContactBlock& block, std::size_t lane) : NormalSolve(c) {
    u = hn::Add(load(block.start_normal[0] + lane), u);
    w1 = hn::Add(load(block.start_normal[1] + lane), w1);
    w2 = hn::Add(load(block.start_normal[2] + lane), w2);
  }

  HWY_INLINE V speed(V x, V y) const { return hn::Sub(hn::Add(u, hn::Mul(y, w1)), hn::Mul(x, w2)); }

  template <MovableSides movable>
  HWY_INLINE void finish(ContactLanes<movable>& c) const {
    apply(c, sum * c.normal, sum_y * c.tangent1 + sum_minus_x * c.tangent2);
  }
};

// Column of K J^T for one point, J = (1, y, -x), and the point's effective mass.
struct PointResponse {
  V u, w1, w2;
  V own;   // of the point's own speed
  V mass;  // its inverse

  HWY_INLINE PointResponse(const ContactBlock& block, std::size_t lane, V x, V y) {
    const V k01 = load(block.k[1] + lane);
    const V k02 = load(block.k[2] + lane);
    const V k12 = load(block.k[4] + lane);
    u = hn::Sub(hn::Add(load(block.k[0] + lane), hn::Mul(y, k01)), hn::Mul(x, k02));
    w1 = hn::Sub(hn::Add(k01, hn::Mul(y, load(block.k[3] + lane))), hn::Mul(x, k12));
    w2 = hn::Sub(hn::Add(k02, hn::Mul(y, k12)), hn::Mul(x, load(block.k[5] + lane)));
    own = hn::Sub(hn::Add(u, hn::Mul(y, w1)), hn::Mul(x, w2));
    mass = hn::Div(splat(1), own);
  }

  HWY_INLINE void apply(V impulse, V x, V y, NormalSolve& solve) const {
    solve.u = hn::Add(solve.u, hn::Mul(impulse, u));
    solve.w1 = hn::Add(solve.w1, hn::Mul(impulse, w1));
    solve.w2 = hn::Add(solve.w2, hn::Mul(impulse, w2));
    solve.sum = hn::Add(solve.sum, impulse);
    solve.sum_y = hn::Add(solve.sum_y, hn::Mul(impulse, y));
    solve.sum_minus_x = hn::Sub(solve.sum_minus_x, hn::Mul(impulse, x));
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace atl::solver
HWY_AFTER_NAMESPACE();

#endif  // ATOLL_SOLVER_CONTACT_LANES_INL_H_
