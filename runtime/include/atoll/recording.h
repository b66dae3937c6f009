#pragma once

#include <atoll/settings.h>
#include <atoll/types.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace atl {

/// Optional contents of a recording, which always has the calls, dt and the hash of the state after every step: see
/// World::record().
struct RecordingOptions {
  /// Bodies are hashed one by one after every so many steps, so that replay() can tell which of them differ; >= 1.
  int body_hash_interval = 30;
  /// But after every step while there are no more bodies than this. 8 bytes a body each time.
  std::size_t few_bodies = 256;
};

struct ReplayOptions {
  int threads = 1;  ///< workers, in [1, 1024]
  Simd simd = Simd::Auto;
  /// Told the number of steps done and of those there are, after each.
  std::function<void(std::int64_t steps, std::int64_t of)> on_step = {};
  /// Asked once a step was done and compared: the replay ends there if it says true, with what it has found.
  std::function<bool()> stop = {};
};

/// A body that is not as it was when it was recorded.
struct ReplayedBody {
  BodyId id;
  /// The parts of the body that differ: "pose", "velocity", "forces", "rest", "bounds", "contacts" or "joints", as in
  /// BodyHash; or "id" alone, if the body exists in only one of the two.
  std::vector<std::string> parts;
};

/// The point at which a replay diverges from its recording.
struct ReplayDivergence {
  std::int64_t step = 0;  ///< the first after which the state has another hash; 0 as the recording began
  /// The step after which `bodies` was found: from `step` on the first after which bodies were hashed one by one, if
  /// any was. What differs may have spread until then.
  std::optional<std::int64_t> bodies_step = {};
  std::vector<ReplayedBody> bodies = {};  ///< in order of ids; none if what differs is no body's
};

struct ReplayResult {
  int recorded_threads = 1;
  Simd recorded_simd = Simd::Auto;
  Simd simd = Simd::Auto;  ///< of the replay; neither is Auto
  std::int64_t recorded_steps = 0;
  bool complete = true;    ///< whether the recording was ended: see World::stop_recording()
  std::int64_t steps = 0;  ///< that were done
  std::uint64_t hash = 0;  ///< of the state after these
  std::optional<ReplayDivergence> divergence = {};
};

/// Makes the calls of a recording again, in a world of its own, and holds the state to what was recorded after every
/// step. Ends with the recording; or where the state differs, once it is known of which bodies. What is cut off, as of
/// a program that crashed, is replayed up to its last whole record, be it a step that has no hash.
///
/// Throws Error on a number of threads out of range or an instruction set that this machine lacks; and, saying what was
/// found where, and expected, if the file can't be read, is no recording, is damaged or is of another version or byte
/// order.
ReplayResult replay(const std::string& path, const ReplayOptions& options = {});

/// True if a file can be read and begins as recordings do.
bool is_recording(const std::string& path);

}  // namespace atl
