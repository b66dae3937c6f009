// What an island is to the direct solver, and what is done with its answers.

#include <solver/constraints/contact_inertia.h>
#include <solver/direct/direct_island.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

#include "constraints/loaded_contact.h"
#include "integrate/rows3.h"

namespace atl::solver {
namespace {

// Of the bound: at it, but for rounding to single precision.
constexpr double at_bound = 1 - 1e-6;

}  // namespace

bool DirectIsland::analyse(const DirectIslandInput& input, const IslandGroup& group) {
  const std::span<const std::uint32_t> bodies = input.islands.bodies(group.begin, group.end);
  const std::span<const TouchingPair> pairs = input.islands.contacts(group.begin, group.end);
  const std::span<const JointLink> links = input.islands.joints(group.begin, group.end);
  island_ = group.begin;
  first_rank_ = input.islands.first_rank(group.begin);
  const auto same_pair = [](const auto& a, const auto& b) { return a.first == b.first && a.second == b.second; };
  const auto same_bodies = [&](const auto& now, const auto& before) {
    return std::equal(now.begin(), now.end(), before.begin(), before.end(), same_pair);
  };
  const bool same = std::equal(bodies.begin(), bodies.end(), members_.begin(), members_.end()) &&
                    same_bodies(pairs, pairs_) && same_bodies(links, links_);
  pairs_.assign(pairs.begin(), pairs.end());  // slots may be others
  links_.assign(links.begin(), links.end());
  if (same) return fits_;
  members_.assign(bodies.begin(), bodies.end());
  if (bodies.size() > tuning::most_bodies) return fits_ = false;
  couplings_.clear();
  const auto couple = [&](const auto& pair) {
    const std::uint32_t first = local(input, pair.first);
    const std::uint32_t second = local(input, pair.second);
    if (first != no_body && second != no_body) couplings_.emplace_back(first, second);
  };
  for (const TouchingPair& pair : pairs_) couple(pair);
  for (const JointLink& link : links_) couple(link);
  return fits_ = search_.matrix.analyse(bodies.size(), couplings_);
}

std::uint32_t DirectIsland::local(const DirectIslandInput& input, std::uint32_t body) const {
  return input.bodies.mobility[body] == Mobility::Dynamic ? input.islands.rank(body) - first_rank_ : no_body;
}

DirectIslandReport DirectIsland::solve(const DirectIslandInput& input) {
  DirectIslandReport report;
  search_.iterations = 0;
  report.solved =
      load_bodies(input) && load_contacts(input) && (links_.empty() ? solve_step(input) : solve_substeps(input));
  report.iterations = search_.iterations;
  if (!report.solved) return report;
  note_work(input, report);
  note_overloads(input);
  return report;
}

// Contacts alone: the step as a whole.
bool DirectIsland::solve_step(const DirectIslandInput& input) {
  const SolverSettings& settings = input.settings;
  free_velocities(input, input.dt);
  lasting_ = problem_.velocity;
  if (!find_motions(settings, input.dt, 0)) return false;
  if (input.capture != nullptr) capture(input, input.dt);
  write_back_step(input);
  write_impulses(input, 1.0 / settings.substeps);
  return true;
}

// The velocities that bodies keep, and those that they move by in dt seconds.
bool DirectIsland::find_motions(const SolverSettings& settings, double dt, double from_outside) {
  const bool relaxes = settings.relax_iterations > 0;
  if (relaxes) {
    stop_contacts(dt);
  } else {
    push_contacts_apart(settings, dt);
  }
  if (!find_velocities(from_outside)) return false;
  if (relaxes) take_back_compliance(problem_, search_, dt);
  keep_velocities();
  pushes_ = relaxes && overlaps_notably(settings, dt);
  if (!pushes_) return true;
  push_contacts_apart(settings, dt);
  return solve_nearby(problem_, search_);
}

// Where Newton's method ends nowhere, an interior point method starts over, from the velocities that bodies came with.
bool DirectIsland::find_velocities(double from_outside) {
  if (!solve_by_newton(problem_, search_)) {
    problem_.velocity = lasting_;
    if (!solve_by_interior_point(problem_, search_)) return false;
  }
  return is_bounded(problem_, from_outside);
}

// Bodies keep the velocities that the impulses make.
void DirectIsland::keep_velocities() {
  velocities_of_impulses(problem_, search_.gradient, lasting_);
  for (DirectContact& contact : problem_.contacts) contact.lasting = contact.answer;
  for (DirectJoint& joint : problem_.joints) joint.lasting = joint.impulse;
}

bool DirectIsland::load_bodies(const DirectIslandInput& input) {
  const BodyTable& table = input.bodies;
  const double solved_time = links_.empty() ? input.dt : input.dt / input.settings.substeps;
  problem_.resize(members_.size());
  search_.resize(members_.size());
  problem_.joints.resize(links_.size());
  states_.resize(members_.size());
  for (std::size_t i = 0; i < members_.size(); ++i) {
    const std::uint32_t body = members_[i];
    const Vector3 spin = table.angular_velocity(body);
    State& state = states_[i];
    state.tumbles = table.gyroscopic[body] != 0;
    if (state.tumbles && !(solved_time * spin.norm() <= tuning::most_tumble)) return false;
    DirectBody& of = problem_.bodies[i];
    of.body = body;
    of.mass = 1 / table.inverse_mass[body];
    if (links_.empty() && is_seen_heavier(table, body)) {
      of.inertia = inertia_in_contact(table, body);
      of.inverse_inertia = inverse_inertia_in_contact(table, body);
    } else {
      const Matrix3 rotation = table.orientation(body).toRotationMatrix();
      of.inertia = rotation * table.inertia[body] * rotation.transpose();
      of.inverse_inertia = rotation * table.inverse_inertia[body] * rotation.transpose();
    }
    of.radius = std::sqrt(of.inertia.trace() / (3 * of.mass));
    state.position = state.start = table.position(body);
    state.turn = state.start_turn = table.orientation(body);
    state.body_inertia = table.inertia[body];
    state.acceleration = input.gravity * table.gravity_scale[body] + table.inverse_mass[body] * table.force(body);
  }
  load_velocities(input);
  return true;
}

// As sweeps would in their substeps.
void DirectIsland::free_velocities(const DirectIslandInput& input, double dt) {
  const BodyTable& table = input.bodies;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    const std::uint32_t body = members_[i];
    const DirectBody& of = problem_.bodies[i];
    const Vector3 spin = table.angular_velocity(body);
    const Vector3 turning = of.inverse_inertia * (table.torque(body) - spin.cross(of.inertia * spin));
    Eigen::Map<Vector3> velocity(&problem_.free[6 * i]);
    Eigen::Map<Vector3> angular(&problem_.free[6 * i + 3]);
    const double h = dt / input.settings.substeps;
    velocity = table.velocity(body);
    angular = spin;
    for (int k = 0; k < input.settings.substeps; ++k) {
      velocity = (velocity + h * states_[i].acceleration) / (1 + h * table.linear_damping[body]);
      angular = (angular + h * turning) / (1 + h * table.angular_damping[body]);
    }
  }
}

