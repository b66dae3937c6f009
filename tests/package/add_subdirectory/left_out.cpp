#include "left_out.h"

#include <atoll/error.h>
#include <atoll/recording.h>
#include <atoll/snapshot.h>
#include <atoll/world.h>

#include <functional>
#include <iostream>
#include <string>
#include <vector>

namespace {

struct Call {
  const char* option;
  std::function<void(atl::World& world)> make;
};

const std::vector<atl::Vector3> corners = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

const Call calls[] = {
    {"JOINTS", [](atl::World& world) { world.add_joint({.first = world.add_body({}), .second = world.add_body({})}); }},
    {"MESHES",
     [](atl::World&) {
       const std::vector<atl::TriangleMesh::Indices> triangles = {{0, 1, 2}};
       atl::TriangleMesh(corners, triangles);
     }},
    {"MESHES",
     [](atl::World&) {
       atl::HeightField(2, 2, 1, 1, {0, 0, 0, 0});
     }},
    {"HULLS", [](atl::World&) { atl::ConvexHull{corners}; }},
    {"SURFACES", [](atl::World& world) { world.add_body({.material = {.rolling_friction = 0.1}}); }},
    {"SURFACES", [](atl::World& world) { world.add_body({.material = {.torsional_friction = 0.1}}); }},
    {"SURFACES",
     [](atl::World& world) {
       world.add_body({.surface_velocity = {1, 0, 0}});
     }},
    {"SURFACES",
     [](atl::World& world) {
       world.set_surface_velocity(world.add_body({}), {1, 0, 0});
     }},
    {"RESTITUTION", [](atl::World& world) { world.add_body({.material = {.restitution = 0.5}}); }},
    {"CONTINUOUS", [](atl::World& world) { world.add_body({.continuous = true}); }},
    {"SNAPSHOTS",
     [](atl::World& world) {
       atl::Snapshot snapshot;
       world.save(snapshot);
     }},
    {"SNAPSHOTS", [](atl::World& world) { world.restore(atl::Snapshot()); }},
    {"SNAPSHOTS", [](atl::World&) { atl::Snapshot::read("none"); }},
    {"RECORDING", [](atl::World& world) { world.record("none"); }},
    {"RECORDING", [](atl::World&) { atl::replay("none"); }},
};

bool throws_of(const Call& call, std::size_t index) {
  const std::string expected = std::string("configure with -DATOLL_WITH_") + call.option + "=ON";
  std::string found = "nothing was thrown";
  try {
    atl::World world;
    call.make(world);
  } catch (const atl::Error& error) {
    found = error.what();
  }
  if (found.find(expected) != std::string::npos) return true;
  std::cerr << "call " << index << ": " << found << "; expected \"... " << expected << "\"\n";
  return false;
}

}  // namespace

bool everything_throws() {
  bool all = true;
  for (std::size_t i = 0; i < std::size(calls); ++i) all &= throws_of(calls[i], i);
  return all;
}
