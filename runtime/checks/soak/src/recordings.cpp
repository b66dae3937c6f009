#include <atoll/error.h>
#include <atoll/recording.h>

#include <utility>

#include "trials.h"

namespace atl::soak {

Recordings::Recordings(Twin& twin, std::filesystem::path folder, std::function<bool()> stop)
    : twin_(twin), folder_(std::move(folder)), stop_(std::move(stop)) {
  begin();
}

Recordings::~Recordings() {
  try {
    if (!twin_.first().is_recording()) return;
    twin_.first().stop_recording();
    if (!keep_) std::filesystem::remove(file());
  } catch (const std::exception&) {  // a disk that is full
  }
}

std::filesystem::path Recordings::file() const { return folder_ / ("soak-" + std::to_string(number_) + ".recording"); }

void Recordings::begin() {
  ++number_;
  steps_ = 0;
  keep_ = false;
  try {
    twin_.first().record(file().string());
  } catch (const Error& error) {
    throw RecordingFailed(error.what());
  }
}

void Recordings::keep(LostBody& lost) {
  keep_ = true;
  lost.recording = file().filename().string();
  lost.recorded_step = steps_;
}

std::string Recordings::keep() {
  LostBody nobody;
  keep(nobody);
  return nobody.recording + ", step " + std::to_string(nobody.recorded_step);
}

void Recordings::change_over(SoakTally& tally) {
  const std::uint64_t hash = twin_.world().state_hash();
  try {
    twin_.first().stop_recording();
  } catch (const Error& error) {
    throw RecordingFailed(error.what());
  }
  replay_last(hash, tally);
  if (!keep_) std::filesystem::remove(file());
  begin();
}

void Recordings::replay_last(std::uint64_t hash, SoakTally& tally) const {
  const World& second = twin_.second();
  const ReplayResult result =
      replay(file().string(), {.threads = second.threads(), .simd = second.simd(), .stop = stop_});
  const bool given_up = stop_ && stop_() && result.steps < result.recorded_steps;
  if (result.divergence) {
    throw CheckFailed("the replay of " + file().string() + " differs in step " +
                      std::to_string(result.divergence->step));
  }
  if (given_up) return;
  ++tally.replays;
  if (!result.complete || result.steps != steps_ || result.hash != hash) {
    throw CheckFailed("the replay of " + file().string() + " ended elsewhere than the world that was recorded");
  }
}

}  // namespace atl::soak
