#include <atoll/scene.h>

#include <cerrno>
#include <cstdio>
#include <memory>
#include <system_error>

#include "builtin.h"

namespace atl {
namespace {

constexpr std::size_t largest_file = std::size_t{1} << 30;

std::string error_words() { return std::generic_category().message(errno); }

std::string read_file(const std::string& path) {
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  const std::unique_ptr<std::FILE, Close> file(std::fopen(path.c_str(), "rb"));
  if (!file) throw SceneError(path + ": found no readable file (" + error_words() + "), expected a scene file");
  std::string text;
  char block[1 << 16];
  while (const std::size_t read = std::fread(block, 1, sizeof block, file.get())) {
    text.append(block, read);
    if (text.size() > largest_file) throw SceneError(path + ": found more than 1 GiB, expected a smaller scene file");
  }
  if (std::ferror(file.get())) {
    throw SceneError(path + ": found no readable file (" + error_words() + "), expected a scene file");
  }
  return text;
}

bool names_file(std::string_view text) {
  std::error_code ignored;  // a text that is no path names no file
  return text.ends_with(".json") || std::filesystem::exists(std::filesystem::path(text), ignored);
}

}  // namespace

Scene load_scene(std::string_view text, std::uint64_t seed) {
  if (!names_file(text)) return scene::load_builtin(text, seed);
  const std::string path(text);
  return parse_scene(read_file(path), path, seed);
}

}  // namespace atl
