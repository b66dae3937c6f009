#include "subprocess.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <system_error>

#include "checks/tradeoff/peer_driver.h"

namespace atl::tradeoff {
namespace {

using Clock = std::chrono::steady_clock;

[[noreturn]] void fail(const std::string& program, int error_number) {
  throw DriverError("cannot run " + program + ": " + std::generic_category().message(error_number));
}

// A pipe that no other child inherits.
class Pipe {
 public:
  explicit Pipe(const std::string& program) {
    if (::pipe2(ends_.data(), O_CLOEXEC) != 0) fail(program, errno);
  }
  ~Pipe() {
    close_end(0);
    close_end(1);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

  int reader() const { return ends_[0]; }
  int writer() const { return ends_[1]; }
  void close_writer() { close_end(1); }
  void close_reader() { close_end(0); }

 private:
  void close_end(std::size_t end) {
    if (ends_[end] >= 0) ::close(ends_[end]);
    ends_[end] = -1;
  }

  std::array<int, 2> ends_ = {-1, -1};
};

pid_t spawn(const std::vector<std::string>& words, const Pipe& out, const Pipe& err) {
  std::vector<char*> argv;
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  ::posix_spawn_file_actions_adddup2(&actions, out.writer(), STDOUT_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, err.writer(), STDERR_FILENO);
  // A process that lets others read what it writes ignores it.
  posix_spawnattr_t attributes;
  ::posix_spawnattr_init(&attributes);
  sigset_t defaults;
  ::sigemptyset(&defaults);
  ::sigaddset(&defaults, SIGPIPE);
  ::posix_spawnattr_setsigdefault(&attributes, &defaults);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
  pid_t child = 0;
  const int failed = ::posix_spawnp(&child, argv[0], &actions, &attributes, argv.data(), environ);
  ::posix_spawnattr_destroy(&attributes);
  ::posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) fail(words.front(), failed);
  return child;
}

int milliseconds_to(Clock::time_point deadline) {
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now()).count();
  return static_cast<int>(std::clamp<long long>(left, 0, 60'000));
}

// A signal that arrives just ahead of a wait doesn't end that: `stop` is asked after this, ms.
constexpr int longest_wait = 100;

// Reads what the pipe has. Returns true at its end.
bool read_some(int reader, std::string& text) {
  std::array<char, 65536> buffer;
  const ssize_t count = ::read(reader, buffer.data(), buffer.size());
  if (count > 0) text.append(buffer.data(), static_cast<std::size_t>(count));
  return count == 0 || (count < 0 && errno != EINTR && errno != EAGAIN);
}

// Reads both pipes until they end, or the time is over.
void read_all(Pipe& out, Pipe& err, Clock::time_point deadline, const Stop& stop, SubprocessResult& result) {
  while (out.reader() >= 0 || err.reader() >= 0) {
    const int left = milliseconds_to(deadline);
    if (left == 0 || (stop && stop())) return;
    std::array<pollfd, 2> waiting = {pollfd{out.reader(), POLLIN, 0}, pollfd{err.reader(), POLLIN, 0}};
    if (::poll(waiting.data(), waiting.size(), std::min(left, longest_wait)) <= 0) continue;
    if (waiting[0].revents != 0 && read_some(out.reader(), result.out)) out.close_reader();
    if (waiting[1].revents != 0 && read_some(err.reader(), result.err)) err.close_reader();
  }
}

// Waits for the child, and kills it when the time is over.
int wait_for(pid_t child, Clock::time_point deadline, const Stop& stop, bool& timed_out) {
  int status = 0;
  for (;;) {
    const pid_t ended = ::waitpid(child, &status, WNOHANG);
    if (ended == child || (ended < 0 && errno != EINTR)) return status;
    if (milliseconds_to(deadline) == 0 || (stop && stop())) break;
    ::poll(nullptr, 0, 2);
  }
  timed_out = true;
  ::kill(child, SIGKILL);
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

}  // namespace

SubprocessResult run_subprocess(const std::vector<std::string>& words, double limit, const Stop& stop) {
  const Clock::time_point deadline =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(limit));
  Pipe out(words.front()), err(words.front());
  const pid_t child = spawn(words, out, err);
  out.close_writer();
  err.close_writer();

  SubprocessResult result;
  read_all(out, err, deadline, stop, result);
  bool timed_out = false;
  const int status = wait_for(child, deadline, stop, timed_out);
  stop_if_asked(stop);
  if (timed_out) {
    result.end = SubprocessResult::End::TimedOut;
  } else if (WIFSIGNALED(status)) {
    result.end = SubprocessResult::End::Signalled;
    result.code = WTERMSIG(status);
  } else {
    result.code = WEXITSTATUS(status);
  }
  return result;
}

}  // namespace atl::tradeoff
