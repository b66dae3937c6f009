#include <solver/select/joint_selection.h>
#include <solver/select/landing.h>
#include <solver/select/solver_selection.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace atl::solver {
namespace {

// What is solved at once is so without locks.
bool has_locks(const LoadInput& input, std::size_t island) {
  const std::span<const std::uint32_t> bodies = input.islands.bodies(island, island + 1);
  return std::any_of(bodies.begin(), bodies.end(), [&](std::uint32_t body) { return input.bodies.locks[body] != 0; });
}

// By body, each once.
void order(std::vector<OverloadedBody>& overloaded) {
  std::sort(overloaded.begin(), overloaded.end(), [](const OverloadedBody& a, const OverloadedBody& b) {
    return a.body != b.body ? a.body < b.body : a.deep > b.deep;
  });
  const auto same = [](const OverloadedBody& a, const OverloadedBody& b) { return a.body == b.body; };
  overloaded.erase(std::unique(overloaded.begin(), overloaded.end(), same), overloaded.end());
}

}  // namespace

int refinement_of(const SolverSettings& settings, double dt) {
  constexpr double rounding = 1 + 1e-9;
  int times = 1;
  while (dt / (settings.substeps * times) > rounding * tuning::refined_substep) times *= 2;
  return times;
}

void SolverSelection::resize(std::size_t bodies) { load_history_.resize(bodies); }

void SolverSelection::forget(std::uint32_t body) {
  std::erase(arrived_, body);
  if (load_history(body) == LoadHistory{}) return;
  load_history_[body] = {};
  loaded_.erase(std::lower_bound(loaded_.begin(), loaded_.end(), body));
}

void SolverSelection::forget_all() {
  arrived_.clear();
  joined_.clear();
  for (const std::uint32_t body : loaded_) load_history_[body] = {};
  loaded_.clear();
}

// What new bodies stand on and under, as if it had been for long: it takes a wall some time to settle on its load.
void SolverSelection::estimate_arrived(const LoadInput& input) {
  if (arrived_.empty()) return;
  std::vector<std::uint32_t> islands;
  for (const std::uint32_t body : arrived_) islands.push_back(input.islands.island_of(body));
  arrived_.clear();
  std::sort(islands.begin(), islands.end());
  islands.erase(std::unique(islands.begin(), islands.end()), islands.end());
  for (const std::uint32_t island : islands) {
    if (island == Islands::none) continue;
    estimated_.clear();
    estimate_.add_overloaded(input, island, estimated_);
    order(estimated_);
    const auto bodies = static_cast<double>(input.islands.body_count(island));
    const bool sags = static_cast<double>(estimated_.size()) >= tuning::part_of_island * bodies;
    for (const OverloadedBody& one : estimated_) {
      load_history_[one.body] = {tuning::most_load_time, one.deep ? tuning::most_load_time : 0, sags};
      loaded_.push_back(one.body);
    }
  }
  std::sort(loaded_.begin(), loaded_.end());
  loaded_.erase(std::unique(loaded_.begin(), loaded_.end()), loaded_.end());
}

std::span<const SolveMode> SolverSelection::choose(const LoadInput& input) {
  refused_.clear();
  estimate_arrived(input);
  find_joined(input, true);
  find_landings(input);
  if (loaded_.empty() && joined_.empty() && landings_.empty()) return {};
  const Islands& islands = input.islands;
  start_modes(islands);
  for (const std::uint32_t body : loaded_) {
    const std::uint32_t island = islands.island_of(body);
    if (island == Islands::none) continue;
    symptoms_[island].failed |= load_history_[body].overloaded < 0;
    symptoms_[island].lasts |= load_history_[body].overloaded > tuning::lasting;
    // What is joined leaps at once.
    const float lasts = islands.joint_count(island) > 0 ? 0 : tuning::lasting;
    symptoms_[island].deep |= load_history_[body].deep > lasts;
    symptoms_[island].sags |= load_history_[body].sags;
  }
  for (const std::size_t island : landings_) {
    if (modes_[island] == SolveMode::Sweep) modes_[island] = SolveMode::Landing;
  }
  bool any = !joined_.empty() || !landings_.empty();
  for (std::size_t island = 0; island < islands.count(); ++island) {
    const Symptoms& has = symptoms_[island];
    if (!(has.lasts || has.deep) || has.failed || modes_[island] == SolveMode::Direct) continue;
    if (islands.contact_count(island) == 0) continue;  // what touched its joints has let go
    const bool small = islands.body_count(island) <= tuning::most_bodies;
    const Build build = build_of(islands, island);
    const bool at_once = build == Build::Columns || (has.deep && small);
    if (at_once && !has_locks(input, island)) {
      modes_[island] = SolveMode::Direct;
    } else if (has.lasts && has.sags && build != Build::Joined) {
      modes_[island] = SolveMode::Refined;
    }
    const bool as_fine = !input.refines || refinement_of(input.settings, input.dt) == 1;
    if (modes_[island] == SolveMode::Refined && as_fine) modes_[island] = SolveMode::Sweep;
    any |= modes_[island] != SolveMode::Sweep;
  }
  return any ? std::span<const SolveMode>(modes_) : std::span<const SolveMode>();
}

