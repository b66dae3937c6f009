#pragma once

#include <jobs/arena.h>

#include <memory>
#include <vector>

namespace atl::jobs {

/// One default-made T a worker, kept between steps so that a steady state allocates nothing. What a loop
/// leaves in one must not outlive the chunk that wrote it: which worker runs a chunk is not fixed.
template <typename T>
class Scratch {
 public:
  explicit Scratch(int threads) {
    for (int i = 0; i < threads; ++i) items_.push_back(std::make_unique<T>());
  }

  T& local() { return *items_[static_cast<std::size_t>(Arena::worker())]; }

 private:
  std::vector<std::unique_ptr<T>> items_;
};

}  // namespace atl::jobs
