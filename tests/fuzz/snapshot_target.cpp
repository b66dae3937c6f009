// Snapshots from files. The input's first byte chooses the world that it is restored into, an empty one or one of
// small_scenes.h. The rest of the input is what follows a file's header, which is made right here: the checksum would
// keep all else out. If the byte's high bit is set the rest is the whole file.

#include <atoll/snapshot.h>

#include <cstring>
#include <fstream>
#include <ios>
#include <iterator>
#include <vector>

#include "few_steps.h"
#include "finding.h"
#include "scratch_file.h"
#include "small_scenes.h"
#include "state/checksum.h"
#include "target.h"

namespace {

using namespace atl;
constexpr std::size_t header_size = 32;

// The header of any snapshot's file, less what is of its content.
std::vector<std::uint8_t> a_header(const fuzz::ScratchFile& file) {
  Snapshot snapshot;
  World().save(snapshot);
  snapshot.write(file.path());
  std::ifstream stream(file.path(), std::ios::binary);
  std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  bytes.resize(header_size);
  return bytes;
}

std::vector<std::uint8_t> with_header(const std::vector<std::uint8_t>& header, std::span<const std::uint8_t> content) {
  std::vector<std::uint8_t> bytes = header;
  const std::uint64_t length = content.size();
  const std::uint64_t checksum = checksum_of(std::as_bytes(content));
  std::memcpy(bytes.data() + 16, &length, sizeof length);
  std::memcpy(bytes.data() + 24, &checksum, sizeof checksum);
  bytes.insert(bytes.end(), content.begin(), content.end());
  return bytes;
}

void restore_and_go_on(World& world, const Snapshot& snapshot) {
  const std::uint64_t before = world.state_hash();
  try {
    world.restore(snapshot);
  } catch (const Error&) {
    fuzz::require(world.state_hash() == before, "a snapshot that is refused changes the world");
    return;
  }
  Snapshot again;
  world.save(again);
  const std::uint64_t hash = world.state_hash();
  fuzz::few_steps(world, 2);
  const std::uint64_t after = world.state_hash();
  world.restore(again);
  fuzz::require(world.state_hash() == hash, "a world goes back to another state than it saved");
  fuzz::few_steps(world, 2);
  fuzz::require(world.state_hash() == after, "a world that went back comes to another state");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::ScratchFile file("snapshot");
  static const std::vector<std::uint8_t> header = a_header(file);
  if (size == 0) return 0;
  const std::size_t choice = data[0];
  const std::span<const std::uint8_t> content(data + 1, size - 1);
  if ((choice & 0x80) != 0) {
    file.write(content);
  } else {
    file.write(with_header(header, content));
  }
  try {
    const Snapshot snapshot = Snapshot::read(file.path());
    World world;
    const std::size_t scene = (choice & 0x7f) % (fuzz::small_scenes.size() + 1);
    if (scene > 0) world = fuzz::small_world(scene - 1, 0);
    restore_and_go_on(world, snapshot);
  } catch (const Error&) {
  }
  return 0;
}
