// Writes inputs to begin with, a folder for each target: built-in scenes and the scene files given as text, as
// snapshots and as recordings; and programs of random bytes.

#include <atoll/snapshot.h>

#include <filesystem>
#include <fstream>
#include <ios>
#include <iostream>
#include <iterator>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "records.h"
#include "scratch_file.h"
#include "small_scenes.h"

namespace {

using namespace atl;
namespace fs = std::filesystem;
using Input = std::vector<std::uint8_t>;

Input read(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

void write(const fs::path& path, const Input& input) {
  fs::create_directories(path.parent_path());
  std::ofstream stream(path, std::ios::binary);
  stream.write(reinterpret_cast<const char*>(input.data()), static_cast<std::streamsize>(input.size()));
  if (!stream.flush()) throw std::runtime_error("cannot write " + path.string());
}

Input text(const std::string& words) { return {words.begin(), words.end()}; }

std::string plain(const std::string& name) { return name.substr(0, name.find(':')); }

void write_scenes(const fs::path& folder, std::span<char*> files) {
  for (const char* name : fuzz::small_scenes) write(folder / plain(name), text(scene_text(load_scene(name))));
  for (const BuiltinScene& scene : builtin_scenes()) {
    // All parameters, and the least of each that is a count.
    std::string name = scene.name;
    for (const SceneParameter& parameter : scene.parameters) {
      std::ostringstream value;
      value << (parameter.integer ? parameter.min : parameter.value);
      name += (name == scene.name ? ":" : ",") + parameter.name + "=" + value.str();
    }
    write(folder / ("named-" + scene.name), text(name));
  }
  const std::string mesh =
      "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0.5\nv 1 1 1\nf 1 2 3\nf 1/1 3/3 4/4\nf 1 2 5 # a comment\n";
  for (const char* type : {"mesh", "hull"}) {
    const std::string shape = std::string("{\"type\": \"") + type + "\", \"file\": \"mesh.obj\", \"scale\": [1, 2, 1]}";
    write(folder / (std::string("wavefront-") + type),
          text("{\"format\": \"atoll-scene\", \"version\": 1, \"bodies\": [{\"type\": \"static\", \"shape\": " + shape +
               "}]}" + '\0' + mesh));
  }
  for (const char* file : files) write(folder / fs::path(file).filename(), read(file));
}

void write_snapshots(const fs::path& folder) {
  const fuzz::ScratchFile file("seed");
  for (std::size_t number = 0; number < fuzz::small_scenes.size(); ++number) {
    for (const int steps : {0, 40}) {
      Snapshot snapshot;
      fuzz::small_world(number, steps).save(snapshot);
      snapshot.write(file.path());
      const Input whole = read(file.path());
      const fs::path name = plain(fuzz::small_scenes[number]) + "-" + std::to_string(steps);
      for (const std::size_t into : {std::size_t{0}, number + 1}) {
        Input input(whole.begin() + 32, whole.end());
        input.insert(input.begin(), static_cast<std::uint8_t>(into));
        write(folder / (name.string() + "-" + std::to_string(into)), input);
      }
      Input input = whole;
      input.insert(input.begin(), 0x80);
      write(folder / (name.string() + "-whole"), input);
    }
  }
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

void write_recordings(const fs::path& folder) {
  const fuzz::ScratchFile file("seed");
  for (std::size_t number = 0; number < fuzz::small_scenes.size(); ++number) {
    World world = fuzz::small_world(number, 10);
    world.record(file.path(), {.body_hash_interval = 4, .few_bodies = 0});
    Snapshot snapshot;
    for (int step = 0; step < 12; ++step) {
      act(world, step);
      if (step == 5) world.save(snapshot);
      if (step == 8) world.set_contact_filter([](const ContactCandidate& of) { return of.b.index % 3 != 0; });
      if (step == 9) world.set_contact_modifier([](ModifiableContact& contact) { contact.friction = 0.1; });
      if (step == 10) world.step(0.01, [](Forces& forces) { forces.forces().row(0).setConstant(1); });
      if (step == 11) world.restore(snapshot);
      world.step(1.0 / 60);
    }
    world.stop_recording();
    write(folder / plain(fuzz::small_scenes[number]), fuzz::bytes_of(test::read_records(file.path())));
    if (number == 0) write(folder / "whole", read(file.path()));
  }
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
  write_programs(folder / "api");
}
