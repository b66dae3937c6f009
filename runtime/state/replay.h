#pragma once

#include <atoll/recording.h>
#include <atoll/report.h>
#include <atoll/snapshot.h>
#include <atoll/world.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "state/geometry_state.h"
#include "state/recorder.h"
#include "state/recording_file.h"
#include "state/state_archive.h"
#include "state/world_definition_state.h"
#include "step/contact_rules.h"
#include "world/body_definition.h"

namespace atl {

/// Which bodies differ, and in what, of two lists in order of ids.
std::vector<ReplayedBody> differing_bodies(const std::vector<RecordedBody>& recorded,
                                           const std::vector<RecordedBody>& found);

/// A recording, and the world in which it is done again, step by step: see recorder.h for what is in it. Throws Error,
/// as replay() says.
class Replay {
 public:
  /// A saved state between two steps, to which the replay can return.
  struct Mark {
    RecordingReader::Place place;
    Snapshot snapshot;
    std::size_t kinds = 0;
    std::int64_t steps = 0;
    std::optional<ReplayDivergence> divergence = {};
  };

  /// Makes all calls ahead of the first step. `machine` says threads and instruction set.
  Replay(const std::string& path, const ReplayOptions& machine);

  /// Makes the calls up to the next step, that step, and compares what it came to. False at the end of the recording,
  /// or where it can't go on as the state is another.
  bool advance();
  /// Makes the calls up to the next step alone.
  void make_calls();
  /// True once it is known which bodies differ, or that none does.
  bool knows_difference() const { return result_.divergence && result_.divergence->bodies_step; }

  Mark mark() const;
  void go_to(const Mark& mark);
  /// Takes over what another replay of the same recording has read, whose marks it is to go to.
  void learn_from(const Replay& other);

  const World& world() const { return world_; }
  std::vector<RecordedBody> bodies() const;
  /// The report of the last step; it is meaningless before the first step, and after go_to().
  const StepReport& report() const { return report_; }
  double dt() const { return dt_; }  ///< s, of that step
  /// The result so far.
  const ReplayResult& result() const { return result_; }

 private:
  // Thrown when the force law's part of a step ends early: the law threw, or the recording is cut off there.
  struct LawEnded {};

  bool next();
  bool take_next();
  void take(StateReader& record);
  void take_kind(StateReader& record);
  const BodyConstants& kind_in(StateReader& record);
  void add_body(StateReader& record);
  void set_shape(StateReader& record);
  void take_state(StateReader& record);
  void step(StateReader& record);
  void take_forces(Forces& forces);
  ContactAnswers take_answers(std::uint32_t question);
  void compare_hash(StateReader& record);
  void compare_bodies(StateReader& record);

  RecordingReader reader_;
  World world_;
  Geometry geometry_;
  std::vector<BodyConstants> kinds_;  // all that were ever read
  std::size_t kind_count_ = 0;        // of these, those that were read up to where it stands
  bool begun_ = false;
  bool put_back_ = false;  // the record that was read last
  bool ended_ = false;
  StepReport report_;
  double dt_ = 0;
  ReplayResult result_;
};

}  // namespace atl
