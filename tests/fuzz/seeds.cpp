// Writes inputs to begin with, a folder for each target: built-in scenes and the scene files given as text, as
// snapshots and as recordings; and programs of random bytes.

#include "seeds.h"

#include <atoll/snapshot.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <iostream>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "records.h"
#include "scratch_file.h"
#include "small_scenes.h"

namespace {

using namespace atl;
using namespace atl::fuzz::seeds;
namespace fs = std::filesystem;

// Writes a snapshot, to be restored into an empty world and into one of the same bodies.
void write_snapshot(const fs::path& path, const World& world, std::size_t its_number) {
  Snapshot snapshot;
  world.save(snapshot);
  const std::vector<std::byte> bytes = snapshot.to_bytes();
  const auto* begin = reinterpret_cast<const std::uint8_t*>(bytes.data());
  const Input whole(begin, begin + bytes.size());
  for (const std::size_t into : {std::size_t{0}, its_number + 1}) {
    Input input(whole.begin() + 32, whole.end());
    input.insert(input.begin(), static_cast<std::uint8_t>(into));
    write(path.string() + "-" + std::to_string(into), input);
  }
  Input input = whole;
  input.insert(input.begin(), 0x80);
  write(path.string() + "-whole", input);
  input.resize(20);
  write(path.string() + "-cut", input);
}

void write_snapshots(const fs::path& folder) {
  for (std::size_t number = 0; number < fuzz::small_scenes.size(); ++number) {
    for (const int steps : {0, 40}) {
      const std::string name = plain(fuzz::small_scenes[number]) + "-" + std::to_string(steps);
      write_snapshot(folder / name, fuzz::small_world(number, steps), number);
    }
  }
  // Bodies that sleep, and one in quarantine.
  World sleepy = fuzz::small_world(0, 0);
  sleepy.set_settings({.sleeping = true, .sleep_speed = 1, .time_to_sleep = 0.02});
  for (int step = 0; step < 20; ++step) sleepy.step(1.0 / 60);
  write_snapshot(folder / "sleepy", sleepy, 0);
  World broken = fuzz::small_world(5, 10);
  broken.set_velocity(broken.bodies().back(), {2e6, 0, 0}, {0, 0, 0});
  broken.step(1.0 / 60);
  write_snapshot(folder / "broken", broken, 5);
}

// A little of everything that is recorded.
void act(World& world, int step) {
  const std::vector<BodyId> bodies = world.bodies();
  const BodyId body = bodies[static_cast<std::size_t>(step) % bodies.size()];
  const bool moves = world.type(body) == BodyType::Dynamic;
  switch (step) {
    case 1:
      if (moves) world.apply_impulse(body, {1, 2, 3}, world.pose(body).position);
      return;
    case 2:
      world.set_material(body, {.friction = 0.3, .restitution = 0.5});
      return world.set_name(body, "name");
    case 3:
      world.set_gravity({0, 1, -9});
      world.set_settings({.substeps = 2, .sleeping = true});
      return;
    case 4: {
      const BodyId added = world.add_body({.shape = Sphere{0.3}, .position = {0, 0, 3}});
      world.add_joint(joint_at(world, HingeJoint{}, body, added, {0, 0, 2}));
      return world.apply_force(added, {1, 0, 0});
    }
    case 5:
      if (world.joint_count() > 0) world.set_joint_enabled(world.joints().front(), false);
      return world.set_pose(bodies.back(), {{1, 1, 4}, Quaternion::Identity()});
    case 6:
      if (world.type(bodies.back()) == BodyType::Dynamic) world.set_shape(bodies.back(), Box{{0.2, 0.3, 0.4}});
      return world.set_filter(bodies.back(), {.category = 2, .mask = 3});
    case 7:
      return world.remove_body(bodies.back());
    default:
      return;
  }
}

std::vector<fuzz::Record> record(World& world, int steps, const std::function<void(World&, int step)>& act) {
  const fuzz::ScratchFile file("seed");
  world.record(file.path(), {.body_hash_interval = 4, .few_bodies = 0});
  for (int step = 0; step < steps; ++step) {
    act(world, step);
    world.step(1.0 / 60);
  }
  world.stop_recording();
  return test::read_records(file.path());
}

// Runs that part: by a call that one has of a body or of none, by what is found in a step, or in the end only.
void write_pairs(const fs::path& folder) {
  using Act = std::function<void(World&, int step)>;
  const auto in_step_3 = [](const std::function<void(World&)>& change) -> Act {
    return [change](World& world, int step) {
      if (step == 3) change(world);
    };
  };
  const std::vector<std::pair<std::string, Act>> acts = {
      {"push", in_step_3([](World& world) {
         world.apply_impulse(world.bodies().back(), {0, 3, 0}, {0, 0, 1});
       })},
      {"settings", in_step_3([](World& world) { world.set_settings({.substeps = 7}); })},
      {"gravity", in_step_3([](World& world) {
         world.set_gravity({0, 0, -1});
       })},
      {"add", in_step_3([](World& world) {
         world.add_body({.position = {0, 0, 9}});
       })},
      {"remove", in_step_3([](World& world) { world.remove_body(world.bodies().back()); })},
      {"name", in_step_3([](World& world) { world.set_name(world.bodies().back(), "another"); })},
      {"sleep", in_step_3([](World& world) { world.set_settings({.sleeping = true, .time_to_sleep = 0.02}); })},
      {"nothing-of-bodies", in_step_3([](World& world) { world.set_settings({.sleep_speed = 0.2}); })},
      {"filter",
       in_step_3([](World& world) { world.set_contact_filter([](const ContactCandidate&) { return false; }); })},
      {"nothing", [](World&, int) {}}};
  for (const auto& [name, act] : acts) {
    World one = fuzz::small_world(0, 0), other = fuzz::small_world(0, 0);
    std::vector<fuzz::Record> records = record(one, 6, act);
    records.push_back({fuzz::next_recording, {}});
    const std::vector<fuzz::Record> second = record(other, 7, [](World&, int) {});
    records.insert(records.end(), second.begin(), second.end());
    write(folder / ("parts-by-" + name), fuzz::bytes_of(records));
    if (name != "push") continue;
    // It holds a hash that it doesn't come to.
    std::ranges::find(records, RecordKind::Hash, &fuzz::Record::kind)->content[0] ^= std::byte{1};
    write(folder / "parts-after-damage", fuzz::bytes_of(records));
  }
}

// Writes a file as it is, and with one place damaged in each part of the format.
void write_damaged(const fs::path& folder, Input whole) {
  const Input begin(fuzz::whole_file.begin(), fuzz::whole_file.end());
  whole.insert(whole.begin(), begin.begin(), begin.end());
  write(folder / "whole", whole);
  for (const std::size_t from_begin : {4, 12, 16, 22, 30, 60, 300}) {
    Input damaged = whole;
    damaged.at(from_begin) ^= 0x10;
    write(folder / ("damaged-" + std::to_string(from_begin)), damaged);
  }
  for (const std::size_t from_end : {1, 10, 14, 45}) {
    Input damaged = whole;
    damaged.at(damaged.size() - from_end) ^= 0x10;
    write(folder / ("damaged-end-" + std::to_string(from_end)), damaged);
  }
  for (const std::size_t length : {6, 14, 20, 40, 2000}) {
    write(folder / ("cut-" + std::to_string(length)),
          {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length)});
  }
}

