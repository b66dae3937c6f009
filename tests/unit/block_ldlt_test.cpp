// The factor of block-sparse systems where numbers are hard: not definite, of any mass ratio, badly conditioned. Random
// graphs, their fill and its limit are held against dense algebra in fuzz/direct_target.cpp.

#include <gtest/gtest.h>
#include <solver/direct/block_ldlt.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <utility>
#include <vector>

#include "support/random.h"

namespace atl::solver {
namespace {

using test::Random;
using Couplings = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

Eigen::MatrixXd times(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return a * b; }

TEST(BlockLdlt, RefusesWhatIsNotPositiveDefinite) {
  BlockLdlt blocks;
  const std::vector<std::uint8_t> sizes = {2, 2};
  ASSERT_TRUE(blocks.analyse(sizes, Couplings{{0, 1}}));
  blocks.clear();
  blocks.diagonal(0).setIdentity();
  blocks.diagonal(1).setIdentity();
  blocks.add(0, 1, 2 * Eigen::Matrix2d::Identity());
  EXPECT_FALSE(blocks.factor());
}

// J M^-1 J^T of a chain of ball joints from a fixed point to a last link of another mass: the arms of a link from its
// centre are along any direction, 0.5 m, and its inertia that of a ball of the same length.
struct Chain {
  Chain(Random& random, std::uint32_t links, double last_mass) {
    Couplings couplings;
    for (std::uint32_t i = 1; i < links; ++i) couplings.push_back({i - 1, i});
    EXPECT_TRUE(blocks.analyse(std::vector<std::uint8_t>(links, 3), couplings));
    blocks.clear();
    dense.setZero(3 * links, 3 * links);
    for (std::uint32_t i = 0; i < links; ++i) {
      const double per_mass = 1 / (i + 1 < links ? 1.0 : last_mass);
      const Eigen::Vector3d arm = 0.5 * random.direction();
      // Mobility between points at arms p and q: 1/m + [p]x I^-1 [q]x^T, with I = 0.1 m.
      const auto mobility = [&](const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
        return Eigen::Matrix3d(per_mass * (Eigen::Matrix3d::Identity() +
                                           10 * (p.dot(q) * Eigen::Matrix3d::Identity() - q * p.transpose())));
      };
      // Joint i holds link i by its first end, joint i + 1 by its other.
      add(i, i, mobility(arm, arm));
      if (i + 1 < links) {
        add(i + 1, i + 1, mobility(-arm, -arm));
        const Eigen::Matrix3d coupling = -mobility(-arm, arm);
        blocks.add(i + 1, i, coupling);
        dense.block<3, 3>(3 * (i + 1), 3 * i) += coupling;
        dense.block<3, 3>(3 * i, 3 * (i + 1)) += coupling.transpose();
      }
    }
  }

  void add(std::uint32_t row, std::uint32_t column, const Eigen::Matrix3d& value) {
    blocks.diagonal(row) += value;
    dense.block<3, 3>(3 * row, 3 * column) += value;
  }

