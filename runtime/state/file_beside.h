#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <system_error>

namespace atl {

/// A new, empty file beside the one that is to be written, under a name of its own. An empty path, and the error, if
/// there can't be one.
std::filesystem::path create_beside(const std::filesystem::path& target, std::error_code& error);

/// Writes a file in place.
std::error_code write_file(const std::filesystem::path& path, const std::function<void(std::ostream&)>& write_content);

/// Gives a file its whole content, or leaves it as it was: written beside it, then renamed.
std::error_code replace_file(const std::filesystem::path& target,
                             const std::function<void(std::ostream&)>& write_content);

}  // namespace atl
