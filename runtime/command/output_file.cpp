#include "output_file.h"

#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "failure.h"
#include "state/files.h"

namespace atl::command {

namespace fs = std::filesystem;

OutputFile::OutputFile(std::string option, const std::string& path) : option_(std::move(option)), path_(path) {
  std::error_code error;
  target_ = fs::weakly_canonical(path, error);
  if (error) fail(error.message());
  const fs::file_status status = fs::status(target_, error);
  if (status.type() == fs::file_type::none) fail(error.message());
  if (status.type() == fs::file_type::directory) fail("is a directory");
  if (!target_.has_filename()) fail("no such directory");
  special_ = fs::exists(status) && status.type() != fs::file_type::regular;
  if (fs::exists(status) && ::access(target_.c_str(), W_OK) != 0) fail(std::generic_category().message(errno));
  if (special_) return;
  const fs::path temporary = create_beside(target_, error);
  if (error) fail(error.message());
  fs::remove(temporary);
}

void OutputFile::write(const std::function<void(std::ostream&)>& write_content) const {
  const std::error_code error = special_ ? write_file(target_, write_content) : replace_file(target_, write_content);
  if (error) fail(error.message());
}

void OutputFile::fail(const std::string& why) const {
  throw Failure(Status::Usage, option_ + ": cannot write " + path_ + ": " + why);
}

}  // namespace atl::command
