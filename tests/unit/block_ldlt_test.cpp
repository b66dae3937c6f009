// The factor of block-sparse systems, against dense algebra.

#include <gtest/gtest.h>
#include <solver/direct/block_ldlt.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <cmath>
#include <utility>
#include <vector>

#include "support/random.h"

namespace atl::solver {
namespace {

using test::Random;
using Couplings = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

// The same matrix as blocks and dense: J M J^T of random rows, so it is positive definite.
struct System {
  System(Random& random, const std::vector<std::uint8_t>& sizes, const Couplings& couplings) {
    EXPECT_TRUE(blocks.analyse(sizes, couplings));
    refill(random, sizes, couplings);
  }

  void refill(Random& random, const std::vector<std::uint8_t>& sizes, const Couplings& couplings) {
    blocks.clear();
    dense.setZero(static_cast<Eigen::Index>(blocks.rows()), static_cast<Eigen::Index>(blocks.rows()));
    const auto any = [&](Eigen::Index rows, Eigen::Index columns) {
      return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return random.real(-1, 1); }).eval();
    };
    const auto at = [&](std::uint32_t a, std::uint32_t b) {
      return dense.block(static_cast<Eigen::Index>(blocks.row(a)), static_cast<Eigen::Index>(blocks.row(b)), sizes[a],
                         sizes[b]);
    };
    for (std::uint32_t node = 0; node < sizes.size(); ++node) {
      const Eigen::MatrixXd own = any(sizes[node], sizes[node]);
      const Eigen::MatrixXd value = own * own.transpose() + 0.1 * Eigen::MatrixXd::Identity(sizes[node], sizes[node]);
      blocks.diagonal(node) += value;
      at(node, node) += value;
    }
    for (const auto& [a, b] : couplings) {
      // Couples the two blocks as a body does that both rows act on.
      const Eigen::MatrixXd of_a = any(sizes[a], 6), of_b = any(sizes[b], 6);
      blocks.diagonal(a) += of_a * of_a.transpose();
      blocks.diagonal(b) += of_b * of_b.transpose();
      at(a, a) += of_a * of_a.transpose();
      at(b, b) += of_b * of_b.transpose();
      blocks.add(a, b, of_a * of_b.transpose());
      at(a, b) += of_a * of_b.transpose();
      at(b, a) += of_b * of_a.transpose();
    }
  }

  BlockLdlt blocks;
  Eigen::MatrixXd dense;
};

void expect_solved(System& system, Random& random) {
  ASSERT_TRUE(system.blocks.factor());
  const auto rows = static_cast<Eigen::Index>(system.blocks.rows());
  const Eigen::VectorXd b = Eigen::VectorXd::NullaryExpr(rows, [&] { return random.real(-1, 1); });
  Eigen::VectorXd x = b;
  system.blocks.solve({x.data(), static_cast<std::size_t>(rows)});
  EXPECT_LT((system.dense * x - b).norm(), 1e-10 * b.norm() * (1 + x.norm()));
  EXPECT_LT((x - system.dense.llt().solve(b)).norm(), 1e-8 * (1 + x.norm()));
}

std::vector<std::uint8_t> any_sizes(Random& random, std::size_t count) {
  std::vector<std::uint8_t> sizes(count);
  for (std::uint8_t& size : sizes) size = static_cast<std::uint8_t>(1 + random.below(6));
  return sizes;
}

TEST(BlockLdlt, SolvesTreesWithoutFill) {
  Random random(1);
  for (int run = 0; run < 50; ++run) {
    const std::size_t count = 1 + random.below(40);
    const std::vector<std::uint8_t> sizes = any_sizes(random, count);
    Couplings couplings;
    for (std::uint32_t node = 1; node < count; ++node) {
      const std::uint32_t other = random.below(node);
      couplings.push_back(random.chance(0.5) ? std::pair(node, other) : std::pair(other, node));
    }
    System system(random, sizes, couplings);
    EXPECT_EQ(system.blocks.factor_blocks(), count - 1);
    expect_solved(system, random);
    system.refill(random, sizes, couplings);
    expect_solved(system, random);
  }
}