void write_recordings(const fs::path& folder) {
  for (std::size_t number = 0; number < fuzz::small_scenes.size(); ++number) {
    World world = fuzz::small_world(number, 10);
    Snapshot snapshot;
    const std::vector<fuzz::Record> records = record(world, 12, [&snapshot](World& its, int step) {
      act(its, step);
      if (step == 5) its.save(snapshot);
      if (step == 8) its.set_contact_filter([](const ContactCandidate& of) { return of.b.index % 3 != 0; });
      if (step == 9) its.set_contact_modifier([](ModifiableContact& contact) { contact.friction = 0.1; });
      if (step == 10) its.step(0.01, [](Forces& forces) { forces.forces().row(0).setConstant(1); });
      if (step == 11) its.restore(snapshot);
    });
    write(folder / plain(fuzz::small_scenes[number]), fuzz::bytes_of(records));
    if (number > 0) continue;
    const fuzz::ScratchFile file("seed");
    test::write_records(file.path(), records);
    write_damaged(folder, read(file.path()));
  }
  // Longer than from one key frame to the next but one, and one in which bodies fall asleep and are woken.
  World longer = fuzz::small_world(0, 10);
  write(folder / "longer", fuzz::bytes_of(record(longer, 24, [](World&, int) {})));
  World sleepy = fuzz::small_world(0, 10);
  write(folder / "sleepy", fuzz::bytes_of(record(sleepy, 20, [](World& world, int step) {
          if (step == 0) world.set_settings({.sleeping = true, .sleep_speed = 1, .time_to_sleep = 0.02});
          if (step == 12) world.wake(world.bodies().back());
        })));
  write_pairs(folder);
}

void write_programs(const fs::path& folder) {
  std::mt19937 random(1);
  for (int i = 0; i < 200; ++i) {
    Input input(500 + 10 * static_cast<std::size_t>(i));
    for (std::uint8_t& byte : input) byte = static_cast<std::uint8_t>(random());
    write(folder / ("random-" + std::to_string(i)), input);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::cerr << "usage: " << argv[0] << " FOLDER [SCENE FILE]...\n";
    return 2;
  }
  const fs::path folder = argv[1];
  write_scenes(folder / "scene", std::span(argv + 2, static_cast<std::size_t>(argc - 2)));
  write_snapshots(folder / "snapshot");
  write_recordings(folder / "recording");
  for (const char* const target : {"api", "batch", "changes", "contacts", "direct", "forces", "geometry", "joints",
                                   "mechanism", "queries", "solids"})
    write_programs(folder / target);
}
