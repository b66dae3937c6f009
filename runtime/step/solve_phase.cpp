#include "step/solve_phase.h"

#include <features/with_direct_contacts.h>
#include <features/with_joints.h>
#include <features/with_surfaces.h>
#include <jobs/arrays.h>
#include <jobs/assert.h>
#include <jobs/stopwatch.h>
#include <jobs/worker_team.h>
#include <solver/integrate/free_flight.h>
#include <solver/tuning.h>

#include <algorithm>
#include <numeric>

#include "step/events.h"
#include "step/results.h"
#include "world/bodies.h"
#include "world/colliders.h"
#include "world/materials.h"
#include "world/settings_check.h"

namespace atl {

using solver::SolveMode;

namespace {

solver::SolverSettings settings_now(const Stores& world, int substeps) {
  solver::SolverSettings how = solver_settings(world.settings);
  how.substeps = substeps;
  if (!world.settings.restitution_threshold) {
    how.restitution_threshold = solver::tuning::min_bounce * world.gravity.norm() * world.clock.dt / substeps;
  }
  return how;
}

// Solver settings of groups that are solved in a mode and get `substeps` substeps, where the caller asked for `asked`.
solver::SolverSettings settings_of(const Stores& world, int asked, int substeps, SolveMode mode) {
  solver::SolverSettings how = settings_now(world, substeps);
  how.refinement = static_cast<double>(substeps) / asked;
  if (mode != SolveMode::Refined && mode != SolveMode::Landing) return how;
  int times = solver::tuning::landing_refinement;
  if (mode == SolveMode::Landing) {
    how.contact_hertz = solver::SubstepConstants::contact_hertz(how, world.clock.dt / substeps);
  } else {
    times = solver::refinement_of(how, world.clock.dt);
  }
  how.refined = true;
  how.refinement *= times;
  how.substeps *= times;
  return how;
}

constexpr bool solves_directly = with_direct_contacts || with_joints;

bool selects_solvers(const Settings& settings) {
  return with_direct_contacts && settings.stabilisation == Stabilisation::Soft &&
         settings.contact_solver != ContactSolver::Iterative;
}

void move_unconstrained_bodies(Stores& world, const StepContext& step, std::span<const std::uint32_t> free,
                               solver::FastBodies& moved) {
  constexpr std::size_t grain = 256;
  step.arena.parallel_for(free.size(), grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      solver::move_free_body(world.bodies, free[i], world.gravity, world.clock.dt, step.substeps, world.aabbs.bounds,
                             moved);
    }
  });
  if (world.contents.kinematic == 0 && !world.settings.run_everything) return;
  for (const std::uint32_t body : world.active.in_order()) {
    if (world.bodies.mobility[body] == solver::Mobility::Kinematic)
      solver::move_kinematic_body(world.bodies, body, world.clock.dt, world.aabbs.bounds, moved);
  }
}

// In how many runs of the phases a step is made: under a force law in as many as it has substeps.
int parts_of_step(const Stores& world, const StepContext& step) { return world.settings.substeps / step.substeps; }

bool measures_residual(const Stores& world) {
  return world.settings.target.residual && world.clock.steps % solver::tuning::residual_interval == 0;
}

solver::ErrorInput error_input(const Stores& world, const StepContext& step, const IslandPhase& islands) {
  return {.islands = islands.islands(),
          .bodies = world.bodies,
          .manifolds = world.cache.manifolds.data(),
          .joints = world.joints.joints.data(),
          .joint_graph = &islands.joint_graph(),
          .joint_systems = &islands.joint_systems(),
          .gravity = world.gravity.norm(),
          .dt = world.clock.dt,
          .asked = step.substeps,
          .parts = parts_of_step(world, step)};
}

// Groups have each island once, and those of one group are solved alike.
void check_groups(std::span<const solver::IslandGroup> groups, std::size_t islands, std::span<const SolveMode> modes,
                  std::span<const std::uint16_t> substeps) {
  ATL_ASSERT(modes.empty() || modes.size() == islands, modes.size(), islands);
  ATL_ASSERT(substeps.empty() || substeps.size() == islands, substeps.size(), islands);
  std::size_t covered = 0;
  for (const solver::IslandGroup& group : groups) {
    ATL_ASSERT(group.begin == covered && group.begin < group.end, group.begin, group.end, covered);
    covered = group.end;
    for (std::size_t island = group.begin; island < group.end; ++island) {
      ATL_ASSERT(modes.empty() || modes[island] == modes[group.begin], group.begin, island);
      ATL_ASSERT(substeps.empty() || substeps[island] == substeps[group.begin], group.begin, island);
    }
  }
  ATL_ASSERT(covered == islands, covered, islands);
}

}  // namespace

