#pragma once

#include <chrono>

namespace atl::jobs {

using Clock = std::chrono::steady_clock;

inline double ms_between(Clock::time_point begin, Clock::time_point end) {
  return std::chrono::duration<double, std::milli>(end - begin).count();
}
inline double ms_since(Clock::time_point start) { return ms_between(start, Clock::now()); }

}  // namespace atl::jobs
