#include <atoll/error.h>
#include <atoll/playback.h>
#include <features/with_recording.h>

#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "state/replay.h"
#include "world/left_out.h"

namespace atl {
namespace {

constexpr std::int64_t first_interval = 8;  // steps from key frame to key frame
// Share of the key frames' memory that the states near the current step may take.
constexpr double near_part = 0.5;

Replay opened(const std::string& path, const PlaybackOptions& options) {
  if constexpr (!with_recording) throw_left_out("Playback is made", "recordings", "RECORDING");
  return Replay(path, {.threads = options.threads, .simd = options.simd});
}

}  // namespace

// States that it can go back to: key frames on all of the way, every `interval_` steps; and near where it stands every
// state, or every few if there is no room for that, from an interval of steps before on. As it goes back, the stretch
// from the key frame before is made again ahead of need, in another world, a step for each that it goes back, so that
// no step back takes many.
class Playback::Impl {
 public:
  Impl(const std::string& path, const PlaybackOptions& options)
      : replay_(opened(path, options)),
        max_near_bytes_(static_cast<std::size_t>(near_part * static_cast<double>(options.key_frame_bytes))),
        max_key_bytes_(options.key_frame_bytes - max_near_bytes_) {
    keep(replay_, keys_);
    if (options.key_frame_bytes > 0) maker_.emplace(opened(path, options));
  }

  const Replay& replay() const { return replay_; }

  bool advance() {
    if (!replay_.advance()) return false;
    const std::int64_t step = replay_.result().steps;
    if (step % interval_ == 0 && !keys_.marks.contains(step)) {
      keep(replay_, keys_);
      thin();
    }
    if (keep_near(replay_, near_)) {
      below_ = {};
      near_.drop_before((step - interval_) / interval_ * interval_);
    }
    return true;
  }

  void seek(std::int64_t step) {
    if (step < replay_.result().steps) go_back(step);
    while (replay_.result().steps < step && advance()) {
    }
  }

 private:
  struct Marks {
    std::map<std::int64_t, Replay::Mark> marks;  // by step
    std::size_t bytes = 0;

    void add(Replay::Mark mark) {
      const std::int64_t step = mark.steps;
      if (marks.contains(step)) return;
      bytes += mark.snapshot.size();
      marks.emplace(step, std::move(mark));
    }
    template <typename Drops>
    void drop_if(const Drops& drops) {
      std::erase_if(marks, [&](const auto& mark) {
        if (!drops(mark.first)) return false;
        bytes -= mark.second.snapshot.size();
        return true;
      });
    }
    void drop_before(std::int64_t step) {
      drop_if([step](std::int64_t at) { return at < step; });
    }
    // Null if there is none.
    const Replay::Mark* last_up_to(std::int64_t step) const {
      const auto after = marks.upper_bound(step);
      return after == marks.begin() ? nullptr : &std::prev(after)->second;
    }
  };

  void keep(const Replay& replay, Marks& into) {
    Replay::Mark mark = replay.mark();
    mark_bytes_ = mark.snapshot.size();
    into.add(std::move(mark));
  }

  // The first always stays.
  void thin() {
    while (keys_.bytes > max_key_bytes_ && keys_.marks.size() > 2) {
      interval_ *= 2;
      keys_.drop_if([this](std::int64_t step) { return step % interval_ != 0; });
    }
  }

  // Steps from one state near by to the next: three intervals of them fit. 0 if not even a few do.
  std::int64_t near_stride() const {
    for (std::int64_t stride = 1; stride < interval_; stride *= 2) {
      if (static_cast<std::size_t>(3 * interval_ / stride) * mark_bytes_ <= max_near_bytes_) return stride;
    }
    return 0;
  }

  // Returns true if states near the current step are kept at all.
  bool keep_near(const Replay& replay, Marks& into) {
    const std::int64_t stride = near_stride();
    if (stride > 0 && replay.result().steps % stride == 0) keep(replay, into);
    return stride > 0;
  }

  void go_back(std::int64_t step) {
    const Replay::Mark* key = keys_.last_up_to(step);
    if (near_.last_up_to(step) == nullptr) {
      near_ = below_ = {};
      near_.add(*key);
      replay_.go_to(*key);
      make_steps(replay_, step, near_);
    }
    near_.drop_if([&](std::int64_t at) { return at > step + interval_; });
    make_below(step);
    const Replay::Mark* near = near_.last_up_to(step);
    if (replay_.result().steps != step) replay_.go_to(near != nullptr && near->steps > key->steps ? *near : *key);
    while (replay_.result().steps < step && replay_.advance()) {
    }
  }

  void make_steps(Replay& replay, std::int64_t to, Marks& into) {
    while (replay.result().steps < to && replay.advance()) keep_near(replay, into);
  }

  // Prepares the stretch below the states near the current step. It never has more steps left to make than lie between
  // these states and `step`, so each call restores the maker or makes one step, and going back costs about one step
  // each time.
  void make_below(std::int64_t step) {
    if (!maker_ || near_stride() == 0 || near_.marks.empty()) return;
    const std::int64_t low = near_.marks.begin()->first;
    if (low == 0 || step - low > interval_) return;
    if (below_.marks.empty()) {
      maker_->learn_from(replay_);
      below_.add(*keys_.last_up_to(low - 1));
      maker_->go_to(below_.marks.begin()->second);
    }
    make_steps(*maker_, low - 1 - (step - low), below_);
    if (step > low) return;
    near_.marks.merge(below_.marks);
    near_.bytes += below_.bytes;
    below_ = {};
  }

  Replay replay_;
  std::size_t max_near_bytes_, max_key_bytes_;
  std::size_t mark_bytes_ = 0;  // of the last one
  std::int64_t interval_ = first_interval;
  Marks keys_;
  Marks near_;                   // states one after another, up to a bit past where it stands
  Marks below_;                  // those from the key frame before them on, as far as `maker_` has made them
  std::optional<Replay> maker_;  // where there is room for what it makes
};

Playback::Playback(const std::string& path, const PlaybackOptions& options)
    : impl_(std::make_unique<Impl>(path, options)) {}
Playback::~Playback() = default;
Playback::Playback(Playback&&) noexcept = default;
Playback& Playback::operator=(Playback&&) noexcept = default;

std::int64_t Playback::steps() const { return impl_->replay().result().recorded_steps; }
std::int64_t Playback::step() const { return impl_->replay().result().steps; }
const World& Playback::world() const { return impl_->replay().world(); }
bool Playback::advance() { return impl_->advance(); }
double Playback::dt() const { return impl_->replay().dt(); }
const StepReport& Playback::report() const { return impl_->replay().report(); }
const std::optional<ReplayDivergence>& Playback::divergence() const { return impl_->replay().result().divergence; }

void Playback::seek(std::int64_t step) {
  if (step < 0 || step > steps()) {
    throw Error("Playback::seek: step is " + std::to_string(step) + "; expected one in [0, " + std::to_string(steps()) +
                "], the steps of the recording");
  }
  impl_->seek(step);
}

}  // namespace atl
