#include "state/recorder.h"

#include "state/world_definition_state.h"

namespace atl {

Recorder::Recorder(const std::filesystem::path& path, const RecordingOptions& options, int threads, Simd simd)
    : options_(options), file_("World::record", path) {
  StateWriter writer(bytes_);
  visit_all(writer, threads, simd);
  write(RecordKind::Begin, writer);
}

void Recorder::record_geometry(const BodyConstants& constants) {
  for (const CheckedCollider& collider : constants.colliders) {
    const auto geometry = std::pair(collider.shape.kind, collider.content);
    if (!collider.geometry || geometry_.contains(geometry)) continue;
    StateWriter writer(bytes_);
    write_geometry(writer, collider);
    write(RecordKind::Geometry, writer);
    geometry_.insert(geometry);  // should memory run out, it is written twice
  }
}

// The number of a kind of body; a new kind is recorded ahead of its first body.
std::uint32_t Recorder::number_of_kind(const BodyConstants& constants, std::uint64_t kind) {
  if (const auto found = kinds_.find(kind); found != kinds_.end()) return found->second;
  record_geometry(constants);
  StateWriter writer(bytes_);
  visit_constants(writer, constants);
  const auto number = static_cast<std::uint32_t>(kinds_.size());
  kinds_.emplace(kind, number);
  // Nothing but the file fails from here on: the number stands for the record.
  write(RecordKind::BodyKind, writer);
  return number;
}

void Recorder::record_body(const CheckedBody& body, std::uint64_t kind) {
  const std::uint32_t number = number_of_kind(body.constants, kind);
  StateWriter writer(bytes_);
  writer.value(number);
  visit_start(writer, body);
  write(RecordKind::AddBody, writer);
}

void Recorder::record_shape(BodyId body, const BodyConstants& constants, std::uint64_t kind) {
  const std::uint32_t number = number_of_kind(constants, kind);
  StateWriter writer(bytes_);
  visit_all(writer, body, number);
  write(RecordKind::SetShape, writer);
}

void Recorder::record_world_state(const WorldDefinition& world_definition, std::span<const std::byte> state) {
  for (const std::shared_ptr<const BodyConstants>& body : world_definition.bodies) {
    if (body) record_geometry(*body);
  }
  StateWriter writer(bytes_);
  write_definition_of_world(writer, world_definition);
  writer.values(state.data(), state.size());
  write(RecordKind::State, writer);
}

void Recorder::record_step(double dt, bool forced, bool everything, const ContactRules& rules) {
  ++steps_;
  StateWriter writer(bytes_);
  writer.value(dt);
  writer.value(forced);
  writer.value(everything);
  writer.value(rules.filters());
  writer.value(rules.modifies());
  write(RecordKind::Step, writer);
  file_.flush();
}

void Recorder::record_forces(const Eigen::Ref<const Eigen::Matrix3Xd>& forces,
                             const Eigen::Ref<const Eigen::Matrix3Xd>& torques) {
  forces_.clear();
  for (Eigen::Index body = 0; body < forces.cols(); ++body) {
    if (forces.col(body).isZero(0) && torques.col(body).isZero(0)) continue;
    forces_.push_back({static_cast<std::uint32_t>(body), forces.col(body), torques.col(body)});
  }
  record_forces(true);
}

void Recorder::record_no_forces() {
  forces_.clear();
  record_forces(false);
}

void Recorder::record_forces(bool given) {
  StateWriter writer(bytes_);
  visit_forces(writer, given, forces_);
  write(RecordKind::Forces, writer);
  file_.flush();
}

void Recorder::record_answers(std::uint32_t question, const ContactAnswers& answers) {
  StateWriter writer(bytes_);
  visit_answers(writer, question, answers);
  write(RecordKind::ContactAnswers, writer);
  file_.flush();
}

void Recorder::record_hash(std::uint64_t hash) {
  StateWriter writer(bytes_);
  writer.value(hash);
  write(RecordKind::Hash, writer);
}

bool Recorder::wants_bodies(std::size_t count) const {
  return count <= options_.few_bodies || steps_ % options_.body_hash_interval == 0;
}

void Recorder::record_bodies(std::span<const RecordedBody> bodies) {
  StateWriter writer(bytes_);
  visit_recorded_bodies(writer, bodies);
  write(RecordKind::Bodies, writer);
}

}  // namespace atl
