#include <jobs/assert.h>
#include <jobs/scratch.h>
#include <solver/constraints/contact_arm.h>
#include <solver/constraints/surface_contact.h>
#include <solver/select/joint_selection.h>
#include <solver/select/solver_selection.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

#include "integrate/rows3.h"

namespace atl::solver {
namespace {

constexpr std::size_t load_grain = 16;  // islands a task

// Islands with locks and contacts are not solved at once: contacts know nothing of locks there, as joints do.
bool has_locks(const LoadInput& input, std::size_t island) {
  const std::span<const std::uint32_t> bodies = input.islands.bodies(island, island + 1);
  return std::any_of(bodies.begin(), bodies.end(), [&](std::uint32_t body) { return input.bodies.locks[body] != 0; });
}

bool may_be_direct(const LoadInput& input, std::size_t island) {
  return input.islands.body_count(island) <= tuning::max_bodies && !has_locks(input, island);
}

// The mode by the present loads of an island.
SolveMode estimated_mode(const LoadInput& input, std::size_t island) {
  const Build build = build_of(input.islands, island);
  const bool direct = may_be_direct(input, island);
  const bool refines = input.refines && build != Build::Joined && refinement_of(input.settings, input.dt) > 1;
  if (!direct && !refines) return SolveMode::Sweep;
  const LoadEstimate::Overload found = jobs::of_this_thread<LoadEstimate>().of(input, island, build);
  if (found.bodies == 0) return SolveMode::Sweep;
  if (direct && (build == Build::Columns || found.deep)) return SolveMode::Direct;
  const double part = tuning::part_of_island * static_cast<double>(input.islands.body_count(island));
  return refines && static_cast<double>(found.bodies) >= part ? SolveMode::Refined : SolveMode::Sweep;
}

bool is_fast(const BodyTable& bodies, std::uint32_t body, double min) {
  const double spin = bodies.radius[body] * bodies.radius[body] * bodies.angular_velocity(body).squaredNorm();
  return bodies.velocity(body).squaredNorm() + spin > min * min;
}

// True if a body that is alone on its island leans on one thing and lands on another in this step: a block that rocks
// from edge to edge, a ball that rolls into a wall.
//
// A new contact stops the body for the whole substep in which it is reached, and the old contact lets go for the whole
// of it. So a landing has an error of the weight's impulse in a substep: first order, while all else is second order.
bool lands(const LoadInput& input, std::size_t island) {
  const Islands& islands = input.islands;
  const BodyTable& bodies = input.bodies;
  // Slower landings don't count.
  const double gained = input.gravity.norm() * input.dt;
  if (!(gained > 0) || !is_fast(bodies, islands.bodies(island, island + 1).front(), gained)) return false;

  bool leans = false, reaches = false;
  for (const TouchingPair& pair : islands.contacts(island, island + 1)) {
    const collision::ContactManifold& manifold = input.manifolds[pair.slot];
    const Vector3 normal = get3(manifold.normal);
    const collision::Tangents tangents = collision::tangents(manifold.normal);
    for (std::size_t i = 0; i < collision::max_points; ++i) {
      leans |= manifold.normal_impulse[i] > 0;
      const double gap = manifold.separation[i];
      if (reaches || manifold.normal_impulse[i] > 0 || gap <= 0 || gap >= collision::no_point) continue;
      const Vector3 off = manifold.x[i] * get3(tangents.first) + manifold.y[i] * get3(tangents.second);
      const Vector3 first = bodies.velocity_at(pair.first, get3(manifold.anchor_first) + off);
      const Vector3 second = bodies.velocity_at(pair.second, get3(manifold.anchor_second) + off);
      const double closing = normal.dot(first - second);
      reaches = closing > gained && gap < (closing + gained) * input.dt;
    }
  }
  return leans && reaches;
}

// Tells contacts that carried something, and those that touch and won't bounce, as where a body has just been put.
bool leans_on(const collision::ContactManifold& manifold) {
  if (has_impulse(manifold)) return true;
  if (manifold.restitution > 0) return false;
  const auto& gaps = manifold.separation;
  return std::any_of(std::begin(gaps), std::end(gaps), [](double gap) { return gap <= tuning::min_overlap; });
}

// m/s^2: by how much a contact's place on a body changes its velocity as the body turns.
double change_by_turning(const LoadInput& input, std::uint32_t body, std::uint32_t collider, const Vector3& anchor,
                         const Vector3& outward) {
  if (!turns_in_step(input.bodies, body, input.dt)) return 0;
  const ContactArm arm = contact_arm(input.bodies, body, input.colliders, collider, anchor, outward);
  const Vector3 spin = input.bodies.angular_velocity(body);
  return spin.cross(turned_arm(arm, input.dt * spin, -outward) - (arm.pivot + arm.rim)).norm() / input.dt;
}

// True if a body that is alone on its island leans on something, and either turns so that their contact comes to move
// otherwise: a coin that rolls in a circle, a top, a box on a turntable. Solved at once, contacts follow such turns to
// second order. A ball or a wheel that rolls straight on is touched where it was.
bool turns(const LoadInput& input, std::size_t island) {
  constexpr double small = 1e-3;  // part of gravity: a box that slides down a slope is swept
  if (has_locks(input, island)) return false;
  const std::span<const TouchingPair> contacts = input.islands.contacts(island, island + 1);
  return std::any_of(contacts.begin(), contacts.end(), [&](const TouchingPair& pair) {
    const collision::ContactManifold& manifold = input.manifolds[pair.slot];
    if (!leans_on(manifold)) return false;
    const collision::Pair colliders = input.contacts[pair.slot].pair;
    const Vector3 normal = get3(manifold.normal).normalized();
    const double change =
        change_by_turning(input, pair.first, colliders.first, get3(manifold.anchor_first), normal) +
        change_by_turning(input, pair.second, colliders.second, get3(manifold.anchor_second), -normal);
    return change > small * input.gravity.norm();
  });
}

}  // namespace

int refinement_of(const SolverSettings& settings, double dt) {
  ATL_ASSERT(settings.substeps >= 1 && std::isfinite(dt), settings.substeps, dt);
  constexpr double rounding = 1 + 1e-9;
  int times = 1;
  while (dt / (settings.substeps * times) > rounding * tuning::refined_substep) times *= 2;
  return times;
}

void SolverSelection::resize(std::size_t bodies) { findings_.resize(bodies); }

void SolverSelection::forget(std::uint32_t body) {
  if (body < findings_.size()) findings_[body] = {};
  jobs::erase(failed_, body);
}

void SolverSelection::forget_all() {
  std::fill(findings_.begin(), findings_.end(), Finding{});
  failed_.clear();
}

void SolverSelection::restore(std::uint32_t body, const Finding& finding) {
  if (body >= findings_.size()) resize(body + std::size_t{1});
  findings_[body] = finding;
  if (finding.swept > 0) failed_.push_back(body);
}

std::span<const SolveMode> SolverSelection::choose(const LoadInput& input, jobs::Arena& arena) {
  refused_.clear();
  find_joined(input, true);
  find_motions(input);
  const Islands& islands = input.islands;
  start_modes(islands);
  arena.parallel_for(islands.count(), load_grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t island = begin; island < end; ++island) {
      if (modes_[island] == SolveMode::Sweep) modes_[island] = mode_by_load(input, island);
    }
  });
  for (const std::size_t island : landings_) {
    if (modes_[island] == SolveMode::Sweep) modes_[island] = SolveMode::Landing;
  }
  for (const std::size_t island : turning_) {
    if (modes_[island] == SolveMode::Sweep) modes_[island] = SolveMode::Direct;
  }
  const bool any = std::any_of(modes_.begin(), modes_.end(), [](SolveMode mode) { return mode != SolveMode::Sweep; });
  return any ? std::span<const SolveMode>(modes_) : std::span<const SolveMode>();
}

