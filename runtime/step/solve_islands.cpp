// The step's solve: which islands are solved how, and who solves them.

#include <jobs/stopwatch.h>
#include <jobs/with_direct_contacts.h>
#include <jobs/with_surfaces.h>
#include <jobs/worker_team.h>
#include <solver/integrate/free_flight.h>
#include <solver/tuning.h>

#include <algorithm>
#include <numeric>

#include "world/settings_check.h"
#include "world/world_impl.h"

namespace atl {
namespace {

using solver::SolveMode;

}  // namespace

void World::Impl::solve_islands() {
  solve_groups();
  move_unconstrained_bodies();
}

solver::SolverSettings World::Impl::how() const {
  solver::SolverSettings how = solver_settings(settings);
  how.substeps = substeps_;
  if (!settings.restitution_threshold) {
    how.restitution_threshold = solver::tuning::least_bounce * gravity.norm() * dt_ / substeps_;
  }
  return how;
}

bool World::Impl::escalates() const {
  return with_direct_contacts && settings.stabilisation == Stabilisation::Soft &&
         settings.contact_solver != ContactSolver::Iterative;
}

// Islands whose contacts carry too much are solved on their own, and otherwise.
void World::Impl::choose_modes() {
  std::span<const SolveMode> modes;
  if (with_direct_contacts && !active_.in_order().empty()) selection_.resize(bodies.size());
  if (with_direct_contacts && escalates()) {
    const solver::SolverSettings how = this->how();
    const solver::LoadInput input = {.islands = islands_,
                                     .bodies = bodies,
                                     .manifolds = cache.manifolds.data(),
                                     .gravity = gravity,
                                     .dt = dt_,
                                     .settings = how,
                                     .joint_graph = joints.count == 0 ? nullptr : &joint_graph_,
                                     .joint_systems = &joint_systems_,
                                     .rebuilt = islands_rebuilt_};
    const bool all = settings.contact_solver == ContactSolver::Direct;
    modes = all ? selection_.choose_direct(input) : selection_.choose(input);
  } else if (with_direct_contacts) {
    selection_.forget_all();
  } else {
    selection_.forget_arrived();
  }
  const bool changed = !std::equal(modes.begin(), modes.end(), modes_.begin(), modes_.end());
  if (!changed && !islands_rebuilt_) return;
  modes_.assign(modes.begin(), modes.end());
  alone_.resize(modes_.size());
  std::transform(modes_.begin(), modes_.end(), alone_.begin(),
                 [](SolveMode mode) -> std::uint8_t { return mode != SolveMode::Sweep; });
  solver::pack_groups(islands_, one_each_, alone_, groups_);
  // Which islands are large follows from the islands alone.
  regrouped_ |= islands_rebuilt_;
}

SolveMode World::Impl::mode_of(const solver::IslandGroup& group) const {
  return modes_.empty() ? SolveMode::Sweep : modes_[group.begin];
}

void World::Impl::solve_groups() {
  const solver::SolverSettings how = this->how();
  solver::SolverSettings how_finer = how;
  how_finer.finer = solver::finer_by(how, dt_);
  how_finer.substeps *= how_finer.finer;
  solver::SolverSettings how_landing = how;
  how_landing.finer = solver::tuning::landing_finer;
  how_landing.contact_hertz = solver::SubstepConstants::contact_hertz(how, dt_ / how.substeps);
  how_landing.substeps *= how_landing.finer;
  const bool captures = settings.keep_contact_problem || settings.run_everything;
  if (captures) capture_.resize(cache.manifolds.size(), bodies.size());
  const bool surfaces = with_surfaces && (settings.run_everything || !bodies.surfaces.empty() || !cache.rises.empty());
  if (surfaces) surface_contacts_.resize(cache.manifolds.size());
  const auto input_with = [&](const solver::SolverSettings& with) {
    return solver::SolveInput{.islands = islands_,
                              .bodies = bodies,
                              .manifolds = cache.manifolds.data(),
                              .gravity = gravity,
                              .dt = dt_,
                              .settings = with,
                              .kernels = *kernels,
                              .bounds = aabbs.bounds,
                              .fast = fast_,
                              .overloads = overloads_,
                              .capture = captures ? &capture_ : nullptr,
                              .surface_contacts = surfaces ? surface_contacts_.data() : nullptr,
                              .rises = cache.rises.empty() ? nullptr : cache.rises.data(),
                              .joints = joints.joints.data(),
                              .joint_graph = joints.count == 0 ? nullptr : &joint_graph_,
                              .joint_systems = &joint_systems_};
  };
  const solver::SolveInput plain = input_with(how);
  const solver::SolveInput fine = input_with(how_finer);
  const solver::SolveInput landing = input_with(how_landing);
  const auto input_of = [&](const solver::IslandGroup& group) -> const solver::SolveInput& {
    const SolveMode mode = mode_of(group);
    return mode == SolveMode::Finer ? fine : mode == SolveMode::Landing ? landing : plain;
  };

  group_reports_.assign(groups_.size(), {});
  prepare_direct_solvers();
  arena.parallel_for(groups_.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t g = begin; g < end; ++g) {
      if (groups_[g].large || solve_directly(plain, g)) continue;
      group_reports_[g] = group_solvers_.local().solve(input_of(groups_[g]), groups_[g]);
    }
  });
  // Large ones are solved one after another, by all workers, and keep their colours while groups stay what they are.
  const auto contacts = regrouped_ ? solver::GroupContacts::New : solver::GroupContacts::Kept;
  regrouped_ = false;
  std::size_t large = 0;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    if (!groups_[g].large) continue;
    if (large == large_solvers_.size()) large_solvers_.push_back(std::make_unique<solver::GroupSolver>());
    jobs::WorkerTeam team(arena);
    group_reports_[g] = large_solvers_[large++]->solve(input_of(groups_[g]), groups_[g], team, contacts);
  }
  note_modes();
}

