// The law of a contact in the direct solver: impulses in their cone that take energy, and their derivative.

#include <gtest/gtest.h>
#include <solver/constraints/contact_law.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "support/random.h"

namespace atl::solver {
namespace {

using test::Random;

ContactLaw random_law(Random& random) {
  ContactLaw law;
  law.points = 1 + static_cast<int>(random.below(4));
  for (int i = 0; i < law.points; ++i) {
    law.x[i] = random.real(-1, 1);
    law.y[i] = random.real(-1, 1);
    law.stiffness[i] = random.real(1, 10);
    law.bias[i] = random.real(-0.5, 0.5);
  }
  law.friction_stiffness = random.real(1, 10);
  law.torsional_stiffness = random.real(1, 10);
  law.friction_bound = random.real(0, 5);
  law.torsional_bound = random.real(0, 2);
  law.pyramid = random.below(2) == 0;
  if (random.below(2) == 0) law.friction_ratio = random.real(0.05, 1);
  for (int k = 1; k < 6; ++k) law.surfaces[k] = random.real(-1, 1);
  if (random.below(2) == 0) law.rolling_stiffness = random.real(1, 10);
  law.rolling_bound = random.real(0, 5);
  return law;
}

Six random_motion(Random& random) {
  Six motion;
  for (double& each : motion) each = random.real(-1, 1);
  return motion;
}

TEST(ContactLaw, ImpulsesStayInTheirCone) {
  Random random(1);
  int slides = 0, sticks = 0, spins = 0, rolls = 0;
  for (int i = 0; i < 1000; ++i) {
    const ContactLaw law = random_law(random);
    const Six motion = random_motion(random);
    const ContactAnswer answer = law.answer(motion);
    for (int p = 0; p < law.points; ++p) {
      const double closing = -(law.speed(p, motion) + law.bias[p]);
      EXPECT_DOUBLE_EQ(answer.normal[p], closing > 0 ? law.stiffness[p] * closing : 0);
    }
    const double scaled[2] = {answer.friction[0], answer.friction[1] / law.friction_ratio};
    const double friction =
        law.pyramid ? std::max(std::abs(scaled[0]), std::abs(scaled[1])) : std::hypot(scaled[0], scaled[1]);
    EXPECT_LE(friction, law.friction_bound * (1 + 1e-14));
    EXPECT_LE(std::abs(answer.torsional), law.torsional_bound);
    EXPECT_LE(std::hypot(answer.rolling[0], answer.rolling[1]), law.rolling_bound * (1 + 1e-14));
    Six rubs = motion;
    for (int k = 1; k < 6; ++k) rubs[k] += law.surfaces[k];
    EXPECT_LE(answer.friction[0] * rubs[3] + answer.friction[1] * rubs[4], 0) << "it takes energy";
    EXPECT_LE(answer.rolling[0] * rubs[1] + answer.rolling[1] * rubs[2], 0) << "it takes energy";
    EXPECT_LE(answer.torsional * rubs[5], 0) << "it takes energy";
    EXPECT_EQ(answer.rolling[0] != 0, law.rolling_stiffness > 0);
    rolls += answer.pieces.rolls;
    if (answer.pieces.slides) {
      EXPECT_NEAR(friction, law.friction_bound, 1e-14 * law.friction_bound);
    }
    (answer.pieces.slides ? slides : sticks) += 1;
    spins += answer.pieces.spins;
  }
  EXPECT_GT(slides, 100);
  EXPECT_GT(sticks, 100);
  EXPECT_GT(spins, 100);
  EXPECT_GT(rolls, 100);
}

TEST(ContactLaw, DerivativeIsThatOfItsImpulses) {
  constexpr double h = 1e-6;
  Random random(3);
  int checked = 0;
  for (int i = 0; i < 2000; ++i) {
    const ContactLaw law = random_law(random);
    const Six at = random_motion(random);
    const ContactPieces pieces = law.answer(at).pieces;
    const auto k = law.derivative(at, pieces);
    Eigen::Matrix<double, 6, 6> matrix;
    bool one_piece = true;
    for (int c = 0; c < 6; ++c) {
      Six before = at, after = at;
      before[c] -= h;
      after[c] += h;
      one_piece &= law.answer(before).pieces == pieces && law.answer(after).pieces == pieces;
      const Six low = law.total(law.answer(before)), high = law.total(law.answer(after));
      for (int r = 0; r < 6; ++r) {
        matrix(r, c) = k[r][c];
        if (!one_piece) continue;
        ASSERT_NEAR(k[r][c], -(high[r] - low[r]) / (2 * h), 1e-6 * (1 + std::abs(k[r][c])));
      }
    }
    if (one_piece) ++checked;
    EXPECT_TRUE(matrix.isApprox(matrix.transpose(), 1e-14) || matrix.isZero());
    EXPECT_GE(matrix.ldlt().vectorD().minCoeff(), -1e-12 * matrix.norm());
  }
  EXPECT_GT(checked, 1900);
}

}  // namespace
}  // namespace atl::solver