TEST(BlockLdlt, SolvesGraphsWithLoops) {
  Random random(2);
  for (int run = 0; run < 50; ++run) {
    const std::size_t count = 2 + random.below(25);
    const std::vector<std::uint8_t> sizes = any_sizes(random, count);
    Couplings couplings;
    for (std::uint32_t a = 0; a < count; ++a) {
      for (std::uint32_t b = 0; b < a; ++b) {
        if (random.chance(0.2)) couplings.push_back({a, b});
      }
    }
    System system(random, sizes, couplings);
    EXPECT_GE(system.blocks.factor_blocks(), couplings.size());
    expect_solved(system, random);
  }
}

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

// Every size of node under every other, and all of one size, which have code of their own.
TEST(BlockLdlt, SolvesEveryPairOfSizes) {
  Random random(4);
  for (std::uint8_t a = 1; a <= BlockLdlt::max_size; ++a) {
    for (std::uint8_t b = 1; b <= BlockLdlt::max_size; ++b) {
      const Couplings couplings = {{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5}, {5, 0}, {1, 4}};
      System system(random, {a, b, a, b, a, b}, couplings);
      expect_solved(system, random);
    }
  }
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
      const Eigen::MatrixXd turn = any().householderQr().householderQ();
      Eigen::VectorXd spread(size);
      for (Eigen::Index k = 0; k < size; ++k) spread[k] = std::pow(10.0, -12.0 * static_cast<double>(k) / (size - 1));
      Eigen::MatrixXd strip = Eigen::MatrixXd::Zero(rows, size);
      strip.middleRows(i * size, size).setIdentity();
      if (i + 1 < count) strip.middleRows((i + 1) * size, size) = any() / size;
      dense += strip * (turn * spread.asDiagonal() * turn.transpose()) * strip.transpose();
    }
    for (std::uint32_t i = 0; i < count; ++i) {
      blocks.diagonal(i) = dense.block(i * size, i * size, size, size);
      if (i > 0) blocks.add(i, i - 1, dense.block(i * size, (i - 1) * size, size, size));
    }
    ASSERT_TRUE(blocks.factor()) << run;
    const Eigen::VectorXd b = dense * Eigen::VectorXd::Ones(rows);
    Eigen::VectorXd x = b;
    blocks.solve({x.data(), static_cast<std::size_t>(rows)});
    EXPECT_LT((dense * x - b).norm(), 1e-14 * dense.norm() * x.norm()) << run;
  }
}

// Couplings of the joints of a square net of bodies: those that share one.
Couplings net(std::uint32_t side, std::uint32_t& joints) {
  std::vector<std::vector<std::uint32_t>> at(side * side);
  joints = 0;
  for (std::uint32_t y = 0; y < side; ++y) {
    for (std::uint32_t x = 0; x < side; ++x) {
      for (const std::uint32_t other : {x + 1 < side ? y * side + x + 1 : 0, y + 1 < side ? (y + 1) * side + x : 0}) {
        if (other == 0) continue;
        at[y * side + x].push_back(joints);
        at[other].push_back(joints++);
      }
    }
  }
  Couplings couplings;
  for (const auto& body : at) {
    for (const std::uint32_t a : body) {
      for (const std::uint32_t b : body) {
        if (a < b) couplings.push_back({a, b});
      }
    }
  }
  return couplings;
}

TEST(BlockLdlt, RefusesMoreBlocksThanAllowed) {
  std::uint32_t joints = 0;
  for (const std::uint32_t side : {2u, 5u, 12u}) {
    const Couplings couplings = net(side, joints);
    const std::vector<std::uint8_t> sizes(joints, 3);
    BlockLdlt blocks;
    ASSERT_TRUE(blocks.analyse(sizes, couplings));
    const std::size_t needed = blocks.factor_blocks();
    EXPECT_TRUE(blocks.analyse(sizes, couplings, needed));
    EXPECT_EQ(blocks.factor_blocks(), needed);
    EXPECT_FALSE(blocks.analyse(sizes, couplings, needed - 1));
    EXPECT_EQ(blocks.nodes(), 0u);
    EXPECT_EQ(blocks.rows(), 0u);
    EXPECT_EQ(blocks.factor_blocks(), 0u);
  }
  const Couplings large = net(100, joints);
  BlockLdlt blocks;
  EXPECT_FALSE(blocks.analyse(std::vector<std::uint8_t>(joints, 3), large, 4 * joints));
}

}  // namespace
}  // namespace atl::solver
