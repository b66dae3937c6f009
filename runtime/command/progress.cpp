#include "progress.h"

#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <string>

namespace atl::command {

Progress::Progress(int steps)
    : steps_(steps), terminal_(::isatty(STDERR_FILENO) != 0), start_(Clock::now()), last_(start_) {}

Progress::~Progress() {
  constexpr const char* clear_line = "\r\033[K";
  if (shown_) std::fputs(clear_line, stderr);
}

void Progress::update(int steps_done) {
  constexpr auto interval = std::chrono::milliseconds(100);
  constexpr int width = 30;
  if (!terminal_) return;
  const Clock::time_point now = Clock::now();
  if (now - last_ < interval) return;
  last_ = now;
  shown_ = true;

  const double elapsed = std::chrono::duration<double>(now - start_).count();
  const double rate = steps_done / elapsed;
  const auto left = std::llround((steps_ - steps_done) / rate);
  const auto filled = static_cast<std::size_t>(static_cast<double>(width) * steps_done / steps_);
  const std::string bar = std::string(filled, '#') + std::string(width - filled, '-');
  std::fprintf(stderr, "\r[%s] %d/%d steps  %.3g steps/s  %lld:%02lld left\033[K", bar.c_str(), steps_done, steps_,
               rate, left / 60, left % 60);
  std::fflush(stderr);
}

}  // namespace atl::command
