// Recordings from files, replayed. An input is records.h's; one that begins with the words of a file's header is the
// file as it is.

#include <atoll/error.h>
#include <atoll/recording.h>

#include <cstdlib>
#include <random>
#include <string_view>
#include <utility>

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