void SolvePhase::solve(Stores& world, const StepContext& step, const solver::AddedSlip* added_slips,
                       IslandPhase& islands, solver::FastBodies& moved) {
  solve_groups(world, step, added_slips, islands, moved);
  move_unconstrained_bodies(world, step, islands.islands().free_bodies(), moved);
}

// Returns true if some island's number of substeps changed, or there are other islands.
bool SolvePhase::choose_substeps(Stores& world, const StepContext& step, const IslandPhase& islands) {
  const auto chosen =
      world.control.choose(error_input(world, step, islands), error_target(world.settings.target), step.arena);
  bool changed = substeps_.size() != chosen.size();
  substeps_.resize(chosen.size());
  const int parts = parts_of_step(world, step);
  for (std::size_t island = 0; island < chosen.size(); ++island) {
    std::uint16_t substeps = chosen[island].substeps;
    if (parts > 1) substeps = static_cast<std::uint16_t>((substeps + parts - 1) / parts);
    changed |= substeps_[island] != substeps;
    substeps_[island] = substeps;
  }
  return changed;
}

void SolvePhase::choose_modes(Stores& world, const StepContext& step, IslandPhase& islands) {
  std::span<const SolveMode> modes;
  if (solves_directly && !world.active.in_order().empty()) world.selection.resize(world.bodies.size());
  if constexpr (solves_directly) {
    const solver::SolverSettings how = settings_now(world, step.substeps);
    const solver::LoadInput input = {.islands = islands.islands(),
                                     .bodies = world.bodies,
                                     .manifolds = world.cache.manifolds.data(),
                                     .contacts = world.cache.contacts.data(),
                                     .colliders = world.colliders,
                                     .gravity = world.gravity,
                                     .dt = world.clock.dt,
                                     .settings = how,
                                     .joint_graph = world.joints.count == 0 ? nullptr : &islands.joint_graph(),
                                     .joint_systems = &islands.joint_systems(),
                                     .refines = !world.settings.target.penetration,
                                     .estimates = world.clock.steps % solver::tuning::load_interval == 0};
    const bool all = world.settings.contact_solver == ContactSolver::Direct;
    modes = !selects_solvers(world.settings) ? world.selection.choose_untouched(input)
            : all                            ? world.selection.choose_direct(input)
                                             : world.selection.choose(input, step.arena);
  }
  bool changed = !std::equal(modes.begin(), modes.end(), modes_.begin(), modes_.end());
  if (world.settings.target.is_set()) {
    changed |= choose_substeps(world, step, islands);
  } else if (!substeps_.empty() || !world.control.is_empty()) {
    world.control.forget_all();
    world.results.missed_targets.clear();
    substeps_.clear();
    changed = true;
  }
  if (!changed && !islands.rebuilt()) return;
  modes_.assign(modes.begin(), modes.end());
  choose_group_keys(world, islands.islands());
  solver::pack_groups(islands.islands(), islands.one_each(), group_keys_, groups_);
  if constexpr (jobs::with_asserts) check_groups(groups_, islands.islands().count(), modes_, substeps_);
  // Which islands are large follows from the islands alone.
  regrouped_ |= islands.rebuilt();
}

// In a substep in which a swept joint bounces, its whole group is swept more often, so an island that has one is alone.
void SolvePhase::choose_group_keys(const Stores& world, const solver::Islands& islands) {
  group_keys_.assign(islands.count(), 0);
  std::copy(substeps_.begin(), substeps_.end(), group_keys_.begin());
  for (std::size_t island = 0; island < islands.count(); ++island) {
    const bool bounces = std::ranges::any_of(islands.joints(island, island + 1), [&](const solver::JointLink& link) {
      return world.joints.joints[link.joint].bounces;
    });
    if (bounces || (!modes_.empty() && modes_[island] != SolveMode::Sweep)) group_keys_[island] = solver::Islands::none;
  }
}

SolveMode SolvePhase::mode_of(const solver::IslandGroup& group) const {
  return modes_.empty() ? SolveMode::Sweep : modes_[group.begin];
}

