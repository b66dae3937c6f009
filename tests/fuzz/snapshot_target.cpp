// Snapshots from files. The input's first byte chooses the world that it is restored into, an empty one or one of
// small_scenes.h. The rest of the input is what follows a file's header, which is made right here: the checksum would
// keep all else out. If the byte's high bit is set the rest is the whole file. In memory it is the same as in a file.

#include <atoll/snapshot.h>

#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "few_steps.h"
#include "finding.h"
#include "scratch_file.h"
#include "small_scenes.h"
#include "state/files.h"
#include "target.h"

namespace {

using namespace atl;
constexpr std::size_t header_size = 32;

// Behind the header that any snapshot has, less what is of its content.
std::vector<std::byte> with_header(std::span<const std::byte> content) {
  static const std::vector<std::byte> header = [] {
    Snapshot snapshot;
    World().save(snapshot);
    return snapshot.to_bytes();
  }();
  std::vector<std::byte> bytes(header.begin(), header.begin() + header_size);
  const std::uint64_t length = content.size();
  const std::uint64_t checksum = checksum_of(content);
  std::memcpy(bytes.data() + 16, &length, sizeof length);
  std::memcpy(bytes.data() + 24, &checksum, sizeof checksum);
  bytes.insert(bytes.end(), content.begin(), content.end());
  return bytes;
}

// A saved world must be readable.
Snapshot saved_again(std::span<const std::byte> bytes) {
  try {
    return Snapshot::from_bytes(bytes);
  } catch (const Error& error) {
    throw fuzz::Finding(std::string("a world's own snapshot is refused: ") + error.what());
  }
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
  const std::vector<std::byte> bytes = again.to_bytes();
  const Snapshot copy = saved_again(bytes);
  fuzz::require(copy.to_bytes() == bytes, "a snapshot is other bytes after it was read");
  world.restore(copy);
  fuzz::require(world.state_hash() == hash, "a world goes back to another state than it saved");
  fuzz::few_steps(world, 2);
  fuzz::require(world.state_hash() == after, "a world that went back comes to another state");
}

// A snapshot, or the words after `place` with which it is refused.
template <typename Read>
std::optional<Snapshot> read(const std::string& place, std::string& words, const Read& make) {
  try {
    return make();
  } catch (const Error& error) {
    words = error.what();
    fuzz::require(words.starts_with(place + ": "), "found " + words + ", expected words on " + place);
    words.erase(0, place.size());
    return std::nullopt;
  }
}

// Reads a snapshot's file, and requires it to be refused in the same words as its bytes are.
std::optional<Snapshot> read_file(const fuzz::ScratchFile& file, std::span<const std::uint8_t> bytes) {
  file.write(bytes);
  std::string words, words_of_bytes;
  std::optional<Snapshot> snapshot =
      read("Snapshot::read: " + file.path(), words, [&] { return Snapshot::read(file.path()); });
  read("Snapshot::from_bytes", words_of_bytes, [&] { return Snapshot::from_bytes(std::as_bytes(bytes)); });
  fuzz::require(words == words_of_bytes, "a file is refused by \"" + words + "\" and its bytes by \"" + words_of_bytes);
  return snapshot;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::ScratchFile file("snapshot");
  if (size == 0) return 0;
  const std::size_t choice = data[0];
  const std::span<const std::uint8_t> content(data + 1, size - 1);
  try {
    const std::optional<Snapshot> snapshot =
        (choice & 0x80) != 0 ? read_file(file, content) : Snapshot::from_bytes(with_header(std::as_bytes(content)));
    if (!snapshot) return 0;
    World world;
    const std::size_t scene = (choice & 0x7f) % (fuzz::small_scenes.size() + 1);
    if (scene > 0) world = fuzz::small_world(scene - 1, 0);
    restore_and_go_on(world, *snapshot);
  } catch (const Error&) {
  }
  return 0;
}
