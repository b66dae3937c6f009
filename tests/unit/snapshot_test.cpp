// Snapshots: what they bring back, what they refuse, and their files.

#include <atoll/atoll.h>
#include <gtest/gtest.h>
#include <jobs/hash.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "recorded_yard.h"
#include "state/files.h"
#include "support/bodies.h"
#include "support/expect_error.h"
#include "support/long_tests.h"
#include "support/temporary_file.h"

namespace atl::test {
namespace {

namespace fs = std::filesystem;

std::vector<std::uint64_t> hashes(World& world, int steps) {
  std::vector<std::uint64_t> all = {world.state_hash()};
  for (int i = 0; i < steps; ++i) {
    world.step(dt);
    all.push_back(world.state_hash());
  }
  return all;
}

TEST(Snapshot, BringsBackTheSameWorldWhateverHappenedToIt) {
  Yard yard;
  run(yard.world, 20);
  Snapshot snapshot;
  yard.world.save(snapshot);
  const std::vector<std::uint64_t> expected = hashes(yard.world, 20);
  const auto expect_back = [&](const char* after) {
    yard.world.restore(snapshot);
    EXPECT_EQ(hashes(yard.world, 20), expected) << after;
  };
  expect_back("nothing");
  yard.world.remove_body(yard.ids[4]);
  expect_back("a hull was removed");
  yard.world.remove_body(yard.ids[2]);
  run(yard.world, 3);
  expect_back("a body went with its joint");
  yard.world.remove_body(yard.ids[4]);
  yard.world.add_body(sphere({9, 9, 9}));
  yard.world.add_body(sphere({9, 9, 12}));
  run(yard.world, 3);
  expect_back("the place was taken by another");
  yard.world.remove_joint(yard.hinge);
  yard.world.add_joint({.first = yard.ids[1], .second = yard.ids[4]});
  expect_back("another joint");
  yard.world.set_joint(yard.hinge, HingeJoint{{.motor = JointMotor{.speed = 3, .max_force = 10}}});
  run(yard.world, 3);
  expect_back("a motor");
  yard.world.set_joint_enabled(yard.hinge, false);
  expect_back("a joint that was let go");
  yard.world.set_filter(yard.ids[1], {.mask = 0});
  yard.world.set_collision_enabled(yard.ids[0], yard.ids[4], false);
  run(yard.world, 3);
  expect_back("filters");
  yard.world.set_velocity(yard.ids[3], {1e9, 0, 0}, {0, 0, 0});
  run(yard.world, 3);
  ASSERT_FALSE(yard.world.quarantined().empty());
  expect_back("quarantine");
  yard.world.set_gravity({0, 0, 1});
  yard.world.set_settings({.substeps = 2, .sleeping = true, .contact_events = true});
  run(yard.world, 3);
  expect_back("settings");
  yard.world.set_surface_velocity(yard.ids[0], {1, 0, 0}, {0, 0, 1});
  run(yard.world, 3);
  expect_back("a belt");
}

TEST(Snapshot, TakesAwayJointsThatCameLater) {
  for (const bool solved : {false, true}) {
    World world({.settings = {.sleeping = true}});
    world.add_body(ground());
    const std::vector<BodyId> crates = add_stack(world, 3);
    run(world, 10);
    Snapshot snapshot;
    world.save(snapshot);
    const std::vector<std::uint64_t> expected = hashes(world, 20);
    const JointId weld = world.add_joint({.kind = FixedJoint{}, .first = crates[0], .second = crates[2]});
    world.add_joint({.first = crates[1], .second = crates[2]});
    if (solved) run(world, 3);
    world.restore(snapshot);
    EXPECT_FALSE(world.contains(weld));
    EXPECT_EQ(hashes(world, 20), expected) << (solved ? "after steps" : "at once");
    EXPECT_EQ(world.add_joint({.first = crates[0], .second = crates[1]}).index, 0u);
  }
}

// Nothing that is done before the next step may make it forget that they are gone.
TEST(Snapshot, JointsThatWereTakenAwayStayAwayWhateverIsSetThen) {
  for (const JointSolver solver : {JointSolver::Iterative, JointSolver::Direct}) {
    World world({.settings = {.sleeping = true}});
    world.add_body(ground());
    const BodyId crate = add_stack(world, 1).front();
    run(world, 120);
    ASSERT_TRUE(world.is_asleep(crate));
    Snapshot before;
    world.save(before);
    const BodyId paddle = world.add_body({.type = BodyType::Kinematic, .shape = Box{}, .position = {0, 0, 4}});
    world.set_velocity(paddle, {0, 0, 0}, {0, 0, 1});
    world.add_joint({.kind = BallJoint{}, .first = paddle, .second = crate, .frame_first = {{0, 0, -3}}});
    const BodyId last = add_stack(world, 3).back();
    world.add_joint({.kind = BallJoint{}, .first = paddle, .second = last});
    world.step(dt);

    world.restore(before);
    Settings settings = world.settings();
    settings.joint_solver = solver;
    world.set_settings(settings);
    const StepReport report = world.step(dt);
    EXPECT_EQ(report.counts.joints, 0);
    EXPECT_TRUE(world.is_asleep(crate));
  }
}

TEST(Snapshot, HoldsWhatCallersChangedSinceTheLastStep) {
  const auto change = [](Yard& yard, int what) {
    World& world = yard.world;
    const BodyId crate = yard.ids[2];
    switch (what) {
      case 0:
        return world.apply_force(crate, {0, 1e4, 0}, {10, 0, 0});
      case 1:
        return world.set_filter(yard.ids[1], {.category = 2, .mask = 4, .group = -3});
      case 2:
        return world.set_collision_enabled(yard.ids[1], crate, false);
      case 3:
        return world.set_pose(yard.ids[4], {{0, 0, 3}, Quaternion::Identity()});
      case 4:
        return world.set_surface_velocity(yard.ids[0], {2, 0, 0});
      case 5:
        return world.set_velocity(yard.ids[3], {0, 1e9, 0}, {0, 0, 0});
      case 6:
        return world.set_pose(yard.ids[4], {{1e13, 0, 0}, Quaternion::Identity()});
      case 7:
        return static_cast<void>(world.add_body(sphere({0.2, 0.1, 2.4})));
      case 8:
        return world.remove_body(yard.ids[1]);
      case 9:
        return world.set_joint_enabled(yard.hinge, false);
      default:
        return world.set_joint(yard.hinge, HingeJoint{{.motor = JointMotor{.speed = 3, .max_force = 10}}});
    }
  };
  for (int what = 0; what <= 10; ++what) {
    Yard yard;
    run(yard.world, 30);
    change(yard, what);
    Snapshot snapshot;
    yard.world.save(snapshot);
    const std::vector<std::uint64_t> expected = hashes(yard.world, 10);
    yard.world.restore(snapshot);
    EXPECT_EQ(hashes(yard.world, 10), expected) << "the same world, change " << what;
    Yard other;
    other.world.restore(snapshot);
    EXPECT_EQ(hashes(other.world, 10), expected) << "another world, change " << what;
  }
}

TEST(Snapshot, GivesOutTheSameIdsAfterwards) {
  Yard yard;
  yard.world.remove_body(yard.ids[3]);
  yard.world.remove_body(yard.ids[1]);
  Snapshot snapshot;
  yard.world.save(snapshot);
  const auto add = [](World& world) {
    std::vector<std::uint64_t> ids;
    BodyId last = {};
    for (int i = 0; i < 4; ++i) {
      const BodyId id = world.add_body(sphere({3.0 * i, 20, 2}));
      ids.push_back(std::uint64_t{id.index} << 32 | id.generation);
      if (i > 0) {
        const JointId joint = world.add_joint({.first = last, .second = id});
        ids.push_back(std::uint64_t{joint.index} << 32 | joint.generation);
      }
      last = id;
    }
    return ids;
  };
  const std::vector<std::uint64_t> expected = add(yard.world);
  const std::vector<std::uint64_t> trail = hashes(yard.world, 5);
  yard.world.restore(snapshot);
  EXPECT_FALSE(yard.world.contains(yard.ids[1]));
  EXPECT_EQ(add(yard.world), expected);
  EXPECT_EQ(hashes(yard.world, 5), trail);
  Yard fresh;
  fresh.world.restore(snapshot);
  EXPECT_EQ(add(fresh.world), expected);
  EXPECT_EQ(hashes(fresh.world, 5), trail);
}

TEST(Snapshot, IsRefusedByAWorldWithOtherBodies) {
  Yard yard;
  Snapshot snapshot;
  yard.world.save(snapshot);
  Yard other({}, 0.3);
  run(other.world, 5);
  const std::uint64_t before = other.world.state_hash();
  expect_error(
      [&] { other.world.restore(snapshot); },
      {"World::restore", "index 3", "Sphere of radius 0.29999999999999999", "expected", "0.40000000000000002"});
  Yard third({}, 0.4, 2);
  expect_error([&] { third.world.restore(snapshot); }, {"index 4", "ConvexHull", "expected"});
  EXPECT_EQ(other.world.state_hash(), before);
  expect_error([&] { other.world.restore(Snapshot()); }, {"World::restore", "empty"});
  EXPECT_EQ(other.world.state_hash(), before);
}

TEST(Snapshot, LeavesThreadsAndInstructionSetToTheWorld) {
  Yard yard;
  Snapshot snapshot;
  yard.world.save(snapshot);
  const std::vector<std::uint64_t> expected = hashes(yard.world, 30);
  Yard other({.threads = 2, .settings = {.profile = true, .simd = Simd::Portable}});
  other.world.restore(snapshot);
  EXPECT_EQ(other.world.threads(), 2);
  EXPECT_EQ(other.world.simd(), Simd::Portable);
  EXPECT_TRUE(other.world.settings().profile);
  EXPECT_EQ(hashes(other.world, 30), expected);
}

// A threshold of 0, at which all bounces, is not the one that is found where none is given.
TEST(Snapshot, TellsAZeroFromWhatIsLeftOut) {
  const WorldDef bouncy{.settings = {.restitution_threshold = 0}};
  World world(bouncy), other(bouncy);
  Snapshot snapshot;
  world.save(snapshot);
  EXPECT_NE(World().state_hash(), world.state_hash());
  world.set_settings({});
  world.restore(snapshot);
  EXPECT_EQ(world.settings().restitution_threshold, 0);
  EXPECT_EQ(world.state_hash(), other.state_hash());
  const TemporaryFile file(".snapshot");
  snapshot.write(file.path());
  world.set_settings({});
  world.restore(Snapshot::read(file.path()));
  EXPECT_EQ(world.settings().restitution_threshold, 0);
}

TEST(Snapshot, ReportsAreEmptyUntilTheNextStep) {
  Yard yard;
  run(yard.world, 30);
  Snapshot snapshot;
  yard.world.save(snapshot);
  ASSERT_FALSE(yard.world.contact_forces().empty());
  yard.world.restore(snapshot);
  EXPECT_TRUE(yard.world.contact_forces().empty());
  EXPECT_TRUE(yard.world.contact_problem().patches.empty());
  yard.world.step(dt);
  EXPECT_FALSE(yard.world.contact_forces().empty());
}

// Geometry isn't in a file: a body with a hull that has gone is made of another's.
TEST(SnapshotFile, BringsBackAWorld) {
  const TemporaryFile file(".snapshot");
  Yard yard;
  run(yard.world, 20);
  Snapshot snapshot;
  yard.world.save(snapshot);
  snapshot.write(file.path());
  const std::vector<std::uint64_t> expected = hashes(yard.world, 20);
  const Snapshot read = Snapshot::read(file.path());
  EXPECT_EQ(read.size(), snapshot.size());
  Yard fresh;
  fresh.world.restore(read);
  EXPECT_EQ(hashes(fresh.world, 20), expected);
  fresh.world.remove_body(fresh.ids[1]);
  fresh.world.remove_body(fresh.ids[3]);
  fresh.world.restore(read);
  EXPECT_EQ(hashes(fresh.world, 20), expected);
  fresh.world.remove_body(fresh.ids[4]);
  const std::uint64_t before = fresh.world.state_hash();
  expect_error([&] { fresh.world.restore(read); }, {"World::restore", "geometry", "index 4", "ConvexHull", "expected"});
  EXPECT_EQ(fresh.world.state_hash(), before);
  fresh.world.add_body({.type = BodyType::Static, .shape = wedge(1), .position = {50, 0, 0}});
  fresh.world.restore(read);
  EXPECT_EQ(hashes(fresh.world, 20), expected);
}

TEST(SnapshotFile, IsTheSameInMemory) {
  const TemporaryFile file(".snapshot");
  Yard yard;
  run(yard.world, 5);
  Snapshot snapshot;
  yard.world.save(snapshot);
  snapshot.write(file.path());
  std::vector<std::byte> bytes = snapshot.to_bytes();
  const std::string written = file.content();
  EXPECT_TRUE(std::ranges::equal(std::as_bytes(std::span(written)), bytes));
  const std::vector<std::uint64_t> expected = hashes(yard.world, 5);
  yard.world.restore(Snapshot::from_bytes(bytes));
  EXPECT_EQ(hashes(yard.world, 5), expected);
  bytes.pop_back();
  expect_error([&] { Snapshot::from_bytes(bytes); }, {"Snapshot::from_bytes: found", "expected"});
  expect_error([] { Snapshot::from_bytes({}); }, {"Snapshot::from_bytes: does not begin with"});
  expect_error([] { Snapshot().to_bytes(); }, {"Snapshot::to_bytes", "empty"});
}

// It pushes with more than any number of a definition may be.
TEST(SnapshotFile, BringsBackTheHeaviestOfBodies) {
  const WorldDef def = {.gravity = {0, 0, -1e4}};
  World world(def), restored(def);
  for (World* each : {&world, &restored}) {
    each->add_body(ground());
    BodyDef heavy = box({0, 0, 0.5});
    heavy.mass = 1e15;
    each->add_body(heavy);
  }
  double largest = 0;
  for (int step = 0; step < 10; ++step) {
    world.step(dt);
    for (const ContactForce& each : world.contact_forces()) largest = std::max(largest, each.normal_force * dt);
    Snapshot saved;
    world.save(saved);
    restored.restore(Snapshot::from_bytes(saved.to_bytes()));
    EXPECT_EQ(restored.state_hash(), world.state_hash());
  }
  EXPECT_GT(largest, 1e16) << "N s";
}

TEST(SnapshotFile, SaysWhyItCannotBeReadOrWritten) {
  const TemporaryFile file(".snapshot");
  expect_error([&] { Snapshot::read(file.path()); }, {"Snapshot::read", file.path().string(), "No such file"});
  expect_error([&] { Snapshot::read(fs::temp_directory_path()); }, {"is a directory", "expected"});
  expect_error([&] { Snapshot::read("/dev/zero"); }, {"is a device", "expected"});
  expect_error([&] { Snapshot().write(file.path()); }, {"Snapshot::write", "empty"});
  Yard yard;
  Snapshot snapshot;
  yard.world.save(snapshot);
  expect_error([&] { snapshot.write("/nowhere/at/all.snapshot"); }, {"Snapshot::write", "No such file"});
  file.set_content("{}");
  expect_error([&] { Snapshot::read(file.path()); }, {"ATOLLSNP", "expected a snapshot"});
  snapshot.write(file.path());
  const std::string whole = file.content();
  const auto expect_refusal = [&](std::size_t at, char value, std::initializer_list<std::string_view> words) {
    std::string bytes = whole;
    bytes[at] = value;
    file.set_content(bytes);
    expect_error([&] { Snapshot::read(file.path()); }, words);
  };
  expect_refusal(8, 1, {"byte order", "0x1020301", "expected", "0x1020304"});
  expect_refusal(12, 99, {"found version 99", "expected 22"});
  expect_refusal(whole.size() - 1, static_cast<char>(whole.back() + 1), {"checksum", "expected", "damaged"});
}

// Some of them; each in long tests.
TEST(SnapshotFile, RefusesEveryCutAndEveryFlippedByte) {
  const TemporaryFile file(".snapshot");
  World world;
  world.add_body(ground());
  world.add_body(box({0, 0, 0.5}));
  run(world, 10);
  Snapshot snapshot;
  world.save(snapshot);
  snapshot.write(file.path());
  const std::string whole = file.content();
  ASSERT_LT(whole.size(), 20'000u);
  for (const std::size_t length : bytes_to_try(whole.size())) {
    file.set_content(whole.substr(0, length));
    EXPECT_THROW(Snapshot::read(file.path()), Error) << length << " of " << whole.size() << " bytes";
  }
  for (const std::size_t at : bytes_to_try(whole.size())) {
    std::string bytes = whole;
    bytes[at] = static_cast<char>(bytes[at] ^ (1 << at % 8));
    file.set_content(bytes);
    EXPECT_THROW(Snapshot::read(file.path()), Error) << "byte " << at;
  }
  file.set_content(whole + "x");
  EXPECT_THROW(Snapshot::read(file.path()), Error);
}

// The same bytes as of a number, in all places where they are.
std::string with_number(const std::string& bytes, double number, double other) {
  std::string changed = bytes;
  const std::string_view from(reinterpret_cast<const char*>(&number), sizeof number);
  for (std::size_t at = changed.find(from); at != std::string::npos; at = changed.find(from, at + 1)) {
    std::memcpy(changed.data() + at, &other, sizeof other);
  }
  return changed;
}

// Numbers that no definition lets through are refused in a file too, and by what they are of.
TEST(SnapshotFile, NumbersThatNoWorldHasAreRefused) {
  const TemporaryFile file(".snapshot");
  World world({.gravity = Vector3::Zero()});
  world.add_body({.shape = Box{{0.375, 0.4375, 0.53125}},
                  .position = {1.0625, 2, 3},
                  .orientation = {0.6, 0.8, 0, 0},
                  .mass = 0.625,
                  .material = {.friction = 0.71875},
                  .linear_damping = 0.15625});
  // Whose centre of mass is at (0, 0.3125, 0).
  world.add_body({.shape = Compound{{{.shape = Sphere{0.25}, .position = {0, 0.34375, 0}},
                                     {.shape = Sphere{0.25}, .position = {0, 0.28125, 0}}}},
                  .position = {0, 10, 3}});
  const BodyId lost = world.add_body({.position = {1.1875, 20, 3}});
  const BodyId strays = world.add_body({.position = {1.3125, 30, 3}});
  world.set_velocity(lost, {1e30, 0, 0}, Vector3::Zero());
  world.step(dt);  // which checks what is new
  ASSERT_TRUE(world.is_quarantined(lost));
  world.set_pose(strays, {{1e200, 0, 0}, Quaternion::Identity()});
  world.add_body({.position = {1.4375, 40, 3}});
  Snapshot snapshot;
  world.save(snapshot);
  snapshot.write(file.path());
  const std::string whole = file.content();
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const auto expect_refusal = [&](double number, double other, std::string_view words) {
    std::string bytes = with_number(whole, number, other);
    ASSERT_NE(bytes, whole) << number;
    const std::uint64_t checksum = checksum_of(std::as_bytes(std::span(bytes)).subspan(32));
    std::memcpy(bytes.data() + 24, &checksum, sizeof checksum);
    file.set_content(bytes);
    expect_error([&] { Snapshot::read(file.path()); }, {words, "expected what World::save wrote"});
  };
  expect_refusal(0.375, -0.375, "a shape with invalid numbers");
  expect_refusal(0.4375, nan, "a shape with invalid numbers");
  expect_refusal(0.53125, 0.5, "a shape with invalid numbers");  // not the size that its bounding radius is of
  expect_refusal(0.71875, -1, "a body of an invalid material");
  expect_refusal(0.15625, nan, "a body of an invalid material, gravity scale or damping");
  expect_refusal(0.34375, nan, "a shape with invalid numbers");
  expect_refusal(0.3125, nan, "a body without a valid centre of mass");
  expect_refusal(1 / 0.625, nan, "a body without a valid mass");
  expect_refusal(0.8, 0.8 + 1e-8, "an orientation that is none");
  expect_refusal(1.0625, nan, "a body whose state is not finite");
  expect_refusal(1.1875, nan, "a body whose state is not finite");  // in quarantine
  expect_refusal(1.4375, nan, "a body whose state is not finite");  // not yet checked by a step
  expect_refusal(1.3125, nan, "a pose to go back to that is none");
}

}  // namespace
}  // namespace atl::test