// Those of the start of the step.
void DirectIsland::load_velocities(const DirectIslandInput& input) {
  for (std::size_t i = 0; i < problem_.bodies.size(); ++i) {
    Eigen::Map<Vector3> velocity(&problem_.velocity[6 * i]);
    Eigen::Map<Vector3> angular(&problem_.velocity[6 * i + 3]);
    velocity = input.bodies.velocity(problem_.bodies[i].body);
    angular = input.bodies.angular_velocity(problem_.bodies[i].body);
  }
}

// Returns false if one bounces: that wants the impact's speed.
bool DirectIsland::load_contacts(const DirectIslandInput& input) {
  // Impulses are kept as those of a substep.
  const double share = links_.empty() ? input.settings.substeps : 1;
  problem_.contacts.resize(pairs_.size());
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    DirectContact& contact = problem_.contacts[c];
    load_contact(input, pairs_[c], share, contact);
    if (input.manifolds[contact.slot].restitution == 0) continue;
    const Six motion = contact.motion_at(problem_.velocity);
    for (int i = 0; i < contact.law.points; ++i) {
      if (contact.law.speed(i, motion) < -input.settings.restitution_threshold) return false;
    }
  }
  forget_factor(problem_);
  return true;
}

void DirectIsland::load_contact(const DirectIslandInput& input, const TouchingPair& pair, double share,
                                DirectContact& contact) const {
  const BodyTable& table = input.bodies;
  const collision::ContactManifold& manifold = input.manifolds[pair.slot];
  contact.slot = pair.slot;
  contact.first = local(input, pair.first);
  contact.second = local(input, pair.second);
  contact.friction = manifold.friction;
  contact.lever = manifold.lever;
  contact.rolling = contact.torsional = 0;
  place(input, pair, contact);

  const double inverse_mass = table.inverse_mass[pair.first] + table.inverse_mass[pair.second];
  const auto response = [&](const Vector3& first, const Vector3& second) {
    double sum = 0;
    if (contact.first != no_body) sum += first.dot(problem_.bodies[contact.first].inverse_inertia * first);
    if (contact.second != no_body) sum += second.dot(problem_.bodies[contact.second].inverse_inertia * second);
    return sum;
  };
  ContactLaw& law = contact.law;
  law.points = 0;
  for (int i = 0; i < collision::max_points; ++i) {
    if (manifold.separation[i] >= collision::no_point) continue;
    const int p = law.points++;
    const double x = law.x[p] = manifold.x[i];
    const double y = law.y[p] = manifold.y[i];
    // (arm + x t1 + y t2) x n, of which t1 x n = -t2 and t2 x n = t1
    const Vector3 offset = y * contact.axes[1] - x * contact.axes[2];
    const double k = inverse_mass + response(contact.arm_first.cross(contact.axes[0]) + offset,
                                             contact.arm_second.cross(contact.axes[0]) + offset);
    contact.mass[p] = 1 / k;
    contact.separation[p] = manifold.separation[i];
  }
  const auto along_tangent = [&](const Vector3& axis) {
    return inverse_mass + response(contact.arm_first.cross(axis), contact.arm_second.cross(axis));
  };
  const double along = 0.5 * (along_tangent(contact.axes[1]) + along_tangent(contact.axes[2]));
  const double twist = response(contact.axes[0], contact.axes[0]);
  law.friction_stiffness = 1 / (tuning::friction_compliance * along);
  law.twist_stiffness = twist > 0 ? 1 / (tuning::friction_compliance * twist) : 0;
  law.pyramid = input.settings.pyramid;
  law.slip = {0, 0};
  law.rolling_stiffness = 0;
  if (input.surface_contacts != nullptr) {
    SurfaceContact& surface = input.surface_contacts[pair.slot];
    note_surfaces_of(pair, table, manifold, input.added_slip(pair.slot), surface);
    const Vector3 slip = get3(surface.slip);
    law.slip = {slip.dot(contact.axes[1]), slip.dot(contact.axes[2])};
    contact.rolling = surface.rolling_friction;
    contact.torsional = surface.torsional_friction;
    const double rolls =
        0.5 * (response(contact.axes[1], contact.axes[1]) + response(contact.axes[2], contact.axes[2]));
    if (contact.rolling > 0 && rolls > 0) law.rolling_stiffness = 1 / (tuning::friction_compliance * rolls);
  }
  warm_start(input, share, contact);
}

