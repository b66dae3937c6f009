#include "text_file.h"

#include <atoll/scene.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <system_error>

namespace atl::scene {
namespace {

constexpr std::size_t largest_file = std::size_t{1} << 30;

[[noreturn]] void refuse(const std::string& path, const char* kind) {
  const std::string why = std::generic_category().message(errno);
  throw SceneError(path + ": found no readable file (" + why + "), expected " + kind);
}

}  // namespace

std::string read_text_file(const std::string& path, const char* kind) {
  // A pipe would block who opens it until another process does, and a device may never end.
  std::error_code error;
  if (const auto status = std::filesystem::status(path, error); exists(status) && !is_regular_file(status)) {
    throw SceneError(path + ": found a directory, pipe or device, expected " + kind);
  }
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  const std::unique_ptr<std::FILE, Close> file(std::fopen(path.c_str(), "rb"));
  if (!file) refuse(path, kind);
  std::string text;
  char block[1 << 16];
  while (const std::size_t read = std::fread(block, 1, sizeof block, file.get())) {
    text.append(block, read);
    if (text.size() > largest_file) throw SceneError(path + ": found more than 1 GiB, expected " + kind);
  }
  if (std::ferror(file.get())) refuse(path, kind);
  return text;
}

}  // namespace atl::scene
