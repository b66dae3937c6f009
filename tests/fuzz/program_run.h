#pragma once
/// A program under way, for those who make its calls.

#include <atoll/error.h>
#include <atoll/recording.h>
#include <atoll/snapshot.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bytes.h"
#include "definitions.h"
#include "lockstep.h"
#include "program.h"
#include "scratch_file.h"

namespace atl::fuzz {

// Views of positions, which a world has been asked to keep.
using View = Eigen::Map<const Eigen::Matrix3Xd>;

struct Run {
  Bytes& bytes;
  Definitions& definitions;
  Lockstep& worlds;
  const ProgramLimits& limits;
  ProgramResult result = {};
  // All that there have been: stale ids are asked for too.
  std::vector<BodyId> bodies = {};
  std::vector<JointId> joints = {};
  std::array<std::vector<Snapshot>, 2> snapshots = {};
  std::array<std::uint64_t, 2> hashes = {};
  std::vector<View> views = {};
  ScratchFile recording = ScratchFile("recording");
  ScratchFile file = ScratchFile("snapshot");

  /// A call that may be refused: the error, or nothing.
  std::string call(const char* name, const Lockstep::Call& make);
  /// Takes a step in each world by a function of it, if the program may still take one, and checks what it comes to.
  void step(const char* name, const std::function<StepReport(World& world)>& take);
  double time_step();
  /// One that there is, or was, or never.
  BodyId body();
  JointId joint();
};

// Makes a choice that may be invalid, such as a hull of points in a plane: nothing if its constructor refuses it.
template <typename Choose>
auto chosen(const Choose& choose) -> std::optional<decltype(choose())> {
  try {
    return choose();
  } catch (const Error&) {
    return std::nullopt;
  }
}

// Kinds of call, each of which reads from the bytes what it is made with.

// Operations of program_files.cpp: worlds in snapshots, recordings and scene files.
void save(Run& run);
void restore(Run& run);
void record(Run& run);
void stop_recording(Run& run, const ReplayOptions& options);
void write_as_scene(Run& run);
void end_while_recording(Run& run);
void use_files_that_cannot_be(Run& run);

// Operations of program_more.cpp: sequences of several calls, and calls that must be refused.
void fall_asleep(Run& run);
void change_often(Run& run);
void keep_views(Run& run);
void look_at_views(const Run& run);
void change_instructions(Run& run);
void make_a_world(Run& run);
void switch_joints(Run& run);
void define_what_cannot_be(Run& run);
void break_and_release(Run& run);
void overstep(Run& run);
void change_target(Run& run);
void redefine(Run& run);
void switch_bodies(Run& run);
void redefine_joint(Run& run);

}  // namespace atl::fuzz
