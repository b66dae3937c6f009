#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <optional>

#include "checks/soak/soak.h"

namespace atl::command {

/// Times of steps, in classes 1% wide, so that it holds as much memory for a billion as for one.
class TimeClasses {
 public:
  void add(double ms);
  void add(const TimeClasses& other);
  std::int64_t count() const { return count_; }
  double quantile(double share) const;  ///< ms, to 1%; 0 of none
  double max() const { return max_; }   ///< ms

 private:
  static constexpr std::size_t classes = 2048;  // from 0.1 us on, to more than a minute

  std::array<std::uint32_t, classes> counts_ = {};
  std::int64_t count_ = 0;
  double max_ = 0;
};

/// Resident memory of this process, bytes; 0 where the system doesn't tell.
std::size_t resident_memory();

/// Whether memory grows. It is sampled as recordings change over, when as much is held each time; what comes ahead of
/// soak::warm_up_steps() is left out. The least of the first samples_each samples is what the least of the last as many
/// is held against.
class MemoryDrift {
 public:
  static constexpr double most = 0.01;  // of what there was after warm-up
  static constexpr std::size_t samples_each = 8;

  void note(std::int64_t step, std::size_t bytes);
  /// Of the memory after warm-up, how much more it is; nothing before there were twice as many samples.
  std::optional<double> drift() const;

 private:
  std::size_t after_warm_up_ = 0;
  std::size_t samples_ = 0;
  std::array<std::size_t, samples_each> last_ = {};
};

void write_soak_head(std::ostream& out);
/// A line on the steps since the last one, and on all since the start.
void write_soak_line(std::ostream& out, double seconds, const soak::Soak& soak, const TimeClasses& times,
                     const std::optional<double>& drift);
void write_soak_end(std::ostream& out, const soak::SoakTally& tally, const TimeClasses& all,
                    const std::optional<double>& drift);

}  // namespace atl::command
