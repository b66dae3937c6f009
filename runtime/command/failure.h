#pragma once

#include <stdexcept>
#include <string>

namespace atl::command {

/// Exit status of the command.
enum class Status {
  Done = 0,
  CheckFailed = 1,
  Usage = 2,      ///< an option, its value or an output file
  BadScene = 3,   ///< or recording
  NonFinite = 4,  ///< a body's state became non-finite or absurd
  // Above 128 by the number of the signal that ended it: see interrupt.h.
  HungUp = 129,
  Interrupted = 130,
  Terminated = 143,
};

/// Ends the command with one line on stderr.
class Failure : public std::runtime_error {
 public:
  Failure(Status status, const std::string& message) : std::runtime_error(message), status_(status) {}
  Status status() const { return status_; }

 private:
  Status status_;
};

}  // namespace atl::command
