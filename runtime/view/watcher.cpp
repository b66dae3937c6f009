#include "view/watcher.h"

#include <atoll/playback.h>

namespace atl::view {

void watch(Playback& playback, std::int64_t to, const std::vector<Watcher*>& watchers,
           const std::function<bool()>& go_on) {
  for (Watcher* watcher : watchers) watcher->begin(playback.world());
  while (playback.step() < to && playback.advance()) {
    for (Watcher* watcher : watchers) watcher->add(playback.world(), playback.report(), playback.dt());
    if (!go_on()) return;
  }
}

}  // namespace atl::view
