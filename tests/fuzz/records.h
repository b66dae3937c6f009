#pragma once
/// Recordings as inputs: records one after another, each as 2 bytes of its kind, 2 of its length and its content.
/// Checksums, which would keep all else out, are made right when the file is written. Or a file as it is.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "support/recording_file.h"

namespace atl::fuzz {

using test::Record;

/// Kind of a marker between two recordings.
inline constexpr auto next_recording = static_cast<RecordKind>(0xffff);
/// Prefix of an input that continues with the bytes of a file.
inline constexpr std::string_view whole_file = "FILE";

/// Any bytes are some records.
inline std::vector<Record> records_of(std::span<const std::uint8_t> bytes) {
  std::vector<Record> records;
  while (bytes.size() >= 4) {
    std::uint16_t kind = 0, length = 0;
    std::memcpy(&kind, bytes.data(), 2);
    std::memcpy(&length, bytes.data() + 2, 2);
    bytes = bytes.subspan(4);
    const std::span content = std::as_bytes(bytes.first(std::min<std::size_t>(length, bytes.size())));
    records.push_back({static_cast<RecordKind>(kind), {content.begin(), content.end()}});
    bytes = bytes.subspan(content.size());
  }
  return records;
}

/// Records of more than 64 KiB are left out.
inline std::vector<std::uint8_t> bytes_of(const std::vector<Record>& records) {
  std::vector<std::uint8_t> bytes;
  for (const Record& record : records) {
    if (record.content.size() > 0xffff) continue;
    const auto kind = static_cast<std::uint16_t>(record.kind);
    const auto length = static_cast<std::uint16_t>(record.content.size());
    for (const std::uint16_t number : {kind, length}) {
      bytes.push_back(static_cast<std::uint8_t>(number & 0xff));
      bytes.push_back(static_cast<std::uint8_t>(number >> 8));
    }
    for (const std::byte byte : record.content) bytes.push_back(static_cast<std::uint8_t>(byte));
  }
  return bytes;
}

}  // namespace atl::fuzz
