// Parcels drop onto a belt all the time and leave the world at its end: bodies come and go while it runs. Where they
// are is streamed as lines of CSV, every tenth step; halfway, the world is saved and taken back, as a client may ask.

#include <atoll/atoll.h>
#include <atoll/snapshot.h>

#include <cstdint>
#include <iostream>
#include <string_view>
#include <unordered_map>

namespace {

constexpr int steps = 1200;

struct Stream {
  atl::World world{atl::WorldDef{.gravity = {0, 0, -9.81}, .settings = {.sleeping = true}}};
  int dropped = 0;
  int delivered = 0;

  Stream() {
    world.add_body({.type = atl::BodyType::Static,
                    .shape = atl::Box{.half_extents = {5, 0.6, 0.1}},
                    .position = {0, 0, 0.9},
                    .material = {.friction = 0.8},
                    .surface_velocity = {1, 0, 0}});
  }

  void step(int number) {
    if (number % 30 == 0) {
      const double size = 0.1 + 0.02 * (dropped % 5);
      world.add_body({.shape = atl::Box{.half_extents = {size, 0.8 * size, 0.6 * size}},
                      .position = {-4.5, 0, 1.5},
                      .density = 200});
      ++dropped;
    }
    world.step(1.0 / 60);
    for (const atl::BodyId id : world.bodies()) {
      if (world.type(id) != atl::BodyType::Dynamic || world.pose(id).position.z() > 0.5) continue;
      world.remove_body(id);
      ++delivered;
    }
  }
};

void write(std::ostream& out, int number, const atl::World& world) {
  for (const atl::BodyId id : world.bodies()) {
    if (world.type(id) != atl::BodyType::Dynamic) continue;
    out << number << "," << id.index << "," << id.generation;
    const atl::Vector3 position = world.pose(id).position;
    for (int axis = 0; axis < 3; ++axis) out << "," << position[axis];
    out << "\n";
  }
}

}  // namespace

int main(int argc, char** argv) {
  const bool quiet = argc < 2 || std::string_view(argv[1]) != "--csv";
  Stream stream;
  atl::Snapshot halfway;
  int dropped_halfway = 0, delivered_halfway = 0;
  for (int number = 0; number < steps; ++number) {
    if (number == steps / 2) {
      stream.world.save(halfway);
      dropped_halfway = stream.dropped, delivered_halfway = stream.delivered;
    }
    stream.step(number);
    if (!quiet && number % 10 == 0) write(std::cout, number, stream.world);
  }
  const std::uint64_t end = stream.world.state_hash();
  const int delivered = stream.delivered;

  stream.world.restore(halfway);
  stream.dropped = dropped_halfway, stream.delivered = delivered_halfway;
  for (int number = steps / 2; number < steps; ++number) stream.step(number);
  const bool same = stream.world.state_hash() == end && stream.delivered == delivered;
  std::cerr << stream.dropped << " parcels dropped, " << delivered << " delivered, " << stream.world.body_count() - 1
            << " on their way; taken back to the middle and run again, it comes to "
            << (same ? "the same bits" : "something else") << "\n";
  return same && delivered > 10 ? 0 : 1;
}
