#include "checks/soak/soak.h"

#include <atoll/forces.h>

#include <algorithm>
#include <exception>

#include "changes.h"
#include "checks/divergence/variant_run.h"
#include "population.h"
#include "trials.h"

namespace atl::soak {
namespace {

// How often, in steps; without common periods, so that all meet all.
constexpr std::int64_t compare_every = 20, query_every = 31, roll_back_every = 97, fresh_every = 997, force_every = 61;
constexpr std::int64_t recorded = 500;
constexpr double drag = 0.3;  // kg/s, of the force law

// The widest that is not the first world's, which has the widest.
Simd other_simd() {
  const std::vector<Simd> simds = divergence::supported_simds();
  return simds.size() > 1 ? simds[simds.size() - 2] : simds.back();
}

}  // namespace

static_assert(settings_cycle > longest_stay);

std::int64_t warm_up_steps() { return 8 * settings_cycle; }
std::int64_t segment_steps() { return recorded; }

class Soak::Impl {
 public:
  explicit Impl(const SoakOptions& options)
      : random_(options.seed),
        twin_(options.threads, options.threads == 1 ? 2 : 1, other_simd()),
        population_(twin_, random_),
        changes_(twin_, population_, random_),
        rollback_(twin_) {
    for (const BodyDef& body : yard(random_)) twin_.each([&](World& world) { return world.add_body(body); });
    recordings_.emplace(twin_, options.folder, options.stop);
  }

  StepReport step() {
    const std::int64_t number = tally_.steps + 1;
    population_.come_and_go(number, tally_);
    changes_.make(number, tally_);
    const StepReport report = step_both(number);
    tally_.steps = number;
    recordings_->count_steps(1);
    look(report);
    try {
      check(number);
    } catch (const CheckFailed& failed) {
      throw CheckFailed(failed.what() + (" (" + recordings_->keep() + ")"));
    }
    return report;
  }

  const SoakTally& tally() const { return tally_; }
  const Twin& twin() const { return twin_; }

 private:
  StepReport step_both(std::int64_t number) {
    if (number % force_every != 0) {
      const StepReport report = twin_.first().step(step_length);
      twin_.second().step(step_length);
      return report;
    }
    const ForceLaw law = [](Forces& forces) {
      for (const BodyId id : forces.world().bodies()) forces.add(id, -drag * forces.world().velocity(id));
    };
    const StepReport report = twin_.first().step(step_length, law);
    twin_.second().step(step_length, law);
    return report;
  }

  // For what no body in the yard should come to.
  void look(const StepReport& report) {
    const World& world = twin_.world();
    for (const JointEvent& event : world.joint_events()) tally_.broke += event.kind == JointEventKind::Broke ? 1 : 0;
    if (report.quarantined > 0) {
      const std::vector<Quarantined> out(world.quarantined().begin(), world.quarantined().end());
      tally_.quarantined += static_cast<std::int64_t>(out.size());
      for (const Quarantined& body : out) record_lost(body.id, body.why);
      for (const Quarantined& body : out) population_.remove_with(body.id, tally_.steps, tally_);
    }
    std::vector<BodyId> fallen;
    for (const Resident& resident : population_.residents()) {
      for (const BodyId id : resident.bodies) {
        tally_.fastest = std::max(tally_.fastest, world.velocity(id).norm());
        if (world.centre_of_mass(id).z() < below_ground) fallen.push_back(id);
      }
    }
    tally_.fell_through += static_cast<std::int64_t>(fallen.size());
    for (const BodyId id : fallen) record_lost(id, "fell through the ground");
    for (const BodyId id : fallen) population_.remove_with(id, tally_.steps, tally_);
  }

  void record_lost(BodyId id, const char* why) {
    if (tally_.lost.size() == max_listed_bodies) return;
    LostBody lost = {.step = tally_.steps,
                     .id = id,
                     .thing = population_.name_of(id),
                     .why = why,
                     .settings = changes_.settings_name()};
    recordings_->keep(lost);
    tally_.lost.push_back(std::move(lost));
  }

  void check(std::int64_t number) {
    if (number % compare_every == 0) {
      twin_.compare();
      ++tally_.hash_checks;
    }
    if (number % query_every == 0) check_queries(twin_, random_, tally_);
    if (number % roll_back_every == 0) recordings_->count_steps(rollback_.check(random_, tally_));
    if (number % fresh_every == 0) {
      rollback_.check_fresh([&](World& world) { set_functions(world, changes_.asks_functions()); }, tally_);
    }
    if (number % recorded == 0) recordings_->change_over(tally_);
  }

  Random random_;
  Twin twin_;
  Population population_;
  Changes changes_;
  Rollback rollback_;
  std::optional<Recordings> recordings_;
  SoakTally tally_;
};

Soak::Soak(const SoakOptions& options) : impl_(std::make_unique<Impl>(options)) {}
Soak::~Soak() = default;

StepReport Soak::step() { return impl_->step(); }
const SoakTally& Soak::tally() const { return impl_->tally(); }
const World& Soak::world() const { return impl_->twin().world(); }
const World& Soak::second() const { return impl_->twin().second(); }

}  // namespace atl::soak
