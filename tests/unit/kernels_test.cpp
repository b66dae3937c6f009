// The wide kernels: against each other bit for bit, and against the textbook.

#include <gtest/gtest.h>
#include <solver/sweep/colouring.h>
#include <solver/sweep/impacts.h>
#include <solver/sweep/kernels.h>

#include <Eigen/Eigenvalues>
#include <cstring>
#include <string>

#include "support/random.h"

namespace atl::solver {
namespace {

using collision::ContactManifold;
using test::Random;

constexpr std::uint32_t first_dynamic = 3;  // 1 and 2 are kinematic

// A random but sensible group: bodies, contacts in coloured blocks, some of them partly filled.
struct Group {
  SolverBodies bodies;
  std::vector<ContactManifold> manifolds;
  Colouring colouring;
  std::vector<ContactBlock> blocks;
  std::vector<BounceBlock> bounces;
  SubstepConstants constants = SubstepConstants::of({}, 1.0 / 60);
  bool leaves_out = true;

  ContactKernelData data() {
    ContactKernelData data{bodies, blocks.data(), bounces.data(), manifolds.data(), constants};
    data.leaves_out = leaves_out;
    return data;
  }
};

// Features that no contact of a group needs, so that the kernels may leave them out.
struct Lacking {
  std::uint32_t most_points = 4;
  bool friction = false;
  bool restitution = false;
  MovableSides movable = MovableSides::Both;  // else of these, the other body is the fixed one
};

void set3(float* to, const Eigen::Vector3d& from) {
  for (int i = 0; i < 3; ++i) to[i] = static_cast<float>(from[i]);
}

Group random_group(std::uint32_t seed, std::uint32_t count, int pairs, const Lacking& lacking = {}) {
  Random random(seed);
  Group group;
  group.bodies.reset(count, {.gyroscopic = true, .blow = true});
  for (std::uint32_t body = 1; body < count; ++body) {
    VelocityRows& velocity = group.bodies.velocity[body];
    set3(velocity.linear, random.vector(2));
    set3(velocity.angular, random.vector(2));
    std::memcpy(&group.bodies.free_velocity[body], &velocity, sizeof velocity);
    group.bodies.free_velocity[body].inverse_mass = 0;
    velocity.inertia_xx = velocity.inertia_yy = 0;
    VelocityRows& start = group.bodies.start_velocity[body];
    start = velocity;
    if (body < first_dynamic) continue;
    const Eigen::Matrix3d root = Eigen::Matrix3d::Identity() + 0.3 * (random.vector(1) * random.vector(1).transpose());
    const Eigen::Matrix3d inverse = random.real(0.1, 3) * root * root.transpose();
    const Eigen::Matrix3d inertia = inverse.inverse();
    start.inertia_xx = velocity.inertia_xx = static_cast<float>(inverse(0, 0));
    start.inertia_yy = velocity.inertia_yy = static_cast<float>(inverse(1, 1));
    group.bodies.inertia[body] = {static_cast<float>(inverse(2, 2)), static_cast<float>(inverse(0, 1)),
                                  static_cast<float>(inverse(0, 2)), static_cast<float>(inverse(1, 2))};
    group.bodies.free_velocity[body].inverse_mass = static_cast<float>(random.real(0.2, 3));
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(inertia);
    Eigen::Matrix3d axes = principal.eigenvectors();
    if (axes.determinant() < 0) axes = -axes;
    group.bodies.gyroscopic[body] = GyroscopicRows::of(Quaternion(axes), principal.eigenvalues());
    set3(group.bodies.acceleration[body].linear, {0, 0, -9.81});
    group.bodies.displacement[body].carries = random.chance(0.8) ? 1 : 0;
  }
  std::vector<LocalContact> contacts;
  for (int i = 0; i < pairs; ++i) {
    std::uint32_t a = random.below(count);
    std::uint32_t b = random.below(count);
    if (lacking.movable == MovableSides::First) b = 0;
    if (lacking.movable == MovableSides::Second) a = 0;
    if (a == b || std::max(a, b) < first_dynamic) continue;
    contacts.push_back({a, b, static_cast<std::uint32_t>(group.manifolds.size())});
    ContactManifold manifold = {};
    set3(manifold.normal, random.direction());
    set3(manifold.anchor_first, random.vector(0.5));
    set3(manifold.anchor_second, random.vector(0.5));
    manifold.friction = static_cast<float>(random.real(0, 1));
    if (lacking.friction) manifold.friction = 0;
    manifold.restitution = random.chance(0.5) && !lacking.restitution ? 0.7f : 0;
    manifold.friction_radius = 0.3f;
    const std::uint32_t points = 1 + random.below(lacking.most_points);
    for (std::uint32_t p = 0; p < 4; ++p) {
      const bool used = p < points;
      manifold.x[p] = used ? static_cast<float>(random.real(-0.4, 0.4)) : 0;
      manifold.y[p] = used ? static_cast<float>(random.real(-0.4, 0.4)) : 0;
      manifold.separation[p] = used ? static_cast<float>(random.real(-0.01, 0.005)) : collision::no_point;
      manifold.normal_impulse[p] = used ? static_cast<float>(random.real(0, 0.2)) : 0;
    }
    set3(manifold.friction_impulse, random.vector(0.05));
    manifold.torsional_impulse = static_cast<float>(random.real(-0.02, 0.02));
    group.manifolds.push_back(manifold);
  }
  group.colouring.build(contacts, first_dynamic, count, group.blocks);
  group.bounces.resize(group.colouring.block_count());
  return group;
}

template <typename Run>
void each_colour(Group& group, const Run& run) {
  for (const Colour& colour : group.colouring.colours()) run(colour.begin_block, colour.end_block);
}

void sweep(Group& group, const Kernels& kernels, const Sweep& how) {
  const ContactKernelData data = group.data();
  each_colour(group, [&](std::size_t begin, std::size_t end) { kernels.sweep(data, how, begin, end); });
}

// Two substeps with every kind of sweep in them.
void simulate(Group& group, const Kernels& kernels) {
  const ContactKernelData data = group.data();
  const std::size_t bodies = group.bodies.padded_count();
  kernels.prepare(data, 0, group.colouring.block_count());
  Impacts impacts;
  impacts.begin_step(bodies, group.colouring.block_count());
  for (const bool again : {false, true}) {
    kernels.note_approaches(data, 0, group.colouring.block_count());
    impacts.solve(data, Friction::Cone);
    kernels.integrate_velocities(group.bodies, group.constants, again, 0, bodies);
    if (!again) {
      each_colour(group, [&](std::size_t begin, std::size_t end) { kernels.warm_start(data, begin, end); });
    }
    sweep(group, kernels, {Push::Bias, again, Friction::Cone, true});
    kernels.integrate_positions(group.bodies, group.constants, 0, bodies);
    sweep(group, kernels, {Push::None, true, again ? Friction::Pyramid : Friction::Cone});
    sweep(group, kernels, {Push::None, false, Friction::None});
  }
  kernels.store(data, 0, group.colouring.block_count());
}

template <typename T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

TEST(Kernels, GiveTheSameBitsOnEveryInstructionSet) {
  ASSERT_FALSE(available_kernels().empty());
  EXPECT_NE(find_kernels("portable"), nullptr);
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    Group reference = random_group(seed, 40, 150);
    const Group start = reference;
    simulate(reference, *find_kernels("portable"));
    EXPECT_FALSE(same_bytes(reference.bodies.velocity, start.bodies.velocity));
    for (const Kernels* kernels : available_kernels()) {
      Group group = start;
      simulate(group, *kernels);
      EXPECT_TRUE(same_bytes(group.bodies.velocity, reference.bodies.velocity)) << kernels->name;
      EXPECT_TRUE(same_bytes(group.bodies.displacement, reference.bodies.displacement)) << kernels->name;
      EXPECT_TRUE(same_bytes(group.manifolds, reference.manifolds)) << kernels->name;
    }
  }
}

// With what no contact has gone through all the same, every body moves and every impulse is as without.
TEST(Kernels, LeaveOutWhatWouldNotChangeABit) {
  std::uint32_t seed = 0;
  for (const std::uint32_t points : {1u, 2u, 3u, 4u}) {
    for (const MovableSides movable : {MovableSides::Both, MovableSides::First, MovableSides::Second}) {
      for (const int lacks : {0, 1, 2, 3}) {
        const Lacking lacking{points, (lacks & 1) != 0, (lacks & 2) != 0, movable};
        Group everything = random_group(++seed, 40, 150, lacking);
        Group lean = everything;
        everything.leaves_out = false;
        for (const Kernels* kernels : available_kernels()) {
          Group with = everything, without = lean;
          simulate(with, *kernels);
          simulate(without, *kernels);
          EXPECT_TRUE(same_bytes(with.bodies.velocity, without.bodies.velocity)) << kernels->name << " " << seed;
          EXPECT_TRUE(same_bytes(with.bodies.displacement, without.bodies.displacement))
              << kernels->name << " " << seed;
          EXPECT_TRUE(same_bytes(with.manifolds, without.manifolds)) << kernels->name << " " << seed;
          const ContactTraits& traits = without.blocks.front().traits;
          EXPECT_LE(traits.points, points);
          EXPECT_EQ(traits.friction, !lacking.friction);
          EXPECT_EQ(without.blocks.front().movable, movable);
          EXPECT_LE(traits.bounces, !lacking.restitution);
        }
      }
    }
  }
}

TEST(Kernels, NeverPullAndNeverWriteABodyThatIsNotDynamic) {
  Group group = random_group(7, 40, 150);
  const Group start = group;
  const Kernels& kernels = *available_kernels().front();
  kernels.prepare(group.data(), 0, group.colouring.block_count());
  for (int i = 0; i < 5; ++i) sweep(group, kernels, {Push::Bias, false, Friction::Cone, true});
  kernels.store(group.data(), 0, group.colouring.block_count());
  for (const ContactManifold& manifold : group.manifolds) {
    float normal = 0;
    for (std::size_t p = 0; p < 4; ++p) {
      EXPECT_GE(manifold.normal_impulse[p], 0);
      if (manifold.separation[p] == collision::no_point) {
        EXPECT_EQ(manifold.normal_impulse[p], 0);
      }
      normal += manifold.normal_impulse[p];
    }
    const float* f = manifold.friction_impulse;
    // Rounding of a sum, a square root and a product.
    EXPECT_LE(std::sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]), manifold.friction * normal * (1 + 1e-5f) + 1e-6f);
    EXPECT_LE(std::abs(manifold.torsional_impulse),
              manifold.friction * normal * manifold.friction_radius * (1 + 1e-5f) + 1e-6f);
  }
  for (std::uint32_t body = 0; body < first_dynamic; ++body) {
    EXPECT_EQ(std::memcmp(&group.bodies.velocity[body], &start.bodies.velocity[body], sizeof(VelocityRows)), 0);
  }
}

