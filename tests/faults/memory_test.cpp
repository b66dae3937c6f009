// Memory that runs out at each place where a call asks for some: that goes through as std::bad_alloc, nothing leaks,
// and either nothing has changed or the world says that it is half done. Restored, it goes on as if nothing had been.

#include <atoll/atoll.h>
#include <atoll/recording.h>
#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "allocation_count.h"
#include "support/bodies.h"
#include "support/temporary_file.h"

namespace atl::test {
namespace {

/// A world with all kinds of shapes and joints on the move, and one step further.
struct Start {
  std::vector<BodyId> ids;
  std::vector<JointId> joints;
  Snapshot now;
  std::uint64_t hash = 0;
  std::uint64_t next_hash = 0;
  Settings settings = {.sleeping = true, .contact_events = true};

  Start() {
    World world({.settings = settings});
    const auto add = [&](const BodyDef& def) { return ids.emplace_back(world.add_body(def)); };
    add(ground());
    add({.type = BodyType::Static, .shape = hills(), .position = {10, 0, 0}});
    for (int i = 0; i < 5; ++i) add(box({0, 0, 0.31 + 0.6 * i}, {0.3, 0.3, 0.3}));
    add(sphere({12, 2.2, 1.2}, 0.3));
    add({.shape = Capsule{0.2, 0.3}, .position = {13, 3.2, 1.2}, .velocity = {1, 0, -5}, .continuous = true});
    const std::vector<Vector3> corners = {{0.4, 0.4, -0.5}, {-0.4, 0.4, -0.5}, {0, -0.5, -0.5}, {0.1, 0, 0.6}};
    add({.shape = ConvexHull(corners), .position = {3, 0, 0.8}});
    add({.shape = pair_of_solids(), .position = {5, 0, 0.5}});
    add({.type = BodyType::Static, .shape = Box{{1, 1, 1}}, .position = {5, 0, 1}, .sensor = true});
    add(heights());
    BodyId before = add(static_box({-5, 0, 4}, {0.1, 0.1, 0.1}));
    for (int i = 1; i <= 6; ++i) {
      const BodyId next = add(sphere({-5 + 0.5 * i, 0, 4}, 0.2));
      JointKind kind = BallJoint{};
      if (i == 2) kind = HingeJoint{{.range = {-1, 1}, .motor = JointMotor{.speed = 1, .max_force = 10}}};
      const Vector3 between = {-5.25 + 0.5 * i, 0, 4};
      joints.push_back(world.add_joint(joint_at(world, kind, before, next, between, Vector3::UnitY())));
      before = next;
    }
    for (int i = 0; i < 8; ++i) world.step(dt);
    world.save(now);
    hash = world.state_hash();
    world.step(dt);
    next_hash = world.state_hash();
  }