// One for each group that is to be solved at once, which keeps its order of elimination.
void World::Impl::prepare_direct_solvers() {
  if constexpr (!with_direct_contacts) return;
  direct_of_group_.clear();
  direct_reports_.clear();
  if (modes_.empty()) return;
  std::size_t count = 0;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    if (mode_of(groups_[g]) != SolveMode::Direct) continue;
    direct_of_group_.resize(groups_.size(), nullptr);
    if (count == direct_solvers_.size()) direct_solvers_.push_back(std::make_unique<solver::DirectIsland>());
    direct_of_group_[g] = direct_solvers_[count++].get();
  }
  direct_reports_.resize(direct_of_group_.size());
}

bool World::Impl::solve_directly(const solver::SolveInput& input, std::size_t group) {
  if constexpr (!with_direct_contacts) return false;
  if (direct_of_group_.empty() || direct_of_group_[group] == nullptr) return false;
  solver::DirectIsland& direct = *direct_of_group_[group];
  solver::DirectIslandReport& report = direct_reports_[group];
  const auto begin = jobs::Clock::now();
  if (direct.analyse(input, groups_[group])) report = direct.solve(input);
  if (settings.profile) report.ms = jobs::ms_since(begin);
  if (!report.solved) return false;
  group_reports_[group].work = report.work;
  group_reports_[group].gyroscopic_bodies = report.gyroscopic_bodies;
  return true;
}

// What is overloaded now, and what could not be solved at once, which decide on the next step's modes.
void World::Impl::note_modes() {
  if constexpr (!with_direct_contacts) return;
  all_overloads_.clear();
  overloads_.for_each([this](std::vector<solver::Overload>& of_worker) {
    all_overloads_.insert(all_overloads_.end(), of_worker.begin(), of_worker.end());
    of_worker.clear();
  });
  failed_.clear();
  escalated_.clear();
  for (std::size_t g = 0; g < groups_.size() && !modes_.empty(); ++g) {
    const solver::IslandGroup& group = groups_[g];
    const SolveMode mode = mode_of(group);
    if (mode == SolveMode::Sweep) continue;
    const std::span<const std::uint32_t> members = islands_.bodies(group.begin, group.end);
    EscalatedIsland island{.lowest = {members.front(), records.generation[members.front()]},
                           .bodies = members.size(),
                           .contacts = islands_.contact_count(group.begin),
                           .why = selection_.why(group.begin)};
    const auto& stage_ms = group_reports_[g].stage_ms;
    island.ms = std::accumulate(stage_ms.begin(), stage_ms.end(), 0.0);
    if (mode == SolveMode::Direct) {
      const solver::DirectIslandReport& report = direct_reports_[g];
      island.direct = report.solved;
      island.gave_up = !report.solved;
      island.iterations = report.iterations;
      island.ms += report.ms;
      if (!report.solved) failed_.insert(failed_.end(), members.begin(), members.end());
    }
    ++(island.direct ? report_.counts.direct_islands : report_.counts.finer_islands);
    report_.counts.newton_iterations += island.iterations;
    escalated_.push_back(island);
  }
  if (escalates()) selection_.note(all_overloads_, failed_, sleeping.awake, dt_);
}

void World::Impl::move_unconstrained_bodies() {
  constexpr std::size_t grain = 256;
  const std::span<const std::uint32_t> free = islands_.free_bodies();
  arena.parallel_for(free.size(), grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      solver::move_free_body(bodies, free[i], gravity, dt_, substeps_, aabbs.bounds, fast_);
    }
  });
  if (contents.kinematic == 0 && !settings.run_everything) return;
  for (const std::uint32_t body : active_.in_order()) {
    if (bodies.mobility[body] == solver::Mobility::Kinematic)
      solver::move_kinematic_body(bodies, body, dt_, aabbs.bounds, fast_);
  }
}

}  // namespace atl
