#include <jobs/assert.h>
#include <solver/direct/island_motions.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

#include "direct/island_joints.h"

namespace atl::solver {
namespace {

// s: of a step of as many substeps as the settings have, in which sweeps part overlaps at their rate. Without joints dt
// is such a step, else a substep.
double whole_step(const IslandProblem& problem, const SolverSettings& settings, double dt) {
  return problem.joints.empty() ? dt : dt * settings.substeps;
}

// The law by which overlap is parted.
struct Parting {
  double rate;       // 1/s, of the overlap
  double stiffness;  // N s by m/s, over the effective mass
};

// The rate and stiffness of the springs that contacts are set to be, or else the rate at which sweeps part overlap.
Parting parting_of(const SolverSettings& settings, double dt, double whole, bool fixed) {
  if (!(settings.contact_hertz > 0)) {
    return {SubstepConstants::parting_rate(settings, whole, fixed), 1 / tuning::compliance};
  }
  const double hertz = fixed ? 2 * settings.contact_hertz : settings.contact_hertz;
  const Softness spring = Softness::of(hertz, settings.contact_damping_ratio, dt);
  return {spring.bias_rate, static_cast<double>(spring.mass_scale) / spring.impulse_scale};
}

void push_contacts_apart(IslandProblem& problem, const SolverSettings& settings, double dt) {
  const double whole = whole_step(problem, settings, dt);
  const Parting from_fixed = parting_of(settings, dt, whole, true);
  const Parting from_dynamic = parting_of(settings, dt, whole, false);
  ATL_ASSERT(from_fixed.rate >= 0 && from_dynamic.rate >= 0, from_fixed.rate, from_dynamic.rate);
  ATL_ASSERT(from_fixed.stiffness > 0 && from_dynamic.stiffness > 0, from_fixed.stiffness, from_dynamic.stiffness);
  for (DirectContact& contact : problem.contacts) {
    const Parting& parting = contact.fixed() ? from_fixed : from_dynamic;
    for (int i = 0; i < contact.law.points; ++i) {
      const double separation = contact.separation[i];
      const bool apart = separation > 0;
      contact.law.stiffness[i] = contact.mass[i] * (apart ? 1 / tuning::compliance : parting.stiffness);
      contact.law.bias[i] = apart ? separation / dt : std::max(parting.rate * separation, -settings.contact_push_speed);
    }
  }
  if (settings.contact_hertz > 0) forget_factor(problem);
}

// Tells whether bodies move by other velocities than those they keep: where something overlaps, or contacts are
// springs.
bool is_pushed(const IslandProblem& problem, const SolverSettings& settings) {
  const bool soft = settings.contact_hertz > 0;
  for (const DirectContact& contact : problem.contacts) {
    for (int i = 0; i < contact.law.points; ++i) {
      if (contact.separation[i] < -tuning::min_overlap || (soft && contact.lasting.normal[i] > 0)) return true;
    }
  }
  return false;
}

// Tells islands in which some contact closes or parts fast.
bool is_fast(const IslandProblem& problem) {
  return std::any_of(problem.contacts.begin(), problem.contacts.end(), [&](const DirectContact& contact) {
    return std::abs(contact.approach) > tuning::spread_speed;
  });
}

// Tells islands of which the last step has said what carries what.
bool is_known(const IslandProblem& problem) {
  return std::any_of(problem.contacts.begin(), problem.contacts.end(),
                     [](const DirectContact& contact) { return contact.answer.load() > 0; });
}

// Without joints, what rests needs few iterations from where it was in the last step, and what moves gains nothing by
// many.
int max_iterations(const IslandProblem& problem, const SolverSettings& settings) {
  if (settings.direct_only || !problem.joints.empty()) return tuning::max_iterations_if_patient;
  if (is_fast(problem)) return tuning::max_iterations_if_fast;
  return is_known(problem) ? tuning::max_iterations : tuning::max_iterations_if_patient;
}

// N s, of all bodies if they moved at such a speed.
double momentum_at(double speed, const IslandProblem& problem) {
  double mass = 0;
  for (const DirectBody& body : problem.bodies) mass += body.mass;
  return mass * speed;
}

// Bodies keep the velocities that the impulses make.
void keep_velocities(IslandMotions& motions) {
  velocities_of_impulses(motions.problem, motions.search.gradient, motions.lasting);
  for (DirectContact& contact : motions.problem.contacts) contact.lasting = contact.answer;
  for (DirectJoint& joint : motions.problem.joints) joint.lasting = joint.impulse;
}

}  // namespace

bool find_motions(IslandMotions& motions, const SolverSettings& settings, double dt, double from_outside) {
  ATL_ASSERT(dt > 0 && !(from_outside < 0), dt, from_outside);
  const bool relaxes = settings.relax_iterations > 0;
  if (relaxes) {
    stop_contacts(motions.problem.contacts, dt);
  } else {
    push_contacts_apart(motions.problem, settings, dt);
  }
  motions.search.max_iterations = max_iterations(motions.problem, settings);
  if (!solve_by_newton(motions.problem, motions.search)) return false;
  if (!is_bounded(motions.problem, from_outside)) return false;
  if (relaxes) take_back_compliance(motions.problem, motions.search, dt);
  keep_velocities(motions);
  motions.pushes = (relaxes && is_pushed(motions.problem, settings)) || any_goes_back(motions.problem.joints);
  if (!motions.pushes) return true;
  push_contacts_apart(motions.problem, settings, dt);
  begin_going_back(motions.problem.joints);
  // A tangle of joints whose overlaps can't be parted is swept: solved at once it would be flung apart.
  if (!motions.problem.joints.empty()) {
    const double pushed = from_outside + momentum_at(settings.contact_push_speed, motions.problem);
    return solve_nearby(motions.problem, motions.search) && is_bounded(motions.problem, pushed);
  }
  motions.pushes = step_by_newton(motions.problem, motions.search);
  return true;
}

void stop_contacts(std::vector<DirectContact>& contacts, double dt) {
  for (DirectContact& contact : contacts) {
    for (int i = 0; i < contact.law.points; ++i) {
      contact.law.stiffness[i] = contact.mass[i] / tuning::compliance;
      contact.law.bias[i] = std::max(contact.separation[i], 0.0) / dt;
    }
  }
}

}  // namespace atl::solver
