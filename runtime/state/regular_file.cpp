#include "state/regular_file.h"

#include <system_error>

namespace atl {

namespace fs = std::filesystem;

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

}  // namespace atl
