#pragma once

#include <atoll/recording.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "state/geometry_state.h"
#include "state/recorded_calls.h"
#include "state/recording_file.h"
#include "state/state_archive.h"
#include "state/world_definition.h"
#include "step/contact_rules.h"
#include "world/body_definition.h"
#include "world/stores.h"

namespace atl {

/// The hash of one body, folded: see fold() in body_hashes.h.
struct RecordedBody {
  BodyId id;
  std::uint64_t parts = 0;
};

/// The records of all bodies, in order of ids.
std::vector<RecordedBody> recorded_bodies(const Stores& world);

/// One force and torque that a force law applied to a body.
struct RecordedForce {
  std::uint32_t body = 0;  // its index
  Vector3 force;
  Vector3 torque;
};

/// Notes down what is done to a world, once it was done, and what came of it.
class Recorder {
 public:
  /// Throws Error if the file can't be written. `threads` and `simd` are the world's.
  Recorder(const std::filesystem::path& path, const RecordingOptions& options, int threads, Simd simd);

  template <typename Call>
  void note(const Call& call) {
    StateWriter writer(bytes_);
    visit_call(writer, call);
    write(kind_of<Call>(), writer);
  }
  /// `kind` is the fingerprint() of what never changes of it.
  void record_body(const CheckedBody& body, std::uint64_t kind);
  /// The body has become one of another kind.
  void record_shape(BodyId body, const BodyConstants& constants, std::uint64_t kind);
  /// All of the world, as the recording begins or after it was restored.
  void record_world_state(const WorldDefinition& world_definition, std::span<const std::byte> state);
  /// Ahead of a step, and in the file by then: should the step crash, the recording has all that leads there.
  /// A forced one is followed by what its law asked for, a record for each time, in the file as soon as it is known.
  void record_step(double dt, bool forced, bool everything, const ContactRules& rules);
  /// 3 x bodies: N, N m.
  void record_forces(const Eigen::Ref<const Eigen::Matrix3Xd>& forces,
                     const Eigen::Ref<const Eigen::Matrix3Xd>& torques);
  void record_no_forces();  ///< the law threw, and ended the step
  /// Records the answer of a contact filter or modifier to the question of that number in the step, and flushes the
  /// file.
  void record_answers(std::uint32_t question, const ContactAnswers& answers);
  void record_hash(std::uint64_t hash);
  /// True if bodies are to be hashed one by one after the step that was recorded last.
  bool wants_bodies(std::size_t count) const;
  void record_bodies(std::span<const RecordedBody> bodies);
  /// Throws Error, naming `call`, if the file could not be written.
  void finish(const char* call) { file_.finish(call); }

 private:
  void write(RecordKind kind, const StateWriter& writer) { file_.write(kind, {bytes_.data(), writer.size()}); }
  void record_geometry(const BodyConstants& constants);
  std::uint32_t number_of_kind(const BodyConstants& constants, std::uint64_t kind);
  void record_forces(bool given);

  RecordingOptions options_;
  RecordingWriter file_;
  std::vector<std::byte> bytes_;       // scratch: a record's
  std::vector<RecordedForce> forces_;  // scratch
  std::int64_t steps_ = 0;
  std::map<std::uint64_t, std::uint32_t> kinds_;                       // numbers, by fingerprint
  std::set<std::pair<collision::ShapeKind, std::uint64_t>> geometry_;  // that is in the file, by content
};

/// How a body starts, for archives, but for what never changes of it.
template <typename Archive, typename Body>
void visit_start(Archive& archive, Body& body) {
  visit_all(archive, body.position, body.orientation, body.velocity, body.angular_velocity, body.surface.velocity,
            body.surface.angular_velocity);
  visit_filter(archive, body.filter);
  archive.value(body.awake);
  visit_text(archive, body.name);
  archive.value(body.user_data);
}

template <typename Archive, typename Forces>
void visit_forces(Archive& archive, bool& given, Forces& forces) {
  archive.value(given);
  visit_each(archive, forces, 7 * sizeof(std::uint32_t),
             [&](auto& of) { visit_all(archive, of.body, of.force, of.torque); });
}

template <typename Archive, typename Answers>
void visit_answers(Archive& archive, std::uint32_t& question, Answers& answers) {
  archive.value(question);
  visit_each(archive, answers.refused, sizeof(collision::Pair),
             [&](auto& pair) { visit_all(archive, pair.first, pair.second); });
  visit_each(archive, answers.modified, sizeof(collision::Pair), [&](auto& of) {
    visit_all(archive, of.pair.first, of.pair.second, of.part, of.points, of.friction, of.restitution, of.slip);
  });
}

template <typename Archive, typename Bodies>
void visit_recorded_bodies(Archive& archive, Bodies& bodies) {
  visit_each(archive, bodies, 2 * sizeof(std::uint64_t), [&](auto& body) { visit_all(archive, body.id, body.parts); });
}

}  // namespace atl
