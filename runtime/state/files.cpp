#include "state/files.h"

#include <fcntl.h>
#include <jobs/hash.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <system_error>

namespace atl {

namespace fs = std::filesystem;

fs::path create_beside(const fs::path& target, std::error_code& error) {
  error.clear();
  // A short name of its own: one made of the target's could be too long for the file system.
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  const std::string stem = ".atoll-" + std::to_string(::getpid()) + "-";
  for (int number = 0;; ++number) {
    fs::path path = folder / (stem + std::to_string(number) + ".tmp");
    const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor >= 0) {
      ::close(descriptor);
      return path;
    }
    if (errno == EEXIST) continue;
    error = {errno, std::generic_category()};
    return {};
  }
}

std::error_code write_file(const fs::path& path, const std::function<void(std::ostream&)>& write_content) {
  errno = 0;
  std::ofstream stream(path, std::ios::binary | std::ios::trunc);
  if (stream) write_content(stream);
  stream.close();
  if (stream) return {};
  return {errno != 0 ? errno : EIO, std::generic_category()};
}

std::error_code replace_file(const fs::path& target, const std::function<void(std::ostream&)>& write_content) {
  std::error_code error;
  const fs::path temporary = create_beside(target, error);
  if (error) return error;
  error = write_file(temporary, write_content);
  if (!error) fs::rename(temporary, target, error);
  std::error_code ignored;
  if (error) fs::remove(temporary, ignored);
  return error;
}

std::string irregular_kind(const fs::path& path) {
  std::error_code error;
  switch (fs::status(path, error).type()) {
    case fs::file_type::directory:
      return "a directory";
    case fs::file_type::fifo:
      return "a pipe";
    case fs::file_type::socket:
      return "a socket";
    case fs::file_type::character:
    case fs::file_type::block:
      return "a device";
    default:
      return "";  // what is wrong with others shows as they are opened
  }
}

std::uint64_t checksum_of(std::span<const std::byte> bytes) {
  jobs::Hash hash;
  hash.add(std::uint64_t{bytes.size()});
  for (std::size_t at = 0; at < bytes.size(); at += sizeof(std::uint64_t)) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + at, std::min(sizeof word, bytes.size() - at));
    hash.add(word);
  }
  return hash.value();
}

}  // namespace atl
