#include "output_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <system_error>

#include "failure.h"

namespace atl::command {
namespace {

namespace fs = std::filesystem;

std::string words_of(int error_number) { return std::generic_category().message(error_number); }

void write_stream(const fs::path& path, const std::function<void(std::ostream&)>& write_content) {
  errno = 0;
  std::ofstream stream(path, std::ios::binary | std::ios::trunc);
  if (stream) write_content(stream);
  stream.close();
  if (!stream) throw fs::filesystem_error("", std::error_code(errno != 0 ? errno : EIO, std::generic_category()));
}

}  // namespace

OutputFile::OutputFile(std::string option, const std::string& path) : option_(std::move(option)), path_(path) {
  std::error_code error;
  target_ = fs::weakly_canonical(path, error);
  if (error) fail(error.message());
  const fs::file_status status = fs::status(target_, error);
  if (status.type() == fs::file_type::none) fail(error.message());
  if (status.type() == fs::file_type::directory) fail("is a directory");
  if (!target_.has_filename()) fail("no such directory");
  special_ = fs::exists(status) && status.type() != fs::file_type::regular;
  if (fs::exists(status) && ::access(target_.c_str(), W_OK) != 0) fail(words_of(errno));
  if (!special_) fs::remove(create_temporary());
}

fs::path OutputFile::create_temporary() const {
  // A short name of its own: one made of the target's could be too long for the file system.
  const std::string stem = ".atoll-" + std::to_string(::getpid()) + "-";
  for (int number = 0;; ++number) {
    fs::path path = target_.parent_path() / (stem + std::to_string(number) + ".tmp");
    const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor >= 0) {
      ::close(descriptor);
      return path;
    }
    if (errno != EEXIST) fail(words_of(errno));
  }
}

void OutputFile::write(const std::function<void(std::ostream&)>& write_content) const {
  fs::path temporary;
  try {
    if (special_) return write_stream(target_, write_content);
    temporary = create_temporary();
    write_stream(temporary, write_content);
    fs::rename(temporary, target_);
  } catch (const fs::filesystem_error& error) {
    std::error_code ignored;
    if (!temporary.empty()) fs::remove(temporary, ignored);
    fail(error.code().message());
  }
}

void OutputFile::fail(const std::string& why) const {
  throw Failure(Status::Usage, option_ + ": cannot write " + path_ + ": " + why);
}

}  // namespace atl::command