void SolverSelection::find_landings(const LoadInput& input) {
  landings_.clear();
  for (std::size_t island = 0; island < input.islands.count(); ++island) {
    if (lands(input, island)) landings_.push_back(island);
  }
}

// Islands of joints alone that are solved at once. Of `touched` ones those in which these and contacts would undo what
// the other did if they took turns: over a light body between heavy ones boxes leap off a bridge.
void SolverSelection::find_joined(const LoadInput& input, bool touched) {
  joined_.clear();
  if (input.joint_graph == nullptr || input.settings.joint_method == JointMethod::Iterative) return;
  const Islands& islands = input.islands;
  for (std::size_t island = 0; island < islands.count(); ++island) {
    if (islands.joint_count(island) == 0) continue;
    const std::uint32_t joint = islands.joints(island, island + 1).front().joint;
    if (islands.contact_count(island) == 0) {
      if (input.joint_systems->is_direct(input.joint_graph->component_of(joint))) joined_.push_back(island);
      continue;
    }
    if (!touched || islands.body_count(island) > tuning::most_bodies || has_locks(input, island)) continue;
    if (is_machine(input, island) || is_pressed(input, island)) joined_.push_back(island);
  }
}

// All islands are swept, but for those of joined bodies that were found.
void SolverSelection::start_modes(const Islands& islands) {
  symptoms_.assign(islands.count(), {});
  modes_.assign(islands.count(), SolveMode::Sweep);
  for (const std::size_t island : joined_) modes_[island] = SolveMode::Direct;
}

std::span<const SolveMode> SolverSelection::choose_untouched(const LoadInput& input) {
  forget_all();
  landings_.clear();
  refused_.clear();
  find_joined(input, false);
  if (joined_.empty()) return {};
  start_modes(input.islands);
  return modes_;
}

// An island is a machine if its bodies are those of one actuated component: it touches only itself and what can't move.
// In one system with its joints its contacts come to rest, which taking turns with them keeps robots from.
bool SolverSelection::is_machine(const LoadInput& input, std::size_t island) {
  const std::span<const JointLink> joints = input.islands.joints(island, island + 1);
  const std::uint32_t component = input.joint_graph->component_of(joints.front().joint);
  if (!input.joint_systems->is_machine(component)) return false;
  on_system_.assign(input.islands.body_count(island), 0);
  for (const JointLink& link : joints) {
    if (input.joint_graph->component_of(link.joint) != component) return false;
    for (const std::uint32_t body : {link.first, link.second}) {
      if (input.bodies.mobility[body] != Mobility::Dynamic) continue;
      on_system_[input.islands.rank(body) - input.islands.first_rank(island)] = 1;
    }
  }
  return std::find(on_system_.begin(), on_system_.end(), 0) == on_system_.end();
}

