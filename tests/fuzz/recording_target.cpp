// Recordings from files, one or two to an input as records.h has it: replayed, gone through to and fro, and held
// against themselves and each other.

#include <atoll/error.h>
#include <atoll/first_difference.h>
#include <atoll/playback.h>
#include <atoll/recording.h>
#include <atoll/world.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
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
constexpr std::int64_t max_steps = 40;
struct Enough {};

void stop_at(std::int64_t steps, std::int64_t) {
  if (steps >= max_steps) throw Enough{};
}

using fuzz::next_recording;
using fuzz::whole_file;

// Whatever order its steps are looked at in, and whatever memory there is for it, each is the same.
void go_through(const std::string& path, std::size_t key_frame_bytes) {
  Playback opened(path, {.key_frame_bytes = key_frame_bytes});
  if (opened.steps() > max_steps) return;
  Playback playback = std::move(opened);
  std::vector<std::uint64_t> hashes = {playback.world().state_hash()};
  while (playback.advance()) {
    hashes.push_back(playback.world().state_hash());
    fuzz::require(playback.dt() > 0 && playback.step() == static_cast<std::int64_t>(hashes.size()) - 1,
                  "a step of a recording is not where it stands");
  }
  if (playback.divergence()) return;
  const auto steps = static_cast<std::int64_t>(hashes.size()) - 1;
  const auto seek = [&](std::int64_t step) {
    playback.seek(step);
    fuzz::require(playback.world().state_hash() == hashes[static_cast<std::size_t>(step)],
                  "a step of a recording is another when it is come to otherwise");
  };
  for (const std::int64_t step : {steps / 2, std::int64_t{0}, steps, steps / 3, steps}) seek(step);
  if (key_frame_bytes > 0) {
    for (std::int64_t step = steps; step >= 0; --step) seek(step);
  }
  fuzz::require_refused("a step after the last", [&] { playback.seek(playback.steps() + 1); });
  fuzz::require_refused("a step before the first", [&] { playback.seek(-1); });
}

// The one parts from the other where that does from it, and neither from itself.
void part(const std::string& first, const std::string& second) {
  const FirstDifferenceResult found = find_first_difference(first, second), back = find_first_difference(second, first);
  fuzz::require(found.steps == back.steps && found.difference.has_value() == back.difference.has_value(),
                "recordings part in one order alone");
  if (found.difference) {
    const FirstDifference &difference = *found.difference, &its = *back.difference;
    fuzz::require(difference.step >= 1 && difference.step <= found.steps, "recordings part in a step that neither has");
    fuzz::require(difference.step == its.step && difference.by_calls == its.by_calls && difference.phase == its.phase &&
                      difference.bodies_step == its.bodies_step && difference.bodies.size() == its.bodies.size(),
                  "recordings part otherwise in the other order");
    fuzz::require(!difference.bodies_step || *difference.bodies_step >= difference.step,
                  "bodies part before their worlds");
  }
  fuzz::require(!find_first_difference(first, first).difference, "a recording parts from itself");
}

void replay_all(const std::string& path) {
  replay(path, {.on_step = stop_at});
  fuzz::require(is_recording(path), "a recording is replayed that is none");
}

void run(std::span<const std::uint8_t> input) {
  static const fuzz::ScratchFile file("recording"), other("other-recording");
  constexpr std::array<std::size_t, 3> memory = {std::size_t{1} << 20, 20000, 0};
  const std::string_view text(reinterpret_cast<const char*>(input.data()), input.size());
  std::vector<fuzz::Record> records;
  auto next = records.begin();
  if (text.starts_with(whole_file)) {
    file.write(input.subspan(whole_file.size()));
  } else {
    records = fuzz::records_of(input);
    next = std::ranges::find(records, next_recording, &fuzz::Record::kind);
    test::write_records(file.path(), {records.begin(), next});
  }
  replay_all(file.path());
  go_through(file.path(), memory[input.size() % memory.size()]);
  if (next == records.end()) return part(file.path(), file.path());
  test::write_records(other.path(), {next + 1, records.end()});
  replay_all(other.path());
  part(file.path(), other.path());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    run({data, size});
  } catch (const Error&) {
  } catch (const Enough&) {
  }
  return 0;
}

// Changes one record in what libFuzzer would do, or which there are.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned int seed) {
  std::minstd_rand random(seed);
  std::vector<fuzz::Record> records = fuzz::records_of({data, size});
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  if (records.empty() || text.starts_with(whole_file) || random() % 16 == 0) {
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
      if (random() % 16 == 0) record.kind = next_recording;
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
