// Recording a world: what notes it down is recorder.h.

#include <atoll/error.h>
#include <atoll/recording.h>
#include <atoll/world.h>

#include <new>
#include <string>
#include <utility>

#include "state/body_hashes.h"
#include "state/recorder.h"
#include "world/settings_check.h"
#include "world/world_impl.h"

namespace atl {

void World::Impl::record(const std::string& path, const RecordingOptions& options) {
  if (recorder) throw Error("World::record: a recording is under way; expected none: see World::stop_recording");
  if (options.body_hash_interval < 1) {
    throw Error("World::record: RecordingOptions.body_hash_interval is " + std::to_string(options.body_hash_interval) +
                "; expected 1 or more");
  }
  recorder = std::make_unique<Recorder>(path, options, arena.threads(), simd_of(*kernels));
  try {
    record_state();
    recorder->record_hash(state_hash());
  } catch (const std::bad_alloc&) {
    recorder.reset();
    throw;
  }
}

void World::Impl::record_state() {
  std::vector<std::byte> state;
  const std::size_t size = save_state(state);
  recorder->record_world_state(*world_definition(), {state.data(), size});
}

std::vector<RecordedBody> recorded_bodies(const Stores& world) {
  const std::vector<BodyHash> hashes = body_hashes(world);
  std::vector<RecordedBody> all;
  all.reserve(world.records.count);
  for (std::uint32_t body = 0; body < world.bodies.size(); ++body) {
    if (world.records.alive[body]) all.push_back({{body, world.records.generation[body]}, fold(hashes[body])});
  }
  return all;
}

void World::Impl::record_result() {
  recorder->record_hash(state_hash());
  if (recorder->wants_bodies(stores.records.count)) recorder->record_bodies(recorded_bodies(stores));
}

void World::Impl::stop_recording(const char* call) {
  recorder->record_bodies(recorded_bodies(stores));
  const std::unique_ptr<Recorder> stopped = std::move(recorder);
  stopped->finish(call);
}

void World::Impl::end_recording() {
  if (!recorder) return;
  try {
    stop_recording("World::~World");
  } catch (const std::exception&) {  // who wants to know calls World::stop_recording()
  }
}

}  // namespace atl