bool SolverSelection::is_pressed(const LoadInput& input, std::size_t island) {
  const Islands& islands = input.islands;
  const std::uint32_t first_rank = islands.first_rank(island);
  const auto is_dynamic = [&](std::uint32_t body) { return input.bodies.mobility[body] == Mobility::Dynamic; };
  on_system_.assign(islands.body_count(island), 0);
  // What is anchored can't give way, as limbs can.
  std::uint32_t component = JointGraph::none;
  bool needs = false;
  for (const JointLink& link : islands.joints(island, island + 1)) {
    if (const std::uint32_t of_link = input.joint_graph->component_of(link.joint); of_link != component) {
      component = of_link;
      const std::span<const JointLink> links = input.joint_graph->links_of(component);
      needs = input.joint_systems->is_direct(component) &&
              std::any_of(links.begin(), links.end(), [&](const JointLink& of_component) {
                return !is_dynamic(of_component.first) || !is_dynamic(of_component.second);
              });
    }
    if (!needs) continue;
    for (const std::uint32_t body : {link.first, link.second}) {
      if (is_dynamic(body)) on_system_[islands.rank(body) - first_rank] = 1;
    }
  }
  const auto carries = [&](std::uint32_t body, std::uint32_t other) {
    const bool light = input.bodies.inverse_mass[body] > tuning::light_ratio * input.bodies.inverse_mass[other];
    return light && on_system_[islands.rank(body) - first_rank] != 0;
  };
  const std::span<const TouchingPair> contacts = islands.contacts(island, island + 1);
  return std::any_of(contacts.begin(), contacts.end(), [&](const TouchingPair& pair) {
    if (!is_dynamic(pair.first) || !is_dynamic(pair.second)) return false;
    return carries(pair.first, pair.second) || carries(pair.second, pair.first);
  });
}

std::span<const SolveMode> SolverSelection::choose_direct(const LoadInput& input) {
  forget_all();
  landings_.clear();
  refused_.clear();
  find_joined(input, false);
  const Islands& islands = input.islands;
  start_modes(islands);
  for (std::size_t island = 0; island < islands.count(); ++island) {
    if (islands.contact_count(island) == 0) continue;
    if (islands.body_count(island) > tuning::most_bodies) {
      refused_.push_back({island, "it has too many bodies"});
    } else if (has_locks(input, island)) {
      refused_.push_back({island, "motions of its bodies are locked"});
    } else {
      modes_[island] = SolveMode::Direct;
    }
  }
  return modes_;
}

const char* SolverSelection::why(std::size_t island) const {
  const bool joined = std::binary_search(joined_.begin(), joined_.end(), island);
  if (joined) return "joints that are solved at once and contacts push on each other";
  if (modes_[island] == SolveMode::Landing) return "something lands in it that leans on something else";
  if (symptoms_[island].deep) return "a body carries many times what its contacts are made for";
  return modes_[island] == SolveMode::Refined ? "it sags under its own weight"
                                              : "columns give way under what they carry";
}

void SolverSelection::note(std::vector<OverloadedBody>& overloaded, std::vector<std::uint32_t>& failed,
                           std::span<const std::uint8_t> awake, double dt) {
  if (overloaded.empty() && loaded_.empty() && failed.empty()) return;
  const auto step = static_cast<float>(dt);
  order(overloaded);
  overloaded_now_.clear();
  std::sort(failed.begin(), failed.end());
  for (const std::uint32_t body : failed) load_history_[body] = {.overloaded = -tuning::failed_time - step};
  for (const OverloadedBody& one : overloaded) {
    if (load_history_[one.body].overloaded < 0) continue;
    overloaded_now_.push_back(one.body);
    const auto grow = [step](float& time) { time = std::min(tuning::most_load_time, time + step) + step; };
    grow(load_history_[one.body].overloaded);
    if (one.deep) grow(load_history_[one.body].deep);
  }
  merged_.clear();
  std::set_union(loaded_.begin(), loaded_.end(), overloaded_now_.begin(), overloaded_now_.end(),
                 std::back_inserter(merged_));
  overloaded_now_.clear();
  std::set_union(merged_.begin(), merged_.end(), failed.begin(), failed.end(), std::back_inserter(overloaded_now_));
  merged_.swap(overloaded_now_);
  for (const std::uint32_t body : merged_) {
    if (!awake[body]) continue;
    // But for rounding.
    const auto wear_off = [step](float& time) {
      time = std::abs(time) < 1.5f * step ? 0 : time - std::copysign(step, time);
    };
    wear_off(load_history_[body].overloaded);
    wear_off(load_history_[body].deep);
  }
  std::erase_if(merged_, [this](std::uint32_t body) {
    if (load_history_[body].overloaded == 0) load_history_[body] = {};
    return load_history_[body] == LoadHistory{};
  });
  loaded_.swap(merged_);
}

}  // namespace atl::solver
