// Impacts that happen together are solved together: energy is kept, and answers are as symmetric as the scene.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "support/bodies.h"
#include "support/random_assembly.h"

namespace atl::test::impact_test {
namespace {

constexpr double radius = 0.5;

BodyDef ball(const Vector3& position, double restitution, double friction = 0) {
  BodyDef def = sphere(position, radius);
  def.mass = 1;
  def.material = {.friction = friction, .restitution = restitution};
  return def;
}

// Balls in rows of 1, 2, 3, ..., which a ball of 8 m/s hits at their tip.
struct Rack {
  World world;
  std::vector<BodyId> ids;
  std::vector<std::pair<std::size_t, std::size_t>> mirrored;  // places in ids

  Rack(int rows, double restitution, double friction, const Settings& settings, int threads = 1)
      : world({.gravity = Vector3::Zero(), .threads = threads, .settings = settings}) {
    constexpr double pitch = radius + 0.5e-4;  // nearly touching
    BodyDef cue = ball({-3, 0, 0}, restitution, friction);
    cue.velocity = {8, 0, 0};
    ids.push_back(world.add_body(cue));
    mirrored.push_back({0, 0});
    for (int row = 0; row < rows; ++row) {
      const std::size_t first = ids.size();
      for (int i = 0; i <= row; ++i) {
        ids.push_back(
            world.add_body(ball({row * std::sqrt(3) * pitch, (2 * i - row) * pitch, 0}, restitution, friction)));
        mirrored.push_back({first + i, first + row - i});
      }
    }
  }
  // The largest energy relative to that at the start, and the largest difference of a velocity from its mirror image.
  std::pair<double, double> run_for(int steps) {
    const double start = mechanical_energy(world, ids);
    double max = 0;
    for (int i = 0; i < steps; ++i) {
      world.step(dt);
      max = std::max(max, mechanical_energy(world, ids) / start);
    }
    double apart = 0;
    for (const auto& [a, b] : mirrored) {
      const Vector3 image = world.velocity(ids[b]).cwiseProduct(Vector3(1, -1, 1));
      apart = std::max(apart, (world.velocity(ids[a]) - image).norm());
    }
    return {max, apart};
  }
};

std::vector<Settings> all_ways() {
  std::vector<Settings> ways;
  for (const Stabilisation stabilisation :
       {Stabilisation::Soft, Stabilisation::Baumgarte, Stabilisation::SplitImpulse}) {
    for (const ContactSolver solver : {ContactSolver::Auto, ContactSolver::Direct, ContactSolver::Iterative}) {
      ways.push_back({.stabilisation = stabilisation, .contact_solver = solver});
      ways.push_back({.substeps = 1, .iterations = 3, .stabilisation = stabilisation, .contact_solver = solver});
    }
  }
  return ways;
}

TEST(Impact, ABreakKeepsItsEnergyAndItsSymmetry) {
  for (const Settings& settings : all_ways()) {
    for (const double restitution : {1.0, 0.95, 0.5}) {
      for (const double friction : {0.0, 0.3}) {
        Rack rack(5, restitution, friction, settings);
        const auto [max, apart] = rack.run_for(180);
        SCOPED_TRACE(testing::Message() << "e " << restitution << ", friction " << friction << ", stabilisation "
                                        << static_cast<int>(settings.stabilisation) << ", substeps "
                                        << settings.substeps);
        EXPECT_LT(max, 1 + 1e-5);
        // Friction takes many sweeps to settle.
        EXPECT_LT(apart, friction > 0 ? 2e-3 : 1e-9);
        Vector3 momentum = Vector3::Zero();
        for (const BodyId id : rack.ids) momentum += rack.world.velocity(id);
        EXPECT_LT((momentum - Vector3(8, 0, 0)).norm(), 1e-4);
        if (restitution == 1 && friction == 0) {
          EXPECT_NEAR(mechanical_energy(rack.world, rack.ids), 32, 1e-3);
        }
      }
    }
  }
}

TEST(Impact, IsTheSameOnAnyNumberOfThreads) {
  Rack one(12, 0.9, 0.1, {}, 1), two(12, 0.9, 0.1, {}, 2);
  one.run_for(120);
  two.run_for(120);
  EXPECT_EQ(one.world.state_hash(), two.world.state_hash());
}

// Both take the normal part of it at once: by Newton's law 2 u / (2 + 2 cos^2) for each normal.
TEST(Impact, OneIntoTwoParts) {
  World world({.gravity = Vector3::Zero()});
  BodyDef comes = ball({-3, 0, 0}, 1);
  comes.velocity = {8, 0, 0};
  const BodyId id = world.add_body(comes);
  const double away = std::sqrt(3) * radius;
  const BodyId a = world.add_body(ball({away, radius + 1e-4, 0}, 1));
  const BodyId b = world.add_body(ball({away, -radius - 1e-4, 0}, 1));
  run(world, 120);
  EXPECT_NEAR(world.velocity(a).x(), 4.8, 1e-2);
  EXPECT_EQ(world.velocity(a).x(), world.velocity(b).x());
  EXPECT_EQ(world.velocity(a).y(), -world.velocity(b).y());
  EXPECT_NEAR(world.velocity(id).x(), 8 - 9.6, 1e-2);
}

TEST(Impact, IsHandedOnByWhatTouches) {
  for (const double gap : {0.0, 1e-6, 1e-4, 1e-2}) {
    for (const int count : {2, 5, 40}) {
      World world({.gravity = Vector3::Zero()});
      std::vector<BodyId> ids;
      for (int i = 0; i < count; ++i) ids.push_back(world.add_body(ball({i * (1 + gap), 0, 0}, 1)));
      BodyDef comes = ball({-2, 0, 0}, 1);
      comes.velocity = {1, 0, 0};
      ids.insert(ids.begin(), world.add_body(comes));
      for (int i = 0; i < 240; ++i) world.step(dt);
      for (const BodyId id : ids) {
        const double right = id == ids.back() ? 1 : 0;
        EXPECT_NEAR(world.velocity(id).x(), right, 1e-6) << "gap " << gap << ", of " << count;
      }
    }
  }
}

// A box that is dropped on a corner, without friction, tumbles on for ever.
TEST(Impact, AnElasticBoxKeepsItsEnergy) {
  for (const Settings& settings : {Settings{}, Settings{.substeps = 16}}) {
    World world({.settings = settings});
    const Material material{.friction = 0, .restitution = 1};
    BodyDef floor = static_box({0, 0, -1}, {100, 100, 1});
    floor.material = material;
    world.add_body(floor);
    BodyDef box{.shape = Box{{0.3, 0.4, 0.5}}, .position = {0, 0, 3}, .material = material};
    box.orientation = Quaternion(0.9, 0.3, 0.2, 0.1).normalized();
    const std::vector<BodyId> ids = {world.add_body(box)};
    const double start = mechanical_energy(world, ids);
    for (int i = 0; i < 6000; ++i) {
      world.step(dt);
      ASSERT_NEAR(mechanical_energy(world, ids) / start, 1, 0.01) << i;
    }
  }
}

// Balls that have bounced push no more: two that lie side by side stay, once a blow has gone through them.
TEST(Impact, LeavesNothingThatPushes) {
  Rack rack(1, 1, 0, {});
  rack.run_for(180);
  EXPECT_NEAR(rack.world.velocity(rack.ids[0]).norm(), 0, 1e-6);
  EXPECT_NEAR(rack.world.velocity(rack.ids[1]).x(), 8, 1e-5);
}

}  // namespace
}  // namespace atl::test::impact_test