  static TriangleMesh hills() {
    std::vector<Vector3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    for (int i = 0; i < 36; ++i) vertices.emplace_back(i / 6, i % 6, 0.1 * (i % 5));
    for (std::uint32_t i = 0; i < 29; ++i) {
      if (i % 6 == 5) continue;
      triangles.push_back({i, i + 6, i + 7});
      triangles.push_back({i, i + 7, i + 1});
    }
    return TriangleMesh(vertices, triangles);
  }
  static Compound pair_of_solids() {
    return {
        {{.shape = Box{{0.2, 0.3, 0.2}}, .position = {-0.2, 0, 0}}, {.shape = Sphere{0.25}, .position = {0.25, 0, 0}}}};
  }
  static BodyDef heights() {
    return {.type = BodyType::Static,
            .shape = HeightField(4, 4, 1, 1, std::vector<double>(16, 0.1)),
            .position = {20, 0, 0}};
  }
  const BodyId& top() const { return ids[6]; }
};

const Start& start() {
  static const Start made;
  return made;
}

struct Call {
  const char* name;
  std::function<void(World&)> make;
};

void PrintTo(const Call& call, std::ostream* stream) { *stream << call.name; }

const std::string long_name = "a name too long to lie within a string";

std::vector<Call> calls_about_bodies() {
  const BodyId top = start().top(), first = start().ids[2], link = start().ids[14];
  return {
      {"add_body",
       [](World& w) {
         w.add_body({.shape = Box{}, .position = {0, 0, 8}, .name = long_name});
       }},
      {"add_compound",
       [](World& w) {
         w.add_body({.shape = Start::pair_of_solids(), .position = {5, 5, 2}});
       }},
      {"remove_body", [=](World& w) { w.remove_body(first); }},
      {"remove_joined_body", [=](World& w) { w.remove_body(link); }},
      {"remove_compound", [](World& w) { w.remove_body(start().ids[10]); }},
      {"set_definition",
       [=](World& w) {
         BodyDef def = w.definition(top);
         def.shape = Sphere{0.3};
         def.position.x() += 0.1;
         def.name = long_name;
         w.set_definition(top, def);
       }},
      {"set_shape", [=](World& w) { w.set_shape(top, Start::pair_of_solids()); }},
      {"set_heights",
       [](World& w) {
         w.set_heights(start().ids[12], 1, 1, 2, std::vector<double>{0.2, 0.3, 0.1, 0.2});
       }},
      {"set_mass", [=](World& w) { w.set_mass(top, 3); }},
      {"set_material", [=](World& w) { w.set_material(top, {.friction = 0.2, .restitution = 0.3}); }},
      {"set_enabled", [=](World& w) { w.set_enabled(top, false); }},
      {"set_pose",
       [=](World& w) {
         w.set_pose(top, {{0, 3, 3}, Quaternion::Identity()});
       }},
      {"set_velocity",
       [=](World& w) {
         w.set_velocity(top, {0, 3, 3}, {1, 0, 0});
       }},
      {"set_surface_velocity",
       [=](World& w) {
         w.set_surface_velocity(top, {0, 3, 3}, {1, 0, 0});
       }},
      {"apply_force",
       [=](World& w) {
         w.apply_force(top, {0, 3, 3}, {1, 0, 0});
       }},
      {"apply_impulse",
       [=](World& w) {
         w.apply_impulse(top, {0, 3, 3}, {1, 0, 0});
       }},
      {"sleep", [=](World& w) { w.sleep(top); }},
      {"set_filter", [=](World& w) { w.set_filter(top, {.group = -2}); }},
      {"set_name", [=](World& w) { w.set_name(top, long_name); }},
      {"set_collision_enabled", [=](World& w) { w.set_collision_enabled(top, first, false); }},
      {"refilter", [=](World& w) { w.refilter(top); }},
  };
}

std::vector<Call> other_calls() {
  const BodyId top = start().top(), first = start().ids[2];
  const JointId hinge = start().joints[1];
  return {
      {"step", [](World& w) { w.step(dt); }},
      {"step_under_a_law", [=](World& w) { w.step(dt, [=](Forces& forces) {
                                             forces.add(top, {1, 0, 0});
                                           }); }},
      {"step_solved_at_once",
       [](World& w) {
         w.set_settings({.contact_solver = ContactSolver::Direct, .joint_solver = JointSolver::Direct});
         w.step(dt);
       }},
      {"step_to_a_target",
       [](World& w) {
         w.set_settings({.target = {.penetration = 1e-5, .motion = 1e-3}});
         w.step(dt);
       }},
      {"step_with_a_filter",
       [](World& w) {
         w.set_contact_filter([](const ContactCandidate& of) { return of.a.index % 3 != 1; });
         w.step(dt);
       }},
      {"add_joint",
       [=](World& w) {
         w.add_joint(joint_at(w, HingeJoint{}, first, top, {0, 0, 2}, Vector3::UnitZ()));
       }},
      {"remove_joint", [](World& w) { w.remove_joint(start().joints[2]); }},
      {"set_joint",
       [=](World& w) {
         JointDef def = w.joint(hinge);
         def.kind = HingeJoint{{.range = {-0.5, 1}}};
         def.name = long_name;
         def.frame_first.position.x() += 0.01;
         w.set_joint(hinge, def);
       }},
      {"set_motor_speed", [=](World& w) { w.set_motor_speed(hinge, 3); }},
      {"set_joint_enabled", [=](World& w) { w.set_joint_enabled(hinge, false); }},
      {"set_material_pair", [](World& w) { w.set_material_pair({.first = 1, .second = 2, .friction = 0.3}); }},
      {"set_gravity",
       [](World& w) {
         w.set_gravity({1, 0, 0});
       }},
      {"set_threads", [](World& w) { w.set_threads(2); }},
      {"contact_forces",
       [](World& w) {
         w.step(dt);
         (void)w.contact_forces();
         (void)w.contact_wrenches();
       }},
      {"queries",
       [=](World& w) {
         w.set_pose(top, {{0, 3, 3}, Quaternion::Identity()});
         (void)Queries(w).cast_ray({{-20, 0, 0.3}, {40, 0, 0}});
       }},
      {"save",
       [](World& w) {
         Snapshot snapshot;
         w.save(snapshot);
       }},
      {"hashes",
       [](World& w) {
         (void)w.state_hash();
         (void)w.body_hashes();
       }},
      {"restore", [](World& w) { w.restore(start().now); }},
      {"restore_other_bodies",
       [=](World& w) {
         w.remove_body(first);
         w.restore(start().now);
       }},
  };
}

std::vector<Call> all_calls() {
  std::vector<Call> calls = calls_about_bodies();
  for (Call& call : other_calls()) calls.push_back(std::move(call));
  return calls;
}

/// The end of a call that had memory for so many allocations.
struct Outcome {
  bool enough, threw;
};
Outcome outcome_of(const std::function<void()>& make, std::int64_t allocations, bool for_good) {
  const OutOfMemory out(allocations, for_good);
  try {
    make();
  } catch (const std::bad_alloc&) {
    return {false, true};
  }
  return {!OutOfMemory::happened(), false};
}

/// A world as the start left it.
World started(int threads) {
  World world({.threads = threads, .settings = start().settings});
  world.restore(start().now);
  return world;
}

/// Makes the call with memory for so many allocations. Returns whether they were enough.
bool survives(const Call& call, int threads, std::int64_t allocations, bool for_good) {
  World world = started(threads);
  const auto [enough, threw] = outcome_of([&] { call.make(world); }, allocations, for_good);
  if (enough) return true;
  // Some algorithms do without the memory that they would have liked to have.
  EXPECT_TRUE(threw || !for_good) << call.name << ", " << allocations;
  try {
    world.step(dt);
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()),
              "World::step: memory ran out within an earlier call; expected the world to be "
              "restored, or destroyed");
    EXPECT_THROW((void)world.state_hash(), Error);
    EXPECT_THROW(world.set_gravity({0, 0, 0}), Error);
  }
  world.restore(start().now);
  world.set_settings(start().settings);
  world.set_gravity({0, 0, -g});
  world.set_contact_filter({});
  EXPECT_EQ(world.state_hash(), start().hash) << call.name << ", " << allocations;
  world.step(dt);
  EXPECT_EQ(world.state_hash(), start().next_hash) << call.name << ", " << allocations;
  return false;
}

