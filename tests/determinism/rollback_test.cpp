// A world goes on from a snapshot as the one that was saved did: same hash at once and after every step, whatever
// happened to the world in between, in a world of its own, from a file, and on any number of threads.

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "support/bodies.h"
#include "support/long_tests.h"
#include "support/random.h"
#include "support/scene_run.h"
#include "support/scenes.h"

namespace atl::test::rollback_test {
namespace {

constexpr int steps_after = 12;

/// A run: a scene, with forces if it has some, and settings that turn on every kind of state.
struct Run {
  SceneRun scene;

  enum class Features { Plain, All, Targets };

  Run(const std::string& text, Features features, int threads, Simd simd = Simd::Auto)
      : scene(text, {.threads = threads, .settings = settings_of(text, features, simd)}) {}

  static Settings settings_of(const std::string& text, Features features, Simd simd) {
    Settings settings = load_scene(text).settings;
    settings.simd = simd;
    if (features == Features::Targets) settings.target = all_targets();
    if (features != Features::Plain) {
      settings.sleeping = true;
      settings.time_to_sleep = 0.1;
      settings.contact_events = true;
    }
    return settings;
  }

  void step() {
    apply_forces(scene.scene, scene.world, scene.ids);
    scene.world.step(scene.scene.dt);
  }
  World& world() { return scene.world; }
};

/// Hashes of the world's state and its events after each step.
std::vector<std::uint64_t> trail(Run& run) {
  std::vector<std::uint64_t> hashes = {run.world().state_hash()};
  for (int i = 0; i < steps_after; ++i) {
    run.step();
    hashes.push_back(run.world().state_hash());
    if (run.world().settings().contact_events) hashes.push_back(run.world().contact_events().size());
    double force = 0;
    for (const ContactForce& point : run.world().contact_forces()) {
      force += point.normal_force * point.position.x() + point.separation;
    }
    hashes.push_back(std::bit_cast<std::uint64_t>(force));
  }
  return hashes;
}

/// Changes that a world may go through before it is taken back.
void disturb(Run& run, Random& choices) {
  World& world = run.world();
  switch (choices.below(5)) {
    case 0:
      break;
    case 1: {
      const BodyId id =
          run.scene.ids[static_cast<std::size_t>(choices.below(static_cast<std::uint32_t>(run.scene.ids.size())))];
      if (world.contains(id)) world.remove_body(id);
      break;
    }
    case 2:
      for (int i = 0; i < 3; ++i) world.add_body(sphere({0.3 * i, 0.2, 4.0 + i}, 0.3));
      break;
    case 3: {
      const BodyId other = world.add_body(box({0.1, 0.1, 5}));
      run.step();
      world.remove_body(other);
      world.set_gravity({1, 0, -5});
      break;
    }
    default:
      world.set_settings({.substeps = 2, .sleeping = false});
      for (const BodyId id : run.scene.ids) {
        if (world.contains(id) && world.type(id) == BodyType::Dynamic) world.apply_force(id, {0, 0, 1e3});
      }
  }
  for (std::uint32_t i = choices.below(8); i > 0; --i) world.step(run.scene.scene.dt);
}

std::filesystem::path file_of(const std::string& text, std::uint64_t seed) {
  return std::filesystem::temp_directory_path() /
         ("atoll-rollback-" + case_name(text) + "-" + std::to_string(seed) + ".snapshot");
}

/// Saves at a step and goes on; goes on again from the snapshot, in one of several ways.
void roll_back(const std::string& text, std::uint64_t seed) {
  Random choices(static_cast<std::uint32_t>(seed));
  const auto features = static_cast<Run::Features>(choices.below(3));
  const int before = static_cast<int>(choices.below(60));
  SCOPED_TRACE(text + ", seed " + std::to_string(seed) + ", step " + std::to_string(before));
  Run run(text, features, 1 + static_cast<int>(choices.below(3)));
  for (int i = 0; i < before; ++i) run.step();
  Snapshot snapshot;
  run.world().save(snapshot);
  const std::uint64_t saved = run.world().state_hash();
  const std::vector<std::uint64_t> expected = trail(run);
  ASSERT_EQ(expected.front(), saved) << "to save changes nothing";

  switch (choices.below(3)) {
    case 0: {
      disturb(run, choices);
      run.world().restore(snapshot);
      EXPECT_EQ(trail(run), expected) << "the same world";
      break;
    }
    case 1: {
      Run fresh(text, features, 1 + static_cast<int>(choices.below(3)),
                choices.below(2) == 0 ? Simd::Auto : Simd::Portable);
      for (std::uint32_t i = choices.below(20); i > 0; --i) fresh.step();
      fresh.world().restore(snapshot);
      EXPECT_EQ(trail(fresh), expected) << "another world";
      break;
    }
    default: {
      const std::filesystem::path file = file_of(text, seed);
      snapshot.write(file);
      Run fresh(text, features, 1 + static_cast<int>(choices.below(3)),
                choices.below(2) == 0 ? Simd::Auto : Simd::Portable);
      // Files hold no geometry: what has a hull of its own is to stay.
      const Shape shape = fresh.world().definition(fresh.scene.ids.back()).shape;
      const bool may_go = !std::holds_alternative<ConvexHull>(shape) && !std::holds_alternative<Compound>(shape);
      if (choices.below(2) == 1 && may_go) fresh.world().remove_body(fresh.scene.ids.back());
      fresh.world().restore(Snapshot::read(file));
      std::filesystem::remove(file);
      EXPECT_EQ(trail(fresh), expected) << "another world, by way of a file";
    }
  }
}

class RollbackTest : public testing::TestWithParam<std::string> {};

TEST_P(RollbackTest, GoesOnAsSaved) {
  const std::uint64_t max = long_tests() ? 25 : 8;
  for (std::uint64_t seed = 1; seed <= max; ++seed) {
    roll_back(GetParam(), seed);
    if (HasFatalFailure() || HasNonfatalFailure()) return;
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, RollbackTest, testing::ValuesIn(small_scenes()),
                         [](const auto& scene) { return case_name(scene.param); });

// Random scenes and steps, their number given by the environment.
TEST(Rollback, ManyAtRandom) {
  const char* asked = std::getenv("ATOLL_ROLLBACKS");
  const int count = asked != nullptr ? std::atoi(asked) : 0;
  if (count <= 0) GTEST_SKIP() << "ATOLL_ROLLBACKS=1000 runs as many";
  const std::vector<std::string> scenes = small_scenes();
  Random choices(7);
  for (int i = 0; i < count; ++i) {
    roll_back(scenes[static_cast<std::size_t>(choices.below(static_cast<std::uint32_t>(scenes.size())))],
              1000 + static_cast<std::uint64_t>(i));
    if (HasFatalFailure() || HasNonfatalFailure()) return;
  }
}

// The direct solvers' caches of islands are no part of a state: here those of contacts of a hinge whose end bounces.
TEST(Rollback, AnIslandSolvedAtOnceKeepsNothingOfAnother) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Random choices(static_cast<std::uint32_t>(seed));
    World world({.settings = {.contact_solver = ContactSolver::Direct, .joint_solver = JointSolver::Direct}});
    world.add_body(static_box({0, 0, -1}, {10, 10, 1}));
    const BodyId a = world.add_body(box({0, 0, 0.2}, {0.3, 0.2, 0.2}));
    const BodyId b = world.add_body(box({0.7, 0, 0.25}, {0.3, 0.2, 0.1}));
    const HingeJoint hinge{.angle = {.range = {.lower = -0.2, .upper = 0.2, .restitution = 0.5}}};
    world.add_joint(joint_at(world, hinge, a, b, {0.35, 0, 0.2}, Vector3::UnitY()));
    run(world, 20);
    Snapshot snapshot;
    world.save(snapshot);
    run(world, 5);
    const std::uint64_t after = world.state_hash();
    world.restore(snapshot);
    world.set_velocity(a, choices.vector(1), 3 * choices.vector(1));
    world.set_velocity(b, choices.vector(1) + Vector3::UnitZ(), choices.vector(1));
    run(world, 2);
    world.restore(snapshot);
    run(world, 5);
    EXPECT_EQ(world.state_hash(), after) << seed;
  }
}

}  // namespace
}  // namespace atl::test::rollback_test
