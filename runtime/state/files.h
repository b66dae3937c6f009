#pragma once
/// Files as they are read and written: their headers, checksums, and how they are put in place.

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <span>
#include <string>
#include <system_error>

#include "state/hex.h"

namespace atl {

/// A new, empty file beside the one that is to be written, under a name of its own. An empty path, and the error, if
/// there can't be one.
std::filesystem::path create_beside(const std::filesystem::path& target, std::error_code& error);

/// Writes a file in place.
std::error_code write_file(const std::filesystem::path& path, const std::function<void(std::ostream&)>& write_content);

/// Gives a file its whole content, or leaves it as it was: written beside it, then renamed.
std::error_code replace_file(const std::filesystem::path& target,
                             const std::function<void(std::ostream&)>& write_content);

/// "" for a regular file and for a path at which there is nothing, else what there is, as "a pipe". A pipe would
/// block who opens it until another process does, and a device may never end: readers ask before they open.
std::string irregular_kind(const std::filesystem::path& path);

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

std::uint64_t checksum_of(std::span<const std::byte> bytes);

}  // namespace atl