class MemoryRunsOut : public testing::TestWithParam<Call> {};

TEST_P(MemoryRunsOut, AndTheWorldGoesOnOnceRestored) {
  const Call& call = GetParam();
  const auto run = [&](int threads, bool for_good) {
    for (std::int64_t allocations = 0; !survives(call, threads, allocations, for_good); ++allocations) {
      ASSERT_LT(allocations, 3000);
      if (testing::Test::HasFailure()) return;
    }
  };
  run(2, false);
  run(1, false);
  run(1, true);
  const std::int64_t before = live_allocations();
  run(1, false);
  run(1, true);
  EXPECT_EQ(live_allocations(), before) << "allocations that nobody gave back";
}

INSTANTIATE_TEST_SUITE_P(Calls, MemoryRunsOut, testing::ValuesIn(all_calls()),
                         [](const auto& of) { return std::string(of.param.name); });

// Shapes, scenes and the like are made or not. JSON is left out: destructors of the library that reads and writes it
// ask for memory, and end the program if there is none.
TEST(MemoryRunsOutOf, WhatMakesThings) {
  const std::vector<Vector3> corners = {{0.4, 0.4, -0.5}, {-0.4, 0.4, -0.5}, {0, -0.5, -0.5}, {0.1, 0, 0.6}};
  const Scene scene = load_scene("ragdolls:count=2");
  const std::vector<std::byte> bytes = start().now.to_bytes();
  const std::vector<std::pair<const char*, std::function<void()>>> makers = {
      {"ConvexHull", [&] { (void)ConvexHull(corners); }},
      {"TriangleMesh", [] { (void)Start::hills(); }},
      {"HeightField", [] { (void)Start::heights(); }},
      {"load_scene", [] { (void)load_scene("vehicle"); }},
      {"Snapshot", [&] { (void)Snapshot::from_bytes(bytes); }},
      {"Batch", [&] { (void)Batch(scene, 2, 1); }},
      {"Mechanism",
       [] {
         World world = started(1);
         (void)Mechanism(world, start().ids[13]).mass_matrix();
       }},
  };
  for (const auto& [name, make] : makers) {
    const auto run = [make = make](std::int64_t step) {
      std::int64_t allocations = 0;
      while (!outcome_of(make, allocations, false).enough) allocations += step;
    };
    run(7);
    const std::int64_t before = live_allocations();
    run(7);
    EXPECT_EQ(live_allocations(), before) << name;
  }
}