TEST(Kernels, SweepsKeepMomentum) {
  Group group = random_group(9, 40, 150);
  const auto momentum = [&] {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::uint32_t body = first_dynamic; body < 40; ++body) {
      const float* v = group.bodies.velocity[body].linear;
      sum += Eigen::Vector3d(v[0], v[1], v[2]) / static_cast<double>(group.bodies.free_velocity[body].inverse_mass);
    }
    return sum;
  };
  // Only between dynamic bodies: with the rest, momentum is exchanged.
  std::vector<LocalContact> contacts;
  for (std::uint32_t i = 0; i < 30; ++i) contacts.push_back({first_dynamic + i, first_dynamic + i + 1, i});
  group.colouring.build(contacts, first_dynamic, 40, group.blocks);
  group.bounces.resize(group.colouring.block_count());
  const Kernels& kernels = *available_kernels().front();
  kernels.prepare(group.data(), 0, group.colouring.block_count());
  const Eigen::Vector3d before = momentum();
  for (int i = 0; i < 10; ++i) sweep(group, kernels, {Push::Bias, false, Friction::Cone, true});
  EXPECT_LT((momentum() - before).norm(), 1e-4);
}

// K of one contact against J M^-1 J^T written out with matrices, and what one sweep without softness does: no
// point is left approaching once the sweeps have converged.
TEST(Kernels, MassesAreThoseOfTheTextbookAndApproachStops) {
  for (std::uint32_t seed = 1; seed <= 10; ++seed) {
    Group group = random_group(seed, 8, 40);
    for (ContactManifold& manifold : group.manifolds) {
      for (float& separation : manifold.separation) {
        if (separation != collision::no_point) separation = 0;
      }
    }
    std::vector<LocalContact> one = {{4, 5, 0}};
    for (const std::uint32_t body : {4u, 5u}) group.bodies.displacement[body].carries = 1;
    group.colouring.build(one, first_dynamic, 8, group.blocks);
    const Kernels& kernels = *available_kernels().front();
    const ContactManifold manifold = group.manifolds[0];
    kernels.prepare(group.data(), 0, 1);

    Eigen::Matrix<double, 3, 12> jacobian = Eigen::Matrix<double, 3, 12>::Zero();
    Eigen::Matrix<double, 12, 12> inverse_mass = Eigen::Matrix<double, 12, 12>::Zero();
    const auto vector = [](const float* v) { return Eigen::Vector3d(v[0], v[1], v[2]); };
    const Eigen::Vector3d n = vector(manifold.normal);
    const collision::Tangents frame = collision::tangents(manifold.normal);
    const Eigen::Vector3d t1 = vector(frame.first.data());
    const Eigen::Vector3d t2 = vector(frame.second.data());
    for (int side = 0; side < 2; ++side) {
      const double sign = side == 0 ? -1 : 1;
      const std::uint32_t body = one[0].first + static_cast<std::uint32_t>(side);
      const Eigen::Vector3d r = vector(side == 0 ? manifold.anchor_first : manifold.anchor_second);
      jacobian.block<1, 3>(0, 6 * side) = sign * n.transpose();
      jacobian.block<1, 3>(0, 6 * side + 3) = sign * r.cross(n).transpose();
      jacobian.block<1, 3>(1, 6 * side + 3) = sign * t1.transpose();
      jacobian.block<1, 3>(2, 6 * side + 3) = sign * t2.transpose();
      const VelocityRows& v = group.bodies.velocity[body];
      const InertiaRow& i = group.bodies.inertia[body];
      inverse_mass.block<3, 3>(6 * side, 6 * side) =
          static_cast<double>(group.bodies.free_velocity[body].inverse_mass) * Eigen::Matrix3d::Identity();
      inverse_mass.block<3, 3>(6 * side + 3, 6 * side + 3) << v.inertia_xx, i.xy, i.xz, i.xy, v.inertia_yy, i.yz, i.xz,
          i.yz, i.zz;
    }
    const Eigen::Matrix3d k = jacobian * inverse_mass * jacobian.transpose();
    const double scale = k.cwiseAbs().maxCoeff();
    const ContactBlock& block = group.blocks[0];
    const int row[6] = {0, 0, 0, 1, 1, 2};
    const int column[6] = {0, 1, 2, 1, 2, 2};
    for (int i = 0; i < 6; ++i) EXPECT_NEAR(block.k[i][0], k(row[i], column[i]), 1e-5 * scale) << i;

    for (int i = 0; i < 500; ++i) sweep(group, kernels, {Push::None, false, Friction::None});
    Eigen::Matrix<double, 12, 1> velocity;
    for (int side = 0; side < 2; ++side) {
      const std::uint32_t body = one[0].first + static_cast<std::uint32_t>(side);
      const VelocityRows& start = group.bodies.start_velocity[body];
      const VelocityRows& gained = group.bodies.velocity[body];
      velocity.segment<3>(6 * side) = vector(start.linear) + vector(gained.linear);
      velocity.segment<3>(6 * side + 3) = vector(start.angular) + vector(gained.angular);
    }
    const Eigen::Vector3d speeds = jacobian * velocity;
    for (std::size_t p = 0; p < 4; ++p) {
      if (manifold.separation[p] == collision::no_point) continue;
      const double closing = speeds[0] + manifold.y[p] * speeds[1] - manifold.x[p] * speeds[2];
      EXPECT_GT(closing, -1e-4) << "seed " << seed << ", point " << p;
      // Complementarity: what still pushes does not move.
      EXPECT_LT(std::min<double>(closing, group.blocks[0].normal_impulse[p][0]), 1e-4);
    }
  }
}

