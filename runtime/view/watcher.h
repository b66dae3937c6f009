#pragma once

#include <cstdint>
#include <functional>
#include <vector>

namespace atl {
class Playback;
class World;
struct StepReport;
}  // namespace atl

namespace atl::view {

/// Follows a run frame by frame and makes a view of it. Changes nothing of the world.
class Watcher {
 public:
  Watcher() = default;
  Watcher(const Watcher&) = delete;
  Watcher& operator=(const Watcher&) = delete;
  virtual ~Watcher() = default;

  /// The world ahead of the first step.
  virtual void begin(const World& world) = 0;
  /// The world after a step of dt seconds.
  virtual void add(const World& world, const StepReport& report, double dt) = 0;
};

/// Goes through a recording, from where it stands to the state after step `to`, or its end, as long as `go_on` says
/// true, which is asked after each step.
void watch(Playback& playback, std::int64_t to, const std::vector<Watcher*>& watchers,
           const std::function<bool()>& go_on);

/// Which steps are frames, and when they are.
class FrameClock {
 public:
  FrameClock(std::int64_t first_step, int stride) : first_(first_step), stride_(stride), step_(first_step) {}

  /// A step was made: whether the state after it is a frame.
  bool tick(double dt) {
    time_ += dt;
    return (++step_ - first_) % stride_ == 0;
  }
  std::int64_t step() const { return step_; }  ///< steps made
  double time() const { return time_; }        ///< s, since the first frame

 private:
  std::int64_t first_;
  int stride_;  // steps a frame
  std::int64_t step_;
  double time_ = 0;
};

}  // namespace atl::view
