#pragma once
/// The header of files with snapshots and recordings.

#include <array>
#include <cstdint>
#include <string>

#include "state/hex.h"

namespace atl {

struct FileHeader {
  std::array<char, 8> magic = {};
  std::uint32_t order = 0x01020304;  // reads otherwise in another byte order
  std::uint32_t version = 0;         // of all that follows
};
static_assert(sizeof(FileHeader) == 16);

/// Describes a wrong byte order or version of a file, in a message's words; empty if both are as expected.
inline std::string fault_of(const FileHeader& header, const FileHeader& expected) {
  if (header.order != expected.order) {
    return "found the byte order " + hex(header.order) + "; expected this machine's, " + hex(expected.order);
  }
  if (header.version != expected.version) {
    return "found version " + std::to_string(header.version) + "; expected " + std::to_string(expected.version);
  }
  return {};
}

}  // namespace atl
