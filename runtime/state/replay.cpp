// A recording, done again: see recorder.h for what is in it.

#include "state/replay.h"

#include <atoll/error.h>
#include <atoll/forces.h>
#include <atoll/recording.h>
#include <atoll/world.h>
#include <features/with_recording.h>

#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "state/body_hashes.h"
#include "state/geometry_state.h"
#include "state/recorded_calls.h"
#include "state/recorder.h"
#include "state/recording_file.h"
#include "state/world_definition_state.h"
#include "world/bodies.h"
#include "world/left_out.h"
#include "world/world_impl.h"

namespace atl {
namespace {

// The call of a number, of those from `number` on.
template <std::size_t number = 0>
void make_call(std::size_t wanted, StateReader& reader, World& world) {
  if constexpr (number < std::variant_size_v<RecordedCall>) {
    if (wanted != number) return make_call<number + 1>(wanted, reader, world);
    std::variant_alternative_t<number, RecordedCall> call;
    visit_call(reader, call);
    reader.check(reader.left() == 0, "more than there should be");
    call.make(world);
  } else {
    reader.check(false, "a record of no known kind");
  }
}

constexpr StateSource record_source = {"", "record", "World::record", true};

}  // namespace

std::vector<ReplayedBody> differing_bodies(const std::vector<RecordedBody>& recorded,
                                           const std::vector<RecordedBody>& found) {
  std::vector<ReplayedBody> result;
  auto a = recorded.begin();
  auto b = found.begin();
  while (a != recorded.end() || b != found.end()) {
    const bool only_a = b == found.end() || (a != recorded.end() && a->id < b->id);
    const bool only_b = a == recorded.end() || (b != found.end() && b->id < a->id);
    if (only_a || only_b) {
      result.push_back({only_a ? a->id : b->id, {"id"}});
    } else if (a->parts != b->parts) {
      result.push_back({a->id, differing_parts(a->parts, b->parts)});
    }
    if (!only_b) ++a;
    if (!only_a) ++b;
  }
  return result;
}

Replay::Replay(const std::string& path, const ReplayOptions& machine)
    : reader_(path), world_({.threads = machine.threads, .settings = {.simd = machine.simd}}) {
  result_.recorded_steps = reader_.steps();
  result_.complete = reader_.complete();
  result_.simd = world_.simd();
  make_calls();
  if (!begun_) reader_.fail("found no state to begin with; expected a recording that holds one");
}

void Replay::make_calls() {
  while (next()) {
    if (reader_.kind() == RecordKind::Step) {
      put_back_ = true;
      break;
    }
    if (!take_next()) break;
  }
}

std::vector<RecordedBody> Replay::bodies() const { return recorded_bodies(world_.impl_->stores); }

bool Replay::advance() {
  bool stepped = false;
  while (next()) {
    const RecordKind kind = reader_.kind();
    if (stepped && kind != RecordKind::Hash && kind != RecordKind::Bodies) {
      put_back_ = true;
      break;
    }
    const std::int64_t before = result_.steps;
    if (!take_next()) break;
    stepped |= result_.steps > before;
  }
  return stepped;
}

// The next record, or again one that was put back. False at the end, be it in a record that is cut off.
bool Replay::next() {
  if (std::exchange(put_back_, false)) return true;
  ended_ = ended_ || !reader_.next();
  return !ended_;
}

// Does what the record says that was read last. False if it can't be done.
bool Replay::take_next() {
  try {
    StateReader record(reader_.content(), record_source);
    take(record);
    return true;
  } catch (const Error& error) {
    // A call that was valid on the recorded state need not be possible on this one.
    if (!result_.divergence) reader_.fail(reader_.place() + ": " + error.what());
    ended_ = true;
    return false;
  }
}

Replay::Mark Replay::mark() const {
  Mark mark{.place = put_back_ || ended_ ? reader_.before() : reader_.after(),
            .snapshot = {},
            .kinds = kind_count_,
            .steps = result_.steps,
            .divergence = result_.divergence};
  world_.save(mark.snapshot);
  return mark;
}

void Replay::learn_from(const Replay& other) {
  if (kinds_.size() < other.kinds_.size()) kinds_ = other.kinds_;
  if (geometry_.size() < other.geometry_.size()) geometry_ = other.geometry_;
}

void Replay::go_to(const Mark& mark) {
  world_.restore(mark.snapshot);
  reader_.go_to(mark.place);
  kind_count_ = mark.kinds;
  put_back_ = ended_ = false;
  result_.steps = mark.steps;
  result_.divergence = mark.divergence;
}

void Replay::take(StateReader& record) {
  const RecordKind kind = reader_.kind();
  record.check(begun_ || kind == RecordKind::Begin || kind == RecordKind::Geometry || kind == RecordKind::State,
               "a record ahead of the state to begin with");
  switch (kind) {
    case RecordKind::Begin:
      visit_all(record, result_.recorded_threads, result_.recorded_simd);
      break;
    case RecordKind::Geometry: {
      ReadGeometry read = read_geometry(record);
      // Read again after the replay was taken back it is what bodies have already.
      geometry_.try_emplace({read.kind, read.content}, std::move(read.geometry));
      break;
    }
    case RecordKind::BodyKind:
      take_kind(record);
      break;
    case RecordKind::AddBody:
      add_body(record);
      break;
    case RecordKind::SetShape:
      set_shape(record);
      break;
    case RecordKind::State:
      return take_state(record);
    case RecordKind::Step:
      step(record);
      break;
    case RecordKind::ContactAnswers:  // to what this run didn't ask: it has come to something else
      return;
    case RecordKind::Hash:
      compare_hash(record);
      break;
    case RecordKind::Bodies:
      compare_bodies(record);
      break;
    default:
      return make_call(static_cast<std::size_t>(kind) - static_cast<std::size_t>(RecordKind::Call), record, world_);
  }
  record.check(record.left() == 0, "more than there should be");
}

void Replay::take_kind(StateReader& record) {
  BodyConstants constants;
  visit_constants(record, constants);
  record.check(give_geometry(constants, geometry_), "a body without its geometry");
  check_built_for(constants);
  if (kind_count_ == kinds_.size()) kinds_.push_back(std::move(constants));
  ++kind_count_;
}

const BodyConstants& Replay::kind_in(StateReader& record) {
  std::uint32_t kind = 0;
  record.value(kind);
  record.check(kind < kind_count_, "a body of no kind");
  return kinds_[kind];
}

void Replay::add_body(StateReader& record) {
  CheckedBody body;
  body.constants = kind_in(record);
  visit_start(record, body);
  check_built_for_surface("BodyDef.surface_velocity", body.surface.velocity);
  check_built_for_surface("BodyDef.surface_angular_velocity", body.surface.angular_velocity);
  world_.impl_->add_body(body);
}

void Replay::set_shape(StateReader& record) {
  BodyId id;
  visit_value(record, id);
  world_.impl_->redefine(index_of(world_.impl_->stores, id, "set_shape"), kind_in(record));
}

void Replay::take_state(StateReader& record) {
  const std::shared_ptr<const WorldDefinition> world_definition = read_definition_of_world(record);
  World::Impl& impl = *world_.impl_;
  const auto definition = with_geometry(world_definition, geometry_);
  const std::span<const std::byte> state = reader_.content().last(record.left());
  // A replay that has come to something else ends at a state that can't be read, and tells of the world ahead of it.
  if (result_.divergence) World::Impl::try_out(definition, state);
  impl.restore(definition, impl.serial, state, true);
  begun_ = true;
}

void Replay::step(StateReader& record) {
  bool forced = false;
  record.value(dt_);
  record.value(forced);
  // No bit shows it while all numbers are finite. What a body that breaks takes along may depend on it.
  record.value(world_.impl_->stores.settings.run_everything);
  ContactRules::Recorded& rules = world_.impl_->rules.recorded;
  record.value(rules.filters);
  record.value(rules.modifies);
  rules.answer = [this](std::uint32_t question) { return take_answers(question); };
  if (forced) {
    try {
      report_ = world_.step(dt_, [this](Forces& forces) { take_forces(forces); });
    } catch (const LawEnded&) {  // as it did when it was recorded
    }
  } else {
    report_ = world_.step(dt_);
  }
  ++result_.steps;
}

// The law's next answer.
void Replay::take_forces(Forces& forces) {
  if (!next()) throw LawEnded{};
  StateReader record(reader_.content(), record_source);
  record.check(reader_.kind() == RecordKind::Forces, "a step without the forces of its law");
  bool given = false;
  std::vector<RecordedForce> recorded;
  visit_forces(record, given, recorded);
  if (!given) throw LawEnded{};
  for (const RecordedForce& of : recorded) {
    record.check(of.body < forces.forces().cols(), "a force on no body");
    forces.forces().col(of.body) = of.force;
    forces.torques().col(of.body) = of.torque;
  }
}

// The recorded answers of a contact filter or modifier; nothing is recorded if it changed nothing.
ContactAnswers Replay::take_answers(std::uint32_t question) {
  ContactAnswers answers;
  if (!next()) return answers;
  if (reader_.kind() == RecordKind::ContactAnswers) {
    StateReader record(reader_.content(), record_source);
    std::uint32_t number = 0;
    visit_answers(record, number, answers);
    record.check(record.left() == 0, "more than there should be");
    if (number == question) return answers;
  }
  put_back_ = true;
  return {};
}

void Replay::compare_hash(StateReader& record) {
  std::uint64_t expected = 0;
  record.value(expected);
  if (result_.divergence || world_.state_hash() == expected) return;
  result_.divergence = {.step = result_.steps};
}

void Replay::compare_bodies(StateReader& record) {
  std::vector<RecordedBody> recorded;
  visit_recorded_bodies(record, recorded);
  if (!result_.divergence || result_.divergence->bodies_step) return;
  result_.divergence->bodies_step = result_.steps;
  result_.divergence->bodies = differing_bodies(recorded, bodies());
}

ReplayResult replay(const std::string& path, const ReplayOptions& options) {
  if constexpr (!with_recording) throw_left_out("replay is called", "recordings", "RECORDING");
  Replay replay(path, options);
  while (!replay.knows_difference() && replay.advance()) {
    if (options.on_step) options.on_step(replay.result().steps, replay.result().recorded_steps);
    if (options.stop && options.stop()) break;
  }
  ReplayResult result = replay.result();
  result.hash = replay.world().state_hash();
  return result;
}

}  // namespace atl
