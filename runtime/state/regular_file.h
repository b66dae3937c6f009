#pragma once

#include <filesystem>
#include <string>

namespace atl {

/// "" for a regular file and for a path at which there is nothing, else what there is, as "a pipe". A pipe would
/// block who opens it until another process does, and a device may never end: readers ask before they open.
std::string irregular_kind(const std::filesystem::path& path);

}  // namespace atl
