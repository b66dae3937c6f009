// Recordings from files: replayed, gone through to and fro, and held against themselves. An input is records.h's; one
// that begins with the words of a file's header is the file as it is.

#include <atoll/error.h>
#include <atoll/parting.h>
#include <atoll/playback.h>
#include <atoll/recording.h>
#include <atoll/world.h>

#include <cstdlib>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "finding.h"
#include "records.h"
#include "scratch_file.h"
#include "target.h"

namespace {

using namespace atl;

// A replay has no end that an input could not put off: so many steps are enough.
constexpr std::int64_t most_steps = 40;
struct Enough {};

void stop_at(std::int64_t steps, std::int64_t) {
  if (steps >= most_steps) throw Enough{};
}

// Whatever order its steps are looked at in, each is the same.
void go_through(const std::string& path) {
  Playback playback(path, {.key_frame_bytes = std::size_t{1} << 20});
  if (playback.steps() > most_steps) return;
  std::vector<std::uint64_t> hashes = {playback.world().state_hash()};
  while (playback.advance()) hashes.push_back(playback.world().state_hash());
  if (playback.divergence()) return;
  const auto steps = static_cast<std::int64_t>(hashes.size()) - 1;
  for (const std::int64_t step : {steps / 2, std::int64_t{0}, steps, steps / 3}) {
    playback.seek(step);
    fuzz::require(playback.world().state_hash() == hashes[static_cast<std::size_t>(step)],
                  "a step of a recording is another when it is come to otherwise");
  }
  fuzz::require(!find_parting(path, path).parting, "a recording parts from itself");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::ScratchFile file("recording");
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    if (text.starts_with("ATOLLREC")) {
      file.write({data, size});
    } else {
      test::write_records(file.path(), fuzz::records_of({data, size}));
    }
    replay(file.path(), {.on_step = stop_at});
    go_through(file.path());
  } catch (const Error&) {
  } catch (const Enough&) {
  }
  return 0;
}

#ifdef ATOLL_LIBFUZZER
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

// Changes one record in what libFuzzer would do, or which there are.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned int seed) {
  std::minstd_rand random(seed);
  std::vector<fuzz::Record> records = fuzz::records_of({data, size});
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  if (records.empty() || text.starts_with("ATOLLREC") || random() % 16 == 0) {
    return LLVMFuzzerMutate(data, size, max_size);
  }
  fuzz::Record& record = records[random() % records.size()];
  switch (random() % 8) {
    case 0:
      std::swap(record, records[random() % records.size()]);
      break;
    case 1:
      records.push_back(record);
      break;
    case 2:
      records.erase(records.begin() + static_cast<std::ptrdiff_t>(random() % records.size()));
      break;
    case 3:
      record.kind = static_cast<RecordKind>(random() % 2 != 0 ? random() % 14 : 256 + random() % 26);
      break;
    default: {
      const std::size_t length = record.content.size();
      const std::size_t room = std::min<std::size_t>(length + 64, 0xffff);
      record.content.resize(room);
      auto* const content = reinterpret_cast<std::uint8_t*>(record.content.data());
      record.content.resize(LLVMFuzzerMutate(content, length, room));
    }
  }
  const std::vector<std::uint8_t> bytes = fuzz::bytes_of(records);
  if (bytes.empty() || bytes.size() > max_size) return size;
  std::memcpy(data, bytes.data(), bytes.size());
  return bytes.size();
}
#endif
