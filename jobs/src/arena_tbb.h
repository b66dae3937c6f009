#pragma once

#include <jobs/arena.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <optional>

namespace atl::jobs {

/// oneTBB's side of an arena.
struct Arena::Tbb {
  explicit Tbb(int threads) : arena(threads) {}

  tbb::task_arena arena;  // begins with its first loop, once the control below is there
  std::optional<tbb::global_control> allowed;
};

}  // namespace atl::jobs
