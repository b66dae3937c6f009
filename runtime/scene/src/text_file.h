#pragma once

#include <string>

namespace atl::scene {

/// A regular file's bytes. Throws SceneError where it is none, can't be read or has more than 1 GiB; `kind` says what
/// was expected, as "a scene file".
std::string read_text_file(const std::string& path, const char* kind);

}  // namespace atl::scene
