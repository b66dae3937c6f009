#include <solver/patch_law.h>

#include <algorithm>
#include <cmath>

namespace atl::solver {

PatchAnswer PatchLaw::answer(const Six& motion) const {
  PatchAnswer answer;
  for (int i = 0; i < points; ++i) {
    const double closing = speed(i, motion) + bias[i];
    if (!(closing < 0)) continue;
    answer.normal[i] = -stiffness[i] * closing;
    answer.pieces.points |= static_cast<std::uint8_t>(1 << i);
  }
  answer.friction = {-friction_stiffness * motion[3], -friction_stiffness * motion[4]};
  const double square = answer.friction[0] * answer.friction[0] + answer.friction[1] * answer.friction[1];
  if (square > friction_bound * friction_bound) {
    const double scale = friction_bound / std::sqrt(square);
    for (double& impulse : answer.friction) impulse *= scale;
    answer.pieces.slides = true;
  }
  const double twist = -twist_stiffness * motion[5];
  answer.twist = std::clamp(twist, -twist_bound, twist_bound);
  answer.pieces.spins = answer.twist != twist;
  return answer;
}

PatchAnswer PatchLaw::linear_answer(const Six& motion, const PatchPieces& pieces, const PatchAnswer& before) const {
  PatchAnswer answer = before;
  answer.pieces = pieces;
  for (int i = 0; i < points; ++i) {
    answer.normal[i] = pieces.points & (1 << i) ? -stiffness[i] * (speed(i, motion) + bias[i]) : 0;
  }
  if (!pieces.slides) answer.friction = {-friction_stiffness * motion[3], -friction_stiffness * motion[4]};
  if (!pieces.spins) answer.twist = -twist_stiffness * motion[5];
  return answer;
}

void PatchLaw::add_points(std::array<Six, 6>& k, const std::array<double, collision::max_points>& held) const {
  for (int i = 0; i < points; ++i) {
    const double row[3] = {1, y[i], -x[i]};
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b) k[a][b] += held[i] * row[a] * row[b];
    }
  }
}

std::array<Six, 6> PatchLaw::secant(const Six& motion, const std::array<double, collision::max_points>& held) const {
  std::array<Six, 6> k = {};
  add_points(k, held);
  const double speed = std::sqrt(motion[3] * motion[3] + motion[4] * motion[4]);
  const double spin = std::abs(motion[5]);
  k[3][3] = k[4][4] = friction_stiffness * speed > friction_bound ? friction_bound / speed : friction_stiffness;
  k[5][5] = twist_stiffness * spin > twist_bound ? twist_bound / spin : twist_stiffness;
  return k;
}

std::array<Six, 6> PatchLaw::derivative(const Six& motion, const PatchPieces& pieces) const {
  std::array<Six, 6> k = {};
  std::array<double, collision::max_points> held = {};
  for (int i = 0; i < points; ++i) held[i] = pieces.points & (1 << i) ? stiffness[i] : 0;
  add_points(k, held);
  if (!pieces.slides) {
    k[3][3] = k[4][4] = friction_stiffness;
  } else if (const double square = motion[3] * motion[3] + motion[4] * motion[4]; square > 0) {
    // Its size is given: only motion across it turns it.
    const double across[2] = {-motion[4], motion[3]};
    const double by_square = friction_bound / (square * std::sqrt(square));
    for (int a = 0; a < 2; ++a) {
      for (int b = 0; b < 2; ++b) k[3 + a][3 + b] = by_square * across[a] * across[b];
    }
  }
  if (!pieces.spins) k[5][5] = twist_stiffness;
  return k;
}

Six PatchLaw::total(const PatchAnswer& answer) const {
  Six sum = {0, 0, 0, answer.friction[0], answer.friction[1], answer.twist};
  for (int i = 0; i < points; ++i) {
    sum[0] += answer.normal[i];
    sum[1] += y[i] * answer.normal[i];
    sum[2] -= x[i] * answer.normal[i];
  }
  return sum;
}

}  // namespace atl::solver
