#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace atl::command {

/// A bar with time left on stderr, where that is a terminal; elsewhere nothing.
class Progress {
 public:
  /// `total` of some unit of work, as "steps", of which count and rate are shown; of a nameless one the share that is
  /// done.
  explicit Progress(std::int64_t total, std::string unit = "steps");
  ~Progress();  ///< clears the bar
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void update(std::int64_t done);

 private:
  using Clock = std::chrono::steady_clock;

  std::int64_t total_;
  std::string unit_;
  bool terminal_;
  bool shown_ = false;
  Clock::time_point start_;
  Clock::time_point last_;
};

}  // namespace atl::command
