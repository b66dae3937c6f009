// Recordings: replayed, looked at step by step, compared.

#include <atoll/first_difference.h>
#include <atoll/playback.h>
#include <atoll/recording.h>
#include <atoll/snapshot.h>
#include <atoll/world.h>

#include <optional>
#include <string>
#include <vector>

#include "arrays.h"
#include "fields.h"
#include "parts.h"

namespace atl::python {
namespace {

void bind_replays(nb::module_& module) {
  nb::class_<ReplayedBody>(module, "ReplayedBody", "A body that is not as it was when it was recorded.")
      .def_ro("id", &ReplayedBody::id)
      .def_ro("parts", &ReplayedBody::parts, "of it, as in BodyHash");
  nb::class_<ReplayDivergence>(module, "ReplayDivergence", "Where a replay parts from what was recorded.")
      .def_ro("step", &ReplayDivergence::step, "the first after which the state has another hash")
      .def_ro("bodies_step", &ReplayDivergence::bodies_step, "after which bodies were compared")
      .def_ro("bodies", &ReplayDivergence::bodies);
  nb::class_<ReplayResult> result(module, "ReplayResult", "What a replay came to.");
  result.def_ro("recorded_threads", &ReplayResult::recorded_threads)
      .def_ro("recorded_simd", &ReplayResult::recorded_simd)
      .def_ro("simd", &ReplayResult::simd)
      .def_ro("recorded_steps", &ReplayResult::recorded_steps)
      .def_ro("complete", &ReplayResult::complete, "whether the recording was ended")
      .def_ro("steps", &ReplayResult::steps, "that were done")
      .def_ro("hash", &ReplayResult::hash, "of the state after these")
      .def_ro("divergence", &ReplayResult::divergence, "None if all is as it was");
  module.def(
      "replay",
      [](const std::string& path, int threads, Simd simd) { return replay(path, {.threads = threads, .simd = simd}); },
      nb::arg("path"), nb::arg("threads") = 1, nb::arg("simd") = Simd::Auto, nb::call_guard<nb::gil_scoped_release>(),
      "Makes the calls of a recording again, and holds the state to what was recorded after every step.");
  module.def("is_recording", &is_recording, nb::arg("path"));
}

template <auto column>
void bind_copy(nb::class_<Playback>& playback, const char* name, const char* doc) {
  playback.def_prop_ro(
      name,
      [](const Playback& self) {
        const auto map = (self.world().*column)();
        const auto rows = static_cast<std::size_t>(map.cols());
        return nb::steal(array_of(map.data(), {rows, static_cast<std::size_t>(map.rows())}));
      },
      doc, nb::sig((std::string("def ") + name + "(self) -> numpy.typing.NDArray[numpy.float64]").c_str()));
}

void bind_playback(nb::module_& module) {
  nb::class_<Playback> playback(module, "Playback",
                                "A recording that is looked at step by step, forwards and backwards.");
  playback
      .def(
          "__init__",
          [](Playback* self, const std::string& path, int threads, Simd simd, std::size_t key_frame_bytes) {
            new (self) Playback(path, {.threads = threads, .simd = simd, .key_frame_bytes = key_frame_bytes});
          },
          nb::arg("path"), nb::arg("threads") = 1, nb::arg("simd") = Simd::Auto,
          nb::arg("key_frame_bytes") = PlaybackOptions{}.key_frame_bytes,
          "key_frame_bytes: what snapshots may take, from which it goes back.")
      .def_prop_ro("steps", &Playback::steps, "in all of the recording")
      .def_prop_ro("step", &Playback::step, "how many were made to come to this state")
      .def("advance", &Playback::advance, nb::call_guard<nb::gil_scoped_release>(),
           "Goes one step on. False, and nothing done, at the end.")
      .def("seek", &Playback::seek, nb::arg("step"), nb::call_guard<nb::gil_scoped_release>(),
           "Goes to the state after so many steps.")
      .def_prop_ro(
          "report", [](const Playback& self) { return self.report(); }, "of the last step that was made")
      .def_prop_ro("dt", &Playback::dt, "s, of that step")
      .def_prop_ro("divergence", [](const Playback& self) { return self.divergence(); })
      .def_prop_ro("bodies", [](const Playback& self) { return self.world().bodies(); })
      .def(
          "pose", [](const Playback& self, BodyId body) { return self.world().pose(body); }, nb::arg("body"))
      .def(
          "definition", [](const Playback& self, BodyId body) { return self.world().definition(body); },
          nb::arg("body"))
      .def("state_hash", [](const Playback& self) { return self.world().state_hash(); })
      .def(
          "save",
          [](const Playback& self) {
            Snapshot snapshot;
            self.world().save(snapshot);
            return snapshot;
          },
          "The state, to go on from in a world of the same bodies.");
  bind_copy<&World::positions>(playback, "positions", "m, shape (n, 3), of centres of mass; a copy");
  bind_copy<&World::orientations>(playback, "orientations", "shape (n, 4): x, y, z, w; a copy");
  bind_copy<&World::velocities>(playback, "velocities", "m/s, shape (n, 3); a copy");
  bind_copy<&World::angular_velocities>(playback, "angular_velocities", "rad/s, shape (n, 3); a copy");
}

void bind_first_difference(nb::module_& module) {
  nb::class_<FirstDifference>(module, "FirstDifference", "Where two runs part.")
      .def_ro("step", &FirstDifference::step, "the first after which their states differ")
      .def_ro("by_calls", &FirstDifference::by_calls, "whether calls ahead of that step made them differ")
      .def_ro("bodies_step", &FirstDifference::bodies_step)
      .def_prop_ro(
          "phase",
          [](const FirstDifference& self) {
            return self.phase ? std::optional<std::string>(phase_name(*self.phase)) : std::nullopt;
          },
          "the first of that step whose results differ, or None")
      .def_ro("bodies", &FirstDifference::bodies);
  nb::class_<FirstDifferenceResult>(module, "FirstDifferenceResult")
      .def_ro("difference", &FirstDifferenceResult::difference, "None if they are the same as far as both go")
      .def_ro("steps", &FirstDifferenceResult::steps, "that both have")
      .def_ro("replays", &FirstDifferenceResult::replays, "that were made to find out");
  module.def(
      "find_first_difference",
      [](const std::string& first, const std::string& second, int threads, Simd simd) {
        return find_first_difference(first, second, {.threads = threads, .simd = simd});
      },
      nb::arg("first"), nb::arg("second"), nb::arg("threads") = 1, nb::arg("simd") = Simd::Auto,
      nb::call_guard<nb::gil_scoped_release>(), "Finds the first step in which two recordings differ, and in what.");
}

}  // namespace

void bind_recordings(nb::module_& module) {
  bind_replays(module);
  bind_playback(module);
  bind_first_difference(module);
}

}  // namespace atl::python
