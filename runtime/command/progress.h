#pragma once

#include <chrono>

namespace atl::command {

/// A bar with rate and time left on stderr, where that is a terminal; elsewhere nothing.
class Progress {
 public:
  explicit Progress(int steps);
  ~Progress();  ///< clears the bar
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void update(int steps_done);

 private:
  using Clock = std::chrono::steady_clock;

  int steps_;
  bool terminal_;
  bool shown_ = false;
  Clock::time_point start_;
  Clock::time_point last_;
};

}  // namespace atl::command
