#include <solver/direct_contacts.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "loaded_contact.h"

namespace atl::solver {
namespace {

// Newton's method takes 0 to 4 iterations at rest. Where it would take more, points come and go one by one, and the
// interior point method gets there in 10 to 25.
constexpr int most_iterations = 6;

// Iterations in which friction's bound follows the load. With more it would go to and fro for long: each halves the
// difference at best.
constexpr int following = 2;

// m/s: where parting overlaps makes bodies faster than this, it is taken out of their velocities again.
constexpr double noticeable_push = 0.05;

}  // namespace

DirectContactsReport DirectContacts::solve(const SolveInput& input) {
  DirectContactsReport report;
  if (!load_bodies(input) || !load_contacts(input)) return report;
  if (!find_velocities(input, report)) return report;
  moving_ = velocity_;
  if (pushes_apart()) {
    leave_out_pushes();
    if (!find_velocities(input, report)) return report;
  }
  report.solved = true;
  note_work(input, report);
  if (input.capture != nullptr) capture(input);
  write_back(input);
  note_overloads(input);
  return report;
}

void DirectContacts::note_work(const SolveInput& input, DirectContactsReport& report) const {
  for (const Contact& contact : contacts_) {
    ++report.work.contacts;
    report.work.several_points += input.manifolds[contact.slot].separation[1] < collision::no_point;
    report.work.two_movable += contact.first != none && contact.second != none;
    report.work.friction += contact.friction > 0;
  }
  for (const std::uint32_t body : members_) report.gyroscopic_bodies += input.bodies.gyroscopic[body];
}

bool DirectContacts::find_velocities(const SolveInput& input, DirectContactsReport& report) {
  if (!solve_on_last_pieces()) return false;
  if (minimise(report)) return true;
  load_velocities(input);
  return follow_interior(report);
}

// The velocities if all contacts stay on the pieces that they are on.
bool DirectContacts::solve_on_last_pieces() {
  balance([](const Contact& contact) {
    return contact.law.linear_answer(contact.motion, contact.answer.pieces, contact.answer);
  });
  if (!factor()) return false;
  find_direction();
  for (std::size_t i = 0; i < velocity_.size(); ++i) velocity_[i] += direction_[i];
  follow_load(1);
  return true;
}

bool DirectContacts::minimise(DirectContactsReport& report) {
  for (int iteration = 0;; ++iteration) {
    balance([](const Contact& contact) { return contact.law.answer(contact.motion); });
    const double residual = unbalanced();
    if (residual <= tolerance) return true;
    if (iteration == most_iterations || !std::isfinite(residual)) return false;
    ++report.iterations;
    if (!is_factored() && !factor()) return false;
    find_direction();
    mass_times(direction_, product_);
    mass_slope_ = mass_curvature_ = 0;
    for (std::size_t i = 0; i < direction_.size(); ++i) {
      mass_slope_ += (velocity_[i] - free_[i]) * product_[i];
      mass_curvature_ += direction_[i] * product_[i];
    }
    const double t = step_length();
    for (std::size_t i = 0; i < velocity_.size(); ++i) velocity_[i] += t * direction_[i];
    if (iteration < following) follow_load(t);
  }
}

// Down the gradient, by the factor that there is.
void DirectContacts::find_direction() {
  for (std::size_t i = 0; i < gradient_.size(); ++i) direction_[i] = -gradient_[i];
  system_.solve(direction_);
  for (Contact& contact : contacts_) contact.change = motion_of(contact, direction_);
}

// The largest part of a body's velocity that the impulses on it don't account for.
double DirectContacts::unbalanced() const {
  double most = 0;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Eigen::Map<const Vector3> linear(&gradient_[6 * i]);
    const Eigen::Map<const Vector3> angular(&gradient_[6 * i + 3]);
    const double off =
        linear.norm() / bodies_[i].mass + bodies_[i].radius * (bodies_[i].inverse_inertia * angular).norm();
    if (!(off <= most)) most = off;  // also where it is no number
  }
  return most;
}

// The bound of friction becomes that of the load a way along the search direction.
void DirectContacts::follow_load(double t) {
  for (Contact& contact : contacts_) {
    contact.bound_friction(contact.law.answer(contact.motion_after(t)).load());
  }
}

// Of the function along the search direction.
double DirectContacts::slope(double t) const {
  double sum = mass_slope_ + t * mass_curvature_;
  for (const Contact& contact : contacts_) {
    const Six impulse = contact.law.total(contact.law.answer(contact.motion_after(t)));
    for (int k = 0; k < 6; ++k) sum -= impulse[k] * contact.change[k];
  }
  return sum;
}

// Where the slope vanishes, or all the way if it doesn't before. Regula falsi that halves what it keeps (Dowell and
// Jarratt, "A modified regula falsi method for computing the root of an equation", BIT 1971).
double DirectContacts::step_length() const {
  constexpr double flat = 1e-3;  // of the slope at the start
  constexpr int rounds = 30;
  double low = 0;
  double high = 1;
  double slope_low = slope(0);
  double slope_high = slope(1);
  const double enough = flat * std::abs(slope_low);
  if (!(slope_low < 0) || !(slope_high > enough)) return 1;
  double t = 1;
  int kept = 0;  // how often the lower end was, if negative the upper
  for (int round = 0; round < rounds; ++round) {
    t = low + (high - low) * slope_low / (slope_low - slope_high);
    const double here = slope(t);
    if (std::abs(here) <= enough) break;
    if (here < 0) {
      low = t;
      slope_low = here;
      kept = std::min(kept, 0) - 1;
      if (kept < -1) slope_high *= 0.5;
    } else {
      high = t;
      slope_high = here;
      kept = std::max(kept, 0) + 1;
      if (kept > 1) slope_low *= 0.5;
    }
  }
  return t;
}

