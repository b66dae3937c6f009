#include <solver/select/joint_selection.h>
#include <solver/select/landing.h>
#include <solver/select/solver_selection.h>
#include <solver/tuning.h>

#include <algorithm>
#include <iterator>

namespace atl::solver {
namespace {

// What is solved at once is so without locks.
bool has_locks(const LoadInput& input, std::size_t island) {
  const std::span<const std::uint32_t> bodies = input.islands.bodies(island, island + 1);
  return std::any_of(bodies.begin(), bodies.end(), [&](std::uint32_t body) { return input.bodies.locks[body] != 0; });
}

// By body, each once.
void order(std::vector<Overload>& overloads) {
  std::sort(overloads.begin(), overloads.end(), [](const Overload& a, const Overload& b) {
    return a.body != b.body ? a.body < b.body : a.crushed > b.crushed;
  });
  const auto same = [](const Overload& a, const Overload& b) { return a.body == b.body; };
  overloads.erase(std::unique(overloads.begin(), overloads.end(), same), overloads.end());
}

}  // namespace

int finer_by(const SolverSettings& settings, double dt) {
  constexpr double rounding = 1 + 1e-9;
  int times = 1;
  while (dt / (settings.substeps * times) > rounding * tuning::finer_substep) times *= 2;
  return times;
}

void SolverSelection::resize(std::size_t bodies) { strain_.resize(bodies); }

void SolverSelection::forget(std::uint32_t body) {
  std::erase(arrived_, body);
  if (strain(body) == Strain{}) return;
  strain_[body] = {};
  strained_.erase(std::lower_bound(strained_.begin(), strained_.end(), body));
}

void SolverSelection::forget_all() {
  arrived_.clear();
  pressed_.clear();
  knows_pressed_ = false;
  for (const std::uint32_t body : strained_) strain_[body] = {};
  strained_.clear();
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
    estimate_.add_overloads(input, island, estimated_);
    order(estimated_);
    const auto bodies = static_cast<double>(input.islands.body_count(island));
    const bool sags = static_cast<double>(estimated_.size()) >= tuning::part_of_island * bodies;
    for (const Overload& overload : estimated_) {
      strain_[overload.body] = {tuning::most_strain, overload.crushed ? tuning::most_strain : 0, sags};
      strained_.push_back(overload.body);
    }
  }
  std::sort(strained_.begin(), strained_.end());
  strained_.erase(std::unique(strained_.begin(), strained_.end()), strained_.end());
}

std::span<const SolveMode> SolverSelection::choose(const LoadInput& input) {
  estimate_arrived(input);
  if (input.rebuilt || !knows_pressed_) find_pressed(input);
  find_landings(input);
  if (strained_.empty() && pressed_.empty() && landings_.empty()) return {};
  const Islands& islands = input.islands;
  symptoms_.assign(islands.count(), {});
  for (const std::uint32_t body : strained_) {
    const std::uint32_t island = islands.island_of(body);
    if (island == Islands::none) continue;
    symptoms_[island].lasts |= strain_[body].overloaded > tuning::lasting;
    // What is joined leaps at once.
    const float lasts = islands.joint_count(island) > 0 ? 0 : tuning::lasting;
    symptoms_[island].crushes |= strain_[body].crushed > lasts;
    symptoms_[island].sags |= strain_[body].sags;
  }
  modes_.assign(islands.count(), SolveMode::Sweep);
  for (const std::size_t island : pressed_) modes_[island] = SolveMode::Direct;
  for (const std::size_t island : landings_) {
    if (modes_[island] == SolveMode::Sweep) modes_[island] = SolveMode::Landing;
  }
  bool any = !pressed_.empty() || !landings_.empty();
  for (std::size_t island = 0; island < islands.count(); ++island) {
    const Symptoms& has = symptoms_[island];
    if (!(has.lasts || has.crushes) || modes_[island] == SolveMode::Direct) continue;
    const bool small = islands.body_count(island) <= tuning::most_bodies;
    const Build build = build_of(islands, island);
    if (build == Build::Columns || (has.crushes && small)) {
      modes_[island] = has_locks(input, island) ? SolveMode::Finer : SolveMode::Direct;
    } else if (has.lasts && has.sags && build == Build::Any) {
      modes_[island] = SolveMode::Finer;
    }
    const bool as_fine = finer_by(input.settings, input.dt) == 1;
    if (modes_[island] == SolveMode::Finer && as_fine) modes_[island] = SolveMode::Sweep;
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

// Where joints that are solved at once and contacts took turns over a light body between heavy ones, each would undo
// what the other did, and boxes leap off a bridge.
void SolverSelection::find_pressed(const LoadInput& input) {
  pressed_.clear();
  knows_pressed_ = true;
  if (input.joint_graph == nullptr || input.settings.joint_method == JointMethod::Iterative) return;
  const Islands& islands = input.islands;
  for (std::size_t island = 0; island < islands.count(); ++island) {
    if (islands.joint_count(island) == 0 || islands.contact_count(island) == 0) continue;
    if (islands.body_count(island) > tuning::most_bodies || !is_pressed(input, island)) continue;
    pressed_.push_back(island);
  }
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
  const Islands& islands = input.islands;
  symptoms_.assign(islands.count(), {});
  modes_.assign(islands.count(), SolveMode::Sweep);
  for (std::size_t island = 0; island < islands.count(); ++island) {
    const bool can = islands.contact_count(island) > 0 && islands.body_count(island) <= tuning::most_bodies &&
                     !has_locks(input, island);
    if (can) modes_[island] = SolveMode::Direct;
  }
  return modes_;
}

const char* SolverSelection::why(std::size_t island) const {
  const bool pressed = std::binary_search(pressed_.begin(), pressed_.end(), island);
  if (pressed) return "a body carries one many times as heavy, and there are joints";
  if (modes_[island] == SolveMode::Landing) return "something lands in it that leans on something else";
  if (symptoms_[island].crushes) return "a body carries many times what its contacts are made for";
  return modes_[island] == SolveMode::Finer ? "it sags under its own weight" : "columns give way under what they carry";
}

void SolverSelection::note(std::vector<Overload>& overloads, std::span<const std::uint32_t> failed,
                           std::span<const std::uint8_t> awake, double dt) {
  if (overloads.empty() && strained_.empty()) return;
  const auto step = static_cast<float>(dt);
  order(overloads);
  of_overloads_.clear();
  for (const Overload& overload : overloads) {
    of_overloads_.push_back(overload.body);
    const auto grow = [step](float& strain) { strain = std::min(tuning::most_strain, strain + step) + step; };
    grow(strain_[overload.body].overloaded);
    if (overload.crushed) grow(strain_[overload.body].crushed);
  }
  merged_.clear();
  std::set_union(strained_.begin(), strained_.end(), of_overloads_.begin(), of_overloads_.end(),
                 std::back_inserter(merged_));
  for (const std::uint32_t body : merged_) {
    if (!awake[body]) continue;
    // But for rounding.
    const auto wear_off = [step](float& strain) { strain = strain < 1.5f * step ? 0 : strain - step; };
    wear_off(strain_[body].overloaded);
    wear_off(strain_[body].crushed);
  }
  for (const std::uint32_t body : failed) strain_[body] = {};
  std::erase_if(merged_, [this](std::uint32_t body) {
    if (strain_[body].overloaded == 0) strain_[body] = {};
    return strain_[body] == Strain{};
  });
  strained_.swap(merged_);
}

}  // namespace atl::solver
