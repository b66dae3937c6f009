#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>

namespace atl::command {

/// A file that either gets its whole content or stays as it was: written beside the target under
/// another name, then renamed. A device or pipe is written directly.
class OutputFile {
 public:
  /// Throws Failure with Status::Usage, naming the option, unless the file can be written. Leaves
  /// nothing behind, so the check can be made long before the content is there.
  OutputFile(std::string option, const std::string& path);

  void write(const std::function<void(std::ostream&)>& write_content) const;

  /// The path of the file itself, with symbolic links resolved.
  const std::filesystem::path& target() const { return target_; }

 private:
  [[noreturn]] void fail(const std::string& why) const;

  std::string option_;
  std::string path_;
  std::filesystem::path target_;
  bool special_ = false;  ///< exists and is no regular file
};

}  // namespace atl::command
