// Nothing gets energy out of nothing: random assemblies of joined bodies, needles that land, rods that are shot at a
// wall.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "support/bodies.h"
#include "support/long_tests.h"
#include "support/random.h"
#include "support/random_assembly.h"

namespace atl::test {
namespace {

constexpr double seconds = 2;
// Factor on an assembly's allowance of energy, for errors of integrating its motion.
constexpr double margin = 2;

// J: the most that bodies have in these steps beyond what they begin with; infinite if one goes into quarantine.
double max_energy_gained(World& world, const std::vector<BodyId>& ids, int steps) {
  const double start = mechanical_energy(world, ids);
  double max = start;
  for (int i = 0; i < steps; ++i) {
    if (world.step(dt).quarantined > 0) return INFINITY;
    max = std::max(max, mechanical_energy(world, ids));
  }
  return max - start;
}

constexpr AssemblyKind plain = {
    .motors = false, .springs = false, .ranges = false, .apart = false, .redundant = false, .pinned = false};

// True if an assembly gains more energy than its allowance times the margin, with its own settings or with these.
bool gains(std::uint32_t seed, const AssemblyKind& kind, JointSolver solver,
           const std::optional<Settings>& settings = {}) {
  Assembly assembly = random_assembly(seed, kind);
  assembly.world.settings = settings.value_or(assembly.world.settings);
  assembly.world.settings.joint_solver = solver;
  World world(assembly.world);
  const std::vector<BodyId> ids = add_to(world, assembly);
  const double allowed = energy_allowance(world, assembly, ids, seconds).all() + 1e-6;
  const double gained = max_energy_gained(world, ids, static_cast<int>(std::lround(seconds / dt)));
  if (gained < margin * allowed) return false;
  std::cout << seed << " gains " << gained << " J of " << allowed << ": " << assembly.features << "\n";
  return true;
}

// Counts the assemblies of the first seeds that gain more.
int gaining(std::uint32_t seeds, const AssemblyKind& kind, JointSolver solver,
            const std::optional<Settings>& settings = {}) {
  int count = 0;
  for (std::uint32_t seed = 0; seed < seeds; ++seed) count += gains(seed, kind, solver, settings);
  return count;
}

std::uint32_t seeds() { return long_tests() ? 10000 : 300; }

// With armatures, whatever the settings.
TEST(Energy, TreesOfDirectJointsGainNone) { EXPECT_EQ(gaining(seeds(), plain, JointSolver::Direct), 0); }

TEST(Energy, NorWhereTheyHaveRangesAndHangOnWhatIsStatic) {
  AssemblyKind kind = plain;
  kind.ranges = kind.pinned = true;
  EXPECT_EQ(gaining(seeds(), kind, JointSolver::Direct), 0);
  EXPECT_FALSE(gains(4870, kind, JointSolver::Direct));  // a rotor whose row turns fast gives what it has, and no more
}

TEST(Energy, NorWithSpringsAndRangesAtTheDefaults) {
  AssemblyKind kind = plain;
  kind.springs = kind.ranges = true;
  EXPECT_EQ(gaining(seeds(), kind, JointSolver::Auto, Settings{}), 0);
}

// Locks and joints together may leave nothing that moves, or little: rows then answer by rounding alone.
TEST(Energy, NorWhereMotionsAreLocked) {
  AssemblyKind kind = plain;
  kind.ranges = kind.pinned = kind.locks = true;
  EXPECT_EQ(gaining(seeds(), kind, JointSolver::Direct), 0);
  EXPECT_FALSE(gains(5852, kind, JointSolver::Direct));  // they start with velocities that their joints forbid
  EXPECT_FALSE(gains(7942, kind, JointSolver::Direct));
  EXPECT_EQ(gaining(seeds(), kind, JointSolver::Iterative, Settings{}), 0);
  for (const std::uint32_t hung : {2193, 4325, 6098}) {  // by points of bodies that only turn
    for (const int iterations : {1, 16}) {
      EXPECT_FALSE(gains(hung, kind, JointSolver::Iterative, Settings{.iterations = iterations})) << iterations;
    }
  }
}

// A rotor has the rate of its coordinate, whatever else moves the bodies that the joint doesn't allow.
TEST(Energy, NorWhereSweptRotorsStartAgainstTheirJoint) {
  AssemblyKind kind = plain;
  kind.ranges = kind.pinned = true;
  for (const int substeps : {1, 4, 64}) {
    for (const int iterations : {1, 16}) {
      const Settings settings{.substeps = substeps, .iterations = iterations};
      EXPECT_FALSE(gains(9906, kind, JointSolver::Iterative, settings)) << substeps << " " << iterations;
    }
  }
}

// Stiff springs and servos are as soft as one sweep holds: of 1000 mechanisms 3 gain energy. As stiff as they are said
// to be, 24 do.
TEST(Energy, FewMechanismsOfSweptSpringsGainAny) {
  AssemblyKind kind = plain;
  kind.springs = kind.ranges = kind.pinned = true;
  EXPECT_LE(gaining(seeds(), kind, JointSolver::Iterative, Settings{}), static_cast<int>(seeds() / 100));
}

// Joints between the same two bodies are together as stiff as one, or sweeps would ring them up.
TEST(Energy, NorWhereSweptJointsHoldTheSameBodies) {
  AssemblyKind kind = plain;
  kind.redundant = true;
  EXPECT_EQ(gaining(seeds(), kind, JointSolver::Iterative, Settings{}), 0);
}

// Rigid joints may gain by sweeps that haven't converged. With locked rows over-relaxed, 28 of 300 did by 16 sweeps.
TEST(Energy, FewMechanismsOfRigidSweptJointsGainAny) {
  AssemblyKind kind = plain;
  kind.ranges = kind.pinned = true;
  for (const Stabilisation stabilisation : {Stabilisation::Baumgarte, Stabilisation::SplitImpulse}) {
    const Settings settings = {.iterations = 8, .stabilisation = stabilisation};
    EXPECT_LE(gaining(seeds(), kind, JointSolver::Iterative, settings), static_cast<int>(seeds() / 100));
  }
}

// A needle that falls on the ground. Half its length is 1 m.
double needle_gain(const Shape& shape, double tilt) {
  World world;
  world.add_body(ground());
  BodyDef needle{.shape = shape};
  needle.position = {0, 0, std::cos(tilt) + 0.5};
  needle.orientation = Quaternion(Eigen::AngleAxisd(tilt, Vector3(1, 0.3, 0).normalized()));
  const std::vector<BodyId> ids = {world.add_body(needle)};
  const double start = mechanical_energy(world, ids);
  return 1 + max_energy_gained(world, ids, 300) / start;
}

TEST(Energy, LandingNeedlesGainNone) {
  for (const double aspect : {100.0, 1000.0, 10000.0}) {
    for (const double tilt : {0.0, 0.3, 0.8, 1.2, 1.5, 1.5707}) {
      SCOPED_TRACE("1:" + std::to_string(aspect) + " at " + std::to_string(tilt));
      EXPECT_LT(needle_gain(Box{{1 / aspect, 1 / aspect, 1}}, tilt), 1.001);
      EXPECT_LT(needle_gain(Capsule{.radius = 1 / aspect, .half_height = 1}, tilt), 1.001);
    }
  }
}

// Thirty needles that fall through each other into a heap.
TEST(Energy, HeapsOfNeedlesGainNone) {
  for (const double aspect : {100.0, 1000.0, 10000.0}) {
    SCOPED_TRACE("1:" + std::to_string(aspect));
    World world;
    world.add_body(ground());
    Random random(1);
    std::vector<BodyId> ids;
    for (int i = 0; i < 30; ++i) {
      BodyDef needle{.shape = Box{{0.5 / aspect, 0.5 / aspect, 0.5}}};
      needle.position = {random.real(-0.5, 0.5), random.real(-0.5, 0.5), 1 + 0.1 * i};
      needle.orientation = random.rotation();
      ids.push_back(world.add_body(needle));
    }
    const double start = mechanical_energy(world, ids);
    for (int i = 0; i < 600; ++i) {
      ASSERT_EQ(world.step(dt).quarantined, 0) << "step " << i;
      ASSERT_LT(mechanical_energy(world, ids), 1.001 * start) << "step " << i;
    }
  }
}

// The most that a heap of solids gains in a step, as a part of the energy it begins with. Each falls from its own
// height; masses range over up to six decades. With `turns`, contacts are solved by each method in turn.
double gain_of_heap(std::uint32_t seed, ContactSolver solver, bool turns) {
  World world({.settings = {.contact_solver = solver}});
  world.add_body(ground());
  Random random(seed);
  const double decades = random.real(0, 6);
  const int count = 3 + static_cast<int>(random.below(12));
  std::vector<BodyId> ids;
  for (int i = 0; i < count; ++i) {
    BodyDef body =
        random.chance(0.3) ? sphere({}, random.real(0.2, 0.5)) : box({}, Vector3::Constant(random.real(0.2, 0.5)));
    body.position = {random.real(-0.3, 0.3), random.real(-0.3, 0.3), 0.9 + 1.75 * i};
    if (random.chance(0.5)) body.orientation = random.rotation();
    body.density = 1000 * std::pow(10, random.real(0, decades));
    ids.push_back(world.add_body(body));
  }
  const double start = mechanical_energy(world, ids);
  double before = start, gained = 0;
  for (int i = 0; i < 300; ++i) {
    if (turns && i % 15 == 14) {
      Settings settings = world.settings();
      settings.contact_solver = i / 15 % 2 == 0 ? ContactSolver::Direct : ContactSolver::Iterative;
      world.set_settings(settings);
    }
    world.step(dt);
    const double now = mechanical_energy(world, ids);
    gained = std::max(gained, now - before);
    before = now;
  }
  return gained / start;
}

// An impulse that stopped a heavy body in one substep would, carried over into the next, throw what lies beneath it: a
// fifth of 400 such heaps gained more than 2% in a step of sweeps, and one 44% at the defaults.
TEST(Energy, HeapsOfUnequalMassesGainNone) {
  for (std::uint32_t seed = 0; seed < (long_tests() ? 400u : 60u); ++seed) {
    EXPECT_LT(gain_of_heap(seed, ContactSolver::Iterative, false), 0.02) << "seed " << seed;
    EXPECT_LT(gain_of_heap(seed, ContactSolver::Direct, false), 0.02) << "seed " << seed;
    EXPECT_LT(gain_of_heap(seed, ContactSolver::Auto, false), 0.02) << "seed " << seed;
    EXPECT_LT(gain_of_heap(seed, ContactSolver::Direct, true), 0.02) << "seed " << seed;
  }
}

// A weight of 3 kg falls along a slider of a block of 5 t, which sags more under a longer substep and is pushed out
// under a shorter one. What contacts do then is no energy that the weight has to pay.
TEST(Energy, WhatContactsLiftIsNotTakenFromMechanisms) {
  constexpr double g = 9.81;
  for (const JointSolver solver : {JointSolver::Auto, JointSolver::Iterative}) {
    for (const int substeps : {4, 16}) {
      for (const double jitter : {0.0, 0.2}) {
        for (const int times : {1, 2}) {  // substeps in odd steps
          World world({.settings = {.substeps = substeps, .joint_solver = solver}});
          world.add_body(static_box({0, 0, -0.5}, {20, 20, 0.5}));
          const BodyId block = world.add_body({.shape = Box{{1.5, 1.5, 0.25}}, .position = {0, 0, 0.25}, .mass = 5000});
          const Vector3 top(0, 0, 8);
          const BodyId weight =
              world.add_body({.shape = Sphere{0.1}, .position = top, .mass = 3, .filter = {.mask = 0}});
          world.add_joint(joint_at(world, SliderJoint{}, block, weight, top, Vector3::UnitZ()));
          double time = 0;
          for (int i = 0; i < 60; ++i) {
            Settings settings = world.settings();
            settings.substeps = i % 2 == 1 ? times * substeps : substeps;
            world.set_settings(settings);
            const double step = dt * (1 + (i % 3 - 1) * jitter);
            world.step(step);
            time += step;
          }
          EXPECT_NEAR(world.velocity(weight).z(), -g * time, 0.003 * g * time)
              << substeps << " substeps, times " << times << ", jitter " << jitter;
        }
      }
    }
  }
}

// What was put into one place is pushed apart, and is then as slow as it was.
TEST(Energy, BodiesInOnePlaceGainNone) {
  for (const int count : {2, 30, 300}) {
    for (const bool balls : {false, true}) {
      SCOPED_TRACE(std::to_string(count) + (balls ? " balls" : " cubes"));
      World world({.gravity = Vector3::Zero()});
      std::vector<BodyId> ids;
      for (int i = 0; i < count; ++i) ids.push_back(world.add_body(balls ? sphere({0, 0, 0}) : box({0, 0, 0})));
      double fastest = 0;
      for (int i = 0; i < 60; ++i) {
        ASSERT_EQ(world.step(dt).quarantined, 0) << "step " << i;
        for (const BodyId id : ids) fastest = std::max(fastest, world.velocity(id).norm());
      }
      EXPECT_LT(fastest, world.settings().contact_push_speed);
    }
  }
}

// In flight a needle's spin about its axis goes along with the axis, at any speed.
TEST(Energy, NeedlesInFlightKeepTheirs) {
  for (const double aspect : {100.0, 1000.0, 10000.0}) {
    for (const double spin : {10.0, 1000.0, 1e5}) {
      SCOPED_TRACE("1:" + std::to_string(aspect) + ", " + std::to_string(spin) + " rad/s");
      World world({.gravity = Vector3::Zero()});
      BodyDef needle{.shape = Box{{1 / aspect, 1.5 / aspect, 1}}};
      needle.angular_velocity = {10, 3, spin};
      const std::vector<BodyId> ids = {world.add_body(needle)};
      const double start = mechanical_energy(world, ids);
      for (int i = 0; i < 300; ++i) {
        ASSERT_EQ(world.step(dt).quarantined, 0) << "step " << i;
        ASSERT_NEAR(mechanical_energy(world, ids), start, 0.01 * start) << "step " << i;
      }
    }
  }
}

// And what has three moments, about whichever axis it turns.
TEST(Energy, BricksInFlightKeepTheirs) {
  for (const double spin : {1e2, 1e4, 3e4, 1e5, 5e5}) {
    for (const Vector3& axis : {Vector3(1, 0.3, 0.1), Vector3(0.1, 1, 0.3), Vector3(0.3, 0.1, 1)}) {
      World world({.gravity = Vector3::Zero()});
      BodyDef brick = box({0, 0, 0}, {0.5, 0.1, 0.3});
      brick.angular_velocity = spin * axis;
      const std::vector<BodyId> ids = {world.add_body(brick)};
      const double start = mechanical_energy(world, ids);
      for (int i = 0; i < 300; ++i) {
        ASSERT_EQ(world.step(dt).quarantined, 0) << spin;
        ASSERT_NEAR(mechanical_energy(world, ids), start, 1e-4 * start) << spin << " rad/s, step " << i;
      }
    }
  }
}

// A hundred rods side by side, a little askew, at a wall of 2 mm.
// Rods that turn by up to fifty radians in a step, and land on the ground, and on another that lies there.
TEST(Energy, RodsThatSpinBlindlyGainNone) {
  const Shape shapes[] = {Box{{0.02, 0.02, 0.5}}, Box{{0.1, 0.05, 0.5}}, Capsule{0.05, 0.45}, Cylinder{0.05, 0.5}};
  for (const Shape& shape : shapes) {
    for (const double spin : {100.0, 300.0, 1000.0, 3000.0}) {
      for (const double restitution : {0.0, 0.9}) {
        for (int start = 0; start < 6; ++start) {
          World world;
          world.add_body(ground());
          BodyDef rod{.shape = shape};
          rod.position = {0, 0, 0.8 + 0.03 * start};
          rod.angular_velocity = spin * Vector3(0.6, 0.3, 0.7);
          rod.material = {.friction = 0.6, .restitution = restitution};
          std::vector<BodyId> ids = {world.add_body(rod)};
          if (start % 2 == 1) ids.push_back(world.add_body({.shape = Box{{0.3, 0.3, 0.1}}, .position = {0, 0, 0.1}}));
          const double before = mechanical_energy(world, ids);
          double max = before;
          for (int i = 0; i < 240; ++i) {
            world.step(dt);
            max = std::max(max, mechanical_energy(world, ids));
          }
          EXPECT_LT(max, 1.005 * before) << spin << " rad/s, restitution " << restitution << ", start " << start;
        }
      }
    }
  }
}

// A tree of joints in the air, with links of up to a hundred times the density of others.
std::vector<BodyId> add_tree(World& world, Random& random, double friction) {
  const Shape shapes[] = {Box{{0.2, 0.1, 0.05}}, Sphere{0.12}, Capsule{0.06, 0.2}, Cylinder{0.1, 0.2}};
  const JointKind kinds[] = {BallJoint{}, HingeJoint{}, HingeJoint{{.range = {-1, 1}}},
                             SliderJoint{{.range = {-0.2, 0.2}}},
                             ConeTwistJoint{.swing_limit = 1, .twist = {.range = {-1, 1}}}};
  const double ratio = random.magnitude(1, 100), spin = random.magnitude(0.1, 100);
  std::vector<BodyId> ids;
  const std::uint32_t count = 2 + random.below(7);
  for (std::uint32_t i = 0; i < count; ++i) {
    BodyDef link{.shape = shapes[random.below(4)], .orientation = random.rotation()};
    link.position = Vector3(0.5 * i, 0, 1.5) + random.vector(0.2);
    link.velocity = random.vector(2);
    link.angular_velocity = random.vector(spin);
    link.density = 1000 * (random.chance(0.5) ? 1 : ratio);
    link.material.friction = friction;
    ids.push_back(world.add_body(link));
    if (i == 0) continue;
    const BodyId to = ids[random.below(i)];
    const Vector3 middle = (world.centre_of_mass(to) + world.centre_of_mass(ids.back())) / 2;
    world.add_joint(joint_at(world, kinds[random.below(5)], to, ids.back(), middle, random.direction()));
  }
  return ids;
}

// Nor in any step, by what was carried over from an impact. One of 2000 is lifted: by a light link that whirls at 180
// rad/s, which sweeps turn into the floor by most of a radian a substep, and push out with all that it carries.
TEST(Energy, TreesThatFallOnTheGroundGainNone) {
  const std::uint32_t count = long_tests() ? 2000 : 150;
  std::uint32_t lifted = 0;
  for (std::uint32_t seed = 0; seed < count; ++seed) {
    Random random(seed);
    const double friction = random.chance(0.5) ? 0 : 0.6;
    const JointSolver solvers[] = {JointSolver::Auto, JointSolver::Iterative, JointSolver::Direct};
    World world({.settings = {.joint_solver = solvers[seed % 3]}});
    BodyDef floor = ground();
    floor.material.friction = friction;
    world.add_body(floor);
    const std::vector<BodyId> ids = add_tree(world, random, friction);
    double before = mechanical_energy(world, ids);
    const double all = before;
    double max = 0;
    for (int i = 0; i < 240; ++i) {
      ASSERT_EQ(world.step(dt).quarantined, 0) << "seed " << seed;
      const double now = mechanical_energy(world, ids);
      max = std::max(max, now - before);
      before = now;
    }
    EXPECT_LT(max, 0.15 * all) << "seed " << seed;
    lifted += max > 0.01 * all;
  }
  EXPECT_LE(lifted, 1u);
}

JointKind kind_of_mechanism(Random& random) {
  switch (random.below(7)) {
    case 0:
      return BallJoint{};
    case 1:
      return HingeJoint{{.motor = JointMotor{.speed = 1e-6, .max_force = 1e-3}}};
    case 2:
      return random.chance(0.5) ? SliderJoint{} : SliderJoint{{.range = {-0.5, 0.5}}};
    case 3:
      return FixedJoint{};
    case 4:
      return UniversalJoint{};
    case 5:
      return GearJoint{.ratio = random.real(0.2, 5)};
    default:
      return ConeTwistJoint{.swing_limit = 1, .twist = {.range = {-1, 1}}};
  }
}

// A tree that hangs, with loops, light links between heavy ones and long arms: more than sweeps at the defaults hold.
std::vector<BodyId> add_mechanism(World& world, Random& random) {
  std::vector<BodyId> ids;
  const std::uint32_t count = 3 + random.below(8);
  for (std::uint32_t i = 0; i < count; ++i) {
    BodyDef body{.type = i == 0 ? BodyType::Static : BodyType::Dynamic};
    body.shape = Box{{random.real(0.05, 0.4), random.real(0.05, 0.4), random.real(0.05, 0.4)}};
    body.position = random.vector(1.5);
    body.orientation = random.rotation();
    body.filter.mask = 0;
    ids.push_back(world.add_body(body));
  }
  const std::uint32_t joints = count - 1 + random.below(count);
  for (std::uint32_t j = 0; j < joints; ++j) {
    const bool tree = j + 1 < count;
    const BodyId first = ids[random.below(tree ? j + 1 : count)], second = ids[tree ? j + 1 : random.below(count)];
    if (first == second) continue;
    const Vector3 middle = (world.centre_of_mass(first) + world.centre_of_mass(second)) / 2 + random.vector(0.2);
    world.add_joint(joint_at(world, kind_of_mechanism(random), first, second, middle, random.direction()));
  }
  return ids;
}

// A mechanism whose joints come apart falls in pieces that nothing throws. Its motors can give a thousandth of a joule.
TEST(Energy, MechanismsThatSweepsLoseHoldOfGainNone) {
  const std::uint32_t count = long_tests() ? 5000 : 400;
  std::uint32_t lifted = 0;
  for (std::uint32_t seed = 0; seed < count; ++seed) {
    Random random(seed);
    World world({.settings = {.joint_solver = JointSolver::Iterative}});
    const std::vector<BodyId> ids = add_mechanism(world, random);
    double weight = 0;  // N
    for (const BodyId id : ids) weight += world.type(id) == BodyType::Dynamic ? 9.81 * world.mass(id) : 0;
    const double gained = max_energy_gained(world, ids, 300);
    EXPECT_LT(gained, 0.2 * weight) << "seed " << seed << ": what lifts all of it by 20 cm";
    lifted += gained > 0.05 * weight;
  }
  EXPECT_LE(lifted, count / 2000);
}

TEST(Energy, RodsShotAtAWallGainNone) {
  for (const double speed : {100.0, 1000.0}) {
    for (const bool continuous : {false, true}) {
      SCOPED_TRACE(std::to_string(speed) + (continuous ? " m/s, continuous" : " m/s"));
      World world({.gravity = Vector3::Zero()});
      world.add_body(static_box({0, 0, 0}, {0.001, 50, 50}));
      std::vector<BodyId> ids;
      for (int i = 0; i < 100; ++i) {
        BodyDef rod{.shape = Capsule{.radius = 0.01, .half_height = 0.5}, .position = {-1, 0.0201 * i, 0}};
        const auto askew = [&](double ratio) { return 0.5 * (std::fmod(ratio * i, 1.0) - 0.5); };
        rod.orientation =
            Eigen::AngleAxisd(askew(0.618034), Vector3::UnitZ()) * Eigen::AngleAxisd(askew(0.414214), Vector3::UnitY());
        rod.velocity = {speed, 0, 0};
        rod.continuous = continuous;
        ids.push_back(world.add_body(rod));
      }
      const double start = mechanical_energy(world, ids);
      for (int i = 0; i < 120; ++i) {
        ASSERT_EQ(world.step(dt).quarantined, 0) << "step " << i;
        ASSERT_LT(mechanical_energy(world, ids), 1.05 * start) << "step " << i;
      }
    }
  }
}

}  // namespace
}  // namespace atl::test
