#include <atoll/error.h>
#include <atoll/playback.h>
#include <features/with_recording.h>

#include <iterator>
#include <map>
#include <utility>

#include "state/replay.h"
#include "world/left_out.h"

namespace atl {
namespace {

constexpr std::int64_t first_interval = 8;  // steps from key frame to key frame
// Of what key frames may take: what the states of the steps between two of them may.
constexpr double fine_part = 0.25;

Replay opened(const std::string& path, const PlaybackOptions& options) {
  if constexpr (!with_recording) throw_left_out("Playback is made", "recordings", "RECORDING");
  return Replay(path, {.threads = options.threads, .simd = options.simd});
}

}  // namespace

class Playback::Impl {
 public:
  Impl(const std::string& path, const PlaybackOptions& options)
      : replay_(opened(path, options)), most_bytes_(options.key_frame_bytes) {
    keep(keys_);
  }

  const Replay& replay() const { return replay_; }

  bool advance() {
    if (!replay_.advance()) return false;
    const std::int64_t step = replay_.result().steps;
    if (step % interval_ == 0 && !keys_.marks.contains(step)) {
      keep(keys_);
      thin();
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
  };

  void keep(Marks& into) {
    Replay::Mark mark = replay_.mark();
    into.bytes += mark.snapshot.size();
    into.marks.insert_or_assign(mark.steps, std::move(mark));
  }

  // The first always stays.
  void thin() {
    while (keys_.bytes > most_bytes_ && keys_.marks.size() > 2) {
      interval_ *= 2;
      std::erase_if(keys_.marks, [&](const auto& key) {
        if (key.first % interval_ == 0) return false;
        keys_.bytes -= key.second.snapshot.size();
        return true;
      });
    }
  }

  static const Replay::Mark* last_up_to(const Marks& marks, std::int64_t step) {
    const auto after = marks.marks.upper_bound(step);
    return after == marks.marks.begin() ? nullptr : &std::prev(after)->second;
  }

  // Steps from the key frame on are made again, and kept.
  void go_back(std::int64_t step) {
    const Replay::Mark* key = last_up_to(keys_, step);
    const Replay::Mark* fine = last_up_to(fine_, step);
    if (fine != nullptr && fine->steps > key->steps) {
      replay_.go_back(*fine);
    } else {
      replay_.go_back(*key);
      fine_ = {};
    }
    const auto room = static_cast<std::size_t>(fine_part * static_cast<double>(most_bytes_));
    while (replay_.result().steps < step && replay_.advance()) {
      if (fine_.bytes < room) keep(fine_);
    }
  }

  Replay replay_;
  std::size_t most_bytes_;
  std::int64_t interval_ = first_interval;
  Marks keys_;
  Marks fine_;  // after the key frame that it went back to last
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
