// Recordings: every call that changes a world is in them and made again, and what they can't be replayed from is
// refused.

#include <atoll/atoll.h>
#include <collision/shapes/shape.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "recorded_yard.h"
#include "state/recording_file.h"
#include "support/bodies.h"
#include "support/expect_error.h"
#include "support/long_tests.h"
#include "support/recording_file.h"
#include "support/temporary_file.h"

namespace atl::test {
namespace {

namespace fs = std::filesystem;

bool holds(const fs::path& path, RecordKind kind) {
  const std::vector<Record> records = read_records(path);
  return std::any_of(records.begin(), records.end(), [kind](const Record& record) { return record.kind == kind; });
}

void expect_same(const ReplayResult& result, std::int64_t steps, std::uint64_t hash, const char* what) {
  EXPECT_FALSE(result.divergence.has_value()) << what;
  EXPECT_TRUE(result.complete) << what;
  EXPECT_EQ(result.steps, steps) << what;
  EXPECT_EQ(result.recorded_steps, steps) << what;
  EXPECT_EQ(result.hash, hash) << what;
}

TEST(Recording, HasEveryCallThatChangesAWorld) {
  for (const Change& change : changes()) {
    const TemporaryFile file(".recording");
    Yard yard;
    run(yard.world, 10);
    yard.world.record(file.path());
    const std::uint64_t before = yard.world.state_hash();
    change.make(yard);
    if (std::string(change.name) != "a call to wake") {
      EXPECT_TRUE(yard.world.state_hash() != before || change.kind == RecordKind::State) << change.name;
    }
    run(yard.world, 10);
    yard.world.stop_recording();
    EXPECT_TRUE(holds(file.path(), change.kind)) << change.name;
    const ReplayResult result = replay(file.path());
    expect_same(result, result.recorded_steps, yard.world.state_hash(), change.name);
    EXPECT_GE(result.steps, 10) << change.name;
  }
}

TEST(Recording, WakesWhatTheCallsWake) {
  const TemporaryFile file(".recording");
  Yard yard({.settings = {.sleeping = true, .sleep_speed = 1, .time_to_sleep = 0.1}});
  run(yard.world, 60);
  ASSERT_TRUE(yard.world.is_asleep(yard.ids[1]));
  yard.world.record(file.path());
  run(yard.world, 2);
  yard.world.wake(yard.ids[1]);
  run(yard.world, 3);
  yard.world.stop_recording();
  expect_same(replay(file.path()), 5, yard.world.state_hash(), "woken");
}

// All in one world, one after the other, from its making on and on other threads with other instructions.
TEST(Recording, IsReplayedOnAnyMachine) {
  const TemporaryFile file(".recording");
  Yard yard({.threads = 2});
  yard.world.record(file.path());
  for (const char* name : {"a body is added", "geometry is added", "a force", "a motor", "two that don't touch",
                           "a restored state", "a pose", "settings", "a body is removed"}) {
    run(yard.world, 5);
    std::find_if(changes().begin(), changes().end(), [name](const Change& c) {
      return std::string(c.name) == name;
    })->make(yard);
  }
  run(yard.world, 5);
  yard.world.stop_recording();
  for (const int threads : {1, 2, 3}) {
    for (const Simd simd : {Simd::Auto, Simd::Portable}) {
      const ReplayResult result = replay(file.path(), {.threads = threads, .simd = simd});
      expect_same(result, 51, yard.world.state_hash(), "threads, instruction set");
      EXPECT_EQ(result.recorded_threads, 2);
      EXPECT_NE(result.recorded_simd, Simd::Auto);
    }
  }
}

TEST(Recording, GoesBackToBeforeTheFirstJoint) {
  const TemporaryFile file(".recording");
  World world;
  world.add_body(ground());
  const std::vector<BodyId> crates = add_stack(world, 2);
  world.record(file.path());
  Snapshot snapshot;
  world.save(snapshot);
  world.add_joint({.first = crates[0], .second = crates[1]});
  run(world, 5);
  world.restore(snapshot);
  run(world, 5);
  world.stop_recording();
  expect_same(replay(file.path()), 10, world.state_hash(), "a joint came and went");
}

// A suspension counts by the mass of its chassis as its joint is set, and not as a motor is.
TEST(Recording, OfAMotorSetsNothingElseOfItsJoint) {
  const TemporaryFile file(".recording");
  World world;
  BodyDef chassis = box({0, 0, 1});
  chassis.type = BodyType::Static;
  const BodyId held = world.add_body(chassis);
  const BodyId wheel = world.add_body(sphere({0, 0, 0.5}, 0.3));
  WheelJoint kind;
  kind.spin.motor = JointMotor{.max_force = 5, .servo = JointServo{.stiffness = 10}};
  const JointId joint = world.add_joint({.kind = kind, .first = held, .second = wheel});
  chassis.type = BodyType::Dynamic;
  world.set_definition(held, chassis);
  world.record(file.path(), {.body_hash_interval = 1});
  world.set_motor_speed(joint, 3, 2);
  world.set_servo_target(joint, 0.5, 2);
  run(world, 5);
  world.stop_recording();
  EXPECT_TRUE(std::get<WheelJoint>(world.joint(joint).kind).suspension.spring->hertz > 0);
  expect_same(replay(file.path()), 5, world.state_hash(), "a motor was set");
}

TEST(Recording, LeavesOutCallsThatThrow) {
  const TemporaryFile file(".recording");
  Yard yard;
  yard.world.record(file.path());
  const BodyId stale = yard.world.add_body(sphere({9, 9, 9}));
  yard.world.remove_body(stale);
  EXPECT_THROW(yard.world.apply_force(stale, {1, 0, 0}), Error);
  EXPECT_THROW(yard.world.remove_body(stale), Error);
  EXPECT_THROW(yard.world.set_gravity({NAN, 0, 0}), Error);
  EXPECT_THROW(yard.world.set_settings({.substeps = 0}), Error);
  EXPECT_THROW(yard.world.add_body({.density = -1}), Error);
  EXPECT_THROW(yard.world.set_velocity(yard.ids[0], {1, 0, 0}, {0, 0, 0}), Error);
  EXPECT_THROW(yard.world.restore(Snapshot()), Error);
  EXPECT_THROW(yard.world.step(2), Error);
  run(yard.world, 3);
  yard.world.stop_recording();
  EXPECT_FALSE(holds(file.path(), kind_of<calls::ApplyForce>()));
  EXPECT_FALSE(holds(file.path(), kind_of<calls::SetGravity>()));
  expect_same(replay(file.path()), 3, yard.world.state_hash(), "calls that throw");
}

TEST(Recording, EndsWithItsWorldAndIsThereOnlyThen) {
  const TemporaryFile file(".recording");
  const TemporaryFile partial(".recording.partial");
  file.set_content("old");
  {
    Yard yard;
    yard.world.record(file.path());
    run(yard.world, 4);
    EXPECT_EQ(file.content(), "old");
    // The file that a program leaves if it ends here: the last step is in it, but not its result.
    const ReplayResult result = replay(partial.path());
    EXPECT_FALSE(result.complete);
    EXPECT_FALSE(result.divergence.has_value());
    EXPECT_EQ(result.steps, 4);
    EXPECT_EQ(result.hash, yard.world.state_hash());
    World moved = std::move(yard.world);
    run(moved, 4);
  }
  EXPECT_FALSE(fs::exists(partial.path()));
  const ReplayResult result = replay(file.path());
  EXPECT_TRUE(result.complete);
  EXPECT_EQ(result.steps, 8);
}

TEST(Recording, SaysWhatItCannotDo) {
  Yard yard;
  expect_error([&] { yard.world.stop_recording(); }, {"World::stop_recording", "no recording"});
  expect_error([&] { yard.world.record("/nowhere/at/all"); }, {"World::record", "/nowhere/at/all", "No such file"});
  expect_error([&] { yard.world.record(fs::temp_directory_path()); }, {"World::record", "is a directory"});
  EXPECT_FALSE(yard.world.is_recording());
  const TemporaryFile file(".recording");
  expect_error([&] { yard.world.record(file.path(), {.body_hash_interval = 0}); },
               {"body_hash_interval is 0", "expected"});
  yard.world.record(file.path());
  expect_error([&] { yard.world.record(file.path()); }, {"World::record", "under way"});
  yard.world.stop_recording();
  EXPECT_TRUE(fs::exists(file.path()));
}

TEST(Recording, AFullDiskShowsAtTheEnd) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
  const TemporaryFile file(".recording");
  const TemporaryFile partial(".recording.partial");
  fs::create_symlink("/dev/full", partial.path());
  Yard yard;
  yard.world.record(file.path());
  run(yard.world, 5);
  expect_error([&] { yard.world.stop_recording(); }, {"World::stop_recording", "No space left"});
  EXPECT_FALSE(yard.world.is_recording());
  EXPECT_FALSE(fs::exists(file.path()));
}

/// Pushes the ball in each of ten steps.
void record_pushes(const fs::path& path, const RecordingOptions& options = {}) {
  Yard yard;
  run(yard.world, 5);
  yard.world.record(path, options);
  for (int i = 0; i < 10; ++i) {
    yard.world.apply_force(yard.ids[4], {300, 0, 0});
    yard.world.step(dt);
  }
  yard.world.stop_recording();
}

TEST(Replay, NamesTheStepAndTheBodyOfAChangedForce) {
  const TemporaryFile file(".recording");
  record_pushes(file.path());
  ASSERT_FALSE(replay(file.path()).divergence.has_value());
  change_a_force(file.path(), 6);
  const ReplayResult result = replay(file.path(), {.threads = 2});
  ASSERT_TRUE(result.divergence.has_value());
  EXPECT_EQ(result.divergence->step, 7);
  EXPECT_EQ(result.steps, 7) << "stops there";
  EXPECT_EQ(result.recorded_steps, 10);
  EXPECT_EQ(result.divergence->bodies_step, 7);
  ASSERT_EQ(result.divergence->bodies.size(), 1u);
  EXPECT_EQ(result.divergence->bodies[0].id.index, 4u);
  const std::vector<std::string>& parts = result.divergence->bodies[0].parts;
  EXPECT_NE(std::find(parts.begin(), parts.end(), "velocity"), parts.end());
  EXPECT_EQ(std::find(parts.begin(), parts.end(), "joints"), parts.end());
}

// Bodies are told of once they were hashed: at the next multiple of the interval, or as the recording ends.
TEST(Replay, NamesBodiesAsSoonAsTheRecordingTellsOfThem) {
  for (const auto& [interval, step] : {std::pair{4, 8}, std::pair{100, 10}}) {
    const TemporaryFile file(".recording");
    record_pushes(file.path(), {.body_hash_interval = interval, .few_bodies = 0});
    change_a_force(file.path(), 5);
    const ReplayResult result = replay(file.path());
    ASSERT_TRUE(result.divergence.has_value());
    EXPECT_EQ(result.divergence->step, 6);
    EXPECT_EQ(result.divergence->bodies_step, step);
    ASSERT_FALSE(result.divergence->bodies.empty());
    EXPECT_EQ(result.divergence->bodies[0].id.index, 4u);
  }
}

TEST(Replay, TellsWhatIsNoBodys) {
  const TemporaryFile file(".recording");
  {
    World world;
    world.record(file.path());
    world.set_gravity({0, 0, -1});
    run(world, 3);
  }
  std::vector<Record> records = read_records(file.path());
  std::erase_if(records, [](const Record& record) { return record.kind == kind_of<calls::SetGravity>(); });
  write_records(file.path(), records);
  const ReplayResult result = replay(file.path());
  ASSERT_TRUE(result.divergence.has_value());
  EXPECT_EQ(result.divergence->step, 1);
  EXPECT_EQ(result.divergence->bodies_step, 1);
  EXPECT_TRUE(result.divergence->bodies.empty());
}

TEST(Replay, TellsOfBodiesThatAreNotThere) {
  const TemporaryFile file(".recording");
  record_pushes(file.path());
  std::vector<Record> records = read_records(file.path());
  const auto force = std::find_if(records.begin(), records.end(),
                                  [](const Record& record) { return record.kind == kind_of<calls::ApplyForce>(); });
  force->kind = kind_of<calls::RemoveBody>();
  force->content.resize(sizeof(BodyId));
  write_records(file.path(), records);
  const ReplayResult result = replay(file.path());
  ASSERT_TRUE(result.divergence.has_value());
  EXPECT_EQ(result.divergence->step, 1);
  ASSERT_EQ(result.divergence->bodies.size(), 1u);
  EXPECT_EQ(result.divergence->bodies[0].parts, std::vector<std::string>{"id"});
}

// Whatever it was cut at: all that is whole is replayed, and it is the same.
TEST(Replay, GoesAsFarAsACutRecordingDoes) {
  const TemporaryFile file(".recording");
  record_pushes(file.path());
  const std::string whole = file.content();
  std::int64_t max = 0;
  for (std::size_t length = whole.size() - 1; length > 400; length -= std::min<std::size_t>(length, 97)) {
    file.set_content(whole.substr(0, length));
    try {
      const ReplayResult result = replay(file.path());
      EXPECT_FALSE(result.complete) << length;
      EXPECT_FALSE(result.divergence.has_value()) << length;
      EXPECT_EQ(result.steps, result.recorded_steps) << length;
      max = std::max(max, result.steps);
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("no state to begin with"), std::string::npos) << error.what();
    }
  }
  EXPECT_EQ(max, 10);
}