  BlockLdlt blocks;
  Eigen::MatrixXd dense;
};

// A tonne at the end of 1000 links of 10 g, and the other way round. The residual is what rounding leaves of a backward
// stable factor; the solution is compared where a dense one is affordable.
TEST(BlockLdlt, SolvesChainsOfAnyMassRatio) {
  Random random(8);
  for (const std::uint32_t links : {200u, 1000u}) {
    for (const double last_mass : {1e5, 1e-5}) {
      Chain chain(random, links, last_mass);
      ASSERT_TRUE(chain.blocks.factor());
      const Eigen::VectorXd b = Eigen::VectorXd::NullaryExpr(3 * links, [&] { return random.real(-1, 1); });
      Eigen::VectorXd x = b;
      chain.blocks.solve({x.data(), static_cast<std::size_t>(x.size())});
      const Eigen::VectorXd scale = chain.dense.cwiseAbs() * x.cwiseAbs() + b.cwiseAbs();
      EXPECT_LT(((chain.dense * x - b).array() / scale.array()).abs().maxCoeff(), 1e-14);
      if (links > 200) continue;
      const Eigen::VectorXd expected = chain.dense.ldlt().solve(b);
      EXPECT_LT((x - expected).norm(), 1e-9 * expected.norm());
    }
  }
}

// The blocks of the inverse where the factor has blocks: trees and loops of nodes of one size, and of several.
TEST(BlockLdlt, InvertsWhereItHasBlocks) {
  Random random(10);
  for (int run = 0; run < 40; ++run) {
    const std::uint32_t count = 1 + static_cast<std::uint32_t>(run) % 12;
    std::vector<std::uint8_t> sizes;
    Couplings couplings;
    for (std::uint32_t i = 0; i < count; ++i) {
      sizes.push_back(
          static_cast<std::uint8_t>(run % 4 == 0 ? 1 + random.below(6) : 3u + static_cast<unsigned>(run) % 4));
      if (i > 0) couplings.push_back({random.below(i), i});
      if (i > 2 && run % 2 == 0) couplings.push_back({i - 2, i});
    }
    BlockLdlt blocks;
    ASSERT_TRUE(blocks.analyse(sizes, couplings));
    blocks.clear();
    const auto rows = static_cast<Eigen::Index>(blocks.rows());
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(rows, rows);
    const auto any = [&](std::uint32_t node) {
      return Eigen::MatrixXd(Eigen::MatrixXd::NullaryExpr(sizes[node], 6, [&] { return random.real(-1, 1); }));
    };
    const auto add = [&](std::uint32_t a, std::uint32_t b, const Eigen::MatrixXd& values) {
      const auto row = static_cast<Eigen::Index>(blocks.row(a)), column = static_cast<Eigen::Index>(blocks.row(b));
      dense.block(row, column, values.rows(), values.cols()) += values;
      if (a == b) {
        blocks.diagonal(a) += values;
      } else {
        dense.block(column, row, values.cols(), values.rows()) += values.transpose();
        blocks.add(a, b, values);
      }
    };
    for (std::uint32_t i = 0; i < count; ++i) add(i, i, Eigen::MatrixXd::Identity(sizes[i], sizes[i]));
    for (const auto& [a, b] : couplings) {
      const Eigen::MatrixXd of_a = any(a), of_b = any(b);
      add(a, a, times(of_a, of_a.transpose()));
      add(b, b, times(of_b, of_b.transpose()));
      add(a, b, times(of_a, of_b.transpose()));
    }
    ASSERT_TRUE(blocks.factor());
    std::vector<double> inverse;
    blocks.invert(inverse);
    const Eigen::MatrixXd expected = dense.ldlt().solve(Eigen::MatrixXd::Identity(rows, rows));
    const auto compare = [&](std::uint32_t a, std::uint32_t b) {
      const std::uint32_t row = blocks.is_earlier(a, b) ? b : a, column = row == a ? b : a;
      const Eigen::Map<const Eigen::MatrixXd> block(&inverse[blocks.block_index(a, b)], sizes[row], sizes[column]);
      const auto first = static_cast<Eigen::Index>(blocks.row(row));
      const auto second = static_cast<Eigen::Index>(blocks.row(column));
      EXPECT_LT((block - expected.block(first, second, block.rows(), block.cols())).norm(), 1e-12 * expected.norm())
          << run << ": " << a << ", " << b;
    };
    for (std::uint32_t i = 0; i < count; ++i) compare(i, i);
    for (const auto& [a, b] : couplings) compare(a, b);
  }
}

// Pivots of condition 1e12, and a coupling along all of them: with their explicit inverses it would cost definiteness.
TEST(BlockLdlt, KeepsDefinitenessOfBadlyConditionedBlocks) {
  Random random(9);
  for (int run = 0; run < 100; ++run) {
    constexpr std::uint32_t count = 20;
    Couplings couplings;
    for (std::uint32_t i = 1; i < count; ++i) couplings.push_back({i - 1, i});
    const std::uint8_t size = run % 2 == 0 ? 3 : 6;
    BlockLdlt blocks;
    ASSERT_TRUE(blocks.analyse(std::vector<std::uint8_t>(count, size), couplings));
    blocks.clear();
    const Eigen::Index rows = size * count;
    const auto any = [&] {
      return Eigen::MatrixXd(Eigen::MatrixXd::NullaryExpr(size, size, [&] { return random.real(-1, 1); }));
    };
    // A = L D L^T from blocks of L below 1 and of D with eigenvalues from 1 to 1e-12.
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(rows, rows);
    for (std::uint32_t i = 0; i < count; ++i) {
      const Eigen::VectorXd along = any().col(0).normalized();
      const Eigen::MatrixXd mirror = Eigen::MatrixXd::Identity(size, size) - 2 * times(along, along.transpose());
      Eigen::VectorXd spread(size);
      for (Eigen::Index k = 0; k < size; ++k) spread[k] = std::pow(10.0, -12.0 * static_cast<double>(k) / (size - 1));
      Eigen::MatrixXd strip = Eigen::MatrixXd::Zero(rows, size);
      strip.middleRows(i * size, size).setIdentity();
      if (i + 1 < count) strip.middleRows((i + 1) * size, size) = any() / size;
      // One product at a time: nested ones take the compiler 20 s.
      Eigen::MatrixXd pivot = mirror;
      for (Eigen::Index k = 0; k < size; ++k) pivot.col(k) *= spread[k];
      pivot = times(pivot, mirror);
      dense += times(times(strip, pivot), strip.transpose());
    }
    for (std::uint32_t i = 0; i < count; ++i) {
      blocks.diagonal(i) = dense.block(i * size, i * size, size, size);
      if (i > 0) blocks.add(i, i - 1, dense.block(i * size, (i - 1) * size, size, size));
    }
    ASSERT_TRUE(blocks.factor()) << run;
    const Eigen::VectorXd b = times(dense, Eigen::VectorXd::Ones(rows));
    Eigen::VectorXd x = b;
    blocks.solve({x.data(), static_cast<std::size_t>(rows)});
    EXPECT_LT((dense * x - b).norm(), 1e-14 * dense.norm() * x.norm()) << run;
  }
}

}  // namespace
}  // namespace atl::solver
