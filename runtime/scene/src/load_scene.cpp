#include <atoll/scene.h>

#include <filesystem>
#include <system_error>

#include "builtin.h"
#include "text_file.h"

namespace atl {
namespace {

bool names_file(std::string_view text) {
  std::error_code ignored;  // a text that is no path names no file
  return text.ends_with(".json") || std::filesystem::exists(std::filesystem::path(text), ignored);
}

}  // namespace

Scene load_scene(std::string_view text, std::uint64_t seed, MeshFiles files) {
  if (!names_file(text)) return scene::load_builtin(text, seed);
  const std::string path(text);
  return parse_scene(scene::read_text_file(path, "a scene file"), path, seed, files);
}

}  // namespace atl