TEST(Replay, RefusesWhatIsNoRecordingOrDamaged) {
  const TemporaryFile file(".recording");
  expect_error([&] { replay(file.path()); }, {"replay", file.path().string(), "No such file"});
  expect_error([&] { replay(fs::temp_directory_path()); }, {"is a directory", "expected"});
  file.set_content("");
  expect_error([&] { replay(file.path()); }, {"ATOLLREC", "expected a recording"});
  file.set_content("{\"bodies\": []}");
  expect_error([&] { replay(file.path()); }, {"ATOLLREC", "expected a recording"});
  {
    Snapshot snapshot;
    Yard().world.save(snapshot);
    snapshot.write(file.path());
  }
  expect_error([&] { replay(file.path()); }, {"ATOLLREC", "expected a recording"});
  record_pushes(file.path());
  const std::string whole = file.content();
  const auto expect_refusal = [&](std::size_t at, char value, std::initializer_list<std::string_view> words) {
    std::string bytes = whole;
    bytes[at] = value;
    file.set_content(bytes);
    expect_error([&] { replay(file.path()); }, words);
  };
  expect_refusal(8, 1, {"byte order", "expected"});
  expect_refusal(12, 99, {"found version 99", "expected 23"});
  file.set_content(whole + "x");
  expect_error([&] { replay(file.path()); }, {"1 bytes after the end"});
  file.set_content(whole);
  expect_error([&] { replay(file.path(), {.threads = 0}); }, {"threads is 0"});
  EXPECT_FALSE(replay(file.path()).divergence.has_value());
}