void DirectIsland::place(const DirectIslandInput& input, const TouchingPair& pair, DirectContact& contact) const {
  const BodyTable& table = input.bodies;
  const collision::ContactManifold& manifold = input.manifolds[pair.slot];
  const collision::Tangents tangents = collision::tangents(manifold.normal);
  const Vector3 normal = get3(manifold.normal).normalized();
  const Vector3 nearly(tangents.first[0], tangents.first[1], tangents.first[2]);
  const Vector3 tangent = (nearly - normal.dot(nearly) * normal).normalized();
  contact.axes = {normal, tangent, normal.cross(tangent)};
  contact.given = {};
  const auto place_side = [&](std::uint32_t body, const float(&anchor)[3], Vector3& arm, double sign) {
    // A ball is touched on the line through its centre.
    arm = table.ball[body] ? Vector3(normal.dot(get3(anchor)) * normal) : get3(anchor);
    if (table.mobility[body] != Mobility::Kinematic) return;
    contact.add_motion(sign, arm, table.velocity(body), table.angular_velocity(body), contact.given);
  };
  place_side(pair.first, manifold.anchor_first, contact.arm_first, -1);
  place_side(pair.second, manifold.anchor_second, contact.arm_second, 1);
}

// The pieces that the last step's impulses were on.
void DirectIsland::warm_start(const DirectIslandInput& input, double share, DirectContact& contact) {
  const collision::ContactManifold& manifold = input.manifolds[contact.slot];
  ContactAnswer& answer = contact.answer;
  answer = {};
  int point = 0;
  for (int i = 0; i < collision::max_points; ++i) {
    if (manifold.separation[i] >= collision::no_point) continue;
    answer.normal[point] = share * manifold.normal_impulse[i];
    if (manifold.normal_impulse[i] > 0) answer.pieces.points |= static_cast<std::uint8_t>(1 << point);
    ++point;
  }
  const double load = answer.load();
  contact.bound_friction(load);
  const Vector3 friction = share * get3(manifold.friction_impulse);
  answer.friction = {friction.dot(contact.axes[1]), friction.dot(contact.axes[2])};
  answer.twist = share * manifold.twist_impulse;
  const auto is_bound = [](double impulse, double bound) { return std::abs(impulse) >= at_bound * bound; };
  if (contact.law.pyramid) {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const bool slides = is_bound(answer.friction[axis], contact.law.friction_bound);
      answer.pieces.slides |= static_cast<std::uint8_t>(slides ? 1 << axis : 0);
    }
  } else {
    answer.pieces.slides = is_bound(friction.norm(), contact.law.friction_bound) ? 3 : 0;
  }
  answer.pieces.spins = is_bound(answer.twist, contact.law.twist_bound);
  if (contact.law.rolling_stiffness > 0) {
    const Vector3 rolling = share * get3(input.surface_contacts[contact.slot].rolling_impulse);
    answer.rolling = {rolling.dot(contact.axes[1]), rolling.dot(contact.axes[2])};
    answer.pieces.rolls = is_bound(rolling.norm(), contact.law.rolling_bound);
  }
  if (load > 0) return;
  // It has just begun.
  for (int i = 0; i < contact.law.points; ++i) {
    if (contact.separation[i] <= 0) answer.pieces.points |= static_cast<std::uint8_t>(1 << i);
  }
}

