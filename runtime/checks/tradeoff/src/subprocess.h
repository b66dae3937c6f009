#pragma once

#include <string>
#include <vector>

#include "checks/tradeoff/stop.h"

namespace atl::tradeoff {

/// How another program ended, and what it printed.
struct SubprocessResult {
  enum class End { Exited, Signalled, TimedOut };

  End end = End::Exited;
  int code = 0;  ///< exit status, or the signal
  std::string out;
  std::string err;
};

/// Runs a program, found as a shell would find it but without a shell, with nothing on its standard input. It is
/// killed after `limit` s, or once `stop` says so, and Stopped thrown. Throws DriverError if it can't be started.
SubprocessResult run_subprocess(const std::vector<std::string>& words, double limit, const Stop& stop);

}  // namespace atl::tradeoff