// Some of them; each in long tests.
TEST(Replay, RefusesEveryFlippedByte) {
  const TemporaryFile file(".recording");
  {
    World world;
    world.record(file.path());
    world.add_body(ground());
    world.add_body(box({0, 0, 0.5}));
    run(world, 2);
  }
  const std::string whole = file.content();
  ASSERT_LT(whole.size(), 10'000u);
  for (const std::size_t at : bytes_to_try(whole.size())) {
    std::string bytes = whole;
    bytes[at] = static_cast<char>(bytes[at] ^ (1 << at % 8));
    file.set_content(bytes);
    EXPECT_THROW(replay(file.path()), Error) << "byte " << at;
  }
}

// Records that are well-formed one by one, but don't fit together, as a faulty program could write them.
TEST(Replay, RefusesRecordsThatDoNotFit) {
  const TemporaryFile file(".recording");
  record_pushes(file.path());
  const std::vector<Record> records = read_records(file.path());
  const auto expect_refusal = [&](const std::function<void(std::vector<Record>&)>& spoil, const char* words) {
    std::vector<Record> spoilt = records;
    spoil(spoilt);
    write_records(file.path(), spoilt);
    SCOPED_TRACE(words);
    expect_error([&] { replay(file.path()); }, {"replay", file.path().string(), words});
  };
  const auto find = [](std::vector<Record>& all, RecordKind kind) {
    return std::find_if(all.begin(), all.end(), [kind](const Record& record) { return record.kind == kind; });
  };
  expect_refusal([](auto& all) { all.clear(); }, "no state to begin with");
  expect_refusal([&](auto& all) { all.erase(find(all, RecordKind::State)); }, "a record ahead of the state");
  expect_refusal([&](auto& all) { all.erase(find(all, RecordKind::Geometry)); }, "geometry");
  expect_refusal([&](auto& all) { find(all, RecordKind::Step)->kind = static_cast<RecordKind>(999); }, "no known kind");
  expect_refusal([&](auto& all) { find(all, RecordKind::Step)->content.push_back({}); }, "more than there should be");
  expect_refusal([&](auto& all) { find(all, RecordKind::Step)->content.pop_back(); }, "the end of the data");
  expect_refusal([&](auto& all) { find(all, RecordKind::Step)->content.assign(12, {}); }, "dt is 0");
  expect_refusal([&](auto& all) { find(all, kind_of<calls::ApplyForce>())->content[0] = std::byte{99}; },
                 "no body has the id");
  expect_refusal([&](auto& all) { find(all, RecordKind::Geometry)->content[4] ^= std::byte{1}; }, "another content");
  expect_refusal([&](auto& all) { find(all, RecordKind::Geometry)->content.resize(99); }, "can't all be there");
  // Offsets of the lowest bits of the hull's first vertex, and of its upper bounds.
  constexpr std::size_t first_vertex = sizeof(collision::ShapeKind) + sizeof(std::uint64_t) + sizeof(std::uint32_t);
  constexpr std::size_t upper_from_end = sizeof(double) + sizeof(bool) + sizeof(std::uint64_t);
  expect_refusal([&](auto& all) { find(all, RecordKind::Geometry)->content[first_vertex] ^= std::byte{1}; },
                 "a hull of another content than it says");
  expect_refusal(
      [&](auto& all) {
        std::vector<std::byte>& content = find(all, RecordKind::Geometry)->content;
        content[content.size() - upper_from_end] ^= std::byte{1};
      },
      "a hull that its vertices and faces don't make");
}

}  // namespace
}  // namespace atl::test