// An island that could not be solved at once is swept for some time. Others are estimated at once where bodies have
// joined or left them, and else keep their mode. A body that is alone may
// land, tip and part within a few steps, and costs little: it is estimated in each.
SolveMode SolverSelection::mode_by_load(const LoadInput& input, std::size_t island) {
  if (input.islands.contact_count(island) == 0) return SolveMode::Sweep;
  const std::span<const std::uint32_t> bodies = input.islands.bodies(island, island + 1);
  const auto count = static_cast<std::uint32_t>(bodies.size());
  ATL_ASSERT(bodies.back() < findings_.size(), island, bodies.back(), findings_.size());
  const auto is_swept = [&](std::uint32_t body) { return findings_[body].swept > 0; };
  if (std::any_of(bodies.begin(), bodies.end(), is_swept)) return SolveMode::Sweep;
  const SolveMode before = findings_[bodies.front()].mode;
  const auto is_same = [&](std::uint32_t body) {
    return findings_[body].mode == before && findings_[body].bodies == count;
  };
  const bool same = count > 1 && std::all_of(bodies.begin(), bodies.end(), is_same);
  if (same && !input.estimates && (before != SolveMode::Direct || may_be_direct(input, island))) return before;
  const SolveMode mode = estimated_mode(input, island);
  for (const std::uint32_t body : bodies) {
    findings_[body].mode = mode;
    findings_[body].bodies = count;
  }
  return mode;
}

// Finds what a body alone on its island does in this step.
void SolverSelection::find_motions(const LoadInput& input) {
  landings_.clear();
  turning_.clear();
  for (std::size_t island = 0; island < input.islands.count(); ++island) {
    if (input.islands.body_count(island) > 1 || input.islands.contact_count(island) == 0) continue;
    if (lands(input, island)) landings_.push_back(island);
    const std::uint32_t body = input.islands.bodies(island, island + 1).front();
    if (findings_[body].swept == 0 && turns(input, island)) turning_.push_back(island);
  }
}

// Finds islands of joints alone that are solved at once. With `touched`, also islands in which joints and contacts
// would undo each other's work by taking turns: on a light body between heavy ones, boxes leap off a bridge.
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
    if (!touched || !may_be_direct(input, island)) continue;
    if (is_machine(input, island) || is_pushed_on(input, island)) joined_.push_back(island);
  }
}

