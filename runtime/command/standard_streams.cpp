#include "standard_streams.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <iostream>
#include <system_error>

#include "failure.h"

namespace atl::command {
namespace {

bool pipes_end_quietly = true;

bool nobody_reads_output() {
  pollfd output = {STDOUT_FILENO, POLLOUT, 0};
  return ::poll(&output, 1, 0) == 1 && (output.revents & POLLERR) != 0;
}

}  // namespace

void prepare_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(stream, F_GETFD) >= 0 || errno != EBADF) continue;
    // The lowest that is free is this one. What is written to standard output is to fail.
    [[maybe_unused]] const int opened = ::open("/dev/null", stream == STDERR_FILENO ? O_WRONLY : O_RDONLY);
  }
  pipes_end_quietly = ::signal(SIGPIPE, SIG_IGN) != SIG_IGN;
}

void finish_output() {
  errno = 0;
  if (std::cout.flush()) return;
  const int error = errno;
  const bool gone = nobody_reads_output();
  if (gone && pipes_end_quietly) throw ReaderGone{};
  const int reason = gone ? EPIPE : error;
  throw Failure(Status::Usage, "cannot write the results to standard output" +
                                   (reason != 0 ? ": " + std::generic_category().message(reason) : ""));
}

int end_by_closed_pipe() {
  ::signal(SIGPIPE, SIG_DFL);
  ::raise(SIGPIPE);
  return 128 + SIGPIPE;  // where it is blocked
}

}  // namespace atl::command
