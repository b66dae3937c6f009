#pragma once
/// Runs that come to the same bits however they are continued: on any threads and instruction set, from a snapshot in
/// the same world and in an empty one, and from a recording.

#include <atoll/recording.h>
#include <atoll/scene.h>
#include <atoll/snapshot.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "support/temporary_file.h"
#include "support/variants.h"

namespace atl::test {

/// Makes a step of a world, given its number.
using MakeStep = std::function<void(World&, int)>;

struct ContinuedRun {
  std::function<MakeStep(World&)> fill;  ///< what it returns steps restored worlds, too
  Settings settings;
  int steps = 60;
  std::function<void(World&)> equip = [](World&) {};  ///< gives a world its functions, which are no state
};

inline MakeStep fill_scene(World& world, const Scene& scene) {
  world.set_gravity(scene.gravity);
  const std::vector<BodyId> ids = build_scene(scene, world);
  return [scene, ids](World& of, int) {
    apply_forces(scene, of, ids);
    of.step(scene.dt);
  };
}

/// Returns the hashes after each step.
inline std::vector<std::uint64_t> expect_same_bits(
    const ContinuedRun& run, const std::vector<divergence::Variant>& variants = variants_of({2, 1})) {
  const auto make = [&](const divergence::Variant& variant) {
    Settings settings = run.settings;
    settings.simd = variant.simd;
    World world({.threads = variant.threads, .settings = settings});
    run.equip(world);
    return world;
  };
  const auto expect_trail = [&](World& world, const MakeStep& step, const std::vector<std::uint64_t>& trail, int from,
                                const std::string& how) {
    for (int i = from; i < run.steps; ++i) {
      step(world, i);
      ASSERT_EQ(world.state_hash(), trail[static_cast<std::size_t>(i)]) << how << ", step " << i;
    }
  };
  const TemporaryFile file(".continued");
  std::vector<std::uint64_t> trail;
  World first = make({});
  const MakeStep step = run.fill(first);
  first.record(file.path());
  Snapshot half;
  for (int i = 0; i < run.steps; ++i) {
    if (i == run.steps / 2) first.save(half);
    step(first, i);
    trail.push_back(first.state_hash());
  }
  first.stop_recording();
  EXPECT_EQ(first.quarantined().size(), 0u);
  for (const divergence::Variant& variant : variants) {
    World other = make(variant);
    const MakeStep its_step = run.fill(other);
    expect_trail(other, its_step, trail, 0, std::to_string(variant.threads) + " threads on " + name_of(variant.simd));
    const ReplayResult replayed = replay(file.path(), {.threads = variant.threads, .simd = variant.simd});
    EXPECT_FALSE(replayed.divergence.has_value()) << "replayed with " << variant.threads << " threads";
    EXPECT_EQ(replayed.hash, trail.back());
  }
  World empty = make({.threads = 2});
  for (World* world : {&first, &empty}) {
    run.equip(*world);
    world->restore(half);
    EXPECT_TRUE(world->sensor_events().empty()) << "of a step that this state doesn't know";
    expect_trail(*world, step, trail, run.steps / 2, world == &empty ? "in an empty world" : "continued");
  }
  return trail;
}

}  // namespace atl::test