// Sets all islands to be swept, except those of joined bodies with a finding.
void SolverSelection::start_modes(const Islands& islands) {
  modes_.assign(islands.count(), SolveMode::Sweep);
  for (const std::size_t island : joined_) modes_[island] = SolveMode::Direct;
}

// Forgets what loads have told, which nobody asks for now.
void SolverSelection::begin_without_loads(const LoadInput& input) {
  forget_all();
  landings_.clear();
  turning_.clear();
  refused_.clear();
  find_joined(input, false);
  start_modes(input.islands);
}

std::span<const SolveMode> SolverSelection::choose_untouched(const LoadInput& input) {
  begin_without_loads(input);
  return joined_.empty() ? std::span<const SolveMode>() : std::span<const SolveMode>(modes_);
}

// An island counts as a machine's if no more bodies than those of actuated components are in it: a robot that stands, a
// hand and what it holds. In one system with its joints its contacts come to rest, which taking turns with them keeps
// robots from; and a grip carries the force of its servos, which contacts know nothing of that are swept.
bool SolverSelection::is_machine(const LoadInput& input, std::size_t island) {
  is_on_system_.assign(input.islands.body_count(island), 0);
  for (const JointLink& link : input.islands.joints(island, island + 1)) {
    if (!input.joint_systems->is_machine(input.joint_graph->component_of(link.joint))) continue;
    for (const std::uint32_t body : {link.first, link.second}) {
      if (input.bodies.mobility[body] != Mobility::Dynamic) continue;
      is_on_system_[input.islands.rank(body) - input.islands.first_rank(island)] = 1;
    }
  }
  const auto of_machines = std::count(is_on_system_.begin(), is_on_system_.end(), 1);
  return 2 * static_cast<std::size_t>(of_machines) >= is_on_system_.size();
}

bool SolverSelection::is_pushed_on(const LoadInput& input, std::size_t island) {
  const Islands& islands = input.islands;
  const std::uint32_t first_rank = islands.first_rank(island);
  const auto is_dynamic = [&](std::uint32_t body) { return input.bodies.mobility[body] == Mobility::Dynamic; };
  is_on_system_.assign(islands.body_count(island), 0);
  // Only anchored components count: they can't give way to a load, as limbs can.
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
      if (is_dynamic(body)) is_on_system_[islands.rank(body) - first_rank] = 1;
    }
  }
  const auto carries = [&](std::uint32_t body, std::uint32_t other) {
    const bool light = input.bodies.inverse_mass[body] > tuning::light_ratio * input.bodies.inverse_mass[other];
    return light && is_on_system_[islands.rank(body) - first_rank] != 0;
  };
  const std::span<const TouchingPair> contacts = islands.contacts(island, island + 1);
  return std::any_of(contacts.begin(), contacts.end(), [&](const TouchingPair& pair) {
    if (!is_dynamic(pair.first) || !is_dynamic(pair.second)) return false;
    return carries(pair.first, pair.second) || carries(pair.second, pair.first);
  });
}

std::span<const SolveMode> SolverSelection::choose_direct(const LoadInput& input) {
  begin_without_loads(input);
  const Islands& islands = input.islands;
  for (std::size_t island = 0; island < islands.count(); ++island) {
    if (islands.contact_count(island) == 0) continue;
    if (islands.body_count(island) > tuning::max_bodies) {
      refused_.push_back({island, "it has too many bodies"});
    } else if (has_locks(input, island)) {
      refused_.push_back({island, "motions of its bodies are locked"});
    } else {
      modes_[island] = SolveMode::Direct;
    }
  }
  return modes_;
}

bool SolverSelection::is_joined(std::size_t island) const {
  return std::binary_search(joined_.begin(), joined_.end(), island);
}

const char* SolverSelection::why(std::size_t island) const {
  ATL_ASSERT(island < modes_.size(), island, modes_.size());
  if (is_joined(island)) return "joints that are solved at once and contacts push on each other";
  switch (modes_[island]) {
    case SolveMode::Landing:
      return "something lands in it that leans on something else";
    case SolveMode::Refined:
      return "it sags under its own weight";
    default:
      if (std::binary_search(turning_.begin(), turning_.end(), island)) return "it turns on what it leans on";
      return "contacts give way under what they carry";
  }
}

void SolverSelection::record_failed(std::span<const std::uint32_t> failed, std::span<const std::uint8_t> awake,
                                    double dt) {
  const auto step = static_cast<float>(dt);
  for (const std::uint32_t body : failed_) {
    float& left = findings_[body].swept;
    ATL_ASSERT(left > 0, body, left);
    if (awake[body]) left = left < 1.5f * step ? 0 : left - step;  // but for rounding
  }
  for (const std::uint32_t body : failed) findings_[body].swept = tuning::failed_time;
  failed_.insert(failed_.end(), failed.begin(), failed.end());
  std::sort(failed_.begin(), failed_.end());
  failed_.erase(std::unique(failed_.begin(), failed_.end()), failed_.end());
  jobs::erase_if(failed_, [this](std::uint32_t body) { return findings_[body].swept == 0; });
}

}  // namespace atl::solver
