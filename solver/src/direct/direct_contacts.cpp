#include <solver/direct/direct_contacts.h>

#include <algorithm>
#include <cmath>

#include "constraints/loaded_contact.h"
#include "integrate/rows3.h"

namespace atl::solver {
namespace {

// Newton's method takes 0 to 4 iterations at rest. Where it would take more, points come and go one by one, and the
// interior point method gets there in 10 to 25.
constexpr int most_iterations = 6;

// How often friction's bound is then brought up to the load that it went with.
constexpr int friction_rounds = 8;

// m/s: what friction makes of velocities may be off by so much, as its bound is not that of the load.
constexpr double friction_tolerance = 1e-3;

// Of what would stop all bodies of the island at once and hold their weights: a contact that pushes harder is wedged
// between others so that nothing tells how hard.
constexpr double most_impulse = 10;

// m/s: slower than this the top of a column may sink.
constexpr double least_sinking = 5e-7;
// With a million times its weight on it, a box sinks by a tenth of what it did in each.
constexpr int most_give_rounds = 8;

// m: what a step parts of overlaps has to be more than this, or nothing is done about them.
constexpr double least_parting = 1e-7;

}  // namespace

DirectContactsReport DirectContacts::solve(const SolveInput& input) {
  DirectContactsReport report;
  if (!load_bodies(input) || !load_contacts(input)) return report;
  const bool relaxes = input.settings.relax_iterations > 0;
  if (relaxes) {
    stop_contacts(input);
  } else {
    push_contacts_apart(input);
  }
  if (!find_velocities(input, report) || !is_bounded()) return report;
  if (relaxes) take_back_give(input);
  keep_velocities();
  if (relaxes && overlaps_notably(input)) {
    push_contacts_apart(input);
    if (!minimise(report, 0)) return report;
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
  if (minimise(report, following) && settle_friction(report)) return true;
  load_velocities(input);
  return follow_interior(report) && settle_friction(report);
}

// Friction's bound was given, and is not quite that of the load which came of it.
bool DirectContacts::settle_friction(DirectContactsReport& report) {
  for (int round = 0; friction_off() > friction_tolerance; ++round) {
    if (round == friction_rounds) return false;
    for (Contact& contact : contacts_) contact.bound_friction(contact.answer.load());
    if (!minimise(report, 0)) return false;
  }
  return true;
}

// m/s: how much too fast or slow friction makes something, by its bounds.
double DirectContacts::friction_off() const {
  double most = 0;
  for (const Contact& contact : contacts_) {
    const ContactAnswer& answer = contact.answer;
    // What is not at its bound asks for this load at least.
    double asks = answer.load();
    const auto ask = [&](double impulse, double of_load) {
      if (of_load > 0) asks = std::max(asks, std::abs(impulse) / of_load);
    };
    if (answer.pieces.slides || answer.pieces.spins || answer.pieces.rolls) asks = contact.bound_load;
    const double pull = contact.law.pyramid ? std::max(std::abs(answer.friction[0]), std::abs(answer.friction[1]))
                                            : std::hypot(answer.friction[0], answer.friction[1]);
    ask(pull, contact.friction);
    ask(answer.twist, contact.lever * contact.friction + contact.torsional);
    ask(std::hypot(answer.rolling[0], answer.rolling[1]), contact.rolling);
    const double off = std::abs(asks - answer.load());
    const auto of = [&](std::uint32_t body) {
      if (body == none) return 0.0;
      const double spin =
          (contact.lever * contact.friction + contact.torsional + contact.rolling) / bodies_[body].radius;
      return off * std::max(contact.friction, spin) / bodies_[body].mass;
    };
    most = std::max({most, of(contact.first), of(contact.second)});
  }
  return most;
}

// Opposite contacts that overlap can't both open, and may push each other as hard as they like.
bool DirectContacts::is_bounded() const {
  double all = 0;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Eigen::Map<const Vector3> velocity(&free_[6 * i]);
    const Eigen::Map<const Vector3> spin(&free_[6 * i + 3]);
    all += bodies_[i].mass * (velocity.norm() + bodies_[i].radius * spin.norm());
  }
  for (const Contact& contact : contacts_) {
    const double moved = std::hypot(contact.given[0], contact.given[3], contact.given[4]);
    if (contact.first != none) all += bodies_[contact.first].mass * moved;
    if (contact.second != none) all += bodies_[contact.second].mass * moved;
  }
  return std::all_of(contacts_.begin(), contacts_.end(),
                     [&](const Contact& contact) { return contact.answer.load() <= most_impulse * all; });
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

bool DirectContacts::minimise(DirectContactsReport& report, int follows) {
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
    if (iteration < follows) follow_load(t);
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

// Contacts are so stiff that they give by little under what they carry, but a column of many, or under many times its
// weight, would sink on them: once more, from where they carry it already.
void DirectContacts::take_back_give(const SolveInput& input) {
  if (!is_factored()) return;
  const auto answer_on_its_pieces = [](Contact& contact) {
    contact.answer = contact.law.linear_answer(contact.motion, contact.answer.pieces, contact.answer);
  };
  for (int round = 0; round < most_give_rounds; ++round) {
    double sinks = 0;
    for (Contact& contact : contacts_) {
      double most = 0;
      for (int i = 0; i < contact.law.points; ++i) {
        if (!(contact.answer.pieces.points & (1 << i))) continue;
        const double closest = std::max(contact.separation[i], 0.0) / input.dt;
        most = std::max(most, -contact.law.speed(i, contact.motion) - closest);
        contact.law.bias[i] = closest - contact.answer.normal[i] / contact.law.stiffness[i];
      }
      sinks += most;
    }
    if (sinks < least_sinking) return;
    for (Contact& contact : contacts_) {
      Six more = contact.law.total(contact.answer);
      for (double& impulse : more) impulse = -impulse;
      answer_on_its_pieces(contact);
      const Six total = contact.law.total(contact.answer);
      for (int k = 0; k < 6; ++k) more[k] += total[k];
      add_impulse(contact, more, -1, gradient_);
    }
    find_direction();
    for (std::size_t i = 0; i < velocity_.size(); ++i) velocity_[i] += direction_[i];
    for (Contact& contact : contacts_) {
      contact.motion = contact.motion_after(1);
      answer_on_its_pieces(contact);
    }
    std::fill(gradient_.begin(), gradient_.end(), 0.0);
  }
}

// Whether there is anything to part.
bool DirectContacts::overlaps_notably(const SolveInput& input) const {
  const bool soft = input.settings.contact_hertz > 0;
  const double from_fixed = SubstepConstants::parting_rate(input.settings, input.dt, true);
  const double from_dynamic = SubstepConstants::parting_rate(input.settings, input.dt, false);
  for (const Contact& contact : contacts_) {
    const double rate = contact.fixed() ? from_fixed : from_dynamic;
    for (int i = 0; i < contact.law.points; ++i) {
      const double parts = rate * -contact.separation[i] * input.dt;
      if (parts > least_parting || (soft && contact.lasting.normal[i] > 0)) return true;
    }
  }
  return false;
}

// The velocities that bodies keep are those that the impulses make, so that no momentum is made up.
void DirectContacts::keep_velocities() {
  lasting_ = velocity_;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    Eigen::Map<Vector3>(&lasting_[6 * i]) -= Eigen::Map<const Vector3>(&gradient_[6 * i]) / bodies_[i].mass;
    Eigen::Map<Vector3>(&lasting_[6 * i + 3]) -=
        bodies_[i].inverse_inertia * Eigen::Map<const Vector3>(&gradient_[6 * i + 3]);
  }
  for (Contact& contact : contacts_) contact.lasting = contact.answer;
}

void DirectContacts::write_back(const SolveInput& input) {
  BodyTable& table = input.bodies;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Body& of = bodies_[i];
    const std::uint32_t body = of.body;
    const BodyPose start{table.position(body), table.orientation(body)};
    const Vector3 velocity = Eigen::Map<const Vector3>(&lasting_[6 * i]);
    const Vector3 spin = Eigen::Map<const Vector3>(&lasting_[6 * i + 3]);
    const Vector3 gained = velocity - table.velocity(body);
    const Vector3 gained_spin = spin - table.angular_velocity(body);
    Vector3 moves = Eigen::Map<const Vector3>(&velocity_[6 * i]);
    Vector3 turns = Eigen::Map<const Vector3>(&velocity_[6 * i + 3]);
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
      manifold.normal_impulse[i] = there ? static_cast<float>(share * contact.lasting.normal[point++]) : 0;
    }
    set3(manifold.friction_impulse, share * contact.in_plane(contact.lasting.friction));
    manifold.twist_impulse = static_cast<float>(share * contact.lasting.twist);
    if (input.surface_contacts == nullptr) continue;
    set3(input.surface_contacts[contact.slot].rolling_impulse, share * contact.in_plane(contact.lasting.rolling));
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
      answer.normal_impulse[i] = there ? static_cast<float>(contact.lasting.normal[point++]) : 0;
    }
    const Vector3 friction = contact.in_plane(contact.lasting.friction);
    const Vector3 rolling = contact.in_plane(contact.lasting.rolling);
    for (int k = 0; k < 3; ++k) {
      answer.friction_impulse[k] = static_cast<float>(friction[k]);
      answer.rolling_impulse[k] = static_cast<float>(rolling[k]);
    }
    answer.twist_impulse = static_cast<float>(contact.lasting.twist);
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
  const double give = SubstepConstants::give_by_impulse(input.settings, input.dt);
  for (const TouchingPair& pair : pairs_) {
    const LoadedContact contact = loaded_contact(input.bodies, input.manifolds, pair);
    note_overload(contact, give * load_of(contact.manifold), build, input.overloads.local());
  }
}

}  // namespace atl::solver