int SolvePhase::substeps_of(const solver::IslandGroup& group, int asked) const {
  return substeps_.empty() ? asked : substeps_[group.begin];
}

void SolvePhase::choose_settings(const Stores& world, int asked) {
  settings_.clear();
  for (const solver::IslandGroup& group : groups_) {
    if (find_settings(group, asked) != nullptr) continue;
    const SolveMode mode = mode_of(group);
    const int substeps = substeps_of(group, asked);
    settings_.push_back({mode, substeps, settings_of(world, asked, substeps, mode)});
    if (modes_.empty() && substeps_.empty()) return;
  }
}

const SolvePhase::GroupSettings* SolvePhase::find_settings(const solver::IslandGroup& group, int asked) const {
  const SolveMode mode = mode_of(group);
  const int substeps = substeps_of(group, asked);
  const auto is_it = [&](const GroupSettings& one) { return one.mode == mode && one.substeps == substeps; };
  const auto found = std::find_if(settings_.begin(), settings_.end(), is_it);
  return found == settings_.end() ? nullptr : &*found;
}

namespace {

// Writes rolling and torsional friction of each contact, the larger of its two materials' values, and how friction
// depends on its direction.
void write_resistance(Stores& world, const solver::Islands& islands) {
  world.surface_contacts.resize(world.cache.manifolds.size());
  for (const solver::TouchingPair& pair : islands.contacts(0, islands.count())) {
    const collision::Contact& of = world.cache.contacts[pair.slot];
    const Material& a = material_of(world, of.pair.first, of.material);
    const Material& b = material_of(world, of.pair.second, of.material);
    solver::SurfaceContact& contact = world.surface_contacts[pair.slot];
    contact.rolling_friction = static_cast<float>(std::max(a.rolling_friction, b.rolling_friction));
    contact.torsional_friction = static_cast<float>(std::max(a.torsional_friction, b.torsional_friction));
    record_grip(world, of, a, b, world.cache.manifolds[pair.slot], contact);
  }
}

}  // namespace

void SolvePhase::solve_groups(Stores& world, const StepContext& step, const solver::AddedSlip* added_slips,
                              IslandPhase& islands, solver::FastBodies& moved) {
  choose_settings(world, step.substeps);
  const bool captures =
      world.settings.keep_contact_problem || world.settings.run_everything || measures_residual(world);
  if (captures) capture_.resize(world.cache.manifolds.size(), world.bodies.size());
  const bool tells_events = finds_contact_events(world.settings);
  pushed_.assign(tells_events ? world.cache.manifolds.size() : 0, solver::not_pushed);
  const bool surfaces =
      with_surfaces && (world.settings.run_everything || !world.bodies.surfaces.empty() || !world.cache.rises.empty() ||
                        added_slips != nullptr || !world.surface_contacts.empty());
  if (surfaces) write_resistance(world, islands.islands());
  const auto input_of = [&](const solver::IslandGroup& group) {
    return solver::SolveInput{.islands = islands.islands(),
                              .bodies = world.bodies,
                              .manifolds = world.cache.manifolds.data(),
                              .gravity = world.gravity,
                              .dt = world.clock.dt,
                              .settings = find_settings(group, step.substeps)->settings,
                              .kernels = step.kernels,
                              .bounds = world.aabbs.bounds,
                              .fast = moved,
                              .contacts = world.cache.contacts.data(),
                              .colliders = &world.colliders,
                              .capture = captures ? &capture_ : nullptr,
                              .pushed = tells_events ? pushed_.data() : nullptr,
                              .surface_contacts = surfaces ? world.surface_contacts.data() : nullptr,
                              .added_slips = added_slips,
                              .rises = world.cache.rises.empty() ? nullptr : world.cache.rises.data(),
                              .joints = world.joints.joints.data(),
                              .joint_graph = world.joints.count == 0 ? nullptr : &islands.joint_graph(),
                              .joint_systems = &islands.joint_systems()};
  };

  group_reports_.assign(groups_.size(), {});
  prepare_direct_solvers(islands.islands());
  step.arena.parallel_for(groups_.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t g = begin; g < end; ++g) {
      if (groups_[g].large) continue;
      const solver::SolveInput input = input_of(groups_[g]);
      if (solve_directly(input, g, world.settings.profile)) continue;
      group_reports_[g] = jobs::of_this_thread<solver::GroupSolver>().solve(input, groups_[g]);
    }
  });
  // Large ones are solved one after another, by all workers, and keep their colours while groups stay what they are.
  const auto colours = regrouped_ ? solver::GroupColours::New : solver::GroupColours::Kept;
  regrouped_ = false;
  std::size_t large = 0;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    if (!groups_[g].large) continue;
    if (large == large_solvers_.size()) large_solvers_.push_back(std::make_unique<solver::GroupSolver>());
    jobs::WorkerTeam team(step.arena);
    group_reports_[g] = large_solvers_[large++]->solve(input_of(groups_[g]), groups_[g], team, colours);
  }
  record_modes(world, islands.islands(), step.report.counts);
}