// Contacts stop what closes them, and no more.
void DirectIsland::stop_contacts(double dt) {
  for (DirectContact& contact : problem_.contacts) {
    for (int i = 0; i < contact.law.points; ++i) {
      contact.law.stiffness[i] = contact.mass[i] / tuning::compliance;
      contact.law.bias[i] = std::max(contact.separation[i], 0.0) / dt;
    }
  }
}

// They part their overlap: as the springs that they are said to be, or as fast as sweeps would.
void DirectIsland::push_contacts_apart(const SolverSettings& settings, double dt) {
  // At the rate that sweeps have in a step of as many substeps.
  const double whole = links_.empty() ? dt : dt * settings.substeps;
  const bool soft = settings.contact_hertz > 0;
  struct Push {
    double rate;  // 1/s, of the overlap
    double held;  // of the mass
  };
  const auto push_from = [&](bool fixed) -> Push {
    if (!soft) return {SubstepConstants::parting_rate(settings, whole, fixed), 1 / tuning::compliance};
    const double hertz = fixed ? 2 * settings.contact_hertz : settings.contact_hertz;
    const Softness spring = Softness::of(hertz, settings.contact_damping_ratio, dt);
    return {spring.bias_rate, static_cast<double>(spring.mass_scale) / spring.impulse_scale};
  };
  const Push from_fixed = push_from(true);
  const Push from_dynamic = push_from(false);
  for (DirectContact& contact : problem_.contacts) {
    const Push& push = contact.fixed() ? from_fixed : from_dynamic;
    for (int i = 0; i < contact.law.points; ++i) {
      const double separation = contact.separation[i];
      const bool apart = separation > 0;
      contact.law.stiffness[i] = contact.mass[i] * (apart ? 1 / tuning::compliance : push.held);
      contact.law.bias[i] = apart ? separation / dt : std::max(push.rate * separation, -settings.contact_push_speed);
    }
    if (soft) contact.factored.points = 0xff;
  }
}

// Whether there is anything to part.
bool DirectIsland::overlaps_notably(const SolverSettings& settings, double dt) const {
  const double whole = links_.empty() ? dt : dt * settings.substeps;
  const bool soft = settings.contact_hertz > 0;
  const double from_fixed = SubstepConstants::parting_rate(settings, whole, true);
  const double from_dynamic = SubstepConstants::parting_rate(settings, whole, false);
  for (const DirectContact& contact : problem_.contacts) {
    const double rate = contact.fixed() ? from_fixed : from_dynamic;
    for (int i = 0; i < contact.law.points; ++i) {
      const double parts = rate * -contact.separation[i] * dt;
      if (parts > tuning::least_parting || (soft && contact.lasting.normal[i] > 0)) return true;
    }
  }
  return false;
}

