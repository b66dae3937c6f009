#pragma once
/// Recordings taken apart and put together again, with other things in them and right checksums.

#include <cstddef>
#include <cstring>
#include <filesystem>
#include <vector>

#include "state/recorded_calls.h"
#include "state/recording_file.h"

namespace atl::test {

struct Record {
  RecordKind kind;
  std::vector<std::byte> content;
};

inline std::vector<Record> read_records(const std::filesystem::path& path) {
  std::vector<Record> records;
  RecordingReader reader(path);
  while (reader.next()) records.push_back({reader.kind(), {reader.content().begin(), reader.content().end()}});
  return records;
}

inline void write_records(const std::filesystem::path& path, const std::vector<Record>& records) {
  RecordingWriter writer("test", path);
  for (const Record& record : records) writer.write(record.kind, record.content);
  writer.finish("test");
}

/// Changes the force along x by a part in a few thousand in the recording's `count`th call of World::apply_force, from
/// 0.
inline void change_a_force(const std::filesystem::path& path, int count) {
  std::vector<Record> records = read_records(path);
  for (Record& record : records) {
    if (record.kind != kind_of<calls::ApplyForce>() || count-- != 0) continue;
    record.content.at(sizeof(BodyId) + 5) ^= std::byte{1};  // of eight bytes, the lowest first
  }
  write_records(path, records);
}

}  // namespace atl::test
