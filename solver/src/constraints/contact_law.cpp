#include <jobs/assert.h>
#include <solver/constraints/contact_law.h>
#include <solver/constraints/friction_ellipse.h>

#include <algorithm>
#include <cmath>

namespace atl::solver {
namespace {

using Two = std::array<double, 2>;

double length(const Two& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1]); }

// The viscous impulse against motion at `speed`, shortened to the radius `bound` of friction's disc. Returns true if it
// was.
bool hold_in_disc(const Two& speed, double stiffness, double bound, Two& impulse) {
  impulse = {-stiffness * speed[0], -stiffness * speed[1]};
  ATL_ASSERT(!(stiffness < 0) && !(bound < 0), stiffness, bound);
  const double wanted = length(impulse);
  if (!(wanted > bound)) return false;
  for (double& of_axis : impulse) of_axis *= bound / wanted;
  ATL_ASSERT(!(length(impulse) > bound * (1 + 1e-12)), length(impulse), bound);
  return true;
}

// The stiffness of a binding disc: the impulse's size is given, and only motion across it turns it.
void add_turning(std::array<Six, 6>& k, int axis, const Two& speed, double bound) {
  const double square = speed[0] * speed[0] + speed[1] * speed[1];
  if (!(square > 0)) return;
  const Two across = {-speed[1], speed[0]};
  const double by_square = bound / (square * std::sqrt(square));
  for (int a = 0; a < 2; ++a) {
    for (int b = 0; b < 2; ++b) k[axis + a][axis + b] += by_square * across[a] * across[b];
  }
}

}  // namespace

Six ContactLaw::rubbing(const Six& motion) const {
  Six sum;
  for (std::size_t k = 0; k < sum.size(); ++k) sum[k] = motion[k] + surfaces[k];
  return sum;
}

ContactAnswer ContactLaw::answer(const Six& motion) const {
  ATL_ASSERT(points >= 0 && points <= 4, points);
  ATL_ASSERT(!(friction_bound < 0), friction_bound);
  ATL_ASSERT(!(torsional_bound < 0), torsional_bound);
  ATL_ASSERT(!(friction_stiffness < 0) && !(torsional_stiffness < 0), friction_stiffness, torsional_stiffness);
  ContactAnswer answer;
  for (int i = 0; i < points; ++i) {
    const double closing = speed(i, motion) + bias[i];
    if (!(closing < 0)) continue;
    answer.normal[i] = -stiffness[i] * closing;
    ATL_ASSERT(!(answer.normal[i] < 0), i, answer.normal[i], stiffness[i], closing);
    answer.pieces.points |= static_cast<std::uint8_t>(1 << i);
  }
  const Six rubs = rubbing(motion);
  const Two slides = {rubs[3], rubs[4]};
  if (pyramid || friction_ratio != 1) {
    const FrictionEllipse ellipse{.ratio = friction_ratio};
    answer.friction = {-friction_stiffness * slides[0], -friction_stiffness * slides[1]};
    answer.pieces.slides =
        static_cast<std::uint8_t>(pyramid ? ellipse.hold_in_rectangle(friction_bound, answer.friction)
                                          : 3 * int{ellipse.hold({1, 0, 1}, friction_bound, answer.friction)});
  } else if (hold_in_disc(slides, friction_stiffness, friction_bound, answer.friction)) {
    answer.pieces.slides = 3;
  }
  const double twist = -torsional_stiffness * rubs[5];
  answer.torsional = std::clamp(twist, -torsional_bound, torsional_bound);
  answer.pieces.spins = answer.torsional != twist;
  if (rolling_stiffness > 0) {
    answer.pieces.rolls = hold_in_disc({rubs[1], rubs[2]}, rolling_stiffness, rolling_bound, answer.rolling);
  }
  return answer;
}

ContactAnswer ContactLaw::linear_answer(const Six& motion, const ContactPieces& pieces,
                                        const ContactAnswer& before) const {
  ContactAnswer answer = before;
  answer.pieces = pieces;
  for (int i = 0; i < points; ++i) {
    answer.normal[i] = pieces.points & (1 << i) ? -stiffness[i] * (speed(i, motion) + bias[i]) : 0;
  }
  const Six rubs = rubbing(motion);
  for (std::size_t axis = 0; axis < 2; ++axis) {
    if (!(pieces.slides & (1 << axis))) answer.friction[axis] = -friction_stiffness * rubs[3 + axis];
    if (!pieces.rolls) answer.rolling[axis] = -rolling_stiffness * rubs[1 + axis];
  }
  if (!pieces.spins) answer.torsional = -torsional_stiffness * rubs[5];
  return answer;
}

std::array<Six, 6> ContactLaw::derivative(const Six& motion, const ContactPieces& pieces) const {
  std::array<Six, 6> k = {};
  for (int i = 0; i < points; ++i) {
    if (!(pieces.points & (1 << i))) continue;
    const double row[3] = {1, y[i], -x[i]};
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b) k[a][b] += stiffness[i] * row[a] * row[b];
    }
  }
  const Six rubs = rubbing(motion);
  if (pieces.slides == 3 && !pyramid) {
    if (friction_ratio != 1) {
      add_sliding(k, rubs);
    } else {
      add_turning(k, 3, {rubs[3], rubs[4]}, friction_bound);
    }
  } else {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      if (!(pieces.slides & (1 << axis))) k[3 + axis][3 + axis] = friction_stiffness;
    }
  }
  if (pieces.rolls) {
    add_turning(k, 1, {rubs[1], rubs[2]}, rolling_bound);
  } else {
    for (std::size_t axis = 1; axis < 3; ++axis) k[axis][axis] += rolling_stiffness;
  }
  if (!pieces.spins) k[5][5] = torsional_stiffness;
  return k;
}

// The impulse f is the point of the ellipse nearest to p, f = p - t n with n its normal at f. Motion changes it along
// the ellipse only.
void ContactLaw::add_sliding(std::array<Six, 6>& k, const Six& rubs) const {
  const Two p = {-friction_stiffness * rubs[3], -friction_stiffness * rubs[4]};
  Two f = p;
  if (!FrictionEllipse{.ratio = friction_ratio}.hold({1, 0, 1}, friction_bound, f)) return;
  const double by_square = 1 / (friction_ratio * friction_ratio);
  const Two n = {f[0], by_square * f[1]};
  const double square = n[0] * n[0] + n[1] * n[1];
  if (!(square > 0)) return;
  const double t = std::max(0.0, ((p[0] - f[0]) * n[0] + (p[1] - f[1]) * n[1]) / square);
  const Two d = {1 / (1 + t), 1 / (1 + t * by_square)};
  const Two dn = {d[0] * n[0], d[1] * n[1]};
  const double over = 1 / (n[0] * dn[0] + n[1] * dn[1]);
  for (int a = 0; a < 2; ++a) {
    for (int b = 0; b < 2; ++b) {
      k[3 + a][3 + b] += friction_stiffness * ((a == b ? d[a] : 0) - over * dn[a] * dn[b]);
    }
  }
}

Six ContactLaw::total(const ContactAnswer& answer) const {
  Six sum = {0, answer.rolling[0], answer.rolling[1], answer.friction[0], answer.friction[1], answer.torsional};
  for (int i = 0; i < points; ++i) {
    sum[0] += answer.normal[i];
    sum[1] += y[i] * answer.normal[i];
    sum[2] -= x[i] * answer.normal[i];
  }
  return sum;
}

}  // namespace atl::solver
