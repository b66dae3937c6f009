// Worlds in files: snapshots, recordings and scene files.

#include <atoll/recording.h>
#include <atoll/snapshot.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "consistency.h"
#include "finding.h"
#include "program_run.h"

namespace atl::fuzz {

void save(Run& run) {
  const std::size_t slot = run.bytes.below(2);
  std::vector<Snapshot>& all = run.snapshots[slot];
  all.resize(run.worlds.worlds().size());
  run.call("save", [&](World& world, std::size_t number) { world.save(all[number]); });
  run.hashes[slot] = run.worlds.first().state_hash();
}

void restore(Run& run) {
  const std::size_t slot = run.bytes.below(2);
  const std::vector<Snapshot>& all = run.snapshots[slot];
  if (all.empty()) return;
  // Its own, another's or one from a file: those of other worlds have to be of the same bodies.
  const std::uint32_t way = run.bytes.below(4);
  if (way == 3) all.front().write(run.file.path());
  const std::string error = run.call("restore", [&](World& world, std::size_t number) {
    if (way == 3) return world.restore(Snapshot::read(run.file.path()));
    world.restore(all[way == 2 ? (number + 1) % all.size() : number]);
  });
  require(way >= 2 || error.empty(), "a world doesn't go back to its own snapshot: " + error);
  if (!error.empty()) return;
  require(run.worlds.first().state_hash() == run.hashes[slot], "a restored world has another hash than the saved one");
  check_world(run.worlds.first());
}

void stop_recording(Run& run, const ReplayOptions& options) {
  run.worlds.first().stop_recording();
  const ReplayResult result = replay(run.recording.path(), options);
  if (result.divergence) {
    std::string found =
        "a replay comes to something else from step " + std::to_string(result.divergence->step) + " on:";
    for (const ReplayedBody& body : result.divergence->bodies) {
      found += " body " + std::to_string(body.id.index);
      for (const std::string& part : body.parts) found += " " + part;
    }
    throw Finding(found);
  }
  require(result.complete && result.steps == result.recorded_steps, "a replay ends too soon");
}

void record(Run& run) {
  if (run.limits.trace) std::cerr << run.result.calls << " record\n";
  if (run.worlds.first().is_recording())
    return stop_recording(run, {.threads = 1 + static_cast<int>(run.bytes.below(2))});
  run.worlds.first().record(run.recording.path(), {.body_hash_interval = 1 + static_cast<int>(run.bytes.below(4))});
}

// Bodies may have come to where a distance joint has no direction; neither worlds nor files take one that starts so.
bool has_closed_distance(const World& world) {
  const std::vector<JointId> joints = world.joints();
  return std::any_of(joints.begin(), joints.end(), [&](JointId id) {
    return std::holds_alternative<DistanceJoint>(world.joint(id).kind) && world.joint_state(id).position[0] < 1e-8;
  });
}

// A scene file of any world is read again, and bodies are as they were.
void write_as_scene(Run& run) {
  const World& world = run.worlds.first();
  if (world.body_count() == 0 || has_closed_distance(world)) return;  // of which there are no scene files
  const std::optional<std::string> written = chosen([&] { return scene_text(scene_of(world)); });
  require(written || !run.definitions.has_normal_numbers(), "a world can't be written as a scene file");
  if (!written) return;
  const std::string& text = *written;
  const Scene scene = parse_scene(text, "scene_of");
  World again({.gravity = scene.gravity, .settings = scene.settings});
  const std::vector<BodyId> ids = build_scene(scene, again);
  const std::vector<BodyId> before = world.bodies();
  require(ids.size() == before.size(), "a scene file has another number of bodies than its world");
  for (std::size_t i = 0; i < ids.size(); ++i) {
    require(again.velocity(ids[i]) == world.velocity(before[i]), "a scene file changes a velocity");
  }
}

// The end of a world ends its recording.
void end_while_recording(Run& run) {
  const World& world = run.worlds.first();
  {
    World alone({.gravity = world.gravity(), .settings = world.settings()});
    alone.record(run.file.path());
    for (const BodyId id : world.bodies()) alone.add_body(world.definition(id));
    alone.step(1.0 / 60);
  }
  require(is_recording(run.file.path()), "a recording is none");
  const ReplayResult result = replay(run.file.path());
  require(result.complete && result.steps == 1 && !result.divergence, "a recording ends otherwise with its world");
}

namespace {

// A folder has taken the name in the meantime: there is no file, and no recording any more.
void lose_a_recording(const std::string& path) {
  World world;
  world.record(path);
  std::filesystem::create_directory(path);
  require_refused("a recording in place of a folder", [&] { world.stop_recording(); });
  require(!world.is_recording() && !std::filesystem::exists(path + ".partial"), "something stays of a lost recording");
  std::filesystem::remove(path);
}

}  // namespace

// Each is told, and nothing else comes of it.
void use_files_that_cannot_be(Run& run) {
  World& world = run.worlds.first();
  const std::uint64_t before = world.state_hash();
  run.file.write({});  // no file of any kind, and no folder
  const std::string none = run.file.path(), within = none + "/file";
  if (!world.is_recording()) {
    require_refused("the end of no recording", [&] { world.stop_recording(); });
    for (const std::string& path : {within, std::string("/dev"), std::string("/dev/null")}) {
      require_refused("a recording to " + path, [&] { world.record(path); });
    }
    require_refused("a recording without hashes", [&] { world.record(none, {.body_hash_interval = 0}); });
    require(!world.is_recording(), "a recording that was refused is under way");
  } else {
    require_refused("a second recording", [&] { world.record(none); });
  }
  require(!is_recording(none) && !is_recording(within), "no file is a recording");
  require_refused("a replay of no recording", [&] { replay(none); });
  require_refused("a replay of no file", [&] { replay(within); });
  require_refused("a replay of a folder", [&] { replay("/dev"); });
  Snapshot snapshot;
  require_refused("no state", [&] { world.restore(snapshot); });
  require_refused("bytes of no state", [&] { snapshot.to_bytes(); });
  require_refused("a file of no state", [&] { snapshot.write(none); });
  world.save(snapshot);
  require_refused("a snapshot within a file", [&] { snapshot.write(within); });
  for (const std::string& path : {none, within, std::string("/dev")}) {
    require_refused("a snapshot of " + path, [&] { Snapshot::read(path); });
    require_refused("a scene of " + path, [&] { load_scene(path + ".json"); });
  }
  require_refused("a scene file within a file", [&] { write_scene(load_scene("stack:height=1"), within); });
  lose_a_recording(none + "-lost");
  require(world.state_hash() == before, "files that cannot be change a world");
}

}  // namespace atl::fuzz
