#include "progress.h"

#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <utility>

namespace atl::command {

Progress::Progress(std::int64_t total, std::string unit)
    : total_(total),
      unit_(std::move(unit)),
      terminal_(::isatty(STDERR_FILENO) != 0),
      start_(Clock::now()),
      last_(start_) {}

Progress::~Progress() {
  constexpr const char* clear_line = "\r\033[K";
  if (shown_) std::fputs(clear_line, stderr);
}

void Progress::update(std::int64_t done) {
  constexpr auto interval = std::chrono::milliseconds(100);
  constexpr int width = 30;
  if (!terminal_) return;
  const Clock::time_point now = Clock::now();
  if (now - last_ < interval) return;
  last_ = now;
  shown_ = true;

  const double elapsed = std::chrono::duration<double>(now - start_).count();
  const double rate = static_cast<double>(done) / elapsed;
  const long long left = done > 0 ? std::llround(static_cast<double>(total_ - done) / rate) : 0;
  const auto filled = static_cast<std::size_t>(width * done / total_);
  const std::string bar = std::string(filled, '#') + std::string(width - filled, '-');
  if (unit_.empty()) {
    std::fprintf(stderr, "\r[%s] %3lld%%", bar.c_str(), static_cast<long long>(100 * done / total_));
  } else {
    std::fprintf(stderr, "\r[%s] %lld/%lld %s  %.3g %s/s", bar.c_str(), static_cast<long long>(done),
                 static_cast<long long>(total_), unit_.c_str(), rate, unit_.c_str());
  }
  std::fprintf(stderr, "  %lld:%02lld left\033[K", left / 60, left % 60);
  std::fflush(stderr);
}

}  // namespace atl::command
