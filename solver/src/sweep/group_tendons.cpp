#include <jobs/assert.h>
#include <solver/sweep/group_tendons.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

#include "integrate/matrix3.h"
#include "integrate/rows3.h"

namespace atl::solver {
namespace {

double rate_of(const PulledBodies& pulled, const SolverBodies& bodies) {
  double rate = 0;
  for (const PulledBody& body : pulled) rate += body.rate(velocity_of(bodies, body.body), spin_of(bodies, body.body));
  return rate;
}

// The same where SolverBodies::correction is in place of velocities.
double correction_of(const PulledBodies& pulled, const SolverBodies& bodies) {
  double rate = 0;
  for (const PulledBody& body : pulled) {
    const VelocityRows& rows = bodies.velocity[body.body];
    rate += body.rate(get3(rows.linear), get3(rows.angular));
  }
  return rate;
}

void apply(const PulledBodies& pulled, double impulse, SolverBodies& bodies) {
  for (const PulledBody& body : pulled) {
    if (bodies.free_velocity[body.body].inverse_mass == 0) continue;
    VelocityRows& rows = bodies.velocity[body.body];
    add3(rows.linear, impulse * inverse_mass_of(bodies, body.body).cwiseProduct(body.linear));
    add3(rows.angular, impulse * product(inverse_inertia_of(bodies, body.body), body.angular));
  }
}

// m/s or rad/s: at which what is off its place is to close, no faster than tuning::max_closing in a substep.
double closing_rate(const SubstepConstants& constants, double off) {
  const double max = tuning::max_closing * constants.inverse_h;
  return std::clamp(-constants.joint.bias_rate * off, -max, max);
}

// The length (m) by which a tendon is beyond its range, or off its locked length.
double beyond(const Law& law, double length) {
  return std::max(length - law.upper, 0.0) + std::min(length - law.lower, 0.0);
}

}  // namespace

void GroupTendons::place(const JointStep& step, Tendon& tendon) {
  const Joint& of = step.joints[tendon.joint];
  ATL_ASSERT(of.is_tendon() && tendon.terms == of.terms, tendon.joint, tendon.terms, of.terms);
  tendon.pulled.count = 0;
  tendon.length = 0;
  for (std::size_t i = 0; i < tendon.terms; ++i) {
    const Ends& ends = tendon.ends[i];
    const Joint& joint = step.joints[of.term[i].joint];
    const TermRow row = term_row(of.term[i], joint, pose_now(step, joint.first, ends.first),
                                 pose_now(step, joint.second, ends.second), tendon.position[i]);
    tendon.position[i] = row.position;
    tendon.length += row.value;
    tendon.pulled.add(ends.first, ends.second, row);
  }
  tendon.response = 0;
  for (const PulledBody& body : tendon.pulled) {
    if (step.bodies.free_velocity[body.body].inverse_mass == 0) continue;
    tendon.moving = body.body;
    tendon.response += body.linear.dot(inverse_mass_of(step.bodies, body.body).cwiseProduct(body.linear)) +
                       body.angular.dot(product(inverse_inertia_of(step.bodies, body.body), body.angular));
  }
  ATL_ASSERT(!(tendon.response < 0), tendon.joint, tendon.response);
}

void GroupTendons::begin_step(const JointStep& step) {
  for (Tendon& tendon : tendons_) {
    const Joint& of = step.joints[tendon.joint];
    for (std::size_t i = 0; i < tendon.terms; ++i) tendon.position[i] = of.term[i].position;
    tendon.impulse = of.impulse[0] / step.constants.refinement;
    place(step, tendon);
  }
}

void GroupTendons::begin_substep(const JointStep& step) {
  for (Tendon& tendon : tendons_) {
    const Law& law = law_of(step, tendon);
    const double mass = tendon.response > 0 ? 1 / tendon.response : 0;
    tendon.law = RowLaw::of(law, {.value = tendon.length}, {.alone = mass, .joined = mass}, step.h, tuning::compliance,
                            max_closed_of(step, tendon.joint));
    if (law.looks_back()) tendon.law.start_at(rate_of(tendon.pulled, step.bodies));
    tendon.split = 0;
  }
}

void GroupTendons::warm_start(SolverBodies& bodies, double applied, double kept, bool carried) {
  for (Tendon& tendon : tendons_) {
    if (carried) {
      apply(tendon.pulled_before, -tendon.carried, bodies);
      apply(tendon.pulled, tendon.carried, bodies);
    }
    if (applied != 0) apply(tendon.pulled, applied * tendon.impulse, bodies);
    tendon.impulse *= kept;
  }
}

void GroupTendons::clear_impulses() {
  for (Tendon& tendon : tendons_) tendon.impulse = 0;
}

void GroupTendons::move(const JointStep& step) {
  for (Tendon& tendon : tendons_) {
    tendon.pulled_before = tendon.pulled;
    tendon.carried = tendon.impulse;
    place(step, tendon);
    // Springs and motors go on from where the substep began. Ends stop what comes to them, and push no more.
    const Law& law = law_of(step, tendon);
    tendon.law.lower_rate = std::min((law.lower - tendon.length) / step.h, 0.0);
    tendon.law.upper_rate = std::max((law.upper - tendon.length) / step.h, 0.0);
  }
}

float GroupTendons::sweep(const JointStep& step, SolverBodies& bodies, Push push) {
  const SubstepConstants& constants = step.constants;
  double max = 0;
  for (Tendon& tendon : tendons_) {
    if (!(tendon.response > 0)) continue;
    const Law& law = law_of(step, tendon);
    const double mass = 1 / tendon.response;
    double impulse = 0;
    if (push == Push::Split) {
      const double off = beyond(law, tendon.length);
      const double wanted = tendon.split + mass * (closing_rate(constants, off) - correction_of(tendon.pulled, bodies));
      const double pushes = law.locked() ? wanted
                            : off > 0    ? std::min(wanted, 0.0)
                            : off < 0    ? std::max(wanted, 0.0)
                                         : 0;
      impulse = pushes - tendon.split;
      tendon.split = pushes;
    } else {
      const double rate = rate_of(tendon.pulled, bodies);
      if (!law.locked()) {
        const double free = rate - tendon.response * tendon.impulse;
        impulse = mass * (tendon.law.rate_from(free, tendon.response) - free) - tendon.impulse;
      } else if (push == Push::Bias) {
        const double closing = closing_rate(constants, tendon.length - law.lower);
        impulse = constants.joint.mass_scale * mass * (closing - rate) - constants.joint.impulse_scale * tendon.impulse;
      } else {
        impulse = -mass * rate;
      }
      tendon.impulse += impulse;
    }
    apply(tendon.pulled, impulse, bodies);
    max = std::max(max, std::abs(tendon.response * impulse));
  }
  return static_cast<float>(max);
}

void GroupTendons::store(const JointStep& step) const {
  for (const Tendon& tendon : tendons_) {
    Joint& joint = step.joints[tendon.joint];
    for (std::size_t i = 0; i < tendon.terms; ++i) joint.term[i].position = tendon.position[i];
    const TendonNow now = tendon_now(joint, step.joints, step.table);
    for (std::size_t i = 0; i < tendon.terms; ++i) {
      if (std::isfinite(now.position[i])) joint.term[i].position = now.position[i];
    }
    if (std::isfinite(now.length)) joint.position[0] = now.length;
    joint.impulse[0] = step.constants.refinement * tendon.impulse;
    joint.force = {tendon.impulse / step.h, 0, 0};
    joint.limit[0] = limit_reached(joint.law[0], now.length, joint.limit[0]);
  }
}

}  // namespace atl::solver
