#pragma once

#include <solver/constraints/row_law.h>

#include <cstdint>

namespace atl::solver {

/// Which piece of its law a coordinate is on, and the equation that this makes of it: for the rate u and the impulse l
/// of a substep, either u + compliance * (l - given) = target, or l = given.
class LawMode {
 public:
  /// Goes on from where a step ended: at that end of the range, or that bound of the motor; see limit(), motor_bound().
  void resume(const Law& law, int limit, int motor_bound);

  /// Starts a substep of h seconds. `effective_mass` along the row, kg or kg m^2.
  void begin(const Law& law, const JointRow& at, double effective_mass, double h);

  /// Starts a kick, which is half a step of h seconds: see RowLaw::of_kick().
  void begin_kick(const Law& law, const JointRow& at, double effective_mass, double h, int sign, double rate,
                  double end_rate);

  /// Gives a substep's law the rate before its forces, once; without it, the row was at rest.
  void start_at(double rate);

  /// Adds an impulse to that of the spring or servo.
  void add_impulse(double impulse);

  bool is_solved() const { return solved_; }  ///< else the impulse is given
  double target() const { return target_; }
  double compliance() const { return compliance_; }
  double given() const { return given_; }
  /// -1 at the lower end of the range, 1 at the upper, else 0.
  int limit() const { return piece_ == Piece::Lower ? -1 : piece_ == Piece::Upper ? 1 : 0; }
  /// -1 where the motor pulls backwards with all it has, 1 forwards, else 0.
  int motor_bound() const { return piece_ == Piece::MotorLow ? -1 : piece_ == Piece::MotorHigh ? 1 : 0; }
  bool is_locked() const { return piece_ == Piece::Locked; }
  /// Locked, or at an end of the range: whose position is held.
  bool holds() const { return is_locked() || limit() != 0; }

  /// Moves to the end of the range, if the coordinate is beyond it, where the rate allowed it not to be held. Returns
  /// whether it was moved.
  bool catch_at_end(const Law& law, double position);

  /// Moves to the piece on which the rate and impulse of a solution belong. Returns whether that is another one.
  bool update(double rate, double impulse);

 private:
  enum class Piece : std::uint8_t { Locked, Lower, Upper, Between, MotorLow, MotorHigh };

  void go_to(Piece piece);
  double spring_impulse(double rate) const { return -row_.spring_slope * (rate - row_.spring_rate); }
  double motor_impulse(double rate) const;
  double rate_at_bound(double sign) const;  // beyond which the motor has less than all, forwards or backwards

  Piece piece_ = Piece::Between;
  bool solved_ = false;
  double target_ = 0, compliance_ = 0, given_ = 0;
  RowLaw row_;
};

}  // namespace atl::solver
