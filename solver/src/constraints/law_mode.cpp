#include <solver/constraints/law_mode.h>
#include <solver/tuning.h>

#include <algorithm>

namespace atl::solver {
namespace {

// Of a motor's bound and of rates, so that rounding doesn't change the piece.
constexpr double margin = 1e-9;

}  // namespace

void LawMode::resume(const Law& law, int limit, int motor_bound) {
  piece_ = Piece::Between;
  if (motor_bound != 0) piece_ = motor_bound < 0 ? Piece::MotorLow : Piece::MotorHigh;
  if (limit < 0 && law.lower > -Law::unlimited) piece_ = Piece::Lower;
  if (limit > 0 && law.upper < Law::unlimited) piece_ = Piece::Upper;
}

void LawMode::begin(const Law& law, const JointRow& at, double effective_mass, double h) {
  if (law.locked()) {
    piece_ = Piece::Locked;
    solved_ = true;
    target_ = compliance_ = given_ = 0;
    return;
  }
  row_ = RowLaw::of(law, at, effective_mass, h);
  go_to(piece_ == Piece::Locked ? Piece::Between : piece_);
}

void LawMode::begin_kick(const Law& law, const JointRow& at, double effective_mass, double h, int sign, double rate,
                         double end_rate) {
  if (law.locked()) return begin(law, at, effective_mass, h);
  row_ = RowLaw::of_kick(law, at, effective_mass, h, sign, rate, end_rate, limit(), motor_bound());
  go_to(piece_);
}

void LawMode::add_impulse(double impulse) {
  if (row_.motor_slope > 0) {
    row_.motor_speed += impulse / row_.motor_slope;
  } else if (row_.spring_slope > 0) {
    row_.spring_rate += impulse / row_.spring_slope;
  }
  go_to(piece_);
}

void LawMode::start_at(double rate) {
  if (row_.spring_slope == 0 && row_.motor_slope == 0) return;
  row_.start_at(rate);
  go_to(piece_);
}

// A motor that reaches its speed holds it like a lock; one that doesn't pulls with all it has. So does a servo at rates
// farther than that from where it does nothing.
double LawMode::motor_impulse(double rate) const {
  if (row_.motor_slope > 0) return row_.motor_impulse_at(rate);
  return rate < row_.motor_speed ? row_.motor_impulse : rate > row_.motor_speed ? -row_.motor_impulse : 0;
}

double LawMode::rate_at_bound(double sign) const {
  return row_.motor_slope > 0 ? row_.motor_speed - sign * row_.motor_impulse / row_.motor_slope : row_.motor_speed;
}

void LawMode::go_to(Piece piece) {
  // Without a motor there is no bound of its, nor with one that has no end of force.
  const bool bounded = row_.motor_impulse > 0 && row_.motor_impulse < Law::unlimited;
  if (!bounded && (piece == Piece::MotorLow || piece == Piece::MotorHigh)) piece = Piece::Between;
  piece_ = piece;
  compliance_ = given_ = target_ = 0;
  switch (piece) {
    case Piece::Lower:
      solved_ = true;
      target_ = row_.lower_rate;
      return;
    case Piece::Upper:
      solved_ = true;
      target_ = row_.upper_rate;
      return;
    case Piece::Between:
      if (row_.motor_impulse > 0) {
        solved_ = true;
        target_ = row_.motor_speed;
        if (row_.motor_slope == 0) return;
        compliance_ = 1 / (row_.spring_slope + row_.motor_slope);
        target_ = compliance_ * (row_.spring_slope * row_.spring_rate + row_.motor_slope * row_.motor_speed);
        return;
      }
      break;
    case Piece::MotorLow:
      given_ = -row_.motor_impulse;
      break;
    case Piece::MotorHigh:
      given_ = row_.motor_impulse;
      break;
    case Piece::Locked:
      return;
  }
  solved_ = row_.spring_slope > 0;
  if (!solved_) return;
  compliance_ = 1 / row_.spring_slope;
  target_ = row_.spring_rate;
}

bool LawMode::catch_at_end(const Law& law, double position) {
  if (is_locked()) return false;
  const Piece end = position < law.lower - tuning::open_gap   ? Piece::Lower
                    : position > law.upper + tuning::open_gap ? Piece::Upper
                                                              : piece_;
  if (end == piece_) return false;
  go_to(end);
  return true;
}

bool LawMode::update(double rate, double impulse) {
  const Piece before = piece_;
  if (piece_ == Piece::Locked) return false;
  const double slack = margin * (1 + std::abs(rate));
  if (piece_ == Piece::Lower || piece_ == Piece::Upper) {
    // What spring and motor do at this rate is not the stop's.
    const double stop = impulse - spring_impulse(rate) - motor_impulse(rate);
    if (piece_ == Piece::Lower ? stop >= 0 : stop <= 0) return false;
    go_to(row_.motor_impulse == 0    ? Piece::Between
          : rate < rate_at_bound(1)  ? Piece::MotorHigh
          : rate > rate_at_bound(-1) ? Piece::MotorLow
                                     : Piece::Between);
    return true;
  }
  if (rate < row_.lower_rate - slack) {
    go_to(Piece::Lower);
  } else if (rate > row_.upper_rate + slack) {
    go_to(Piece::Upper);
  } else if (row_.motor_impulse > 0) {
    if (piece_ == Piece::Between) {
      const double motor = impulse - spring_impulse(rate);
      if (motor > row_.motor_impulse * (1 + margin)) go_to(Piece::MotorHigh);
      if (motor < -row_.motor_impulse * (1 + margin)) go_to(Piece::MotorLow);
    } else if (piece_ == Piece::MotorHigh ? rate > rate_at_bound(1) + slack : rate < rate_at_bound(-1) - slack) {
      go_to(Piece::Between);
    }
  }
  return piece_ != before;
}

}  // namespace atl::solver