// One for each group of contacts that is to be solved at once, which keeps its order of elimination.
void SolvePhase::prepare_direct_solvers(const solver::Islands& islands) {
  if constexpr (!solves_directly) return;
  direct_.of_group.clear();
  direct_.reports.clear();
  std::size_t count = 0;
  for (std::size_t g = 0; g < groups_.size() && !modes_.empty(); ++g) {
    if (mode_of(groups_[g]) != SolveMode::Direct || islands.contact_count(groups_[g].begin) == 0) continue;
    ATL_ASSERT(groups_[g].end == groups_[g].begin + 1, g, groups_[g].begin, groups_[g].end);
    direct_.of_group.resize(groups_.size(), nullptr);
    if (count == direct_.solvers.size()) direct_.solvers.push_back(std::make_unique<solver::DirectIsland>());
    direct_.of_group[g] = direct_.solvers[count++].get();
  }
  direct_.solvers.resize(count);
  direct_.reports.resize(direct_.of_group.size());
}

bool SolvePhase::solve_directly(const solver::SolveInput& input, std::size_t group, bool profile) {
  if constexpr (!solves_directly) return false;
  if (mode_of(groups_[group]) != SolveMode::Direct) return false;
  const std::size_t place = groups_[group].begin;
  if (input.islands.contact_count(place) == 0) {
    const std::uint32_t joint = input.islands.joints(place, place + 1).front().joint;
    if (!input.joint_systems->of(input.joint_graph->component_of(joint)).solve(input)) return false;
    for (const std::uint32_t body : input.islands.bodies(place, place + 1)) {
      group_reports_[group].gyroscopic_bodies += input.bodies.gyroscopic[body];
    }
    return true;
  }
  ATL_ASSERT(group < direct_.of_group.size() && direct_.of_group[group] != nullptr, group, direct_.of_group.size());
  solver::DirectIsland& direct = *direct_.of_group[group];
  solver::DirectIslandReport& report = direct_.reports[group];
  const auto begin = jobs::Clock::now();
  if (direct.analyse(input, groups_[group])) {
    solver::PassiveEnergy& energy = jobs::of_this_thread<solver::PassiveEnergy>();
    energy.begin(input, groups_[group]);
    report = direct.solve(input);
    if (report.solved) energy.bound(input);
  } else {
    report.why_not = solver::DirectIsland::too_large;
  }
  if (profile) report.ms = jobs::ms_since(begin);
  if (!report.solved) return false;
  group_reports_[group].work = {.contacts = report.contacts,
                                .several_points = report.several_points,
                                .two_movable = report.two_movable,
                                .friction = report.friction};
  group_reports_[group].gyroscopic_bodies = report.gyroscopic_bodies;
  return true;
}