bool DirectContacts::pushes_apart() const {
  return std::any_of(contacts_.begin(), contacts_.end(), [](const Contact& contact) {
    for (int i = 0; i < contact.law.points; ++i) {
      if (contact.law.bias[i] < 0 && contact.law.speed(i, contact.motion) > noticeable_push) return true;
    }
    return false;
  });
}

// Points that overlap hold what they hold, and stop instead of parting.
void DirectContacts::leave_out_pushes() {
  for (Contact& contact : contacts_) {
    for (int i = 0; i < contact.law.points; ++i) {
      double& bias = contact.law.bias[i];
      if (bias < 0) bias = -contact.answer.normal[i] / contact.law.stiffness[i];
    }
  }
}

// Velocities are those that the impulses make, so that no momentum is made up.
void DirectContacts::write_back(const SolveInput& input) {
  BodyTable& table = input.bodies;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Body& of = bodies_[i];
    const std::uint32_t body = of.body;
    const BodyPose start{table.position(body), table.orientation(body)};
    const Vector3 velocity =
        Eigen::Map<const Vector3>(&velocity_[6 * i]) - Eigen::Map<const Vector3>(&gradient_[6 * i]) / of.mass;
    const Vector3 spin = Eigen::Map<const Vector3>(&velocity_[6 * i + 3]) -
                         of.inverse_inertia * Eigen::Map<const Vector3>(&gradient_[6 * i + 3]);
    const Vector3 gained = velocity - table.velocity(body);
    const Vector3 gained_spin = spin - table.angular_velocity(body);
    Vector3 moves = Eigen::Map<const Vector3>(&moving_[6 * i]);
    Vector3 turns = Eigen::Map<const Vector3>(&moving_[6 * i + 3]);
    if (changes_steadily(gained, gained_spin, of.acceleration, input.dt, table.radius[body])) {
      moves -= 0.5 * gained;
      turns -= 0.5 * gained_spin;
    }
    table.velocity(body) = velocity;
    table.angular_velocity(body) = spin;
    table.position(body) += input.dt * moves;
    const Vector3 half = 0.5 * input.dt * turns;
    table.set_orientation(body, (Quaternion(1, half.x(), half.y(), half.z()) * start.orientation).normalized());
    note_motion(table, body, start, input.dt, input.fast);
  }
  const double share = 1.0 / input.settings.substeps;  // impulses are kept as those of a substep
  for (const Contact& contact : contacts_) {
    collision::ContactManifold& manifold = input.manifolds[contact.slot];
    int point = 0;
    for (int i = 0; i < collision::max_points; ++i) {
      const bool there = manifold.separation[i] < collision::no_point;
      manifold.normal_impulse[i] = there ? static_cast<float>(share * contact.answer.normal[point++]) : 0;
    }
    const Vector3 friction = share * contact.friction_impulse();
    for (int k = 0; k < 3; ++k) manifold.friction_impulse[k] = static_cast<float>(friction[k]);
    manifold.twist_impulse = static_cast<float>(share * contact.answer.twist);
  }
}

// What was solved is the whole step.
void DirectContacts::capture(const SolveInput& input) const {
  for (const Contact& contact : contacts_) {
    const collision::ContactManifold& manifold = input.manifolds[contact.slot];
    ContactCapture::Answer& answer = input.capture->answers[contact.slot];
    answer.planar = false;
    answer.step = input.dt;
    int point = 0;
    for (std::size_t i = 0; i < collision::max_points; ++i) {
      answer.separation[i] = manifold.separation[i];
      const bool there = manifold.separation[i] < collision::no_point;
      answer.normal_impulse[i] = there ? static_cast<float>(contact.answer.normal[point++]) : 0;
    }
    const Vector3 friction = contact.friction_impulse();
    for (int k = 0; k < 3; ++k) answer.friction_impulse[k] = static_cast<float>(friction[k]);
    answer.twist_impulse = static_cast<float>(contact.answer.twist);
    answer.rolling_impulse = {0, 0, 0};
  }
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    ContactCapture::Motion& motion = input.capture->motions[bodies_[i].body];
    motion.free_velocity = Eigen::Map<const Vector3>(&free_[6 * i]);
    motion.free_angular_velocity = Eigen::Map<const Vector3>(&free_[6 * i + 3]);
    motion.inverse_inertia = bodies_[i].inverse_inertia;
  }
}

// By the measure of soft contacts, so that the island is solved at once for as long as these would give way.
void DirectContacts::note_overloads(const SolveInput& input) const {
  const Build build = build_of(input.islands, island_);
  const double give = SubstepConstants::give_by_impulse(input.settings, input.dt, build);
  for (const TouchingPair& pair : pairs_) {
    const LoadedContact contact = loaded_contact(input.bodies, input.manifolds, pair);
    note_overload(contact, give * load_of(contact.manifold), build, input.overloads.local());
  }
}

}  // namespace atl::solver
