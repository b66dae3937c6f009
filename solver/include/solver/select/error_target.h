#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace atl::solver {

/// Errors that islands are to stay below, infinite where one is not asked for, and how many substeps a step of an
/// island may get for it. Meanings as in atoll/settings.h.
struct ErrorTarget {
  static constexpr double none = std::numeric_limits<double>::infinity();

  double penetration = none;  ///< m
  double joint_gap = none;    ///< m
  double residual = none;     ///< relative
  double motion = none;       ///< m/s
  int min_substeps = 1;
  int max_substeps = 1024;
};

/// Numbers of substeps that islands get: few enough that islands alike share lanes, near enough to each other that none
/// takes much more than it needs.
inline constexpr std::array<std::uint16_t, 35> substep_rungs = {
    1,  2,  3,  4,  5,   6,   7,   8,   10,  12,  14,  16,  20,  24,  28,  32,  40,  48,
    56, 64, 80, 96, 112, 128, 160, 192, 224, 256, 320, 384, 448, 512, 640, 768, 1024};

/// The substeps that an error of an island calls for.
struct ErrorNeed {
  int substeps = 1;      ///< with which it would be held; max_needed_substeps if with none
  bool missed = false;   ///< it is larger than its target
  bool follows = false;  ///< so is the part of it that more substeps make less at once
};
inline constexpr int max_needed_substeps = 2048;
/// The least number of substeps whose square is so large; max_needed_substeps if there is none.
int rung_of(double square);

/// Counts the errors of an island by size. The island's error is the size that one in a hundred exceeds, as in
/// `PenetrationReport::p99`; with few errors it is the largest. Counts add up in any order.
///
/// Between bodies that have just met, errors can stay beyond the target whatever the number of substeps. The part of
/// the errors that does fall with substeps is then held only to the size of the others: reducing it further would cost
/// time, and leave the island's error as large.
class ErrorCounts {
 public:
  /// An error within the target, that was made in so many substeps.
  void add(double error, double substeps, double target);
  /// One beyond it, of which `following` falls with the square of the substeps.
  void add_missed(double error, double following, double substeps, double target);
  /// One that is too small to count. With fewer substeps it might: no more than in proportion to it are taken away.
  void add_small(double error, double substeps) { small_ = std::max(small_, error * substeps * substeps); }
  void operator+=(const ErrorCounts& other);
  ErrorNeed need(double target) const;

 private:
  using ByRung = std::array<std::uint32_t, substep_rungs.size() + 1>;

  ByRung by_rung_ = {};      // by the rung that would hold them
  ByRung left_ = {};         // of those beyond the target: that would hold the rest if it followed
  std::size_t highest_ = 0;  // place of a rung that holds all
  double small_ = 0;         // m, of the largest of those, in one substep
  std::uint32_t counted_ = 0;
  std::uint32_t missed_ = 0;
  std::uint32_t follow_ = 0;
};

}  // namespace atl::solver
