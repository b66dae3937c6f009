#include <atoll/queries.h>

#include "trials.h"

namespace atl::soak {
namespace {

constexpr int max_steps = 6;

std::uint64_t hash_after(World& world, int steps) {
  for (int i = 0; i < steps; ++i) world.step(step_length);
  return world.state_hash();
}

void expect_same(std::uint64_t a, std::uint64_t b, const char* what, SoakTally& tally) {
  ++tally.hash_checks;
  if (a != b) throw CheckFailed(what);
}

// Makes changes that restoring the state must undo.
void disturb(World& world, Random& random) {
  const std::vector<BodyId> bodies = world.bodies();
  const BodyId gone = bodies[pick(random, bodies.size())];
  if (world.type(gone) == BodyType::Dynamic) world.remove_body(gone);
  world.add_body({.shape = Sphere{0.3}, .position = {random.uniform(-9, 9), random.uniform(-9, 9), 14}});
  const std::vector<JointId> joints = world.joints();
  if (!joints.empty()) world.remove_joint(joints[pick(random, joints.size())]);
}

}  // namespace

std::int64_t Rollback::check(Random& random, SoakTally& tally) {
  World& world = twin_.first();
  const int steps = 1 + static_cast<int>(pick(random, max_steps));
  world.save(snapshot_);
  const std::uint64_t before = world.state_hash();
  const std::uint64_t after = hash_after(world, steps);
  world.restore(snapshot_);
  expect_same(world.state_hash(), before, "a state that was taken back has another hash", tally);
  disturb(world, random);
  hash_after(world, 2);
  world.restore(snapshot_);
  expect_same(world.state_hash(), before, "a state that was taken back has another hash, after bodies came and went",
              tally);
  expect_same(hash_after(world, steps), after, "steps from a state that was taken back came to something else", tally);
  world.restore(snapshot_);
  ++tally.rollbacks;
  return 2 * steps + 2;
}

void Rollback::check_fresh(const std::function<void(World&)>& set_functions, SoakTally& tally) {
  World& world = twin_.second();
  world.save(snapshot_);
  World fresh({.threads = 1, .settings = {.simd = world.settings().simd}});
  fresh.restore(snapshot_);
  set_functions(fresh);
  expect_same(fresh.state_hash(), world.state_hash(), "a world that was empty restored another state", tally);
  const std::uint64_t hash = hash_after(fresh, 3);
  expect_same(hash_after(world, 3), hash, "a world that was empty came to something else once it was restored", tally);
  world.restore(snapshot_);
  ++tally.rollbacks;
}

}  // namespace atl::soak