// A snapshot that couldn't be taken holds nothing, and no part of what it held.
TEST(MemoryRunsOutOf, ASnapshot) {
  World world = started(1);
  Snapshot snapshot;
  for (std::int64_t allocations = 0;; ++allocations) {
    world.add_body(sphere({0, 0, 10}, 0.1));
    if (!outcome_of([&] { world.save(snapshot); }, allocations, true).threw) break;
    World other({.settings = start().settings});
    if (!snapshot.empty()) other.restore(snapshot);
  }
  EXPECT_FALSE(snapshot.empty());
}

// All calls that a recording has are those that were made.
TEST(MemoryRunsOutOf, ARecordedWorld) {
  const TemporaryFile file(".recording");
  for (std::int64_t allocations = 0;; allocations += 3) {
    World world = started(1);
    const auto act = [&] {
      world.record(file.path());
      world.set_velocity(start().top(), {0, 3, 3}, {1, 0, 0});
      world.step(dt);
      world.set_name(start().top(), long_name);
    };
    const bool threw = outcome_of(act, allocations, false).threw;
    if (!world.is_recording()) continue;
    world.restore(start().now);
    world.step(dt);
    world.stop_recording();
    const ReplayResult replayed = replay(file.path());
    EXPECT_FALSE(replayed.divergence.has_value()) << allocations;
    EXPECT_EQ(replayed.hash, start().next_hash) << allocations;
    if (!threw) break;
  }
}

// Worlds of a batch are half done each by itself.
TEST(MemoryRunsOutOf, ABatch) {
  Batch batch(load_scene("ragdolls:count=1"), 4, 2);
  batch.step(dt, 3);
  batch.save_start();
  batch.step(dt);
  const std::uint64_t next = batch.world(0).state_hash();
  for (std::int64_t allocations = 0;; ++allocations) {
    batch.for_each([](World& world, std::size_t) { world.set_settings({.sleeping = true}); });
    const bool threw = outcome_of([&] { batch.step(dt); }, allocations, false).threw;
    batch.reset();
    batch.step(dt);
    for (std::size_t i = 0; i < batch.size(); ++i) {
      EXPECT_EQ(batch.world(i).state_hash(), next) << allocations << ", world " << i;
    }
    if (!threw) break;
  }
}

}  // namespace
}  // namespace atl::test
