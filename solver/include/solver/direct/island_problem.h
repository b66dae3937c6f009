#pragma once

#include <jobs/bytes.h>
#include <solver/direct/block_ldlt.h>
#include <solver/direct/direct_rows.h>
#include <solver/tuning.h>

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

namespace atl::solver {

/// The velocities of an island's bodies at which its contacts and joints are in balance, in one system.
///
/// Contacts and joints are very slightly soft, so impulses are functions of the velocities v (ContactLaw, RowLaw), and
/// these are where a convex function is least:
///
///   |v - v*|^2_M / 2 + sum over contacts and joints of psi(J v),
///
/// with v* the velocities without them and -psi' their impulses. Newton's method with an exact line search finds them;
/// its matrix, M plus the stiffness of what holds, is positive definite, with a block of 6 x 6 for each body and each
/// pair, and is factored directly (Todorov, "Convex and analytically-invertible dynamics with contacts and
/// constraints", ICRA 2014; Castro, Permenter and Han, "An unconstrained convex formulation of compliant contact", T-RO
/// 2022). Friction's bound is given while that is done, and follows the load from one time to the next. Where Newton's
/// method doesn't end soon, as after an impact, an interior point method starts over, with the same matrices.
class IslandProblem {
 public:
  std::vector<DirectBody> bodies;
  std::vector<DirectContact> contacts;
  std::vector<DirectJoint> joints;
  std::vector<double> velocity;  ///< six numbers a body, linear and angular, m/s and rad/s: the solution
  std::vector<double> free;      ///< likewise: without contacts and joints

  /// For as many bodies, of which these pairs touch or are joined. Returns false if the factor would be too large.
  bool analyse(std::size_t body_count, std::span<const std::pair<std::uint32_t, std::uint32_t>> pairs);
  /// Makes room; bodies, contacts and joints are filled in by the caller.
  void resize(std::size_t body_count);

  /// By Newton's method, from `velocity` and the pieces that the answers are on. Returns false where that ends nowhere.
  bool solve();
  /// By an interior point method, from `velocity`, where all may be other than it was.
  bool solve_by_interior();
  /// The same from velocities near the solution; friction's bounds stay.
  bool solve_nearby() { return minimise(0); }
  /// If everything stays on the pieces that it is on.
  bool solve_on_last_pieces();
  /// Whether no contact pushes ten times as hard as would stop the whole island: opposite contacts that overlap can't
  /// both open, and may push each other as hard as they like. `from_outside` in N s: what drives and carries it beside
  /// its own momentum.
  bool is_bounded(double from_outside) const;
  /// Contacts and locks give by little under what they carry, but a column of many, or under many times its weight,
  /// would sink on them: once more, from where they carry it already. `closest(contact, point)`: m/s, at which a point
  /// may close.
  template <typename Closest>
  void take_back_give(const Closest& closest);
  /// The velocities that the impulses make, so that no momentum is made up.
  void velocities_of_impulses(std::vector<double>& to) const;

  /// What joints have to move by, as rates, is what the factor makes of it: replaces `direction()` by the motion that
  /// closes `gap(joint, row)` with the least work, and moves no contact that holds.
  template <typename Gap>
  void find_closing_motion(const Gap& gap);
  /// Adds the impulses of that motion to those that bodies keep, times `scale`.
  template <typename Gap>
  void add_closing_impulses(const Gap& gap, double scale);
  std::span<const double> direction() const { return direction_; }

  /// The motion that `velocity` makes at a contact.
  Six motion_of(const DirectContact& contact) const;
  /// Where bodies, axes or stiffnesses have changed.
  void forget_factor();
  /// For what everything is on now. Returns false if that can't be.
  bool factor();
  int iterations() const { return iterations_; }
  void count_anew() { iterations_ = 0; }

  /// Memory held.
  std::size_t bytes() const {
    return system_.bytes() + jobs::bytes_of(bodies, contacts, joints, velocity, free, gradient_, direction_, product_);
  }

 private:
  Six motion_of(const DirectContact& contact, const std::vector<double>& velocities) const;
  double rate_of(const DirectJoint& joint, std::size_t row, const std::vector<double>& velocities) const;
  void add_impulse(const DirectContact& contact, const Six& impulse, double sign, std::vector<double>& to) const;
  void add_impulse(const DirectJoint& joint, std::size_t row, double impulse, std::vector<double>& to) const;
  void mass_times(const std::vector<double>& velocities, std::vector<double>& product) const;
  void add_masses();
  void add_stiffness(const DirectContact& contact, const std::array<Six, 6>& k);
  void add_stiffness(DirectJoint& joint);
  bool is_factored() const;

  bool settle_friction();
  double friction_off() const;
  bool minimise(int follows);
  template <typename Answer>
  void balance(const Answer& answer);
  double unbalanced() const;
  void find_direction();
  void follow_load(double t);
  double slope(double t) const;
  double step_length() const;

