// A world of a batch comes to its own bits: wherever it is among however many others, on whatever threads and
// instruction set.

#include <atoll/batch.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "checks/divergence/variant_run.h"
#include "world/simd_names.h"

namespace atl::test::batch_test {
namespace {

constexpr double dt = 1.0 / 60;
constexpr std::size_t kinds = 13;

// Makes worlds of one kind different from those of the others.
void make_kind(World& world, std::size_t kind) {
  const auto x = static_cast<double>(kind);
  for (const BodyId body : world.bodies()) {
    if (world.type(body) != BodyType::Dynamic) continue;
    world.set_velocity(body, {0.1 * x, 0.03 * x, 0}, {0, 0.2 * x, 0.1});
    world.set_mass(body, 1 + 0.25 * x);
    world.set_material(body, {.friction = 0.2 + 0.05 * x});
  }
}

std::uint64_t alone(const Scene& scene, std::size_t kind, int steps) {
  World world({.gravity = scene.gravity, .settings = scene.settings});
  const std::vector<BodyId> ids = build_scene(scene, world);
  make_kind(world, kind);
  for (int i = 0; i < steps; ++i) {
    apply_forces(scene, world, ids);
    world.step(dt);
  }
  return world.state_hash();
}

// Every place once, in an order that is the same on every machine.
std::vector<std::size_t> shuffled(std::size_t size) {
  std::vector<std::size_t> order(size);
  std::iota(order.begin(), order.end(), 0);
  std::mt19937 random(static_cast<std::uint32_t>(size));
  for (std::size_t i = size; i > 1; --i) std::swap(order[i - 1], order[random() % i]);
  return order;
}

void expect_own_bits(const std::string& text, const std::vector<std::size_t>& sizes, int steps) {
  Scene scene = load_scene(text);
  scene.settings.simd = Simd::Portable;
  std::vector<std::uint64_t> expected;
  for (std::size_t kind = 0; kind < kinds; ++kind) expected.push_back(alone(scene, kind, steps));
  ASSERT_NE(expected[0], expected[1]);
  for (const std::size_t size : sizes) {
    const std::vector<std::size_t> order = shuffled(size);
    for (const int threads : {1, 2, 3}) {
      Batch batch(scene, size, threads);
      for (const Simd simd : divergence::supported_simds()) {
        Settings settings = scene.settings;
        settings.simd = simd;
        batch.reset();
        batch.for_each([&](World& world, std::size_t place) {
          world.set_settings(settings);
          make_kind(world, order[place] % kinds);
        });
        batch.step(dt, steps);
        ASSERT_EQ(batch.world(size - 1).simd(), simd);
        const std::vector<std::uint64_t> hashes = batch.hashes();
        for (std::size_t place = 0; place < size; ++place) {
          ASSERT_EQ(hashes[place], expected[order[place] % kinds])
              << text << ": world " << place << " of " << size << " with " << threads << " threads on "
              << name_of(simd);
        }
      }
    }
  }
}

TEST(BatchIndependence, WorldsOfManyBodies) {
  for (const char* scene : {"pile:bodies=6", "vehicle", "ragdolls:count=1", "rocks:bodies=4"}) {
    expect_own_bits(scene, {1, 7, 64}, 12);
  }
}

TEST(BatchIndependence, ThousandsOfSmallWorlds) { expect_own_bits("stack:height=2", {4096}, 2); }

}  // namespace
}  // namespace atl::test::batch_test
