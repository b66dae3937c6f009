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

/// Detects growing memory. It is sampled as recordings change over, when the same data are held each time; the least of
/// the last samples counts. Warm-up is at least soak::warm_up_steps(), and otherwise a quarter to half of the steps so
/// far: buffers grow with the largest crowd so far, which grows with the logarithm of time, while a leak grows with
/// time itself.
class MemoryDrift {
 public:
  static constexpr double max_growth = 0.01;  // of what there was after warm-up

  void note(std::int64_t step, std::size_t bytes);
  /// Growth relative to the memory after warm-up; nothing before twice the least warm-up.
  std::optional<double> drift() const;

 private:
  static constexpr std::size_t samples = 8;

  std::size_t min() const;

  std::array<std::size_t, samples> last_ = {};
  std::size_t new_ = 0;
  std::int64_t next_mark_ = soak::warm_up_steps();  // steps; twice as many each time
  std::size_t at_mark_ = 0, at_mark_before_ = 0;    // bytes; 0 where there was none
};

void write_soak_head(std::ostream& out);
/// A line on the steps since the last one, and on all since the start.
void write_soak_line(std::ostream& out, double seconds, const soak::Soak& soak, const TimeClasses& times,
                     const std::optional<double>& drift);
void write_soak_end(std::ostream& out, const soak::SoakTally& tally, const TimeClasses& all,
                    const std::optional<double>& drift);

}  // namespace atl::command
