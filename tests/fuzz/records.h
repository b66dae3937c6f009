#pragma once
/// Recordings as inputs: records one after another, each as 2 bytes of its kind, 2 of its length and its content.
/// Checksums, which would keep all else out, are made right when the file is written.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "state/recording_file.h"

namespace atl::fuzz {

struct Record {
  std::uint16_t kind = 0;
  std::vector<std::uint8_t> content;
};

/// Any bytes are some records.
inline std::vector<Record> records_of(std::span<const std::uint8_t> bytes) {
  std::vector<Record> records;
  while (bytes.size() >= 4) {
    Record record;
    std::uint16_t length = 0;
    std::memcpy(&record.kind, bytes.data(), 2);
    std::memcpy(&length, bytes.data() + 2, 2);
    bytes = bytes.subspan(4);
    const std::span<const std::uint8_t> content = bytes.first(std::min<std::size_t>(length, bytes.size()));
    record.content.assign(content.begin(), content.end());
    bytes = bytes.subspan(content.size());
    records.push_back(std::move(record));
  }
  return records;
}

inline std::vector<std::uint8_t> bytes_of(const std::vector<Record>& records) {
  std::vector<std::uint8_t> bytes;
  for (const Record& record : records) {
    const auto length = static_cast<std::uint16_t>(record.content.size());
    for (const std::uint16_t number : {record.kind, length}) {
      bytes.push_back(static_cast<std::uint8_t>(number & 0xff));
      bytes.push_back(static_cast<std::uint8_t>(number >> 8));
    }
    bytes.insert(bytes.end(), record.content.begin(), record.content.end());
  }
  return bytes;
}

/// Those of a file; records of more than 64 KiB are left out.
inline std::vector<Record> read_records(const std::string& path) {
  std::vector<Record> records;
  RecordingReader reader(path);
  while (reader.next()) {
    if (reader.content().size() > 0xffff) continue;
    Record record{.kind = static_cast<std::uint16_t>(reader.kind()), .content = {}};
    for (const std::byte byte : reader.content()) record.content.push_back(static_cast<std::uint8_t>(byte));
    records.push_back(std::move(record));
  }
  return records;
}

inline void write_records(const std::string& path, const std::vector<Record>& records) {
  RecordingWriter writer("fuzz", path);
  for (const Record& record : records) {
    writer.write(static_cast<RecordKind>(record.kind), std::as_bytes(std::span(record.content)));
  }
  writer.finish("fuzz");
}

}  // namespace atl::fuzz
