#include <jobs/assert.h>
#include <solver/direct/balance_search.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

namespace atl::solver {
namespace {

// m/s: the most that one of its points closes too fast. Shifts the points' laws such that they push as they do now
// where they stop.
double shift_contact(DirectContact& contact, double dt) {
  double max = 0;
  for (int i = 0; i < contact.law.points; ++i) {
    if (!(contact.answer.pieces.points & (1 << i))) continue;
    const double may_close = std::max(contact.separation[i], 0.0) / dt;
    max = std::max(max, -contact.law.speed(i, contact.motion) - may_close);
    ATL_ASSERT(!(contact.law.stiffness[i] <= 0), contact.slot, i, contact.law.stiffness[i]);
    contact.law.bias[i] = may_close - contact.answer.normal[i] / contact.law.stiffness[i];
  }
  return max;
}

// The same of the locks of a joint.
double shift_joint(DirectJoint& joint) {
  double max = 0;
  for (std::size_t r = 0; r < joint.rows; ++r) {
    RowLaw& law = joint.law[r];
    if (!law.locked) continue;
    max = std::max(max, std::abs(joint.rate[r] + joint.bend[r]));
    ATL_ASSERT(!(law.stiffness <= 0), joint.joint, r, law.stiffness);
    law.lock_rate = joint.impulse[r] / law.stiffness - joint.bend[r];
  }
  return max;
}

// Impulses become those of the shifted laws, and the gradient what they change.
void answer_shifted(IslandProblem& problem, std::vector<double>& gradient) {
  for (DirectContact& contact : problem.contacts) {
    Six more = contact.law.total(contact.answer);
    for (double& impulse : more) impulse = -impulse;
    contact.answer = contact.law.linear_answer(contact.motion, contact.answer.pieces, contact.answer);
    const Six total = contact.law.total(contact.answer);
    for (int k = 0; k < 6; ++k) more[k] += total[k];
    contact.add_impulse(more, -1, gradient);
  }
  for (DirectJoint& joint : problem.joints) {
    DirectJoint::Rows<double> less = {};
    for (std::size_t r = 0; r < joint.rows; ++r) {
      if (!joint.law[r].locked) continue;
      const double impulse = joint.law[r].impulse(joint.rate[r]);
      less[r] = joint.impulse[r] - impulse;
      joint.impulse[r] = impulse;
    }
    joint.add_impulses(less.data(), gradient.data());
  }
}

// Goes to the end of the search direction with all rows on their last pieces. The gradient is then rounding alone.
void go_to_end(IslandProblem& problem, BalanceSearch& search) {
  for (std::size_t i = 0; i < search.direction.size(); ++i) problem.velocity[i] += search.direction[i];
  balance_on_last_pieces(problem, search.gradient);
}

}  // namespace

void take_back_compliance(IslandProblem& problem, BalanceSearch& search, double dt) {
  if (!is_factored(problem)) return;
  for (int round = 0; round < tuning::max_penetration_rounds; ++round) {
    double sinks = 0;
    for (DirectContact& contact : problem.contacts) sinks += shift_contact(contact, dt);
    for (DirectJoint& joint : problem.joints) sinks += shift_joint(joint);
    if (sinks < tuning::min_sinking) return;
    answer_shifted(problem, search.gradient);
    find_direction(problem, search);
    go_to_end(problem, search);
  }
}

}  // namespace atl::solver