// However the narrowphase places a contact on a ball, what presses on it points at its centre.
TEST(Kernels, NormalImpulsesDoNotTurnBalls) {
  for (std::uint32_t seed = 1; seed <= 10; ++seed) {
    Group group = random_group(seed, 8, 40);
    for (std::uint32_t body = first_dynamic; body < 8; ++body) {
      group.bodies.displacement[body].carries = 0;
      std::fill_n(group.bodies.velocity[body].angular, 3, 0.0f);
      std::fill_n(group.bodies.start_velocity[body].angular, 3, 0.0f);
    }
    const std::vector<LocalContact> one = {{4, 5, 0}};
    for (std::size_t i = 0; i < 4; ++i) {
      group.manifolds[0].x[i] = group.manifolds[0].y[i] = 0;
      group.manifolds[0].separation[i] = i == 0 ? 0 : collision::no_point;
    }
    group.colouring.build(one, first_dynamic, 8, group.blocks);
    const Kernels& kernels = *available_kernels().front();
    kernels.prepare(group.data(), 0, 1);
    for (int i = 0; i < 10; ++i) sweep(group, kernels, {Push::None, false, Friction::None});
    for (const std::uint32_t body : {4u, 5u}) {
      for (const float spin : group.bodies.velocity[body].angular) EXPECT_NEAR(spin, 0, 1e-5) << seed;
    }
  }
}

}  // namespace
}  // namespace atl::solver