// Islands that were not swept as the settings say; those that could not be solved at once are swept for some time.
void SolvePhase::record_modes(Stores& world, const solver::Islands& islands, StepCounts& counts) {
  if constexpr (!solves_directly) return;
  failed_.clear();
  world.results.solver_choices.clear();
  const auto describe = [&](std::size_t island, const char* why) {
    const std::span<const std::uint32_t> members = islands.bodies(island, island + 1);
    return SolverChoice{.lowest = {members.front(), world.records.generation[members.front()]},
                        .bodies = members.size(),
                        .contacts = islands.contact_count(island),
                        .why = why};
  };
  const bool all = world.settings.contact_solver == ContactSolver::Direct;
  constexpr const char* asked_for = "the contact solver is to be direct";
  for (const auto& [place, why_not] : world.selection.refused()) {
    SolverChoice island = describe(place, asked_for);
    island.why_not = why_not;
    ++counts.refused_islands;
    world.results.solver_choices.push_back(island);
  }
  for (std::size_t g = 0; g < groups_.size() && !modes_.empty(); ++g) {
    const solver::IslandGroup& group = groups_[g];
    const SolveMode mode = mode_of(group);
    if (mode == SolveMode::Sweep) continue;
    if (islands.contact_count(group.begin) == 0) continue;
    SolverChoice island = describe(group.begin, all ? asked_for : world.selection.why(group.begin));
    const auto& phase_ms = group_reports_[g].phase_ms;
    island.ms = std::accumulate(phase_ms.begin(), phase_ms.end(), 0.0);
    if (mode == SolveMode::Direct) {
      const solver::DirectIslandReport& report = direct_.reports[g];
      const bool refused = report.why_not == solver::DirectIsland::too_large;
      const std::span<const std::uint32_t> members = islands.bodies(group.begin, group.end);
      island.direct = report.solved;
      island.gave_up = !report.solved && !refused;
      island.why_not = report.why_not;
      island.iterations = report.iterations;
      island.ms += report.ms;
      counts.unsolved_islands += island.gave_up;
      counts.refused_islands += refused;
      counts.discarded_iterations += report.solved ? 0 : report.iterations;
      if (!report.solved) failed_.insert(failed_.end(), members.begin(), members.end());
    }
    counts.direct_islands += island.direct;
    counts.refined_islands += mode != SolveMode::Direct;
    counts.newton_iterations += island.iterations;
    world.results.solver_choices.push_back(island);
  }
  if (selects_solvers(world.settings)) world.selection.record_failed(failed_, world.sleeping.awake, world.clock.dt);
}

namespace {

const char* why_missed(const solver::SubstepControl::Island& island, const ErrorTarget& target, TargetError error) {
  if (island.needed > island.substeps && island.substeps >= target.max_substeps) {
    return "it has the most substeps that it may get";
  }
  switch (error) {
    case TargetError::Penetration:
      return island.settles ? "its substeps have just changed, which takes a moment to show"
                            : "bodies overlapped as they met, and more substeps don't part them";
    case TargetError::JointGap:
      return island.settles ? "its substeps have just changed, which takes a moment to show"
                            : "no load holds its joints open, and more substeps don't close them";
    case TargetError::Residual:
      return "it gets more substeps, a few at a time";
    case TargetError::Motion:
      break;
  }
  return "its motion changed in this step, and it gets more substeps from the next one on";
}

}  // namespace

void SolvePhase::record_errors(Stores& world, const StepContext& step, std::span<const solver::TouchingPair> touching,
                               const IslandPhase& phase) {
  const solver::Islands& islands = phase.islands();
  std::vector<double> residuals;
  if (measures_residual(world)) {
    const double substep = world.clock.dt / step.substeps;
    residuals = island_residuals(contact_problem(world, touching, capture_, substep), islands);
  }
  world.control.note(error_input(world, step, phase), error_target(world.settings.target), residuals);
  StepCounts& counts = step.report.counts;
  const auto controlled = world.control.islands();
  ATL_ASSERT(controlled.size() == islands.count() && substeps_.size() == islands.count(), controlled.size(),
             substeps_.size(), islands.count());
  for (std::size_t i = 0; i < controlled.size(); ++i) {
    counts.max_substeps = std::max<std::int64_t>(counts.max_substeps, controlled[i].substeps);
    counts.island_bodies += static_cast<std::int64_t>(islands.body_count(i));
    counts.body_substeps += static_cast<std::int64_t>(islands.body_count(i) * substeps_[i]);
  }
  world.results.missed_targets.clear();
  std::uint32_t before = solver::Islands::none;
  for (const solver::SubstepControl::Miss& miss : world.control.misses()) {
    const std::span<const std::uint32_t> members = islands.bodies(miss.island, miss.island + 1);
    const auto error = static_cast<TargetError>(miss.error);
    world.results.missed_targets.push_back({.lowest = {members.front(), world.records.generation[members.front()]},
                                            .bodies = members.size(),
                                            .contacts = islands.contact_count(miss.island),
                                            .joints = islands.joint_count(miss.island),
                                            .error = error,
                                            .measured = miss.measured,
                                            .substeps = controlled[miss.island].substeps,
                                            .why = why_missed(controlled[miss.island], world.settings.target, error)});
    counts.missed_targets += miss.island != before;
    before = miss.island;
  }
}

}  // namespace atl