  bool follow_interior();
  void start_interior();
  void take_pieces();
  double note_interior();
  bool factor_interior();
  double interior_step(double target, bool corrected);
  double interior_after(double t) const;
  void take_interior_step(double t);

  BlockLdlt system_;
  std::vector<double> gradient_, direction_, product_;  // N s, N m s; m/s, rad/s; N s, N m s
  double mass_slope_ = 0, mass_curvature_ = 0;          // of the first term, along direction_
  int iterations_ = 0;                                  // of Newton's method, beyond the first solves
};

template <typename Closest>
void IslandProblem::take_back_give(const Closest& closest) {
  if (!is_factored()) return;
  const auto answer_on_its_pieces = [](DirectContact& contact) {
    contact.answer = contact.law.linear_answer(contact.motion, contact.answer.pieces, contact.answer);
  };
  for (int round = 0; round < tuning::most_give_rounds; ++round) {
    double sinks = 0;
    for (DirectContact& contact : contacts) {
      double most = 0;
      for (int i = 0; i < contact.law.points; ++i) {
        if (!(contact.answer.pieces.points & (1 << i))) continue;
        const double may_close = closest(contact, i);
        most = std::max(most, -contact.law.speed(i, contact.motion) - may_close);
        contact.law.bias[i] = may_close - contact.answer.normal[i] / contact.law.stiffness[i];
      }
      sinks += most;
    }
    for (DirectJoint& joint : joints) {
      double most = 0;
      for (std::size_t r = 0; r < joint.rows; ++r) {
        RowLaw& law = joint.law[r];
        if (!law.locked) continue;
        most = std::max(most, std::abs(joint.rate[r]));
        law.lock_rate = joint.impulse[r] / law.stiffness;
      }
      sinks += most;
    }
    if (sinks < tuning::least_sinking) return;
    for (DirectContact& contact : contacts) {
      Six more = contact.law.total(contact.answer);
      for (double& impulse : more) impulse = -impulse;
      answer_on_its_pieces(contact);
      const Six total = contact.law.total(contact.answer);
      for (int k = 0; k < 6; ++k) more[k] += total[k];
      add_impulse(contact, more, -1, gradient_);
    }
    for (DirectJoint& joint : joints) {
      for (std::size_t r = 0; r < joint.rows; ++r) {
        if (!joint.law[r].locked) continue;
        const double impulse = joint.law[r].impulse(joint.rate[r]);
        add_impulse(joint, r, joint.impulse[r] - impulse, gradient_);
        joint.impulse[r] = impulse;
      }
    }
    find_direction();
    for (std::size_t i = 0; i < velocity.size(); ++i) velocity[i] += direction_[i];
    for (DirectContact& contact : contacts) {
      contact.motion = contact.motion_after(1);
      answer_on_its_pieces(contact);
    }
    for (DirectJoint& joint : joints) {
      for (std::size_t r = 0; r < joint.rows; ++r) {
        joint.rate[r] += joint.change[r];
        joint.impulse[r] = joint.law[r].impulse(joint.rate[r]);
      }
    }
    std::fill(gradient_.begin(), gradient_.end(), 0.0);
  }
}

template <typename Gap>
void IslandProblem::find_closing_motion(const Gap& gap) {
  std::fill(direction_.begin(), direction_.end(), 0.0);
  for (const DirectJoint& joint : joints) {
    for (std::size_t r = 0; r < joint.rows; ++r) {
      const double apart = gap(joint, r);
      if (apart != 0) add_impulse(joint, r, -apart * joint.law[r].stiffness, direction_);
    }
  }
  system_.solve(direction_);
}

template <typename Gap>
void IslandProblem::add_closing_impulses(const Gap& gap, double scale) {
  for (DirectJoint& joint : joints) {
    for (std::size_t r = 0; r < joint.rows; ++r) {
      const double apart = gap(joint, r);
      if (apart != 0) joint.lasting[r] -= scale * joint.law[r].stiffness * (apart + rate_of(joint, r, direction_));
    }
  }
}

// Of M (v - v*), what is left after the impulses that contacts answer with to their motion, and joints to theirs: the
// gradient.
template <typename Answer>
void IslandProblem::balance(const Answer& answer) {
  for (std::size_t i = 0; i < velocity.size(); ++i) product_[i] = velocity[i] - free[i];
  mass_times(product_, gradient_);
  for (DirectContact& contact : contacts) {
    contact.motion = motion_of(contact);
    contact.answer = answer(contact);
    add_impulse(contact, contact.law.total(contact.answer), -1, gradient_);
  }
  for (DirectJoint& joint : joints) {
    for (std::size_t r = 0; r < joint.rows; ++r) {
      joint.rate[r] = rate_of(joint, r, velocity) + joint.given[r];
      joint.impulse[r] = joint.law[r].impulse(joint.rate[r]);
      add_impulse(joint, r, -joint.impulse[r], gradient_);
    }
  }
}

}  // namespace atl::solver
