// Sequential impulses over contact blocks. Included once for each instruction set. Symbols are those of
// ContactBlock: u, w1, w2 the relative speeds of a manifold, K how impulses change them.

#if defined(ATOLL_SOLVER_CONTACT_KERNELS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATOLL_SOLVER_CONTACT_KERNELS_INL_H_
#undef ATOLL_SOLVER_CONTACT_KERNELS_INL_H_
#else
#define ATOLL_SOLVER_CONTACT_KERNELS_INL_H_
#endif

#include <jobs/lanes-inl.h>
#include <solver/kernels.h>

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

HWY_INLINE BodyLanes load_bodies(const SolverBodies& bodies, const std::int32_t* index) {
  const VelocityRows* velocity = bodies.velocity.data();
  const InertiaRow* inertia = bodies.inertia.data();
  const V4 v = load_rows([=](std::size_t k) { return velocity[index[k]].linear; });
  const V4 w = load_rows([=](std::size_t k) { return velocity[index[k]].angular; });
  const V4 i = load_rows([=](std::size_t k) { return &inertia[index[k]].zz; });
  return {index, {v.x, v.y, v.z}, {w.x, w.y, w.z}, {v.w, w.w, i.x, i.y, i.z, i.w}};
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

// A block's contacts from `lane` on, with their bodies.
struct ContactLanes {
  BodyLanes first, second;
  V3 normal, tangent1, tangent2;
  V3 anchor_first, anchor_second;
  V inverse_mass_first, inverse_mass_second;
};

HWY_INLINE ContactLanes load_contacts(const ContactKernelData& data, const ContactBlock& block, std::size_t lane) {
  ContactLanes c;
  c.first = load_bodies(data.bodies, block.first + lane);
  c.second = load_bodies(data.bodies, block.second + lane);
  c.normal = load3(block.normal, lane);
  c.tangent1 = load3(block.tangent, lane);
  c.tangent2 = cross(c.normal, c.tangent1);
  c.anchor_first = load3(block.anchor_first, lane);
  c.anchor_second = load3(block.anchor_second, lane);
  c.inverse_mass_first = load(block.inverse_mass[0] + lane);
  c.inverse_mass_second = load(block.inverse_mass[1] + lane);
  return c;
}

HWY_INLINE void store_contact_bodies(const ContactLanes& c, const ContactKernelData& data, const ContactBlock& block,
                                     std::size_t lane) {
  store_bodies(c.first, data.bodies, static_cast<unsigned>(block.write_first) >> lane);
  store_bodies(c.second, data.bodies, static_cast<unsigned>(block.write_second) >> lane);
}

// Velocity of the second body against the first at the centre, and relative spin.
HWY_INLINE V3 relative_velocity(const ContactLanes& c) {
  return (c.second.v + cross(c.second.w, c.anchor_second)) - (c.first.v + cross(c.first.w, c.anchor_first));
}
HWY_INLINE V3 relative_spin(const ContactLanes& c) { return c.second.w - c.first.w; }

// An impulse at the centre and an angular impulse, on the second body; the opposite on the first.
HWY_INLINE void apply(ContactLanes& c, const V3& impulse, const V3& angular) {
  c.first.v = c.first.v - c.inverse_mass_first * impulse;
  c.first.w = c.first.w - c.first.inverse_inertia * (cross(c.anchor_first, impulse) + angular);
  c.second.v = c.second.v + c.inverse_mass_second * impulse;
  c.second.w = c.second.w + c.second.inverse_inertia * (cross(c.anchor_second, impulse) + angular);
}

// The normal impulses of a manifold's points and the speeds that they change.
struct NormalSolve {
  V u, w1, w2;
  V sum = zero(), sum_y = zero(), sum_minus_x = zero();  // of the impulses applied

  HWY_INLINE NormalSolve(const ContactLanes& c) {
    u = dot(c.normal, relative_velocity(c));
    const V3 spin = relative_spin(c);
    w1 = dot(c.tangent1, spin);
    w2 = dot(c.tangent2, spin);
  }

  HWY_INLINE V speed(V x, V y) const { return hn::Sub(hn::Add(u, hn::Mul(y, w1)), hn::Mul(x, w2)); }

  HWY_INLINE void finish(ContactLanes& c) const {
    apply(c, sum * c.normal, sum_y * c.tangent1 + sum_minus_x * c.tangent2);
  }
};

// Column of K J^T for one point, J = (1, y, -x), and the point's effective mass.
struct PointResponse {
  V u, w1, w2;
  V mass;

  HWY_INLINE PointResponse(const ContactBlock& block, std::size_t lane, V x, V y) {
    const V k01 = load(block.k[1] + lane);
    const V k02 = load(block.k[2] + lane);
    const V k12 = load(block.k[4] + lane);
    u = hn::Sub(hn::Add(load(block.k[0] + lane), hn::Mul(y, k01)), hn::Mul(x, k02));
    w1 = hn::Sub(hn::Add(k01, hn::Mul(y, load(block.k[3] + lane))), hn::Mul(x, k12));
    w2 = hn::Sub(hn::Add(k02, hn::Mul(y, k12)), hn::Mul(x, load(block.k[5] + lane)));
    mass = hn::Div(splat(1), hn::Sub(hn::Add(u, hn::Mul(y, w1)), hn::Mul(x, w2)));
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

// R(q)^T n - n without cancellation, for the rotation that a body has made since the start of the step.
HWY_INLINE V3 turned_normal_change(const V4& q, const V3& n) {
  const V3 v{q.x, q.y, q.z};
  const V3 t = cross(v, n);
  const V3 change = cross(v, t) - q.w * t;
  return change + change;
}

// separation = start + n . (moved centres) + turned anchors; linear in a point's x and y.
HWY_INLINE void refresh_separations(const ContactKernelData& data, ContactBlock& block, std::size_t lane,
                                    const ContactLanes& c) {
  const DisplacementRows* displacement = data.bodies.displacement.data();
  const auto linear_of = [=](const std::int32_t* index) {
    return load_rows([=](std::size_t k) { return displacement[index[k]].linear; });
  };
  const auto rotation_of = [=](const std::int32_t* index) {
    return load_rows([=](std::size_t k) { return displacement[index[k]].rotation; });
  };
  const V4 first = linear_of(c.first.index);
  const V4 second = linear_of(c.second.index);
  // A rolling ball's lowest point does not rise with its surface.
  const V3 change_first = first.w * turned_normal_change(rotation_of(c.first.index), c.normal);
  const V3 change_second = second.w * turned_normal_change(rotation_of(c.second.index), c.normal);
  const V3 moved = V3{second.x, second.y, second.z} - V3{first.x, first.y, first.z};
  const V turned = hn::Sub(dot(change_second, c.anchor_second), dot(change_first, c.anchor_first));
  const V at_centre = hn::Add(dot(c.normal, moved), turned);
  const V3 change = change_second - change_first;
  const V along_x = dot(change, c.tangent1);
  const V along_y = dot(change, c.tangent2);
  for (std::size_t i = 0; i < max_points; ++i) {
    const V x = load(block.x[i] + lane);
    const V y = load(block.y[i] + lane);
    const V shift = hn::Add(at_centre, hn::Add(hn::Mul(x, along_x), hn::Mul(y, along_y)));
    store(hn::Add(load(block.start_separation[i] + lane), shift), block.separation[i] + lane);
  }
}

template <Friction model>
HWY_INLINE void solve_friction(ContactBlock& block, std::size_t lane, ContactLanes& c) {
  const V3 velocity = relative_velocity(c);
  const V v1 = dot(c.tangent1, velocity);
  const V v2 = dot(c.tangent2, velocity);
  const V spin = dot(c.normal, relative_spin(c));
  V normal_impulse = load(block.normal_impulse[0] + lane);
  for (std::size_t i = 1; i < max_points; ++i) {
    normal_impulse = hn::Add(normal_impulse, load(block.normal_impulse[i] + lane));
  }
  const V bound = hn::Mul(load(block.friction + lane), normal_impulse);

  const V old1 = load(block.friction_impulse[0] + lane);
  const V old2 = load(block.friction_impulse[1] + lane);
  const V m11 = load(block.friction_mass[0] + lane);
  const V m12 = load(block.friction_mass[1] + lane);
  const V m22 = load(block.friction_mass[2] + lane);
  V new1 = hn::Sub(old1, hn::Add(hn::Mul(m11, v1), hn::Mul(m12, v2)));
  V new2 = hn::Sub(old2, hn::Add(hn::Mul(m12, v1), hn::Mul(m22, v2)));
  if constexpr (model == Friction::Cone) {
    const V length = hn::Sqrt(hn::Add(hn::Mul(new1, new1), hn::Mul(new2, new2)));
    const M slides = hn::Gt(length, bound);
    const V scale = hn::IfThenElse(slides, hn::Div(bound, hn::IfThenElse(slides, length, splat(1))), splat(1));
    new1 = hn::Mul(scale, new1);
    new2 = hn::Mul(scale, new2);
  } else {
    new1 = clamp_to(new1, bound);
    new2 = clamp_to(new2, bound);
  }
  const V old_twist = load(block.twist_impulse + lane);
  const V new_twist = clamp_to(hn::Sub(old_twist, hn::Mul(load(block.twist_mass + lane), spin)),
                               hn::Mul(bound, load(block.lever + lane)));
  store(new1, block.friction_impulse[0] + lane);
  store(new2, block.friction_impulse[1] + lane);
  store(new_twist, block.twist_impulse + lane);
  apply(c, hn::Sub(new1, old1) * c.tangent1 + hn::Sub(new2, old2) * c.tangent2,
        hn::Sub(new_twist, old_twist) * c.normal);
}

template <bool bias>
HWY_INLINE void solve_normals(const ContactKernelData& data, ContactBlock& block, std::size_t lane, ContactLanes& c) {
  const SubstepConstants& constants = data.constants;
  const V inverse_h = splat(constants.inverse_h);
  const M fixed = hn::Or(hn::Eq(c.inverse_mass_first, zero()), hn::Eq(c.inverse_mass_second, zero()));
  const auto soft = [&](float of_fixed, float of_dynamic) {
    return hn::IfThenElse(fixed, splat(of_fixed), splat(of_dynamic));
  };
  const Softness& with_fixed = constants.fixed_contact;
  const Softness& with_dynamic = constants.dynamic_contact;
  const V soft_rate = soft(with_fixed.bias_rate, with_dynamic.bias_rate);
  const V soft_mass = soft(with_fixed.mass_scale, with_dynamic.mass_scale);
  const V soft_impulse = soft(with_fixed.impulse_scale, with_dynamic.impulse_scale);

  NormalSolve solve(c);
  for (std::size_t i = 0; i < max_points; ++i) {
    const V x = load(block.x[i] + lane);
    const V y = load(block.y[i] + lane);
    const V old_impulse = load(block.normal_impulse[i] + lane);
    const V separation = load(block.separation[i] + lane);
    const PointResponse response(block, lane, x, y);
    // Apart: may close the gap in this substep, no faster. Overlapping: a soft push, or nothing but a stop.
    const M apart = hn::Gt(separation, zero());
    V speed_bias = hn::Mul(separation, inverse_h);
    V mass = response.mass;
    V leak = zero();
    if constexpr (bias) {
      const V push = hn::Max(hn::Mul(soft_rate, separation), splat(-constants.push_speed));
      speed_bias = hn::IfThenElse(apart, speed_bias, push);
      mass = hn::IfThenElse(apart, mass, hn::Mul(mass, soft_mass));
      leak = hn::IfThenElse(apart, zero(), hn::Mul(soft_impulse, old_impulse));
    } else {
      speed_bias = hn::IfThenElse(apart, speed_bias, zero());
    }
    // All but the product with the speed is off the chain from point to point.
    const V offset = hn::Neg(hn::Add(hn::Mul(mass, speed_bias), leak));
    const V wanted = hn::Sub(offset, hn::Mul(mass, solve.speed(x, y)));
    const V impulse = hn::Max(wanted, hn::Neg(old_impulse));
    store(hn::Add(old_impulse, impulse), block.normal_impulse[i] + lane);
    response.apply(impulse, x, y, solve);
  }
  solve.finish(c);
}

template <bool bias, bool refresh, Friction friction>
void sweep_blocks(const ContactKernelData& data, std::size_t begin, std::size_t end) {
  for (std::size_t b = begin; b < end; ++b) {
    ContactBlock& block = data.blocks[b];
    for (std::size_t lane = 0; lane < block_lanes; lane += lanes) {
      ContactLanes c = load_contacts(data, block, lane);
      if constexpr (refresh) refresh_separations(data, block, lane, c);
      // Friction last, so that its bound is the normal impulse that it goes with.
      solve_normals<bias>(data, block, lane, c);
      // Where both run it is the first substep, and contacts may be new: one round over the points leaves a body that
      // lands flat tilted, and friction with too low a bound.
      if constexpr (bias && friction != Friction::None) solve_normals<bias>(data, block, lane, c);
      if constexpr (friction != Friction::None) solve_friction<friction>(block, lane, c);
      store_contact_bodies(c, data, block, lane);
    }
    if (data.bounces != nullptr) {
      BounceBlock& bounce = data.bounces[b];
      for (std::size_t i = 0; i < max_points; ++i) {
        for (std::size_t lane = 0; lane < block_lanes; lane += lanes) {
          const V impulse = load(block.normal_impulse[i] + lane);
          store(hn::Max(impulse, load(bounce.max_impulse[i] + lane)), bounce.max_impulse[i] + lane);
        }
      }
    }
  }
}

template <bool bias, bool refresh>
void sweep_with_friction(const ContactKernelData& data, Friction friction, std::size_t begin, std::size_t end) {
  switch (friction) {
    case Friction::None:
      return sweep_blocks<bias, refresh, Friction::None>(data, begin, end);
    case Friction::Cone:
      return sweep_blocks<bias, refresh, Friction::Cone>(data, begin, end);
    case Friction::Pyramid:
      return sweep_blocks<bias, refresh, Friction::Pyramid>(data, begin, end);
  }
}

inline void sweep(const ContactKernelData& data, const Sweep& sweep, std::size_t begin, std::size_t end) {
  if (sweep.bias) {
    if (sweep.refresh) return sweep_with_friction<true, true>(data, sweep.friction, begin, end);
    return sweep_with_friction<true, false>(data, sweep.friction, begin, end);
  }
  if (sweep.refresh) return sweep_with_friction<false, true>(data, sweep.friction, begin, end);
  return sweep_with_friction<false, false>(data, sweep.friction, begin, end);
}

inline void warm_start(const ContactKernelData& data, std::size_t begin, std::size_t end) {
  for (std::size_t b = begin; b < end; ++b) {
    const ContactBlock& block = data.blocks[b];
    for (std::size_t lane = 0; lane < block_lanes; lane += lanes) {
      ContactLanes c = load_contacts(data, block, lane);
      V sum = zero();
      V sum_y = zero();
      V sum_minus_x = zero();
      for (std::size_t i = 0; i < max_points; ++i) {
        const V impulse = load(block.normal_impulse[i] + lane);
        sum = hn::Add(sum, impulse);
        sum_y = hn::Add(sum_y, hn::Mul(impulse, load(block.y[i] + lane)));
        sum_minus_x = hn::Sub(sum_minus_x, hn::Mul(impulse, load(block.x[i] + lane)));
      }
      const V f1 = load(block.friction_impulse[0] + lane);
      const V f2 = load(block.friction_impulse[1] + lane);
      const V twist = load(block.twist_impulse + lane);
      apply(c, sum * c.normal + (f1 * c.tangent1 + f2 * c.tangent2),
            twist * c.normal + (sum_y * c.tangent1 + sum_minus_x * c.tangent2));
      store_contact_bodies(c, data, block, lane);
    }
  }
}

// Over the points of each contact: with one, a face that hits flat would leave spinning.
constexpr std::size_t restitution_sweeps = 16;

inline void restitute(const ContactKernelData& data, std::size_t begin, std::size_t end) {
  const V threshold = splat(-data.constants.restitution_threshold);
  for (std::size_t b = begin; b < end; ++b) {
    ContactBlock& block = data.blocks[b];
    const BounceBlock& bounce = data.bounces[b];
    for (std::size_t lane = 0; lane < block_lanes; lane += lanes) {
      ContactLanes c = load_contacts(data, block, lane);
      const V restitution = load(bounce.restitution + lane);
      NormalSolve solve(c);
      for (std::size_t n = 0; n < restitution_sweeps * max_points; ++n) {
        const std::size_t i = n % max_points;
        const V x = load(block.x[i] + lane);
        const V y = load(block.y[i] + lane);
        const V old_impulse = load(block.normal_impulse[i] + lane);
        const V approach = load(bounce.approach[i] + lane);
        const PointResponse response(block, lane, x, y);
        const M bounces = hn::And(hn::And(hn::Lt(approach, threshold), hn::Gt(restitution, zero())),
                                  hn::Gt(load(bounce.max_impulse[i] + lane), zero()));
        const V target = hn::Add(solve.speed(x, y), hn::Mul(restitution, approach));
        const V wanted = hn::Max(hn::Neg(hn::Mul(response.mass, target)), hn::Neg(old_impulse));
        const V impulse = hn::IfThenElse(bounces, wanted, zero());
        store(hn::Add(old_impulse, impulse), block.normal_impulse[i] + lane);
        response.apply(impulse, x, y, solve);
      }
      solve.finish(c);
      store_contact_bodies(c, data, block, lane);
    }
  }
}

// The rows of ContactManifold, transposed; see there.
struct ManifoldLanes {
  V4 normal, anchor_first, anchor_second, x, y, separation, impulse, friction;
};

template <typename ManifoldOf>
HWY_INLINE ManifoldLanes load_manifolds(const ManifoldOf& of) {
  return {load_rows([&](std::size_t k) { return of(k).normal; }),
          load_rows([&](std::size_t k) { return of(k).anchor_first; }),
          load_rows([&](std::size_t k) { return of(k).anchor_second; }),
          load_rows([&](std::size_t k) { return of(k).x; }),
          load_rows([&](std::size_t k) { return of(k).y; }),
          load_rows([&](std::size_t k) { return of(k).separation; }),
          load_rows([&](std::size_t k) { return of(k).normal_impulse; }),
          load_rows([&](std::size_t k) { return of(k).friction_impulse; })};
}

HWY_INLINE void store4(const V4& v, float (*rows)[block_lanes], std::size_t lane) {
  store(v.x, rows[0] + lane);
  store(v.y, rows[1] + lane);
  store(v.z, rows[2] + lane);
  store(v.w, rows[3] + lane);
}

// J M^-1 J^T for two rows with angular parts j (on both bodies, towards the second) and linear parts alike.
HWY_INLINE V angular_response(const ContactLanes& c, const V3& j_first, const V3& j_second, const V3& i_first,
                              const V3& i_second) {
  return hn::Add(dot(j_first, c.first.inverse_inertia * i_first), dot(j_second, c.second.inverse_inertia * i_second));
}

HWY_INLINE void prepare_masses(ContactBlock& block, std::size_t lane, const ContactLanes& c) {
  const V inverse_mass = hn::Add(c.inverse_mass_first, c.inverse_mass_second);
  const M vacant = hn::Eq(inverse_mass, zero());
  const V one_if_vacant = hn::IfThenElse(vacant, splat(1), zero());
  const V3& t1 = c.tangent1;
  const V3& t2 = c.tangent2;

  const V3 n_first = cross(c.anchor_first, c.normal);
  const V3 n_second = cross(c.anchor_second, c.normal);
  const V k[6] = {
      hn::Add(hn::Add(inverse_mass, angular_response(c, n_first, n_second, n_first, n_second)), one_if_vacant),
      angular_response(c, n_first, n_second, t1, t1),
      angular_response(c, n_first, n_second, t2, t2),
      angular_response(c, t1, t1, t1, t1),
      angular_response(c, t1, t1, t2, t2),
      angular_response(c, t2, t2, t2, t2)};
  for (std::size_t i = 0; i < 6; ++i) store(k[i], block.k[i] + lane);

  const V3 t1_first = cross(c.anchor_first, t1);
  const V3 t1_second = cross(c.anchor_second, t1);
  const V3 t2_first = cross(c.anchor_first, t2);
  const V3 t2_second = cross(c.anchor_second, t2);
  const V diagonal = hn::Add(inverse_mass, one_if_vacant);
  const V f11 = hn::Add(diagonal, angular_response(c, t1_first, t1_second, t1_first, t1_second));
  const V f12 = angular_response(c, t1_first, t1_second, t2_first, t2_second);
  const V f22 = hn::Add(diagonal, angular_response(c, t2_first, t2_second, t2_first, t2_second));
  const V inverse_determinant = hn::Div(splat(1), hn::Sub(hn::Mul(f11, f22), hn::Mul(f12, f12)));
  store(hn::Mul(f22, inverse_determinant), block.friction_mass[0] + lane);
  store(hn::Neg(hn::Mul(f12, inverse_determinant)), block.friction_mass[1] + lane);
  store(hn::Mul(f11, inverse_determinant), block.friction_mass[2] + lane);

  const V twist = angular_response(c, c.normal, c.normal, c.normal, c.normal);
  const M turns = hn::Gt(twist, zero());
  store(hn::IfThenElse(turns, hn::Div(splat(1), hn::IfThenElse(turns, twist, splat(1))), zero()),
        block.twist_mass + lane);
}

// m/s^2, of the forces on the bodies along the normal.
struct Pull {
  V relative;  // negative where it brings them together
  V most;      // either could be held up by something else: as if both came
};
HWY_INLINE Pull pull_together(const SolverBodies& bodies, const ContactBlock& block, std::size_t lane,
                              const V3& normal) {
  const auto along_normal = [&](const std::int32_t* index) {
    const V4 a = load_rows([&](std::size_t k) { return bodies.acceleration[index[k]].linear; });
    return dot({a.x, a.y, a.z}, normal);
  };
  const V first = along_normal(block.first + lane);
  const V second = along_normal(block.second + lane);
  return {hn::Sub(second, first), hn::Neg(hn::Add(hn::Abs(first), hn::Abs(second)))};
}

// Whether a point that closes at `speed` under `acceleration` gets through its separation within the step.
HWY_INLINE M meets(V speed, V separation, V acceleration, float step) {
  const V shift = hn::Mul(splat(step), hn::Add(speed, hn::Mul(splat(0.5f * step), acceleration)));
  return hn::Or(hn::Le(separation, zero()), hn::Lt(hn::Add(separation, shift), zero()));
}

// The speed (negative) with which such a point arrives: as if the impact were found to the instant, so that bodies
// bounce off with the energy that they came with.
HWY_INLINE V impact_speed(V speed, V separation, V acceleration) {
  const V gained = hn::Mul(hn::Mul(splat(2), acceleration), separation);
  const V square = hn::Max(hn::Sub(hn::Mul(speed, speed), gained), zero());
  return hn::IfThenElse(hn::And(hn::Lt(speed, zero()), hn::Gt(separation, zero())), hn::Neg(hn::Sqrt(square)), speed);
}

// Bounces go from body to body one step after the other: a bouncy point that would meet nothing in this step, if it
// were not for other impacts, waits for the next. Solved at once, as one impact, they would end as one that shares its
// motion.
HWY_INLINE void prepare_bounces(const ContactKernelData& data, ContactBlock& block, BounceBlock& bounce,
                                std::size_t lane, const ContactLanes& c, V restitution) {
  const NormalSolve solve(c);
  const Pull pull = pull_together(data.bodies, block, lane, c.normal);
  const M bouncy = hn::Gt(restitution, zero());
  for (std::size_t i = 0; i < max_points; ++i) {
    const V speed = solve.speed(load(block.x[i] + lane), load(block.y[i] + lane));
    const V separation = load(block.start_separation[i] + lane);
    const M comes = meets(speed, separation, pull.most, data.constants.step);
    const V seen = hn::IfThenElse(hn::Or(comes, hn::Not(bouncy)), separation, splat(collision::no_point));
    store(seen, block.start_separation[i] + lane);
    store(seen, block.separation[i] + lane);
    store(hn::IfThenElse(comes, impact_speed(speed, separation, pull.relative), zero()), bounce.approach[i] + lane);
    store(zero(), bounce.max_impulse[i] + lane);
  }
  store(restitution, bounce.restitution + lane);
}

// A ball is touched where the normal through its centre leaves it. Its contact may be some way from there: as the step
// starts, it may yet have to travel to where it will be hit.
HWY_INLINE void put_on_line_of_centres(const SolverBodies& bodies, const ContactBlock& block, std::size_t lane,
                                       ContactLanes& c) {
  const auto on_line = [&](const std::int32_t* index, const V3& anchor) {
    const V carries = load_rows([&](std::size_t k) { return bodies.displacement[index[k]].linear; }).w;
    return select(hn::Gt(carries, zero()), anchor, dot(anchor, c.normal) * c.normal);
  };
  c.anchor_first = on_line(block.first + lane, c.anchor_first);
  c.anchor_second = on_line(block.second + lane, c.anchor_second);
}

inline void prepare(const ContactKernelData& data, std::size_t begin, std::size_t end) {
  // What a lane without a contact reads.
  static constexpr collision::ContactManifold vacant = {
      {0, 0, 1},
      0,
      {0, 0, 0},
      0,
      {0, 0, 0},
      0,
      {0, 0, 0, 0},
      {0, 0, 0, 0},
      {collision::no_point, collision::no_point, collision::no_point, collision::no_point},
      {0, 0, 0, 0},
      {0, 0, 0},
      0};
  for (std::size_t b = begin; b < end; ++b) {
    ContactBlock& block = data.blocks[b];
    for (std::size_t lane = 0; lane < block_lanes; lane += lanes) {
      const auto manifold_of = [&](std::size_t k) -> const collision::ContactManifold& {
        const std::int32_t slot = block.slot[lane + k];
        return slot < 0 ? vacant : data.manifolds[slot];
      };
      const ManifoldLanes m = load_manifolds(manifold_of);
      ContactLanes c;
      c.normal = {m.normal.x, m.normal.y, m.normal.z};
      c.tangent1 = tangent_lanes(c.normal).first;
      c.tangent2 = cross(c.normal, c.tangent1);
      c.anchor_first = {m.anchor_first.x, m.anchor_first.y, m.anchor_first.z};
      c.anchor_second = {m.anchor_second.x, m.anchor_second.y, m.anchor_second.z};
      c.first = load_bodies(data.bodies, block.first + lane);
      c.second = load_bodies(data.bodies, block.second + lane);
      const FreeVelocityRows* free_velocity = data.bodies.free_velocity.data();
      const auto inverse_mass_of = [&](const std::int32_t* index) {
        return load_rows([=](std::size_t k) { return free_velocity[index[k]].linear; }).w;
      };
      c.inverse_mass_first = inverse_mass_of(block.first + lane);
      c.inverse_mass_second = inverse_mass_of(block.second + lane);

      if (data.bodies.balls) put_on_line_of_centres(data.bodies, block, lane, c);

      store3(c.normal, block.normal, lane);
      store3(c.tangent1, block.tangent, lane);
      store3(c.anchor_first, block.anchor_first, lane);
      store3(c.anchor_second, block.anchor_second, lane);
      store(m.normal.w, block.friction + lane);
      store(m.anchor_second.w, block.lever + lane);
      store4(m.x, block.x, lane);
      store4(m.y, block.y, lane);
      store4(m.separation, block.start_separation, lane);
      store4(m.separation, block.separation, lane);
      store4(m.impulse, block.normal_impulse, lane);
      store(c.inverse_mass_first, block.inverse_mass[0] + lane);
      store(c.inverse_mass_second, block.inverse_mass[1] + lane);
      const V3 friction{m.friction.x, m.friction.y, m.friction.z};
      store(dot(c.tangent1, friction), block.friction_impulse[0] + lane);
      store(dot(c.tangent2, friction), block.friction_impulse[1] + lane);
      store(m.friction.w, block.twist_impulse + lane);
      prepare_masses(block, lane, c);

      if (data.bounces != nullptr) prepare_bounces(data, block, data.bounces[b], lane, c, m.anchor_first.w);
    }
  }
}

inline void store_impulses(const ContactKernelData& data, std::size_t begin, std::size_t end) {
  for (std::size_t b = begin; b < end; ++b) {
    const ContactBlock& block = data.blocks[b];
    for (std::size_t lane = 0; lane < block_lanes; lane += lanes) {
      unsigned used = 0;
      for (std::size_t k = 0; k < lanes; ++k) used |= (block.slot[lane + k] >= 0 ? 1u : 0u) << k;
      const std::int32_t* slot = block.slot + lane;
      collision::ContactManifold* manifolds = data.manifolds;
      store_rows(
          {load(block.normal_impulse[0] + lane), load(block.normal_impulse[1] + lane),
           load(block.normal_impulse[2] + lane), load(block.normal_impulse[3] + lane)},
          [=](std::size_t k) { return manifolds[slot[k]].normal_impulse; }, used);
      const V3 t1 = load3(block.tangent, lane);
      const V3 t2 = cross(load3(block.normal, lane), t1);
      const V3 friction = load(block.friction_impulse[0] + lane) * t1 + load(block.friction_impulse[1] + lane) * t2;
      store_rows(
          {friction.x, friction.y, friction.z, load(block.twist_impulse + lane)},
          [=](std::size_t k) { return manifolds[slot[k]].friction_impulse; }, used);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace atl::solver
HWY_AFTER_NAMESPACE();

#endif  // ATOLL_SOLVER_CONTACT_KERNELS_INL_H_
