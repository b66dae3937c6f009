#pragma once

#include <atoll/error.h>
#include <atoll/world.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "state/world_definition.h"
#include "step/pipeline.h"
#include "world/query_gate.h"
#include "world/step_guard.h"
#include "world/stores.h"
#include "world/viewed_columns.h"

namespace atl {

class Recorder;

/// The implementation of World: its stores, the pipeline that steps them, and what runs that.
class World::Impl {
 public:
  explicit Impl(const WorldDef& def);
  ~Impl();

  StepReport step(double dt);
  /// Throws Error, naming the call, if a step is under way: it is made by a function that the step asks, or by another
  /// thread. Or if memory ran out within an earlier one, unless the call makes the world anew.
  void check_idle(const char* call, bool makes_anew = false) const;
  void check_not_in_batch() const {
    if (in_batch) throw Error("World: a move of a world of a Batch; expected one by itself: see Batch::world()");
  }
  /// The index of a body that the call is about to change. Throws Error as check_idle() does, and on a stale id.
  std::uint32_t index_to_change(BodyId id, const char* call) const;
  std::uint32_t index_to_change(JointId id, const char* call) const;
  void begin_step();
  /// Tells observers of a step that was made.
  void observe(const World& world, const StepReport& report, double dt);
  /// By dt seconds of the step that has begun, maybe all of it. Its events wait for its end.
  StepReport advance(double dt, int substeps, bool ends_step);

  BodyId add_body(const CheckedBody& start);
  void redefine(std::uint32_t body, const BodyConstants& constants);
  void use_kernels(Simd simd);

  // restore.cpp
  std::size_t save_state(std::vector<std::byte>& bytes) const;  // the number of those that it wrote
  /// `origin` is the serial number of the world that was saved. A state from a file has its numbers checked too, and
  /// leaves the world unusable where it throws: see try_out().
  void restore(const std::shared_ptr<const WorldDefinition>& saved, std::uint64_t origin,
               std::span<const std::byte> state, bool from_file = false);
  /// Throws Error if what is in a file is no state of such bodies.
  static void try_out(const std::shared_ptr<const WorldDefinition>& world_definition, std::span<const std::byte> state);
  /// Made when asked for, and kept until bodies come or go.
  const std::shared_ptr<const WorldDefinition>& world_definition() const;
  std::uint64_t state_hash() const;

  // recording.cpp
  void record(const std::string& path, const RecordingOptions& options);
  void record_state();
  void record_result();  // of a step
  void stop_recording(const char* call);
  void end_recording();  // as the world ends

  Stores stores;
  ViewedColumns viewed;
  StepPipeline pipeline;
  ContactRules rules;
  const solver::Kernels* kernels;
  const collision::NarrowphaseKernels* narrowphase_kernels;
  jobs::Arena arena;
  QueryGate query_gate;
  StepGuard step_guard;
  std::unique_ptr<Recorder> recorder;  // null while nothing is recorded
  const char* asking = nullptr;        // "a force law" or "a step observer", while one is asked
  std::vector<StepObserver> observers;
  const std::uint64_t serial;  // of this world in the process
  bool in_batch = false;       // which keeps it: it isn't moved

 private:
  void adopt(const std::shared_ptr<const WorldDefinition>& world_definition);
  void read_state(std::span<const std::byte> state, bool from_file);

  struct KnownDefinition {
    std::shared_ptr<const WorldDefinition> world_definition;
    std::shared_ptr<const WorldDefinition> known_as;  // a snapshot's, found to be the same
    std::uint64_t version = 0;                        // of the bodies that it is of
  };
  mutable KnownDefinition world_definition_;
};

}  // namespace atl
