// Snapshots as files: a header, then the world definition and the state as they are in memory, with lengths before
// them.

#include <atoll/error.h>
#include <atoll/snapshot.h>
#include <atoll/world.h>
#include <features/with_snapshots.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <ios>
#include <iterator>
#include <string>
#include <system_error>

#include "state/files.h"
#include "state/hex.h"
#include "state/state_archive.h"
#include "state/world_definition_state.h"
#include "world/left_out.h"
#include "world/world_impl.h"

namespace atl {
namespace {

namespace fs = std::filesystem;

struct Header {
  FileHeader begin = {.magic = {'A', 'T', 'O', 'L', 'L', 'S', 'N', 'P'}, .version = 22};
  std::uint64_t length = 0;    // bytes that follow the header
  std::uint64_t checksum = 0;  // of these
};
static_assert(sizeof(Header) == 32);

// `place` names the source of the bytes: "Snapshot::read: a/b.snapshot".
[[noreturn]] void fail(const std::string& place, const std::string& why) { throw Error(place + ": " + why); }

std::string place_of(const char* call, const fs::path& path) {
  return std::string("Snapshot::") + call + ": " + path.string();
}

std::vector<char> read_all(const fs::path& path) {
  const std::string place = place_of("read", path);
  if (const std::string kind = irregular_kind(path); !kind.empty())
    fail(place, "is " + kind + "; expected a snapshot's file");
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  std::vector<char> bytes{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  if (!stream.is_open() || stream.bad()) {
    fail(place, std::generic_category().message(errno != 0 ? errno : EIO));
  }
  return bytes;
}

// The bytes after the header, once they are known to be complete.
std::span<const std::byte> checked_content(const std::string& place, std::span<const std::byte> bytes) {
  const Header expected;
  Header header;
  const std::array<char, 8>& magic = expected.begin.magic;
  if (bytes.size() < magic.size() || std::memcmp(magic.data(), bytes.data(), magic.size()) != 0) {
    fail(place, "does not begin with \"ATOLLSNP\"; expected a snapshot's file");
  }
  if (bytes.size() < sizeof header) {
    fail(place, "found " + std::to_string(bytes.size()) + " bytes; expected a header of " +
                    std::to_string(sizeof header) + " at least");
  }
  std::memcpy(&header, bytes.data(), sizeof header);
  if (const std::string fault = fault_of(header.begin, expected.begin); !fault.empty()) fail(place, fault);
  const std::span<const std::byte> content = bytes.subspan(sizeof header);
  if (content.size() != header.length) {
    fail(place, "found " + std::to_string(content.size()) + " bytes after the header; expected " +
                    std::to_string(header.length));
  }
  if (const std::uint64_t checksum = checksum_of(content); checksum != header.checksum) {
    fail(place, "found the checksum " + hex(checksum) + "; expected " + hex(header.checksum) + ": the file is damaged");
  }
  return content;
}

}  // namespace

bool Snapshot::owns_bytes() const {
  if (bytes_.use_count() != 1) return false;
  // Another thread may have had a copy until now: what it read of them comes before what is written.
  std::atomic_thread_fence(std::memory_order_acquire);
  return true;
}

void Snapshot::fit(const Snapshot& other) {
  const std::span<const std::byte> own = state();
  const bool same = std::ranges::equal(own, other.state());
  bytes_ = same ? other.bytes_ : std::make_shared<std::vector<std::byte>>(own.begin(), own.end());
}

std::vector<std::byte> Snapshot::to_bytes() const {
  if (empty()) fail("Snapshot::to_bytes", "the snapshot is empty; expected one that holds a state");
  std::vector<std::byte> content;
  StateWriter writer(content);
  write_definition_of_world(writer, *world_definition_);
  writer.values(bytes_->data(), size_);
  content.resize(writer.size());
  Header header;
  header.length = content.size();
  header.checksum = checksum_of(content);
  const auto* begin = reinterpret_cast<const std::byte*>(&header);
  content.insert(content.begin(), begin, begin + sizeof header);
  return content;
}

void Snapshot::write(const std::string& path) const {
  const std::string place = place_of("write", path);
  if (empty()) fail(place, "the snapshot is empty; expected one that holds a state");
  const std::vector<std::byte> bytes = to_bytes();
  const std::error_code error = replace_file(path, [&](std::ostream& out) {
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  });
  if (error) fail(place, error.message());
}

Snapshot Snapshot::from_bytes(std::span<const std::byte> bytes) { return from_bytes(bytes, "Snapshot::from_bytes"); }

Snapshot Snapshot::from_bytes(std::span<const std::byte> bytes, const std::string& place) {
  if constexpr (!with_snapshots) throw_left_out((place + " is called").c_str(), "snapshots", "SNAPSHOTS");
  const std::span<const std::byte> content = checked_content(place, bytes);
  Snapshot snapshot;
  try {
    StateReader reader(content, {.from_file = true});
    std::shared_ptr<const WorldDefinition> world_definition = read_definition_of_world(reader);
    const std::span<const std::byte> state = content.last(reader.left());
    // Restores the state into a world of its own first: a fault found there can't harm another world.
    World::Impl::try_out(world_definition, state);
    snapshot.bytes_ = std::make_shared<std::vector<std::byte>>(state.begin(), state.end());
    snapshot.size_ = state.size();
    snapshot.world_definition_ = std::move(world_definition);
  } catch (const Error& error) {
    fail(place, error.what());
  }
  return snapshot;
}

Snapshot Snapshot::read(const std::string& path) {
  const std::string place = place_of("read", path);
  if constexpr (!with_snapshots) throw_left_out("Snapshot::read is called", "snapshots", "SNAPSHOTS");
  const std::vector<char> file = read_all(path);
  return from_bytes(std::as_bytes(std::span(file)), place);
}

}  // namespace atl