void DirectIsland::write_back_step(const DirectIslandInput& input) {
  BodyTable& table = input.bodies;
  for (std::size_t i = 0; i < problem_.bodies.size(); ++i) {
    const std::uint32_t body = problem_.bodies[i].body;
    const BodyPose start{table.position(body), table.orientation(body)};
    const Vector3 velocity = Eigen::Map<const Vector3>(&lasting_[6 * i]);
    const Vector3 spin = Eigen::Map<const Vector3>(&lasting_[6 * i + 3]);
    const Vector3 gained = velocity - table.velocity(body);
    const Vector3 gained_spin = spin - table.angular_velocity(body);
    Vector3 moves = Eigen::Map<const Vector3>(&problem_.velocity[6 * i]);
    Vector3 turns = Eigen::Map<const Vector3>(&problem_.velocity[6 * i + 3]);
    if (changes_steadily(gained, gained_spin, states_[i].acceleration, input.dt, table.radius[body])) {
      moves -= 0.5 * gained;
      turns -= 0.5 * gained_spin;
    }
    table.velocity(body) = velocity;
    table.angular_velocity(body) = spin;
    table.position(body) += input.dt * moves;
    const Vector3 half = 0.5 * input.dt * turns;
    table.set_orientation(body, (Quaternion(1, half.x(), half.y(), half.z()) * start.orientation).normalized());
    note_motion(table, input.bounds, body, start, input.dt, input.fast.local());
  }
}

// `share`: of the impulses that were solved for, those of a substep.
void DirectIsland::write_impulses(const DirectIslandInput& input, double share) const {
  for (const DirectContact& contact : problem_.contacts) {
    collision::ContactManifold& manifold = input.manifolds[contact.slot];
    int point = 0;
    for (int i = 0; i < collision::max_points; ++i) {
      const bool there = manifold.separation[i] < collision::no_point;
      manifold.normal_impulse[i] = there ? static_cast<float>(share * contact.lasting.normal[point++]) : 0;
    }
    set3(manifold.friction_impulse, share * contact.in_plane(contact.lasting.friction));
    manifold.twist_impulse = static_cast<float>(share * contact.lasting.twist);
    if (input.surface_contacts == nullptr) continue;
    set3(input.surface_contacts[contact.slot].rolling_impulse, share * contact.in_plane(contact.lasting.rolling));
  }
}

// What was solved, of so many seconds.
void DirectIsland::capture(const DirectIslandInput& input, double step) const {
  for (const DirectContact& contact : problem_.contacts) {
    const collision::ContactManifold& manifold = input.manifolds[contact.slot];
    ContactCapture::Answer& answer = input.capture->answers[contact.slot];
    answer.planar = false;
    answer.step = step;
    int point = 0;
    for (std::size_t i = 0; i < collision::max_points; ++i) {
      answer.separation[i] = manifold.separation[i];
      const bool there = manifold.separation[i] < collision::no_point;
      answer.normal_impulse[i] = there ? static_cast<float>(contact.lasting.normal[point++]) : 0;
    }
    const Vector3 friction = contact.in_plane(contact.lasting.friction);
    const Vector3 rolling = contact.in_plane(contact.lasting.rolling);
    for (int k = 0; k < 3; ++k) {
      answer.anchor_first[k] = static_cast<float>(contact.arm_first[k]);
      answer.anchor_second[k] = static_cast<float>(contact.arm_second[k]);
      answer.friction_impulse[k] = static_cast<float>(friction[k]);
      answer.rolling_impulse[k] = static_cast<float>(rolling[k]);
    }
    answer.twist_impulse = static_cast<float>(contact.lasting.twist);
  }
  for (std::size_t i = 0; i < problem_.bodies.size(); ++i) {
    ContactCapture::Motion& motion = input.capture->motions[problem_.bodies[i].body];
    motion.free_velocity = Eigen::Map<const Vector3>(&problem_.free[6 * i]);
    motion.free_angular_velocity = Eigen::Map<const Vector3>(&problem_.free[6 * i + 3]);
    motion.inverse_inertia = problem_.bodies[i].inverse_inertia;
  }
}

// By the measure of soft contacts, so that the island is solved at once for as long as these would give way.
void DirectIsland::note_overloads(const DirectIslandInput& input) const {
  const Build build = build_of(input.islands, island_);
  const double give = SubstepConstants::give_by_impulse(input.settings, input.dt);
  for (const TouchingPair& pair : pairs_) {
    const LoadedContact contact = loaded_contact(input.bodies, input.manifolds, pair);
    note_overload(contact, give * load_of(contact.manifold), build, input.overloads.local());
  }
}

void DirectIsland::note_work(const DirectIslandInput& input, DirectIslandReport& report) const {
  for (const DirectContact& contact : problem_.contacts) {
    ++report.contacts;
    report.several_points += input.manifolds[contact.slot].separation[1] < collision::no_point;
    report.two_movable += contact.first != no_body && contact.second != no_body;
    report.friction += contact.friction > 0;
  }
  for (const std::uint32_t body : members_) report.gyroscopic_bodies += input.bodies.gyroscopic[body];
}

}  // namespace atl::solver
